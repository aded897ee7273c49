"""Measurements in a process of their own, held to one core's worth of threads.

The thread count of numpy's BLAS is read once, at import, from the environment; so a fresh
interpreter is the only way to set it.  Its peak memory is its own, too.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tactgen.fem.solvers.pardiso import VARIABLE
from tactgen.geometry.errors import InputError

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", VARIABLE)


def on_one_core(module: str, function: str, *arguments: Any, python: str = sys.executable) -> Any:
    """Call ``module.function(*arguments)`` alone, with an empty store.

    Arguments and result are JSON values.
    What the call itself prints is not looked at.  `python` may be another interpreter, as
    long as it can import the module.

    Raises InputError if the process ends badly, with the last line that it wrote.
    """
    # another interpreter need not know this package's place
    places = filter(None, [str(Path(__file__).parents[3]), os.environ.get("PYTHONPATH")])
    variables = {**dict.fromkeys(_THREADS, "1"), "PYTHONPATH": os.pathsep.join(places)}
    with tempfile.TemporaryDirectory() as empty:  # what other runs cached takes no time
        done = subprocess.run(
            [python, "-m", __name__, module, function, json.dumps(arguments)],
            env={**os.environ, **variables, "TACTGEN_CACHE": empty},
            capture_output=True, text=True, check=False,
        )  # fmt: skip
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise InputError(
            f"the measurement {function} could not be finished ({last}); free some memory, or "
            "ask for less with --quick"
        )
    return json.loads(done.stdout.splitlines()[-1])


def peak_memory() -> int:
    """Largest resident size of this process so far, in bytes.

    Where there is /proc, from there: getrusage counts what the parent had before exec.
    """
    try:
        import resource
    except ImportError:  # Windows: not known
        return 0
    with contextlib.suppress(OSError):
        return 1024 * _kilobytes("/proc/self/status", "VmHWM:")
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def _keep_within_memory() -> None:
    """Limit this process to the machine's free memory.

    Where there is no /proc nothing is done.
    """
    with contextlib.suppress(ImportError, OSError):
        import resource

        free = _kilobytes("/proc/meminfo", "MemAvailable:")
        mapped = _kilobytes("/proc/self/status", "VmSize:")
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        most = 1024 * (mapped + free)
        if hard != resource.RLIM_INFINITY:
            most = min(most, hard)
        resource.setrlimit(resource.RLIMIT_AS, (most, hard))


def _kilobytes(path: str, key: str) -> int:
    return int(Path(path).read_text("ascii").split(key)[1].split()[0])


if __name__ == "__main__":
    _keep_within_memory()
    _module, _function, _arguments = sys.argv[1:]
    _call = getattr(importlib.import_module(_module), _function)
    _result = json.dumps(_call(*json.loads(_arguments)))
    print(f"\n{_result}")


def least_time(work: Callable[[], Any], repeats: int = 1) -> tuple[float, Any]:
    """Least processor time (s) of several runs, and the last result."""
    least, result = math.inf, None
    for _ in range(repeats):
        started = time.process_time()
        result = work()
        least = min(least, time.process_time() - started)
    return least, result
