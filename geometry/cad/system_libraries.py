"""System libraries and memory that Python packages need.

Looked for before the import that would otherwise fail with a traceback, or crash.
"""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path

from tactgen.geometry.errors import InputError

#: Debian package of each library.
_PACKAGE = {"libGL.so.1": "libgl1", "libOSMesa.so.8": "libosmesa6"}

#: Address space that cadquery and what it imports take (bytes), measured with release 2.6.
_KERNEL = 1_000_000_000


def require_library(name: str, purpose: str) -> None:
    """Make sure that a shared library of Linux can be loaded.

    Raises InputError if not, with the command that installs it.
    """
    if sys.platform != "linux":  # the names are those of Linux; elsewhere the system has OpenGL
        return
    import ctypes

    try:
        ctypes.CDLL(name)
    except OSError:
        raise InputError(
            f"{purpose} need the library {name}, which is missing; install it with "
            f"apt-get install --no-install-recommends {_PACKAGE[name]}"
        ) from None


def require_package(name: str, purpose: str) -> None:
    """Make sure that a Python package is installed; InputError if not.

    Not every system has a wheel of each.
    """
    from importlib.util import find_spec

    if name not in sys.modules and find_spec(name) is None:
        raise InputError(
            f"{purpose} need the package {name}, which is not installed; install it (pip install "
            f"{name}) if there is one for this system, or ask for another model"
        )


def require_cad_kernel() -> None:
    """Make sure that CAD solids can be made; InputError as the others.

    Where there is too little room the libraries of the kernel fail amid loading, in many ways.
    """
    require_package("cadquery", "CAD solids")
    require_library("libGL.so.1", "CAD solids")
    if "cadquery" not in sys.modules:
        require_room(_KERNEL, "CAD solids")


def require_room(size: int, purpose: str) -> None:
    """Make sure that this process may still take so many bytes of address space.

    Where the system has no such limit, or does not tell, nothing is asked.

    Raises InputError if not, with what is left.
    """
    left = _room()
    if left is not None and left < size:
        raise InputError(
            f"{purpose} need {size / 1e9:.1f} GB of address space, and this process may take "
            f"{max(left, 0) / 1e9:.1f} GB more; raise its limit (ulimit -v) or ask for less"
        )


def _room() -> int | None:
    """Bytes left below the limit, None if there is none or it is not known."""
    with contextlib.suppress(ImportError, OSError):
        import resource

        most, _ = resource.getrlimit(resource.RLIMIT_AS)
        if most != resource.RLIM_INFINITY:
            pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
            return most - pages * os.sysconf("SC_PAGE_SIZE")
    return None
