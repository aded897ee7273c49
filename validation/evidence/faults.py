"""Commands under bad circumstances: nothing half-written, nothing wrong trusted.

Each trial spoils one thing, lets the command end, looks at what it left, and runs it again
undisturbed on the same store and folder, which must give what an undisturbed run gives.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import random
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import cached_result, stored_result
from tactgen.validation.evidence.judgement import Family, Judged, Row, rows
from tactgen.validation.evidence.stress import RULE
from tactgen.validation.evidence.verification import ENGINE

#: Seconds after which a process is taken for endless.
ENDLESS = 300.0
#: How the names of drafts begin, which a killed process leaves and the next one sweeps.
DRAFT = ".tactgen-"


@dataclass(frozen=True)
class Command:
    """A command that writes."""

    #: What it is called in the table, and its words, with ``{out}`` for the folder that it writes
    #: to, and ``{measured}`` for a file to read
    name: str
    line: str
    #: Key of what must be the same in its JSON on stdout whatever happened before; empty where it
    #: prints none
    answer: str = ""
    #: Whether it writes over what is there; else it is run again for another folder
    overwrites: bool = True


#: A measured curve for those that want one: a resonator of 782 Hz and Q 12, as its file.
MEASURED = "frequency (Hz),velocity (mm/s)\n" + "".join(
    f"{f},{22.8 / math.hypot(1.0, 12.0 * (f / 782.0 - 782.0 / f)):.4g}\n"
    for f in range(600, 1000, 40)
)
_SOLVED = "--quantity static_tip_displacement --quantity short_circuit_frequencies --json"
_STATIC = "--model lumped --quantity static_tip_displacement"
_COARSE = "--set mesh.level=2"
_QUICK = "--set models=tmm --set modes=1"
#: The light ones take a second each.
LIGHT = (
    Command("init", "init {out}/scene.toml", overwrites=False),
    Command("whatif", "whatif prototype --model tmm --vary bimorph.length=13mm:15mm:3 "
            "--quantity static_tip_displacement --out {out}/study", overwrites=False),
    Command("solve, beam", f"solve prototype --model beam {_SOLVED}", "quantities"),
)  # fmt: skip
HEAVY = (
    Command("solve, solid", f"solve j1 --model solid {_COARSE} {_SOLVED}", "quantities"),
    Command("export, CAD", "export paper --step {out}/a.step --glb {out}/a.glb"),
    Command("export, ports", f"export j1 {_COARSE} --ports {{out}}/a.npz --mesh {{out}}/a.vtu"),
    Command("export, map", "export reluctance --set models=network --map {out}/a.nc"),
    Command("verify", "verify --only beams --quick --out {out}/book"),
    Command("coverage", "coverage --only beam --devices 2 --seed 1 --out {out}/c"),
    Command("stress", "stress --only tmm --quick --out {out}/s"),
    Command("export, states", f"export j1 {_COARSE} --state-space {{out}}/a.npz"),
    Command("export, fields",
            f"export j1 {_QUICK} --fields {{out}}/a.vtu --animated-glb {{out}}/a.glb"),
    Command("export, machine", "export generator --machine {out}/a.npz --fmu {out}/a.fmu"),
    Command("view", f"view j1 {_QUICK} --out {{out}}/a.html"),
    Command("simulate", "simulate paper --set load.kind=none --voltage '10 V sine 200 Hz' --until "
            "'50 us' --accuracy 0.2 --out {out}/a.nc --plot {out}/a.svg"),
    Command("identify", "identify {measured} --plot {out}/a.svg --write {out}/a.toml --json",
            "parameters", overwrites=False),
    Command("compare", f"compare prototype paper {_STATIC} --out {{out}}/c"),
    Command("positions", "positions generator --model network --current 0:140mA:8 "
            "--csv {out}/a.csv --plot {out}/a.svg"),
    Command("backbone", "backbone prototype --set support.kind=contact --set coil.current=0mA "
            "--voltage 0.2 --frequency 700:800 --model lumped --plot {out}/a.svg"),
    Command("sensitivity", f"sensitivity prototype {_STATIC} --key bimorph.length --json"),
    Command("cache", "cache --clear --json"),
    Command("bill", "bill display --json"),
    Command("plan", "plan prototype --json"),
    Command("bench", "bench --only tmm --quick --out {out}/b"),
    Command("design", "design --lengths 20mm:22mm --plot {out}/a.svg"),
    Command("report", "report prototype --quick --model lumped --set frequency=10:900:3 "
            "--out {out}/report"),
)  # fmt: skip


@dataclass(frozen=True)
class Surroundings:
    """Where a command runs."""

    #: Folder to write to, that of the store, and a file to read
    out: Path
    store: Path
    measured: Path
    #: Of the environment, None to take one away
    variables: Mapping[str, str | None] = field(default_factory=dict)
    #: Name of a resource (``RLIMIT_...``) and the most of it
    limit: tuple[str, int] | None = None


class Ended(NamedTuple):
    """Exit of a process: code (negative for a signal) and output."""

    code: int
    out: str = ""
    err: str = ""


def begin(command: Command, around: Surroundings, **streams: Any) -> subprocess.Popen[str]:
    """Start a command as a process of its own."""
    words = [
        word.format(out=around.out, measured=around.measured) for word in shlex.split(command.line)
    ]
    variables = {**os.environ, "TACTGEN_CACHE": str(around.store), **around.variables}
    process = subprocess.Popen(
        [sys.executable, "-m", "tactgen", *words],
        env={name: value for name, value in variables.items() if value is not None},
        stdin=subprocess.DEVNULL, text=True, encoding="utf-8", start_new_session=True,
        **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams},
    )  # fmt: skip
    if around.limit is not None:  # long before Python has read its first module
        import resource

        name, most = around.limit
        resource.prlimit(process.pid, getattr(resource, name), (most, most))
    return process


def finish(
    process: subprocess.Popen[str], after: float | None = None, end: int = signal.SIGKILL
) -> Ended:
    """Wait for a process; after so many seconds (if it still runs) it gets a signal.

    A process that hangs is killed and has no code of its own: it counts as endless.
    """
    try:
        out, err = process.communicate(timeout=ENDLESS if after is None else after)
    except subprocess.TimeoutExpired:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, end)  # and all that it started
        if after is not None:
            return finish(process)
        process.communicate()
        return Ended(124, "", "endless")
    return Ended(process.returncode, out or "", err or "")


def _files(folder: Path) -> dict[str, Path]:
    """Files below a folder by their names; drafts have no name of ours yet."""
    files = (p for p in folder.rglob("*") if p.is_file() and not p.name.startswith(DRAFT))
    return {str(path.relative_to(folder)): path for path in sorted(files)}


def half_written(folder: Path) -> list[str]:
    """Files below a folder that are not whole."""
    return [name for name, path in _files(folder).items() if not _whole(path)]


def _whole(path: Path) -> bool:
    content = path.read_bytes()
    try:
        return bool(content) and _ENDS.get(path.suffix, bool)(content)
    except (ValueError, IndexError):  # the latter where a header is cut short
        return False


def _netcdf(content: bytes) -> bool:
    """Whether all that a classic netCDF file says it holds is there."""
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
    ".npz": lambda content: zipfile.is_zipfile(io.BytesIO(content)),
    ".fmu": lambda content: zipfile.is_zipfile(io.BytesIO(content)),
    ".nc": _netcdf,
}


def answer(command: Command, done: Ended) -> Any:
    """Answer of a command without its timings."""
    if not command.answer:
        return None
    found = json.loads(done.out)[command.answer]
    return [{k: v for k, v in entry.items() if k != "seconds"} for entry in found]


def said(done: Ended) -> tuple[bool, str]:
    """Whether a process speaks as a command should, and its refusal (empty if it has none).

    No traceback; and a refusal (code 2) is a sentence of the program's own.
    """
    own = [line for line in done.err.splitlines() if line.startswith("tactgen: ")]
    refusals = [x for x in own if not x.startswith(("tactgen: warning", "tactgen: note"))]
    clean = "Traceback" not in done.out + done.err
    return clean and (done.code != 2 or bool(refusals)), " ".join(refusals)


#: Codes with which a command may end that was not allowed to do its work.
_REFUSED, _INTERRUPTED, _TERMINATED, _PIPE = 2, 130, 143, 141
#: A place where no file can be made, even by root.
_NOWHERE = Path("/proc/tactgen")
_CODE = ("tactgen.validation.command_line.cli", *ENGINE)
_KIND = "stress.faults"


class Undisturbed(NamedTuple):
    """A command that was let alone: what it answered, how long it took (s), and what it left."""

    answer: Any
    seconds: float
    around: Surroundings


class Trials:
    """The undisturbed runs of the commands, and the folders of the spoilt ones."""

    def __init__(self, commands: Sequence[Command], folder: Path, seed: int) -> None:
        self.commands, self.folder, self.chance = commands, folder, random.Random(seed)
        self.measured = folder / "measured.csv"
        self.measured.write_text(MEASURED, encoding="utf-8")
        self.count = 0
        self.right: dict[str, Undisturbed] = {}
        for command in commands:
            around, started = self.place(), time.perf_counter()
            done = finish(begin(command, around))
            seconds = time.perf_counter() - started
            assert done.code == 0, f"{command.name} undisturbed: {done.err}"
            self.right[command.name] = Undisturbed(answer(command, done), seconds, around)

    def place(self) -> Surroundings:
        """Own folder and an own store."""
        self.count += 1
        out = self.folder / f"{self.count}"
        out.mkdir()
        return Surroundings(out, self.folder / f"{self.count}.store", self.measured)

    def judge(
        self, command: Command, around: Surroundings, done: Ended, codes: Sequence[int]
    ) -> str:
        """Faults after a disturbed run, "" if none."""
        if done.code not in codes:
            return f"ended with {done.code}: {done.err[-200:]}"
        if not said(done)[0]:
            return f"said {done.err[-200:]}"
        if left := half_written(around.out):
            return f"half-written: {', '.join(left)}"
        if done.code == 0:  # it did its work all the same: that is what is looked at
            return self.compared(command, around, done)
        return self.again(command, around)

    def again(self, command: Command, around: Surroundings) -> str:
        """Run a command again after a disturbance; return the faults."""
        out = around.out if command.overwrites else self.place().out
        around = Surroundings(out, around.store, self.measured)
        done = finish(begin(command, around))
        if done.code != 0:
            return f"afterwards it ended with {done.code}: {done.err[-200:]}"
        return self.compared(command, around, done)

    def compared(self, command: Command, around: Surroundings, done: Ended) -> str:
        """Differences of a run from an undisturbed one."""
        right = self.right[command.name]
        if answer(command, done) != right.answer:
            return "the answer is another"
        missing = _files(right.around.out).keys() - _files(around.out)
        if missing or half_written(around.out):
            return f"not all files are there: {sorted(missing)}"
        drafts = [p.name for p in around.out.rglob(f"{DRAFT}*")]
        return f"drafts were left: {drafts}" if drafts else ""


#: Points of a family: where, what is wrong (nothing if all is right), and how the process ended
#: where its refusal is quoted.
Points: TypeAlias = Iterator[tuple[str, str, Ended | None]]


def ended_by(number: int, codes: Sequence[int], share: int = 1) -> Callable[[Trials, int], Points]:
    """Runner that ends commands at random moments by a signal, in one of `share` turns."""

    def run(trials: Trials, times: int) -> Points:
        for turn in range(times // share):
            command = trials.commands[turn % len(trials.commands)]
            around = trials.place()
            moment = trials.chance.random() * trials.right[command.name].seconds
            done = finish(begin(command, around), moment, number)
            # Ctrl-C met Python while it was loading itself: its words then, not ours
            if done.code == 1 and "KeyboardInterrupt" in done.err and "tactgen" not in done.err:
                done = Ended(-number)
            wrong = trials.judge(command, around, done, codes)
            yield f"{command.name} after {moment:.2f} s", wrong, None

    return run


def corrupted(trials: Trials, times: int) -> Points:
    """Flip a bit, cut, empty or swap entries of the store."""
    for turn in range(times // 2):
        command = trials.commands[turn % len(trials.commands)]
        around = trials.place()
        store = trials.right[command.name].around.store
        if store.exists():  # some commands cache nothing
            shutil.copytree(store, around.store)
        entries = sorted(around.store.rglob("*.kept"))
        how = trials.chance.choice(("bit", "cut", "empty", "swapped"))
        for path in entries:
            _spoil(path, trials.chance.choice(entries), how, trials.chance)
        wrong = trials.again(command, around)
        yield f"{command.name}, {len(entries)} entries, {how}", wrong, None


def in_each(codes: Sequence[int], *changes: dict[str, Any]) -> Callable[[Trials, int], Points]:
    """Runner of all commands in each of the changed surroundings, ended by one of the codes."""

    def run(trials: Trials, _: int) -> Points:
        for command, change in product(trials.commands, changes):
            around = replace(trials.place(), **change)
            done = finish(begin(command, around))
            how = " ".join(str(value) for value in change.values())
            yield f"{command.name}, {how}", trials.judge(command, around, done, codes), done

    return run


def no_folder(trials: Trials, _: int) -> Points:
    """Let the folder to write to be one in which no file can be made."""
    for command in trials.commands:
        if "{out}" in command.line:
            spoilt = replace(trials.place(), store=_NOWHERE, out=_NOWHERE)
            done = finish(begin(command, spoilt))
            yield command.name, _refused(done), done


def _refused(done: Ended) -> str:
    """Faults of a process that was to refuse, "" if none."""
    right = done.code == _REFUSED and said(done)[0]
    return "" if right else f"ended with {done.code}: {done.err[-200:]}"


def two_at_once(trials: Trials, _: int) -> Points:
    """Start a command twice at once, with one store and one folder."""
    for command in trials.commands:
        around = trials.place()
        pair = [finish(process) for process in [begin(command, around) for _ in range(2)]]
        for number, done in enumerate(pair, start=1):
            wrong = trials.compared(command, around, done) if done.code == 0 else _refused(done)
            yield f"{command.name}, number {number}", wrong, done
        if any(done.code for done in pair):
            yield f"{command.name}, both", trials.again(command, around), None


def shut_pipe(trials: Trials, _: int) -> Points:
    """Close the other end of stdout before anything is written."""
    for command in trials.commands:
        around = trials.place()
        read, write = os.pipe()
        os.close(read)
        process = begin(command, around, stdout=write)
        os.close(write)
        done = finish(process)
        yield command.name, trials.judge(command, around, done, (0, _PIPE, _REFUSED)), None


#: Faults by name: what is spoilt, and what runs the trials.
_FAULTS: dict[str, tuple[str, Callable[[Trials, int], Points]]] = {
    "killed (SIGKILL)": ("at random moments", ended_by(signal.SIGKILL, (-signal.SIGKILL, 0))),
    # before the program has begun its code is the signal's
    "told to end (SIGTERM)": ("at random moments",
                              ended_by(signal.SIGTERM, (_TERMINATED, -signal.SIGTERM, 0), 2)),
    "interrupted (SIGINT)": ("at random moments",
                             ended_by(signal.SIGINT, (_INTERRUPTED, -signal.SIGINT, 0), 2)),
    "corrupted store": ("every entry with a bit flipped, cut, emptied, or another's content",
                        corrupted),
    "no room on the disk": ("files of at most 0 and 300 bytes",
                            in_each((0, _REFUSED), {"limit": ("RLIMIT_FSIZE", 0)},
                                    {"limit": ("RLIMIT_FSIZE", 300)})),
    "read-only store": ("one in which no file can be made", in_each((0,), {"store": _NOWHERE})),
    "read-only folder": ("one in which no file can be made", no_folder),
    "two at once": ("the same command twice on one store and one folder", two_at_once),
    "little memory": ("1 GiB of address space: an answer, or a sentence",
                      in_each((0, _REFUSED), {"limit": ("RLIMIT_AS", 2**30)})),
    "closed pipe": ("stdout into a pipe that nobody reads", shut_pipe),
    "no home": ("HOME missing, empty, not there",
                in_each((0,), *({"variables": {"HOME": home, "TACTGEN_CACHE": None}}
                                for home in (None, "", "/nonexistent")))),
}  # fmt: skip


def _spoil(path: Path, other: Path, how: str, chance: random.Random) -> None:
    content = bytearray(path.read_bytes())
    if how == "bit" and content:
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    elif how == "cut":
        del content[len(content) // 2 :]
    elif how == "swapped":
        content = bytearray(other.read_bytes())
    path.write_bytes(b"" if how == "empty" else bytes(content))


def judge(family: Family, quick: bool) -> None:
    """Put all commands under all faults: half a minute if quick, else some twenty.

    Raises InputError where the system is not Linux, whose limits are set.
    """
    if sys.platform != "linux":
        raise InputError("the part faults runs on Linux only; choose other parts with --only")
    with tempfile.TemporaryDirectory(prefix="tactgen-faults-") as folder:
        family.announce("faults: undisturbed runs")
        commands = LIGHT if quick else (*LIGHT, *HEAVY)
        trials = Trials(commands, Path(folder), family.seed)
        for name, (what, run_family) in _FAULTS.items():
            family.announce(f"faults: {name}")
            row = f"{name}: {len(commands)} commands, {what}"
            for where, wrong, done in run_family(trials, 6 if quick else 60):
                if done is not None and done.code == _REFUSED:
                    family.refuse(said(done)[1], of=row)
                place = f"{where}: {wrong}" if wrong else where
                family.add(place, math.inf if wrong else 0.0, 0.0, of=row)
    # and once more for the verification book, whatever the seed
    cached_result(_KIND, (quick,), _CODE, lambda: family.answers, serves=lambda _: False)


#: All together: how long the undisturbed runs take steers all that follows.
FAMILIES = {"faults": judge}


def cached_rows() -> list[Row]:
    """Cached rows of this very code, of a full run if there was one."""
    for quick in (False, True):
        answers: list[Judged] | None = stored_result(_KIND, (quick,), _CODE)
        if answers is not None:
            return rows(answers, RULE)
    return []
