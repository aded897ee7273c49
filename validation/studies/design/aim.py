"""What is wanted of the actuator's length (paper section 4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD, ThresholdCurve

AimKind = Literal["shortest", "margin"]
#: The paper's lengths (m): 20 mm (red) to 40 mm (blue line of Fig 9).
PAPER_LENGTHS = (20e-3, 40e-3)
#: The paper's frequencies (Hz).
PAPER_BAND = (10.0, 1000.0)


def stated_band(threshold: ThresholdCurve) -> tuple[float, float]:
    """Return the paper's band as far as a threshold is stated; all of it if nowhere (Hz)."""
    low, high = max(PAPER_BAND[0], threshold.range[0]), min(PAPER_BAND[1], threshold.range[1])
    return (low, high) if low < high else threshold.range


@dataclass(frozen=True)
class Aim:
    """What is wanted of the length.

    Attributes
    ----------
    kind : {"shortest", "margin"}
        The shortest length that keeps the margin, or the length of the largest margin.
    margin : float
        Deflection over detection threshold to keep.
    band : (float, float)
        Frequencies over which it is to be kept (Hz).
    lengths : (float, float)
        Shortest and longest ceramic length (m).
    threshold : ThresholdCurve
        The detection threshold.
    """

    kind: AimKind = "shortest"
    margin: float = 1.0
    band: tuple[float, float] = PAPER_BAND
    lengths: tuple[float, float] = PAPER_LENGTHS
    threshold: ThresholdCurve = DISPLAY_THRESHOLD

    def __post_init__(self) -> None:
        """Refuse an aim that means nothing.

        Raises
        ------
        InputError
            Naming the option.
        """
        if not (math.isfinite(self.margin) and self.margin > 0.0):
            raise InputError(
                f"margin = {self.margin:g} is not a factor above 0; write for example --margin 1.5"
            )
        low, high = self.band
        if not low < high:
            raise InputError(
                f"band = {low:g} to {high:g} Hz does not rise; write for example --band 10:1000"
            )
        if self.threshold.outside(np.array(self.band)).any():
            first, last = self.threshold.range
            raise InputError(
                f"band = {low:g} to {high:g} Hz reaches beyond the detection threshold, which is "
                f"stated from {first:g} to {last:g} Hz; write for example --band "
                f"{first:g}:{last:g}"
            )
        short, long = self.lengths
        if not 0.0 < short < long:
            raise InputError(
                f"lengths = {1e3 * short:g} mm to {1e3 * long:g} mm must rise and start above "
                "0 mm; write for example --lengths 20mm:40mm"
            )
