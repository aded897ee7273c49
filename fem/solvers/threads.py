"""How many threads the sparse solver may take: the environment variable TACTGEN_THREADS.

Unset, MKL decides: all cores, or what OMP_NUM_THREADS or MKL_NUM_THREADS say.
"""

from __future__ import annotations

import os

from tactgen.geometry.errors import InputError

VARIABLE = "TACTGEN_THREADS"


def thread_count() -> int | None:
    """Return the number of threads that the environment asks for, None if it does not say.

    Raises
    ------
    InputError
        If that is not a whole number from 1.
    """
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return None
    if not (text.isascii() and text.isdigit() and 1 <= int(text) <= 1024):
        raise InputError(
            f"the environment variable {VARIABLE} is '{text}'; "
            "set it to a whole number of threads from 1 to 1024, or unset it to use all cores"
        )
    return int(text)
