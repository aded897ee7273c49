"""Row of a quantity, and the analyses of a model that it is read off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.device.parameters import Limits
from tactgen.geometry.units import Unit
from tactgen.tmm.ports.readout import ModalReadout, PortMatrix, Readout
from tactgen.validation.catalogue.detection import ThresholdCurve

Need = Literal[
    "static", "modes_short", "modes_open", "harmonic", "magnetic_point", "magnetic_map", "rest",
    "small_signal", "machine_poles", "crosstalk", "spread", "neighbours", "load",
]  # fmt: skip
#: The two, the machine that both make, and many of these side by side.
Actuator = Literal["bimorph", "reluctance", "generator", "display"]


class NeedRow(NamedTuple):
    """Kind of answer: its actuator and its name in words."""

    actuator: Actuator
    words: str


NEEDS: dict[Need, NeedRow] = {
    "static": NeedRow("bimorph", "a static value"),
    "modes_short": NeedRow("bimorph", "short-circuit modes"),
    "modes_open": NeedRow("bimorph", "open-circuit modes"),
    "harmonic": NeedRow("bimorph", "the response at given frequencies"),
    "load": NeedRow("bimorph", "what the tip touches"),
    "magnetic_point": NeedRow("reluctance", "the magnetic circuit at one current and gap"),
    "magnetic_map": NeedRow("reluctance", "the magnetic circuit over the stroke"),
    "rest": NeedRow("reluctance", "where the rod rests"),
    "small_signal": NeedRow("generator", "the machine's response at given frequencies"),
    "machine_poles": NeedRow("generator", "the poles of the rod and its coil"),
    "crosstalk": NeedRow("display", "what one unit moves at the others"),
    "spread": NeedRow("display", "how far the units differ"),
    "neighbours": NeedRow("display", "the field between neighbouring units"),
}


@dataclass(frozen=True)
class AnswerReadout:
    """A value with its error bar, as a model's answer holds it."""

    need: Need  #: The answer that is asked for
    #: Takes the answer, gives a :class:`validation.engine.results.Estimate`, or a Estimate
    of: Callable[[Any], Any]


@dataclass(frozen=True)
class DrivenReadout:
    """Load of ceramic and amplifier of the driven bimorph."""

    #: Takes a :class:`tmm.beam.port_quantities.DrivenCeramic`, the scene's limits and the drive
    #: voltage (V), gives an array (n,) over the frequencies
    of: Callable[[Any, Limits, float], Any]


@dataclass(frozen=True)
class LoadReadout:
    """Value of the load at the tip."""

    #: Takes the load's dynamic stiffness (n,) in N/m, the tip's displacement (n,) in m at the drive
    #: voltage and the angular frequency (n,) in rad/s, gives an array (n,)
    of: Callable[[Complex, Complex, Floats], Any]


@dataclass(frozen=True)
class QuantityRow:
    """One quantity that can be asked for."""

    #: Name in the interface, SI unit, one line of explanation
    name: str
    unit: str
    meaning: str
    #: How it is read off a model; all that follows from it are properties
    read: Readout | ModalReadout | PortMatrix | AnswerReadout | DrivenReadout | LoadReadout
    label: str = ""  #: What people call it; the name in words if left out
    headline: bool = False  #: Whether it stands at the head of a report
    #: Whether studies of uncertainty look at it: a response at a few frequencies, of modes the
    #: first
    varied: bool = False
    #: If it can be measured as a frequency response: what its column is called, and the magnitudes
    #: that can be meant
    curve: Unit | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "label", self.label or self.name.replace("_", " "))

    def at_threshold(self, threshold: ThresholdCurve) -> QuantityRow:
        """Row with a level, if it has one, that is this detection threshold."""
        if not (isinstance(self.read, Readout) and self.read.level is not None):
            return self
        return replace(self, read=replace(self.read, level=threshold.at))

    @property
    def needs(self) -> tuple[Need, ...]:
        """Answers of a model that it is computed from."""
        match self.read:
            case Readout(static=True):
                return ("static",)
            case ModalReadout(circuits=circuits):
                of: dict[str, Need] = {"short": "modes_short", "open": "modes_open"}
                return tuple(of[circuit] for circuit in circuits)
            case AnswerReadout(need=need):
                return (need,)
            case _:
                return ("harmonic",)

    @property
    def port_readout(self) -> Readout:
        """Readout from terminated ports, if there is one."""
        assert isinstance(self.read, Readout), f"{self.name} is not read off terminated ports"
        return self.read

    @property
    def actuator(self) -> Actuator:
        """Actuator that the quantity belongs to."""
        return NEEDS[self.needs[0]].actuator

    @property
    def by_frequency(self) -> bool:
        """Whether it is an array over the frequencies asked for."""
        return bool({"harmonic", "small_signal", "crosstalk", "load"} & set(self.needs))

    @property
    def static(self) -> bool:
        """Whether it is a value at 0 Hz."""
        return "static" in self.needs

    @property
    def loaded(self) -> bool:
        """Whether the tip's load enters with its losses."""
        if self._is_driven or {"small_signal", "crosstalk", "load"} & set(self.needs):
            return True
        return isinstance(self.read, Readout) and self.read.is_loaded

    @property
    def held_by_support(self) -> bool:
        """Whether only the support keeps the actuator from moving as a rigid body."""
        return self._is_driven or (isinstance(self.read, Readout) and self.read.has_free_ports)

    @property
    def _is_driven(self) -> bool:
        return isinstance(self.read, DrivenReadout | LoadReadout)

    @property
    def has_level(self) -> bool:
        """Whether it is held against a level, which is stated in a range only."""
        return isinstance(self.read, Readout) and self.read.level is not None

    @property
    def is_transduced(self) -> bool:
        """Whether it is nothing without piezoelectricity."""
        return isinstance(self.read, Readout | ModalReadout) and self.read.is_transduced
