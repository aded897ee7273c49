"""Origin of a number: the program, its code, the libraries, the machine."""

from __future__ import annotations

import importlib.metadata
import platform
import subprocess
from dataclasses import dataclass
from pathlib import Path

from tactgen.geometry.store.values import source_digest

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
