"""One measured frequency response, whichever file it came from."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints, Numbers
from tactgen.validation.catalogue.quantities import measurable
from tactgen.validation.catalogue.row import QuantityRow


@dataclass(frozen=True)
class MeasuredCurve:
    """One measured frequency response in SI units, peak amplitudes.

    Attributes
    ----------
    source : str
        Name of the file, for messages.
    kind : str
        One of :func:`validation.catalogue.quantities.measurable`, such as ``velocity``.
    frequencies : (n,) array
        Hz, ascending, above 0.
    values : (n,) array
        Complex (time factor e^{+jΩt}, phase relative to the drive voltage), or real and
        positive where only the magnitude was measured.
    uncertainty : (n,) array or None
        Standard deviation of the magnitude, or of the real and of the imaginary part.
    weight : (n,) array
        How much each point counts in the sum of squares compared with others, whatever the
        scale; 0 leaves it out.
    """

    source: str
    kind: str
    frequencies: Floats
    values: Numbers
    error: Floats | None
    weight: Floats

    @property
    def has_phase(self) -> bool:
        """Whether the values are complex."""
        return np.iscomplexobj(self.values)

    @property
    def used(self) -> Bools:
        """Which points (n,) count."""
        return np.asarray(self.weight > 0.0)

    @property
    def relative_weight(self) -> Floats:
        """Weights (n,) with a mean of 1: only their ratios mean anything."""
        return np.asarray(self.weight / self.weight.mean())

    def at(self, points: Ints | Bools) -> MeasuredCurve:
        """Return the curve at some of its points."""
        bars = None if self.error is None else self.error[points]
        return replace(
            self,
            frequencies=self.frequencies[points],
            values=self.values[points],
            error=bars,
            weight=self.weight[points],
        )

    @property
    def unit(self) -> str:
        """SI unit of the values."""
        return self.quantity.unit

    @property
    def quantity(self) -> QuantityRow:
        """The quantity of `tactgen solve` that the curve is compared with."""
        return measurable()[self.kind]
