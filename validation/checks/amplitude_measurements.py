"""What the rows of :mod:`validation.checks.amplitude` measure."""

from __future__ import annotations

from tactgen.validation.checks.cases import oscillators


def strong_cubic_frequency() -> float:
    """Free angular frequency of x'' + x + x³ = 0 from x = 5 (rad/s)."""
    return oscillators.free_on_cubic(1.0, 1.0, 1.0, 5.0).omega


def vm156_period() -> float:
    """Period of VM156 (s)."""
    return oscillators.period_of_vm156()


def duffing_peak_height() -> float:
    """Largest first harmonic of the driven Duffing oscillator."""
    return abs(oscillators.fundamental(oscillators.driven_duffing_peak()))


def duffing_peak_place() -> float:
    """Angular frequency of that peak (rad/s)."""
    return oscillators.driven_duffing_peak().omega


def duffing_fold(number: int) -> float:
    """Angular frequency of a fold, in the order in which they are met (rad/s)."""
    return oscillators.driven_duffing_folds()[number].omega


def one_sided(ratio: float) -> float:
    """Free frequency on a spring that is stiffer on one side, over the exact one."""
    found = oscillators.free_on_one_sided(ratio, 160).omega
    return found / oscillators.one_sided_frequency(ratio)
