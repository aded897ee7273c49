"""What the tip touches, by itself: its impedance over frequency, with how well that is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.ends import Ends
from tactgen.tmm.ports.elements import tip_stiffness
from tactgen.tmm.ports.measured_load import OF_THE_TABLE, MeasuredLaw
from tactgen.validation.engine.results import Estimate

#: Rounding of a formula.
_ROUNDING = 1e-14


@dataclass(frozen=True)
class MeasuredLoad:
    """The load of a scene over frequencies (Hz)."""

    ends: Ends
    frequencies: Floats

    @property
    def method(self) -> str:
        """How the error bars come about."""
        return OF_THE_TABLE if isinstance(self.ends.tip, MeasuredLaw) else "rounding of a formula"

    @property
    def impedance(self) -> Estimate:
        """Force per velocity (n,) in N s/m; nan at 0 Hz, where nothing moves steadily."""
        omega = 2.0 * np.pi * np.where(self.frequencies > 0.0, self.frequencies, np.nan)
        # a real division: of complex numbers by nan numpy warns
        value = tip_stiffness(self.ends.tip, self.frequencies) * (-1j * (1.0 / omega))
        bar = _ROUNDING * np.abs(value)
        if isinstance(self.ends.tip, MeasuredLaw):
            bar = bar + self.ends.tip.error(self.frequencies) / omega
        return Estimate(value, bar)
