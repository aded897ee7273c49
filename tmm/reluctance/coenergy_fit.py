"""Fit of the co-energy map to samples, and its interpolation error by leaving samples out.

One linear least-squares problem in the coefficients of the surface: flux linkage, force
and what else the model gives are all derivatives of it.  Each sample counts relative to
its own size.  Samples that belong to no common surface show as residual.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.tmm.reluctance.coenergy_map import (
    CURRENT_DEGREE,
    GAP_DEGREE,
    TABLES,
    CoenergyMap,
    MapError,
    Samples,
    current_basis,
    gap_derivative,
    splines,
)

#: Fewest currents above zero and gaps: half of them must still make a map.
_FEWEST = 6

#: What an inductance counts beside a flux linkage: it is the rougher function of the two.
_INDUCTANCE_WEIGHT = 0.1

#: Smallest and largest g0 of the surface's ln(g + g0), as shares of the range of gaps.
_LEAST_OFFSET, _MOST_OFFSET = 0.05, 20.0

#: Smallest coefficient, relative to the largest: inductance stays positive.
_LEAST = 1e-9

#: Steps of the least squares with a sign, per coefficient: 3 are usual, saturation over six decades
#: of gaps takes more.
_NNLS_STEPS = 30

#: What remains of the error when the samples lie twice as dense.  Smooth samples leave an
#: eighth; magnetisation curves from tables have kinks, which can leave a half.
_REMAINS = 0.5
#: The same of gaps alone: cubics in the gap leave a sixteenth in the flux linkage and an eighth in
#: the force, their slope.  Twice the eighth is taken, as the kinks move with the gap.
_REMAINS_OF_GAPS = 0.25

#: Below this share of the largest value at the same gap, errors are judged against the share;
#: pulls count relative to no less than this share of the largest at a lower current.
_SMALL = 0.1

_UNKNOWN = MapError(np.nan, np.nan)


def fit(samples: Samples) -> CoenergyMap:
    """Map that fits the samples best.

    Raises InputError if the samples are too few, not finite, or no co-energy can have them.
    """
    _check(samples)
    found = _fitted(samples)
    i, g = _kept(samples)
    fewer_currents = _miss(_fitted(_picked(samples, i, np.arange(samples.gap.size))), samples)
    fewer_gaps = _miss(_fitted(_picked(samples, np.arange(samples.current.size), g)), samples)

    def between(name: str) -> float:
        currents, gaps = (float(getattr(of, name)) for of in (fewer_currents, fewer_gaps))
        left = _REMAINS * currents + _REMAINS_OF_GAPS * gaps
        return max(left, float(getattr(found.residual, name)))

    return replace(found, interpolation_error=MapError(between("flux_linkage"), between("force")))


def thinned(found: CoenergyMap) -> tuple[CoenergyMap, float]:
    """Map of every second sample, and the weight of its distance from the full map.

    That factor times the distance of an answer by the one from the answer by the other is the
    error that the samples' density leaves in the answer.
    """
    return _fitted(_picked(found.samples, *_kept(found.samples))), _REMAINS


def _check(samples: Samples) -> None:
    """Refuse samples that no co-energy map can be made from."""
    i, g, shape = samples.current, samples.gap, (samples.current.size, samples.gap.size)
    given = _tables(samples)
    for name, values in {"current": i, "gap": g, **given}.items():
        if not np.isfinite(values).all():
            raise InputError(f"samples of {name} are not all finite; leave out what did not solve")
    for name, values in given.items():
        if values.shape != shape:
            raise InputError(
                f"samples of {name} have the shape {values.shape}, not {shape} of currents and gaps"
            )
    above = int(np.count_nonzero(i > 0.0))
    if min(above, g.size) < _FEWEST:
        raise InputError(
            f"{above} currents above 0 mA and {g.size} gaps make no map; sample at least "
            f"{_FEWEST} of each"
        )
    for name, values in (("current", i), ("gap", g)):
        if values[0] < 0.0 or not (np.diff(values) > 0.0).all():
            raise InputError(f"samples of {name} must increase from 0 or above; sort them")
    if not (np.diff(samples.flux_linkage, axis=0) > 0.0).all():
        raise InputError("samples of flux_linkage must increase with the current at every gap")


def _tables(samples: Samples) -> dict[str, Floats]:
    """What a map is fitted to, over currents and gaps, as far as the model has it."""
    return {n: getattr(samples, n) for n in TABLES if getattr(samples, n) is not None}


def _fitted(samples: Samples) -> CoenergyMap:
    """Map without an estimate of its interpolation error."""
    offset = _gap_offset(samples)
    width = samples.gap + offset
    points = np.union1d(samples.current, 0.0)
    some = points.size - 1
    if samples.incremental_inductance is not None:
        some += some // 2  # inductances tell about the shape between currents
    along = _breaks(points, some - CURRENT_DEGREE)
    across = _breaks(np.log(width), width.size - GAP_DEGREE)
    rows, targets = _equations(samples, along, across, width)
    coefficients = _positive_least_squares(rows, targets)
    found = CoenergyMap(
        samples,
        along,
        across,
        offset,
        coefficients.reshape(some, width.size),
        residual=_UNKNOWN,
        interpolation_error=_UNKNOWN,
    )
    return replace(found, residual=_miss(found, samples))


def _gap_offset(samples: Samples) -> float:
    """G0 such that λ ∝ 1/(g + g0) at the lowest current, within reason (m)."""
    lowest = int(np.count_nonzero(samples.current == 0.0))
    first, last = samples.flux_linkage[lowest, [0, -1]]
    low, high = samples.gap[[0, -1]]
    span = high - low
    offset = (high * last - low * first) / (first - last) if first > last else np.inf
    return float(np.clip(offset, _LEAST_OFFSET * span, _MOST_OFFSET * span))


def _breaks(points: Floats, spans: int) -> Floats:
    """Spans + 1 breaks spread like the points."""
    share = np.linspace(0.0, 1.0, points.size)
    return np.asarray(np.interp(np.linspace(0.0, 1.0, spans + 1), share, points))


def _equations(
    samples: Samples, current_breaks: Floats, width_breaks: Floats, width: Floats
) -> tuple[Floats, Floats]:
    """Rows (r, j·k) and right sides (r,) of all samples, each relative to its size.

    What vanishes with the current does so in the surface as well, and says nothing there.
    """
    of_current, of_gap = current_basis(current_breaks), splines(width_breaks, GAP_DEGREE)
    rows: list[Floats] = []
    targets: list[Floats] = []
    for values, by_current, by_gap, weight in (
        (samples.flux_linkage, 1, 0, 1.0),
        (samples.force, 0, 1, -1.0),
        (samples.coenergy, 0, 0, 1.0),
        (samples.incremental_inductance, 2, 0, _INDUCTANCE_WEIGHT),
    ):
        if values is None:
            continue
        along = of_current(samples.current, by_current)
        there = gap_derivative(of_gap, width, by_gap)
        telling = (values != 0.0).any(axis=1)
        values, along = values[telling], along[telling]
        size = np.abs(values)
        if by_gap:  # a pull grows with the current until the steel saturates, then may fall to 0
            size = np.maximum(size, _SMALL * np.maximum.accumulate(size, axis=0))
        scale = weight / size
        block = np.einsum("ij,gk,ig->igjk", along, there, scale)
        rows.append(block.reshape(values.size, -1))
        targets.append((np.abs(scale) * values).ravel())
    return np.concatenate(rows), np.concatenate(targets)


def _positive_least_squares(rows: Floats, targets: Floats) -> Floats:
    """Solution with all coefficients positive; the free one if it is so already."""
    size = np.linalg.norm(rows, axis=0)
    scaled = rows / size
    found = np.asarray(np.linalg.lstsq(scaled, targets, rcond=None)[0] / size)
    least = _LEAST * float(np.abs(found).max())
    if found.min() >= least:
        return found
    from scipy.optimize import nnls  # slow to import, and rarely needed

    above, _ = nnls(scaled, targets - rows.sum(axis=1) * least, maxiter=_NNLS_STEPS * size.size)
    return np.asarray(above / size + least)


def _kept(samples: Samples) -> tuple[Ints, Ints]:
    """Currents and gaps left when every second is dropped.

    The first current above zero goes, so that the stretch down to zero is judged too; other ends
    stay.
    """
    n, m = samples.flux_linkage.shape
    zeros = int(np.count_nonzero(samples.current == 0.0))
    i = np.unique([*range(zeros), *range(zeros + 1, n, 2), n - 1])
    return i, np.unique([*range(0, m, 2), m - 1])


def _picked(samples: Samples, i: Ints, g: Ints) -> Samples:
    tables: dict[str, Any] = {n: v[np.ix_(i, g)] for n, v in _tables(samples).items()}
    return replace(samples, current=samples.current[i], gap=samples.gap[g], **tables)


def _miss(found: CoenergyMap, samples: Samples) -> MapError:
    """Misfit of a map at samples."""
    said = found.sampled(samples.current, samples.gap)
    return MapError(
        largest_share(said.flux_linkage - samples.flux_linkage, samples.flux_linkage),
        largest_share(said.force - samples.force, samples.force),
    )


def largest_share(error: Floats, values: Floats) -> float:
    """Largest error relative to the value there, or to a tenth of the gap's largest."""
    size = np.abs(values)
    return float((np.abs(error) / np.maximum(size, _SMALL * size.max(axis=0))).max())


#: What the global attribute `title` says; files that say otherwise are refused.
TITLE = "co-energy map of a reluctance actuator"

#: Name, dimensions, unit and meaning of each variable.
_VARIABLES = (
    ("current", ("current",), "A", "current in the winding"),
    ("gap", ("gap",), "m", "working air gap"),
    ("flux_linkage", ("current", "gap"), "Wb", "flux linkage of the winding, dW'/di"),
    ("force", ("current", "gap"), "N", "pull, positive when it closes the gap, -dW'/dg"),
    ("coenergy", ("current", "gap"), "J", "magnetic co-energy W'"),
    ("incremental_inductance", ("current", "gap"), "H", "d(flux linkage)/d(current)"),
    ("force_error", ("current", "gap"), "N", "numerical error bar of the force"),
)
#: Those that not every model has.
_OPTIONAL = ("coenergy", "incremental_inductance", "force_error")


def write_map(path: str | Path, found: CoenergyMap) -> None:
    """Write a map's samples, with units and sign conventions, whole or not at all.

    Raises InputError if the file cannot be written.
    """
    from scipy.io import netcdf_file  # slow to import

    samples = found.samples
    with written_whole(path) as temporary, netcdf_file(str(temporary), "w") as file:
        file.title = TITLE
        file.conventions = (
            "SI units; samples of one co-energy W'(i, g); W' = 0 without current and even in it"
        )
        file.model = samples.model
        file.device = samples.device
        for name in ("current", "gap"):
            file.createDimension(name, getattr(samples, name).size)
        for name, dimensions, unit, meaning in _VARIABLES:
            values = getattr(samples, name)
            if values is None:
                continue
            variable = file.createVariable(name, "f8", dimensions)
            variable[:] = values
            variable.units = unit
            variable.long_name = meaning


def read_map(path: str | Path) -> CoenergyMap:
    """Map whose samples a file holds.

    Raises InputError if the file cannot be read, is no co-energy map, or holds no usable samples.
    """
    from scipy.io import netcdf_file

    path = Path(path)
    try:
        # the reader trusts what it reads: a damaged file may fail anywhere in it
        with netcdf_file(str(path), "r", mmap=False) as file:
            samples = _samples(file, path)
    except InputError:
        raise
    except Exception as error:  # noqa: BLE001
        reason = (getattr(error, "strerror", None) or "not a whole netCDF file").lower()
        raise InputError(
            f"{path} cannot be read as a co-energy map ({reason}); give a file that was written "
            "as one"
        ) from None
    return fit(samples)


def _samples(file: Any, path: Path) -> Samples:
    if _text(file, "title") != TITLE:
        raise InputError(
            f'{path} is not a co-energy map: its title is not "{TITLE}"; give a file that tactgen '
            "export --map wrote"
        )
    found: dict[str, Floats | None] = {}
    for name, dimensions, unit, _ in _VARIABLES:
        variable = file.variables.get(name)
        if variable is None and name in _OPTIONAL:
            found[name] = None
            continue
        if variable is None:
            raise InputError(f"{path} has no variable {name}; write the map again")
        if variable.dimensions != dimensions or _text(variable, "units") != unit:
            raise InputError(
                f"{path} gives {name} over {variable.dimensions} in {_text(variable, 'units')!r}; "
                f"it must be over {dimensions} in {unit!r}"
            )
        # netCDF is big-endian
        found[name] = np.array(variable[:], dtype=float)
    return Samples(**found, model=_text(file, "model"), device=_text(file, "device"))  # type: ignore[arg-type]


def _text(holder: Any, name: str) -> str:
    value = getattr(holder, name, b"")
    return value.decode() if isinstance(value, bytes) else str(value)
