"""Tactile detection threshold of the paper, as data with its source.

Two experiments, not to be mixed.  One subject after another on a single pin (section 2.1: 12
subjects, 2.5 g preload): its mean is the black line of Figs 9, 15 and 17, of which the text
gives no value.  And on the display (section 2.2: 10 other subjects, 50 g preload): its mean
is given at three frequencies, with the excitation voltages that were needed.  Everything here
is the second; between the three points it is interpolated, outside nothing is known.
A scene may name a table of its own in its place.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Bools, Floats
from tactgen.geometry.csv_tables import read_table
from tactgen.geometry.device.parameters import Threshold
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import AMPLITUDE, FREQUENCY, quoted

_FIG_17 = "paper sections 6 and 7, Fig 17: mean of 10 subjects on the display, 50 g preload"


@dataclass(frozen=True)
class ThresholdPoint:
    """A stated detection threshold: displacement amplitude (m) at a frequency (Hz)."""

    frequency: float
    amplitude: float
    source: str


@dataclass(frozen=True)
class ThresholdCurve:
    """Stated points, straight lines between them in ln amplitude over ln frequency."""

    points: tuple[ThresholdPoint, ...]  #: At least two, in ascending frequency

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest frequency with a value (Hz)."""
        return self.points[0].frequency, self.points[-1].frequency

    def outside(self, frequencies: Floats) -> Bools:
        """Mask (n,) of frequencies without a value."""
        f = np.asarray(frequencies, dtype=float)
        low, high = self.range
        tolerance = 1e-9 * high  # a sweep's last frequency may be off by rounding
        return np.asarray((f < low - tolerance) | (f > high + tolerance))

    def at(self, frequencies: Floats) -> Floats:
        """Threshold (n,) in m; nan outside the range."""
        f = np.asarray(frequencies, dtype=float)
        beyond = self.outside(f)
        inside = np.where(beyond, self.range[0], f)
        level = np.interp(np.log(inside), *self._knots)
        return np.asarray(np.where(beyond, np.nan, np.exp(level)))

    def weights(self, frequency: float) -> Floats:
        """D ln threshold(frequency) / d ln amplitude of each point, shape (points,)."""
        knots, _ = self._knots
        return np.array([np.interp(np.log(frequency), knots, row) for row in np.eye(knots.size)])

    @property
    def _knots(self) -> Floats:
        """Logarithms of frequencies and amplitudes, (2, points)."""
        return np.log([(p.frequency, p.amplitude) for p in self.points]).T


#: The only threshold of which the text gives values.  "Starts at around 2 µm": the first
#: frequency is taken as 10 Hz, where the paper's other measurements start.
DISPLAY_THRESHOLD = ThresholdCurve(
    (
        ThresholdPoint(10.0, 2e-6, f"{_FIG_17}; start of the curve, taken as 10 Hz"),
        ThresholdPoint(250.0, 0.2e-6, _FIG_17),
        ThresholdPoint(1000.0, 1e-6, _FIG_17),
    )
)

_EXAMPLE = "frequency (Hz), threshold (um)"


def threshold_of(threshold: Threshold) -> ThresholdCurve:
    """Threshold that a scene names.

    Raises InputError if it is a table without file, or one that cannot be used.
    """
    if threshold.kind == "paper":
        return DISPLAY_THRESHOLD
    if not threshold.file:
        raise InputError(
            'threshold.kind = "table" needs threshold.file, the path of a CSV file with the '
            f"columns {_EXAMPLE}"
        )
    name = f"threshold.file = {quoted(threshold.file)}"
    known = {"frequency": FREQUENCY, "threshold": AMPLITUDE}
    table = read_table(Path(threshold.file), name, known, _EXAMPLE)
    if "threshold" not in table.columns:
        raise InputError(f"{name} has no threshold column; name the columns like {_EXAMPLE}")
    frequencies, amplitudes = table.columns["frequency"], table.columns["threshold"]
    for line, amplitude in zip(table.lines, amplitudes, strict=True):
        if amplitude <= 0.0:
            raise InputError(
                f"{name} line {line}: threshold {amplitude:g} m is not above 0; give the peak "
                "amplitude that is just felt"
            )
    if frequencies.size < 2:
        raise InputError(f"{name} holds {frequencies.size} frequencies; a curve needs at least 2")
    return ThresholdCurve(
        tuple(
            ThresholdPoint(float(f), float(a), f"{Path(threshold.file).name} line {line}")
            for f, a, line in zip(frequencies, amplitudes, table.lines, strict=True)
        )
    )
