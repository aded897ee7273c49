"""A measured load as a law of frequency: interpolated in its band, by a passive fit beyond.

Between the points Re Z and Im Z are monotone cubics (Fritsch and Carlson) over ln f, which pass
neither above nor below their neighbours: what takes energy at every point does so between them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from tactgen.geometry.arrays import Bools, Complex, Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.device.load_table import LoadTable, load_table
from tactgen.geometry.device.parameters import Load
from tactgen.geometry.device.support_table import SupportTable
from tactgen.geometry.errors import InputError


@dataclass(frozen=True)
class Dictionary:
    """Resonators that a fit may use."""

    per_decade: int = 10  #: How many frequencies a decade
    ratios: tuple[float, ...] = (0.05, 0.2, 1.0)  #: Their damping ratios
    #: How far beyond the band they reach, a factor: what lies further off acts in the band as
    #: spring, damper or mass
    reach: float = 10.0


_RICH = Dictionary()


@dataclass(frozen=True)
class PassiveFit:
    """An impedance Z(s) = m s + d + k/s + Σ (a s + b)/(s² + 2ζω s + ω²), 0 ≤ b ≤ 2ζω a."""

    #: m, d and k (kg, N s/m, N/m), none negative
    mass: float
    damping: float
    stiffness: float
    #: (k,) Angular frequency (rad/s), damping ratio and numerator of each resonator
    omega: Floats
    ratio: Floats
    a: Floats
    b: Floats

    def stiffness_at(self, frequencies: Floats) -> Complex:
        """Dynamic stiffness s Z (n,) in N/m at frequencies from 0 on (Hz)."""
        s = 2j * np.pi * np.asarray(frequencies, dtype=float)[:, None]
        below = s**2 + 2.0 * self.ratio * self.omega * s + self.omega**2
        resonators = (s * (self.a * s + self.b) / below).sum(axis=1)
        plain = self.mass * s**2 + self.damping * s + self.stiffness
        return np.asarray(plain[:, 0] + resonators)


def passive_fit(
    frequencies: Floats, impedance: Complex, dictionary: Dictionary = _RICH
) -> PassiveFit:
    """Passive load with the least sum of squared relative errors.

    Parameters
    ----------
    frequencies : (n,) array
        Hz, ascending, above 0.
    impedance : (n,) complex array
        N s/m, nowhere 0.
    dictionary : Dictionary
        Fewer resonators follow it less closely, and are a smaller system.
    """
    from scipy.optimize import nnls

    omega, ratio = _resonators(dictionary, float(frequencies[0]), float(frequencies[-1]))
    s = 2j * np.pi * np.asarray(frequencies, dtype=float)[:, None]
    below = s**2 + 2.0 * ratio * omega * s + omega**2
    # with b at its least, and at its most
    terms = np.concatenate(
        [s, np.ones_like(s), 1.0 / s, s / below, (s + 2.0 * ratio * omega) / below], axis=1
    )
    relative = terms / np.abs(impedance)[:, None]
    wanted = impedance / np.abs(impedance)
    rows = np.concatenate([relative.real, relative.imag])
    sizes = np.linalg.norm(rows, axis=0)
    found, _ = nnls(
        rows / sizes, np.concatenate([wanted.real, wanted.imag]), maxiter=30 * sizes.size
    )
    mass, damping, stiffness, *rest = found / sizes
    least, most = np.reshape(rest, (2, omega.size))
    used = least + most > 0.0
    return PassiveFit(
        float(mass),
        float(damping),
        float(stiffness),
        omega[used],
        ratio[used],
        (least + most)[used],
        (2.0 * ratio * omega * most)[used],
    )


def _resonators(dictionary: Dictionary, low: float, high: float) -> tuple[Floats, Floats]:
    """Angular frequency (rad/s) and damping ratio of all resonators."""
    reach = dictionary.reach
    decades = np.log10(high / low * reach**2)
    count = int(np.ceil(dictionary.per_decade * decades)) + 1
    omega = 2.0 * np.pi * np.geomspace(low / reach, high * reach, count)
    grid = np.meshgrid(omega, dictionary.ratios, indexing="ij")
    return grid[0].ravel(), grid[1].ravel()


#: What the error bar of a loaded response contains besides, in words.
OF_THE_TABLE = "the load's table between its points, and of a fit its distance"
#: Most points to which a load is fitted, evenly chosen: a fit follows no finer features.
_FITTED = 300
#: Share of the band, in ln f, that the second fit leaves out at either end.
_LEFT_OUT = 0.2
#: How far beyond the band a fit is believed, a factor: over random chains of springs, dampers and
#: masses nine of ten bars hold there, and fewer further out (a test asks for that).
_BELIEVED = 3.0


@dataclass(frozen=True)
class MeasuredLaw:
    """A table as a dynamic stiffness over frequency, and how far that may be off."""

    table: LoadTable  #: What was measured
    #: Empty, so that nothing is said beyond the band; or the fit to the whole band, which answers
    #: everywhere, and one to the inner part of the band, by which its continuation is judged
    fits: tuple[PassiveFit, ...] = ()

    def __call__(self, frequencies: Floats) -> Complex:
        """Dynamic stiffness (n,) in N/m.

        Raises InputError for a frequency outside :attr:`reach`.
        """
        f = np.asarray(frequencies, dtype=float)
        beyond = outside(self.reach, f)
        if beyond.any():
            raise self._refusal(float(f[beyond][0]))
        return self.fits[0].stiffness_at(f) if self.fits else _interpolated(self.table, f)

    @property
    def reach(self) -> tuple[float, float]:
        """Lowest and highest frequency (Hz) for which there is a value."""
        low, high = self.table.band
        return (low / _BELIEVED, high * _BELIEVED) if self.fits else (low, high)

    def _refusal(self, frequency: float) -> InputError:
        low, high = self.reach
        where = f"frequency = {frequency:g} Hz is outside the table {self.table.source}"
        if self.fits:
            return InputError(
                f"{where} and its passive fit, which is believed up to a factor of {_BELIEVED:g} "
                f"beyond it ({low:g} to {high:g} Hz); choose frequencies inside"
            )
        return InputError(
            f"{where} ({low:g} to {high:g} Hz); choose frequencies inside it, or continue it with "
            "load.extrapolation = passive_fit"
        )

    def error(self, frequencies: Floats) -> Floats:
        """By how much the dynamic stiffness may be off (n,), in N/m.

        Between points what leaving out every other one changes; of a fit also its distance from
        the table, and beyond the band the difference of the two fits and the largest relative
        distance in the band.
        """
        f = np.asarray(frequencies, dtype=float)
        within = np.clip(f, *self.table.band)
        table = _interpolated(self.table, within)
        error: Floats = np.abs(table - _interpolated(_thinned(self.table), within))
        if not self.fits:
            return error
        error = error + np.abs(table - self.fits[0].stiffness_at(within))
        whole, inner = (fit.stiffness_at(f) for fit in self.fits)
        worst = self.misfit[0] * np.maximum(np.abs(whole), np.abs(inner))
        return np.where(outside(self.table.band, f), np.abs(whole - inner) + worst, error)

    @property
    def misfit(self) -> tuple[float, float]:
        """Largest and root-mean-square relative distance of the fit from the table; 0 if none."""
        if not self.fits:
            return 0.0, 0.0
        at, impedance = _fitted_points(self.table)
        apart = np.abs(self.fits[0].stiffness_at(at) / (2j * np.pi * at * impedance) - 1.0)
        return float(apart.max()), float(np.sqrt(np.mean(apart**2)))


@lru_cache(maxsize=16)
def continued(table: LoadTable) -> MeasuredLaw:
    """Table with the passive fits that continue it."""
    frequencies, impedance = _fitted_points(table)
    x = np.log(frequencies)
    inside = np.abs(x - 0.5 * (x[0] + x[-1])) <= (0.5 - _LEFT_OUT) * (x[-1] - x[0])
    whole = passive_fit(frequencies, impedance)
    return MeasuredLaw(table, (whole, passive_fit(frequencies[inside], impedance[inside])))


def measured_law(load: Load) -> MeasuredLaw:
    """Law of a scene's table, continued by passive fits if the scene says so.

    Raises InputError if the table cannot be used.
    """
    table = load_table(load)
    return MeasuredLaw(table) if load.extrapolation == "refuse" else continued(table)


def _fitted_points(table: LoadTable) -> tuple[Floats, Complex]:
    """Points of a table to which a load is fitted, those without force left out."""
    count = table.frequencies.size
    chosen = np.unique(np.linspace(0, count - 1, min(count, _FITTED)).round().astype(int))
    chosen = chosen[np.abs(table.impedance[chosen]) > 0.0]
    return table.frequencies[chosen], table.impedance[chosen]


def outside(band: tuple[float, float], frequencies: Floats) -> Bools:
    """Mask of frequencies (n,) in Hz outside a band; a sweep's last may be rounded."""
    f = np.asarray(frequencies, dtype=float)
    return np.asarray((f < band[0] * (1.0 - 1e-9)) | (f > band[1] * (1.0 + 1e-9)))


def _thinned(table: LoadTable) -> LoadTable:
    """Every other point of a table, and its last."""
    chosen = np.unique([*range(0, table.frequencies.size, 2), table.frequencies.size - 1])
    return LoadTable(table.source, table.frequencies[chosen], table.impedance[chosen])


def _interpolated(table: LoadTable, frequencies: Floats) -> Complex:
    """Dynamic stiffness (n,) in N/m between the points of a table."""
    found = _between(table.frequencies, table.impedance, frequencies)
    return np.asarray(2j * np.pi * frequencies * found)


def _between(points: Floats, values: Complex, frequencies: Floats) -> Complex:
    """Values (n,) between points (m,) in Hz, beyond them those of the last."""
    from scipy.interpolate import PchipInterpolator

    at = np.log(np.clip(frequencies, points[0], points[-1]))
    both = np.stack([values.real, values.imag])
    real, imaginary = PchipInterpolator(np.log(points), both, axis=1)(at)
    return np.asarray(real + 1j * imaginary)


@dataclass(frozen=True)
class MeasuredSupport:
    """A table of the base's support as dynamic stiffness over frequency."""

    table: SupportTable
    held: float  #: Lateral stiffness (N/m) where none was measured
    #: By how much of its error it is off: see :func:`disturbed`
    off: complex = 0.0

    def __call__(self, frequencies: Floats) -> tuple[Complex, Complex]:
        """Lateral and rotational dynamic stiffness (n,) in N/m and N m/rad.

        Raises InputError for a frequency outside the table.
        """
        f, table = np.asarray(frequencies, dtype=float), self.table
        beyond = outside(table.band, f)
        if beyond.any():
            low, high = table.band
            raise InputError(
                f"frequency = {float(f[beyond][0]):g} Hz is outside the table {table.source} "
                f"({low:g} to {high:g} Hz); choose frequencies inside it"
            )
        lateral = np.full(f.shape, self.held, dtype=complex)
        if table.lateral is not None:
            lateral = self._at(table.lateral, f)
        return lateral, self._at(table.rotational, f)

    @property
    def at_rest(self) -> tuple[float, float]:
        """Real parts at the lowest frequency, at least 0."""
        both = self(self.table.frequencies[:1])
        lateral, rotational = (max(float(values[0].real), 0.0) for values in both)
        return lateral, rotational

    def _at(self, values: Complex, frequencies: Floats) -> Complex:
        """Values (n,) at frequencies, off by what leaving out every other point changes."""
        points = self.table.frequencies
        found = _between(points, values, frequencies)
        if not self.off:
            return found
        few = np.unique([*range(0, points.size, 2), points.size - 1])
        return found + self.off * np.abs(found - _between(points[few], values[few], frequencies))


def disturbed(ends: Ends) -> tuple[Ends, ...]:
    """Tables of load and support off by their errors, in phase and a quarter turn later.

    None for other ends.  What is analytic in the load moves by as much either way, and what is
    a magnitude by no more than both together.
    """
    found: list[Ends] = []
    tip, base = ends.tip, ends.base
    for turn in (1.0, 1j):
        if isinstance(tip, MeasuredLaw):
            found.append(replace(ends, tip=partial(_tip_off, tip, turn)))
        if base is not None and isinstance(base.law, MeasuredSupport):
            found.append(replace(ends, base=replace(base, law=replace(base.law, off=turn))))
    return tuple(found)


def _tip_off(law: MeasuredLaw, turn: complex, frequencies: Floats) -> Complex:
    return np.asarray(law(frequencies) + turn * law.error(frequencies))
