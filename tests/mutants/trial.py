"""Runs tests on a copy of the packages, in a process that ends with them.

The libraries that are no part of the project are imported once, here, and each run is a fork of
this process: what a run imports anew is what may hold a mistake.
"""

import contextlib
import importlib
import os
import resource
import signal
import sys
import time
from pathlib import Path

import pytest

#: Imported before the forks; neither pytest's plugins, which it rewrites, nor the project.
AHEAD = (
    "numpy", "scipy.sparse.linalg", "scipy.optimize", "scipy.integrate", "scipy.interpolate",
    "scipy.special", "scipy.spatial", "scipy.signal", "pydantic", "pint", "jinja2", "skfem",
    "meshio", "matplotlib.pyplot", "cadquery", "pyvista", "rich.console", "mpmath", "SALib",
)  # fmt: skip
#: Most processor time (s) of the run on one mistake: it may have made a loop without end.
SECONDS = 120
#: Longest that such a run may wait (s), however busy the machine is.
LONGEST = 900.0
#: Most memory (bytes) that it may take.
LARGEST = 8 * 2**30


def import_ahead() -> None:
    """Import what every run may need, and fork from there."""
    for name in AHEAD:
        importlib.import_module(name)


class _Chosen:
    """A plugin that runs given tests in their order, and notes which failed."""

    def __init__(self, tests: list[str] | None, notes: Path) -> None:
        self.tests, self.notes = tests, notes

    @pytest.hookimpl(trylast=True)  # the suite itself puts first what takes long
    def pytest_collection_modifyitems(self, items) -> None:
        if self.tests is not None:
            place = {test: number for number, test in enumerate(self.tests)}
            chosen = [item for item in items if item.nodeid in place]
            items[:] = sorted(chosen, key=lambda item: place[item.nodeid])

    def pytest_collectreport(self, report) -> None:
        self._note(report)

    def pytest_runtest_logreport(self, report) -> None:
        self._note(report)

    def _note(self, report) -> None:
        if report.failed:
            with self.notes.open("a", encoding="utf-8") as file:
                file.write(f"{report.nodeid}\n")


def tried(
    copy: Path, tests: list[str] | None, *, first_only: bool = True, folders: tuple[str, ...] = ()
) -> tuple[str, list[str]]:
    """Run tests (None: all there are in the folders) on the packages in `copy`.

    Return "survived" where none fails, "killed" and those that failed, or "undecided" where the
    run took too long before one did.  A test that is no longer there is left out.
    """
    notes = copy.parent / "failed.txt"
    notes.write_text("")
    pid = os.fork()
    if pid == 0:
        try:
            os._exit(_run(copy, tests, notes, folders or ("tests",), first_only=first_only))
        finally:
            os._exit(70)
    code = _waited(pid, LONGEST if first_only else None)
    failed = list(dict.fromkeys(notes.read_text(encoding="utf-8").splitlines()))
    if code in (None, -signal.SIGXCPU) and not failed:
        return "undecided", []
    return ("survived", []) if code in (0, 5) else ("killed", failed or [f"exit code {code}"])


def _run(
    copy: Path, tests: list[str] | None, notes: Path, folders: tuple[str, ...], *, first_only: bool
) -> int:
    """Run pytest in this process, which is a fork, and return its exit code."""
    os.setsid()
    with (copy.parent / "said.txt").open("w") as said:
        os.dup2(said.fileno(), 1)
        os.dup2(said.fileno(), 2)
    if first_only:
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 10))
    resource.setrlimit(resource.RLIMIT_DATA, (LARGEST, LARGEST))
    os.environ["PYTHONPATH"] = str(copy / ".setup")
    sys.path.insert(0, str(copy / ".setup"))
    os.chdir(copy)
    files = folders if tests is None else dict.fromkeys(t.split("::")[0] for t in tests)
    there = [file for file in files if Path(file).exists()]
    if not there:
        return pytest.ExitCode.NO_TESTS_COLLECTED
    options = ["-q", "-p", "no:cacheprovider", f"--basetemp={copy.parent / 'base'}"]
    stop = ["-x"] if first_only else []
    return int(pytest.main([*options, *stop, *there], plugins=[_Chosen(tests, notes)]))


def _waited(pid: int, longest: float | None) -> int | None:
    """Wait for a fork and end what it started; its exit code, None where it took too long."""
    begun, code = time.monotonic(), None
    while longest is None or time.monotonic() - begun < longest:
        ended, status = os.waitpid(pid, os.WNOHANG)
        if ended:
            code = os.waitstatus_to_exitcode(status)
            break
        time.sleep(0.05)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGKILL)
    if code is None:
        os.waitpid(pid, 0)
    return code
