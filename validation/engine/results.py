"""Numbers with their errors."""

from __future__ import annotations

import importlib.metadata
import platform
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.store.values import source_digest, storable


@storable
@dataclass(frozen=True)
class Estimate:
    """A number, or an array of them, with its numerical error."""

    value: Any  #: In SI units; nan where there is none
    #: Absolute numerical error, of the unit and shape of `value`'s magnitude; nan if not known
    error: Any
    method: str = ""  #: How the error was estimated, for the reader
    classes: tuple[str, ...] | None = None  #: The class of motion of each value of a list of modes

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", self.value + 0.0)  # no -0


@storable
@dataclass(frozen=True, kw_only=True)
class Quantity(Estimate):
    """An estimate by one model: one number, or an array over frequency or mode."""

    name: str
    model: str
    unit: str
    seconds: float = 0.0
    frequency: tuple[float, ...] | None = None


#: Order assumed between two uniform meshes of tetrahedra.  Corners where stiffness jumps at a clamp
#: limit quadratic elements to between 1 and 2 in energy-like quantities.
ASSUMED_ORDER = 1.5
#: Factor by which the error falls at least from one level of bricks to the next: with it, and
#: the safety factor, 19 of 20 errors of varied bimorphs are within their bars
#: (validation/evidence/coverage_bimorph.py).
ASSUMED_GAIN = 1.6
#: Least gain in error of halved elements that is counted with.  Less is seen where rounding is all
#: that separates two meshes; then what does separate them is the bar, with the safety factor.
LEAST_HALVED = 2.0
#: Safety factor on the extrapolated error.
SAFETY = 1.25
#: Share of the largest difference in a class of modes, or at rest; or of what a difference of two
#: errors can be at most.
_BY_CHANCE = 0.1
#: Error bar of one level of bricks per difference from the next coarser level.
BRICK_FACTOR = SAFETY / (ASSUMED_GAIN - 1.0)
#: Error bar of bricks per difference that polynomials of one degree more make by their residual,
#: those of displacement and those of potential apart.  Theirs is most of what is missing, but less
#: where the solution is singular at an edge inside the body: at the end of a tab, of glue or of an
#: electrode, or where a base holds the shim alone.  Chosen on 31 bimorphs drawn at random, so that
#: 19 of 20 errors are within their bars; of 35 drawn after it 98 % were, with half the bars at most
#: 4.2 times the error (validation/evidence/coverage_bimorph.py).  With one factor for all, those
#: without such an edge had to have bars of ten errors for those with one to be covered.
SURPLUS_FACTOR, SURPLUS_FACTOR_AT_EDGES = 2.5, 5.0


def observed_factor(before: Floats, last: Floats, order: float) -> Floats:
    """Error bar of the finest of three meshes per difference from the next coarser.

    Each mesh has the last one's elements halved.  The error falls by what the two differences
    show: at most by what the order promises, at least by :data:`LEAST_HALVED`.

    Parameters
    ----------
    before, last : (...) array
        Sizes of the difference of the coarser two meshes, and of the finer two.
    order : float
        Of the error in the size of elements.
    """
    shown = np.asarray(before) / np.maximum(last, np.finfo(float).tiny)
    return np.asarray(SAFETY / (np.clip(shown, LEAST_HALVED, 2.0**order) - 1.0))


def least_difference(fine: Floats, coarse: Floats) -> Floats:
    """Relative difference (...) that each answer of a group counts with at least.

    Two levels may agree in one mode, or in one answer at rest, by chance, while they differ in
    its neighbours: a tenth of the largest difference in the group.

    Parameters
    ----------
    fine, coarse : (..., n) array
        Frequencies of one class of motion, or sizes at rest; nan where a mode has no partner.
        What is zero, such as motion without piezoelectricity, has no share.
    """
    apart = np.abs(fine - coarse) / np.where(fine == 0.0, np.inf, fine)
    return np.asarray(
        _BY_CHANCE * np.where(np.isfinite(apart), apart, 0.0).max(axis=-1, initial=0.0)
    )


def cancelling(change: float, most: float) -> float:
    """Size that a difference of two errors counts with, estimated as `change`.

    Of two errors that are much alike next to nothing may be left by chance: a tenth of the `most`
    that it can be counts besides.  Chosen on coupling factors of 20 bimorphs and of 15 members of
    families drawn at random: with the factors above, those of 20 and of 7 drawn after them were
    all covered, half of them by bars of at most 2.7 and 2.2 errors.
    """
    return abs(change) + _BY_CHANCE * most


def two_mesh_factor(ratio: float, order: float = ASSUMED_ORDER) -> float:
    """Error bar of the finer mesh per difference between two meshes.

    Parameters
    ----------
    ratio : float
        Element size of the coarser over that of the finer mesh, above 1.
    """
    return float(SAFETY / (ratio**order - 1.0))


#: Libraries that numbers, meshes and pictures come from.
LIBRARIES = ("numpy", "scipy", "scikit-fem", "cadquery", "pytetwild", "pyvista", "mkl")
#: The code that computes numbers; what writes them down is not among it.
_CODE = (
    "tactgen.validation.engine.solve", "tactgen.validation.models", "tactgen.validation.catalogue",
    "tactgen.fem", "tactgen.tmm",
)  # fmt: skip


@dataclass(frozen=True)
class Origin:
    """Who computed something."""

    #: Name and version of this package
    program: str
    version: str
    code: str  #: Hash of all code that computes numbers
    commit: str  #: The commit of the sources, or that there is none
    libraries: dict[str, str]  #: Versions by library
    #: The sparse solver that ``auto`` takes, the interpreter, system and processor
    solver: str
    python: str
    machine: str


def this_origin() -> Origin:
    """Program, libraries and machine of this process."""
    from tactgen.fem.solvers.linear_solver import available_solver

    return Origin(
        program="tactgen",
        version=_version("tactgen"),
        code=source_digest(_CODE),
        commit=_commit(),
        libraries={name: _version(name) for name in LIBRARIES},
        solver=available_solver(),
        python=platform.python_version(),
        machine=f"{platform.system()} {platform.machine()}",
    )


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _commit() -> str:
    here = Path(__file__).resolve()
    try:
        # installed or unpacked inside of another project's repository, it is not of that commit
        _git(here.parent, "ls-files", "--error-unmatch", here.name)
        # tags are left out and the length is stated: both would depend on the clone
        return _git(here.parent, "describe", "--always", "--dirty", "--exclude=*", "--abbrev=12")
    except (OSError, subprocess.SubprocessError):
        return "installed without its repository"


def _git(folder: Path, *asked: str) -> str:
    done = subprocess.run(
        ["git", "-C", str(folder), *asked], capture_output=True, text=True, timeout=10, check=True
    )
    return done.stdout.strip()
