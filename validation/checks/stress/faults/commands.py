"""Commands that write, run as processes of their own in surroundings that can be spoilt."""

from __future__ import annotations

import io
import json
import math
import os
import resource
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

#: Seconds after which a process is taken for endless.
ENDLESS = 300.0
#: How the names of drafts begin, which a killed process leaves and the next one sweeps.
DRAFT = ".tactgen-"


@dataclass(frozen=True)
class Command:
    """A command that writes.

    Attributes
    ----------
    name : str
        What it is called in the table.
    arguments : tuple of str
        With ``{out}`` for the folder that it writes to, and ``{measured}`` for a file to read.
    answer : str
        Key of what must be the same in its JSON on stdout whatever happened before; empty
        where it prints none.
    overwrites : bool
        Whether it writes over what is there; else it is run again for another folder.
    """

    name: str
    arguments: tuple[str, ...]
    answer: str = ""
    overwrites: bool = True


#: A measured curve for those that want one: a resonator of 782 Hz and Q 12, as its file.
MEASURED = "frequency (Hz),velocity (mm/s)\n" + "".join(
    f"{f},{22.8 / math.hypot(1.0, 12.0 * (f / 782.0 - 782.0 / f)):.4g}\n"
    for f in range(600, 1000, 40)
)
_SOLVED = (
    "--quantity", "static_tip_displacement", "--quantity", "short_circuit_frequencies", "--json",
)  # fmt: skip
#: The light ones take a second each.
LIGHT = (
    Command("init", ("init", "{out}/scene.toml"), overwrites=False),
    Command(
        "whatif",
        ("whatif", "prototype", "--model", "tmm", "--vary", "bimorph.length=13mm:15mm:3",
         "--quantity", "static_tip_displacement", "--out", "{out}/study"),
        overwrites=False,
    ),
    Command("solve, beam", ("solve", "prototype", "--model", "beam", *_SOLVED), "quantities"),
)  # fmt: skip
HEAVY = (
    Command(
        "solve, solid", ("solve", "j1", "--model", "solid", "--set", "mesh.level=2", *_SOLVED),
        "quantities",
    ),
    Command(
        "export, CAD", ("export", "paper", "--step", "{out}/a.step", "--glb", "{out}/a.glb")
    ),
    Command(
        "export, ports",
        ("export", "j1", "--set", "mesh.level=2", "--ports", "{out}/a.npz", "--mesh",
         "{out}/a.vtu"),
    ),
    Command(
        "export, map",
        ("export", "reluctance", "--set", "models=network", "--map", "{out}/a.nc"),
    ),
    Command("verify", ("verify", "--only", "beams", "--quick", "--out", "{out}/book")),
    Command(
        "coverage",
        ("coverage", "--only", "beam", "--devices", "2", "--seed", "1", "--out", "{out}/c"),
    ),
    Command("stress", ("stress", "--only", "tmm", "--quick", "--out", "{out}/s")),
    Command(
        "export, states",
        ("export", "j1", "--set", "mesh.level=2", "--state-space", "{out}/a.npz"),
    ),
    Command(
        "export, fields",
        ("export", "j1", "--set", "models=tmm", "--set", "modes=1", "--fields", "{out}/a.vtu",
         "--animated-glb", "{out}/a.glb"),
    ),
    Command(
        "export, machine",
        ("export", "generator", "--machine", "{out}/a.npz", "--fmu", "{out}/a.fmu"),
    ),
    Command(
        "view", ("view", "j1", "--set", "models=tmm", "--set", "modes=1", "--out", "{out}/a.html")
    ),
    Command(
        "simulate",
        ("simulate", "paper", "--set", "load.kind=none", "--voltage", "10 V sine 200 Hz", "--until",
         "50 us", "--accuracy", "0.2", "--out", "{out}/a.nc", "--plot", "{out}/a.svg"),
    ),
    Command(
        "identify",
        ("identify", "{measured}", "--plot", "{out}/a.svg", "--write", "{out}/a.toml", "--json"),
        "parameters",
        overwrites=False,
    ),
    Command(
        "compare",
        ("compare", "prototype", "paper", "--model", "lumped", "--quantity",
         "static_tip_displacement", "--out", "{out}/c"),
    ),
    Command(
        "positions",
        ("positions", "generator", "--model", "network", "--current", "0:140mA:8", "--csv",
         "{out}/a.csv", "--plot", "{out}/a.svg"),
    ),
    Command(
        "backbone",
        ("backbone", "prototype", "--set", "support.kind=contact", "--set", "coil.current=0mA",
         "--voltage", "0.2", "--frequency", "700:800", "--model", "lumped", "--plot",
         "{out}/a.svg"),
    ),
    Command(
        "sensitivity",
        ("sensitivity", "prototype", "--model", "lumped", "--quantity", "static_tip_displacement",
         "--key", "bimorph.length", "--json"),
    ),
    Command("cache", ("cache", "--clear", "--json")),
    Command("bill", ("bill", "display", "--json")),
    Command("plan", ("plan", "prototype", "--json")),
    Command("bench", ("bench", "--only", "tmm", "--quick", "--out", "{out}/b")),
    Command("design", ("design", "--lengths", "20mm:22mm", "--plot", "{out}/a.svg")),
    Command(
        "report",
        ("report", "prototype", "--quick", "--model", "lumped", "--set", "frequency=10:900:3",
         "--out", "{out}/report"),
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Surroundings:
    """Where a command runs.

    Attributes
    ----------
    out, store, measured : Path
        Folder to write to, that of the store, and a file to read.
    variables : dict of str to (str or None)
        Of the environment, None to take one away.
    limit : (int, int), optional
        A resource (``resource.RLIMIT_...``) and the most of it.
    """

    out: Path
    store: Path
    measured: Path
    variables: Mapping[str, str | None] = field(default_factory=dict)
    limit: tuple[int, int] | None = None


@dataclass(frozen=True)
class Ended:
    """How a process ended: its code (negative for a signal), and what it said."""

    code: int
    out: str
    err: str


def begin(command: Command, around: Surroundings, **streams: Any) -> subprocess.Popen[str]:
    """Start a command as a process of its own."""
    words = [word.format(out=around.out, measured=around.measured) for word in command.arguments]
    variables = {**os.environ, "TACTGEN_CACHE": str(around.store), **around.variables}
    process = subprocess.Popen(
        [sys.executable, "-m", "tactgen", *words],
        env={name: value for name, value in variables.items() if value is not None},
        stdin=subprocess.DEVNULL, text=True, encoding="utf-8", start_new_session=True,
        **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams},
    )  # fmt: skip
    if around.limit is not None:  # long before Python has read its first module
        what, most = around.limit
        resource.prlimit(process.pid, what, (most, most))
    return process


def finish(process: subprocess.Popen[str], *, after: float | None = None, end: int = 0) -> Ended:
    """Wait for a process; after so many seconds (if it still runs) it gets a signal.

    A process that hangs is killed and has no code of its own: it counts as endless.
    """
    try:
        out, err = process.communicate(timeout=after if after is not None else ENDLESS)
    except subprocess.TimeoutExpired:
        _signal(process, end or signal.SIGKILL)
        try:
            out, err = process.communicate(timeout=ENDLESS)
        except subprocess.TimeoutExpired:
            _signal(process, signal.SIGKILL)
            process.communicate()
            return Ended(124, "", "endless")
        if after is None:
            return Ended(124, out or "", "endless")
    return Ended(process.returncode, out or "", err or "")


def before_us(done: Ended) -> bool:
    """Return whether Ctrl-C met Python while it was loading itself: its words then, not ours."""
    return done.code == 1 and "KeyboardInterrupt" in done.err and "tactgen" not in done.err


def _signal(process: subprocess.Popen[str], number: int) -> None:
    """Signal the process and all that it started."""
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:
        return


def half_written(folder: Path) -> list[str]:
    """Return the files below a folder that are not whole; drafts have no name of ours yet."""
    files = (p for p in folder.rglob("*") if p.is_file() and not p.name.startswith(DRAFT))
    return [str(path.relative_to(folder)) for path in sorted(files) if not _whole(path)]


def _whole(path: Path) -> bool:
    content = path.read_bytes()
    try:
        return bool(content) and _ENDS.get(path.suffix, bool)(content)
    except (ValueError, IndexError):  # the latter where a header is cut short
        return False


def _zip(content: bytes) -> bool:
    return content[:2] == b"PK" and b"PK\x05\x06" in content[-1000:]


def _netcdf(content: bytes) -> bool:
    """Return whether all that a classic netCDF file says it holds is there."""
    from scipy.io import netcdf_file

    if content[:3] != b"CDF":
        return False
    with netcdf_file(io.BytesIO(content), mmap=False) as file:
        return bool(file.variables)


def _parses(load: Callable[[str], Any]) -> Callable[[bytes], bool]:
    return lambda content: load(content.decode()) is not None


_ENDS: dict[str, Callable[[bytes], bool]] = {
    ".json": _parses(json.loads),
    ".toml": _parses(tomllib.loads),
    ".html": lambda content: content.rstrip().endswith(b"</html>"),
    ".svg": lambda content: content.rstrip().endswith(b"</svg>"),
    ".csv": lambda content: content.endswith(b"\n"),
    ".step": lambda content: content.rstrip().endswith(b"END-ISO-10303-21;"),
    ".glb": lambda content: int.from_bytes(content[8:12], "little") == len(content),
    ".vtu": lambda content: content.rstrip().endswith(b"</VTKFile>"),
    ".npz": _zip,
    ".fmu": _zip,
    ".nc": _netcdf,
}


def answer(command: Command, done: Ended) -> Any:
    """Return what a command answered, without what its run took."""
    if not command.answer:
        return None
    found = json.loads(done.out)[command.answer]
    return [{k: v for k, v in entry.items() if k != "seconds"} for entry in found]


def said(done: Ended) -> tuple[bool, str]:
    """Return whether a process speaks as a command should, and its refusal (empty if it has none).

    No traceback; and a refusal (code 2) is a sentence of the program's own.
    """
    own = [line for line in done.err.splitlines() if line.startswith("tactgen: ")]
    refusals = [x for x in own if not x.startswith(("tactgen: warning", "tactgen: note"))]
    clean = "Traceback" not in done.out + done.err
    return clean and (done.code != 2 or bool(refusals)), " ".join(refusals)
