"""fTetWild in a process of its own, which stays for the meshes that follow.

Its libraries take half a second to load: a process that is started before the surface is there
has them when it comes, and the second mesh need not load them again.
"""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.errors import MeshError

_WORKER = Path(__file__).with_name("worker.py")


class Mesher:
    """A process that meshes one surface after another; it ends with the ``with`` block.

    Attributes
    ----------
    meanwhile : callable, optional
        What the caller has to do anyway: called once, while the next surface is meshed.
    spent : float
        Processor time (s) that all meshes have taken so far, less those it died of.
    """

    def __init__(self) -> None:
        self.meanwhile: Callable[[], object] | None = None
        self.spent = 0.0
        self._process: subprocess.Popen[bytes] | None = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    def __enter__(self) -> Mesher:
        """Return itself; nothing is started yet."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End the process and remove its folder."""
        self._end()
        if self._folder is not None:
            self._folder.cleanup()

    def start(self) -> None:
        """Let the process load its libraries while the caller does something else."""
        if self._process is not None:
            return
        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix="tactgen-")
        with (Path(self._folder.name) / "log").open("wb") as log:
            # -P: the folder of the worker holds modules with everyday names; cwd: fTetWild
            # leaves files there when it meets trouble
            self._process = subprocess.Popen(
                [sys.executable, "-P", str(_WORKER)],
                cwd=self._folder.name,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
            )

    def mesh(self, arrays: dict[str, NDArray[Any]], time_limit: float) -> tuple[Floats, Ints]:
        """Return points (n, 3) and corners (m, 4) of what fTetWild makes of the arrays.

        Parameters
        ----------
        arrays : dict of str to array
            As ``worker.py`` wants them.
        time_limit : float
            Processor time (s) after which the process is ended, in whole seconds.

        Raises
        ------
        MeshError
            If the time is up or fTetWild fails.
        """
        self.start()
        assert self._process is not None
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        assert self._folder is not None
        folder = Path(self._folder.name)
        source, target = folder / "surface.npz", folder / "tets.npz"
        np.savez(source, allow_pickle=False, **arrays)
        try:
            self._process.stdin.write(f"{source}\n{target}\n{time_limit}\n".encode())
            self._process.stdin.flush()
        except BrokenPipeError:
            raise self._failed(time_limit) from None
        work, self.meanwhile = self.meanwhile, None
        if work is not None:
            work()
        took = self._process.stdout.readline()
        if not took:
            raise self._failed(time_limit)
        self.spent += float(took)
        with np.load(target) as result:
            return result["points"], result["tets"].astype(np.int64)

    def _failed(self, time_limit: float) -> MeshError:
        """Return what to say of a process that is gone; the next mesh gets a new one."""
        assert self._process is not None
        assert self._folder is not None
        code = self._process.wait()
        self._end()
        if code == -signal.SIGXCPU:
            self.spent += time_limit
            return MeshError(
                f"meshing was not done after {time_limit:.3g} s of processor time; raise the time "
                "limit, or the edge length, or make the thinnest feature thicker"
            )
        log = (Path(self._folder.name) / "log").read_text(errors="replace")
        lines = log.strip().splitlines()
        reason = lines[-1] if lines else f"exit code {code}"
        return MeshError(f"fTetWild failed ({reason}); change the edge length slightly")

    def _end(self) -> None:
        if self._process is None:
            return
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):  # what it was told and did not read
                    pipe.close()
        self._process = None
