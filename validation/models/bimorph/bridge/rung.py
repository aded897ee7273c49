"""What a step of a bridge is."""

from __future__ import annotations

from dataclasses import dataclass

from tactgen.validation.models.bimorph.beam_values import Steps, Values

#: Where no change is known.
UNKNOWN = Steps()


@dataclass(frozen=True)
class Rung:
    """One step of a bridge.

    Attributes
    ----------
    name, what : str
        Short, and in a sentence.
    values : Values
        After this step.
    step : Steps
        Change from the rung before, nan at the start.
    predicted : Steps
        The change that a closed form gives.
    theory : str
        Which closed form.
    section : Steps
        The change that the solid's own section, far from its ends, makes in the beam model.
    """

    name: str
    what: str
    values: Values
    step: Steps = UNKNOWN
    predicted: Steps = UNKNOWN
    theory: str = ""
    section: Steps = UNKNOWN

    @property
    def deflection(self) -> float:
        """Tip displacement per volt (m)."""
        return self.values.deflection

    @property
    def first_frequency(self) -> float:
        """First short-circuit bending frequency (Hz)."""
        return self.values.first_frequency

    @property
    def capacitance(self) -> float:
        """Free capacitance (F)."""
        return self.values.capacitance
