"""System libraries that Python packages need but do not bring along.

Looked for before the import that would otherwise fail with a traceback, or crash.
"""

from __future__ import annotations

import ctypes

from tactgen.geometry.errors import InputError

#: Debian package of each library.
_PACKAGE = {"libGL.so.1": "libgl1", "libOSMesa.so.8": "libosmesa6"}


def require_library(name: str, purpose: str) -> None:
    """Make sure that a shared library can be loaded.

    Raises
    ------
    InputError
        If not, with the command that installs it.
    """
    try:
        ctypes.CDLL(name)
    except OSError:
        raise InputError(
            f"{purpose} need the library {name}, which is missing; install it with "
            f"apt-get install --no-install-recommends {_PACKAGE[name]}"
        ) from None
