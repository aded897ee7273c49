"""Systems without Unix modules, symbolic links or MKL: the same commands, the same numbers."""

import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tactgen.validation.command_line.cli import main

ROOT = Path(__file__).parent.parent
PACKAGES = ("geometry", "fem", "tmm", "validation")

#: A Python as on Windows: file locks by msvcrt alone, few signals, and no MKL.
BARE = """
import os, signal, subprocess, sys, types
for name in ("fcntl", "resource", "pwd", "termios", "grp"):
    sys.modules[name] = None
for name in ("SIGHUP", "SIGVTALRM", "SIGXCPU", "setitimer", "ITIMER_VIRTUAL"):
    delattr(signal, name)
del os.sched_getaffinity, os.O_NONBLOCK
held = set()
def locking(descriptor, mode, size):
    place = os.fstat(descriptor).st_ino
    if mode == 1 and place in held:
        raise PermissionError
    (held.add if mode == 1 else held.discard)(place)
import ctypes
library = ctypes.CDLL
def without_mkl(name, *more, **options):
    if "mkl" in str(name):
        raise OSError
    return library(name, *more, **options)
ctypes.CDLL = without_mkl
sys.modules["msvcrt"] = types.SimpleNamespace(locking=locking, LK_NBLCK=1, LK_UNLCK=0)
"""
RUN = "from tactgen.validation.command_line.cli import main; sys.exit(main(sys.argv[1:]))"
SOLVE = ("solve", "j1", "--set", "mesh.level=2", "--quantity", "capacitance_free", "--json")


def values(written):
    return {q["model"]: q["value"] for q in json.loads(written)["quantities"]}


def answers(code, path, store, *words):
    done = subprocess.run(
        [sys.executable, "-c", code, *words],
        env={"PYTHONPATH": str(path), "TACTGEN_CACHE": str(store), "PATH": ""},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return values(done.stdout)


def test_without_unix_modules_and_mkl_the_numbers_are_the_same(tmp_path, own_store, capsys):
    """SuperLU rounds in another order: the solid's condition number times epsilon is below 1e-6."""
    words = [*SOLVE, "--model", "tmm", "--model", "solid"]
    assert main(words) == 0
    usual = values(capsys.readouterr().out)
    bare = answers(f"{BARE}\n{RUN}", ROOT / ".setup", tmp_path / "b", *words)
    assert bare == pytest.approx(usual, rel=1e-6)


@pytest.mark.parametrize("package", ["cadquery", "pytetwild"])
def test_a_package_without_a_wheel_is_named_in_one_line(package, monkeypatch, own_store, capsys):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda n: None if n == package else find(n))
    monkeypatch.delitem(sys.modules, package, raising=False)
    assert main([*SOLVE[:-1], "--model", "cad"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert package in line


def test_a_checkout_without_links_is_a_package(tmp_path):
    """Where git cannot make the links, each is a small file with the name of its target."""
    for name in PACKAGES:
        (tmp_path / name).symlink_to(ROOT / name)
        place = tmp_path / ".setup" / "tactgen" / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(f"../../{name}", encoding="utf-8")
    for name in ("__init__.py", "__main__.py"):
        shutil.copy(ROOT / ".setup" / "tactgen" / name, tmp_path / ".setup" / "tactgen" / name)
    found = answers(
        f"import sys; {RUN}", tmp_path / ".setup", tmp_path / "store", *SOLVE, "--model", "tmm"
    )
    assert set(found) == {"tmm"}


def test_the_version_is_that_of_the_installed_package():
    from importlib.metadata import version

    import tactgen

    assert tactgen.__version__ == version("tactgen")
