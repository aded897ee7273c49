"""Commands under bad circumstances: nothing half-written, nothing wrong trusted.

Each trial spoils one thing, lets the command end, looks at what it left, and runs it again
undisturbed on the same store and folder, which must give what an undisturbed run gives.
"""

from __future__ import annotations

import math
import os
import random
import resource
import shutil
import signal
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from tactgen.geometry.store.store import kept, recalled
from tactgen.validation.checks.stress import Asked
from tactgen.validation.checks.stress.answers import Family
from tactgen.validation.checks.stress.faults.commands import (
    DRAFT,
    HEAVY,
    LIGHT,
    MEASURED,
    Command,
    Ended,
    Surroundings,
    answer,
    before_us,
    begin,
    finish,
    half_written,
    said,
)
from tactgen.validation.checks.stress.result import Row, Stress, answered

_STATEMENT = (
    "A point is one run of a command, spoilt, and the same run again undisturbed: it counts as "
    "wrong if a file was half-written, if the second run's answer is not that of an undisturbed "
    "one, if words are not ours, or if it never ends. What is refused is quoted."
)
#: Codes with which a command may end that was not allowed to do its work.
_REFUSED, _INTERRUPTED, _TERMINATED, _PIPE = 2, 130, 143, 141
#: A place where no file can be made, even by root.
_NOWHERE = "/proc/tactgen"
_GIB = 2**30
_CODE = (
    "tactgen.validation.command_line.cli", "tactgen.validation.models",
    "tactgen.validation.catalogue", "tactgen.fem", "tactgen.tmm",
)  # fmt: skip
_KIND = "stress.faults"


class Trials:
    """The undisturbed runs of the commands, and the folders of the spoilt ones."""

    def __init__(self, commands: Sequence[Command], folder: Path, seed: int) -> None:
        self.commands, self.folder, self.chance = commands, folder, random.Random(seed)
        self.measured = folder / "measured.csv"
        self.measured.write_text(MEASURED, encoding="utf-8")
        self.count = 0
        self.right: dict[str, Any] = {}
        self.seconds: dict[str, float] = {}
        self.files: dict[str, list[str]] = {}
        self.stores: dict[str, Path] = {}
        for command in commands:
            around, started = self.place(), time.perf_counter()
            self.stores[command.name] = around.store
            done = finish(begin(command, around))
            self.seconds[command.name] = time.perf_counter() - started
            assert done.code == 0, f"{command.name} undisturbed: {done.err}"
            self.right[command.name] = answer(command, done)
            self.files[command.name] = _names(around.out)

    def place(self) -> Surroundings:
        """Return an own folder and an own store."""
        self.count += 1
        out = self.folder / f"{self.count}"
        out.mkdir()
        return Surroundings(out, self.folder / f"{self.count}.store", self.measured)

    def judge(
        self, command: Command, around: Surroundings, done: Ended, codes: Sequence[int]
    ) -> str:
        """Return what is wrong after a spoilt run, nothing if all is right."""
        ours, _ = said(done)
        if done.code not in codes:
            return f"ended with {done.code}: {done.err[-200:]}"
        if not ours:
            return f"said {done.err[-200:]}"
        left = half_written(around.out)
        if left:
            return f"half-written: {', '.join(left)}"
        if done.code == 0:  # it did its work all the same: that is what is looked at
            return self.compared(command, around, done)
        return self.again(command, around)

    def again(self, command: Command, around: Surroundings) -> str:
        """Run a command undisturbed where it was spoilt; return what is wrong then."""
        out = around.out if command.overwrites else self.place().out
        around = Surroundings(out, around.store, self.measured)
        done = finish(begin(command, around))
        if done.code != 0:
            return f"afterwards it ended with {done.code}: {done.err[-200:]}"
        return self.compared(command, around, done)

    def compared(self, command: Command, around: Surroundings, done: Ended) -> str:
        """Return what sets a run that did its work apart from an undisturbed one."""
        if answer(command, done) != self.right[command.name]:
            return "the answer is another"
        missing = set(self.files[command.name]) - set(_names(around.out))
        if missing or half_written(around.out):
            return f"not all files are there: {sorted(missing)}"
        drafts = [p.name for p in around.out.rglob(f"{DRAFT}*")]
        return f"drafts were left: {drafts}" if drafts else ""


def _names(folder: Path) -> list[str]:
    return sorted(
        str(p.relative_to(folder)) for p in folder.rglob("*") if not p.name.startswith(DRAFT)
    )


def _add(family: Family, where: str, wrong: str, done: Ended | None = None) -> None:
    if done is not None and done.code == _REFUSED:
        family.refusals.append(said(done)[1])
    family.add(f"{where}{': ' if wrong else ''}{wrong}", math.inf if wrong else 0.0, 0.0)


def killed(trials: Trials, times: int) -> Row:
    """Kill commands at random moments, by SIGKILL."""
    return _ended_by(trials, times, signal.SIGKILL, "killed (SIGKILL)", (-signal.SIGKILL, 0))


def terminated(trials: Trials, times: int) -> Row:
    """Tell commands to end at random moments, by SIGTERM."""
    codes = (_TERMINATED, -signal.SIGTERM, 0)  # the latter before the program has begun
    return _ended_by(trials, times, signal.SIGTERM, "told to end (SIGTERM)", codes)


def interrupted(trials: Trials, times: int) -> Row:
    """Interrupt commands at random moments, as Ctrl-C does: by SIGINT."""
    codes = (_INTERRUPTED, -signal.SIGINT, 0)
    return _ended_by(trials, times, signal.SIGINT, "interrupted (SIGINT)", codes)


def _ended_by(trials: Trials, times: int, number: int, name: str, codes: Sequence[int]) -> Row:
    family = Family()
    for turn in range(times):
        command = trials.commands[turn % len(trials.commands)]
        around = trials.place()
        moment = trials.chance.random() * trials.seconds[command.name]
        done = finish(begin(command, around), after=moment, end=number)
        if before_us(done):
            done = Ended(-number, "", "")
        wrong = trials.judge(command, around, done, codes)
        _add(family, f"{command.name} after {moment:.2f} s", wrong)
    what = f"{times} runs of {len(trials.commands)} commands, at random moments"
    return answered(f"faults: {name}", what, family.points, family.refusals)


def no_room(trials: Trials) -> Row:
    """Let no file grow beyond some bytes, as on a full disk."""
    family = Family()
    for command in trials.commands:
        for size in (0, 300):
            around = replace(trials.place(), limit=(resource.RLIMIT_FSIZE, size))
            done = finish(begin(command, around))
            wrong = trials.judge(command, around, done, (0, _REFUSED))
            _add(family, f"{command.name}, files of {size} bytes", wrong, done)
    what = "files of at most 0 and 300 bytes"
    return answered("faults: no room on the disk", what, family.points, family.refusals)


def read_only(trials: Trials) -> Row:
    """Let neither store nor output folder be writable."""
    family = Family()
    for command in trials.commands:
        spoilt = replace(trials.place(), store=Path(_NOWHERE))
        done = finish(begin(command, spoilt))
        _add(family, f"{command.name}, store", trials.judge(command, spoilt, done, (0,)), done)
        if "{out}" in " ".join(command.arguments):
            done = finish(begin(command, replace(spoilt, out=Path(_NOWHERE))))
            ours, _ = said(done)
            wrong = "" if done.code == _REFUSED and ours else f"ended with {done.code}: {done.err}"
            _add(family, f"{command.name}, folder", wrong, done)
    what = "a store and a folder in which no file can be made"
    return answered("faults: read-only places", what, family.points, family.refusals)


def nobody(trials: Trials) -> Row:
    """Take HOME away, or let it name nothing."""
    family = Family()
    homes = (None, "", "/nonexistent")
    for turn in range(max(len(homes), len(trials.commands))):
        command = trials.commands[turn % len(trials.commands)]
        home = homes[turn % len(homes)]
        around = trials.place()
        spoilt = replace(around, variables={"HOME": home, "TACTGEN_CACHE": None})
        done = finish(begin(command, spoilt))
        wrong = trials.judge(command, around, done, (0,))
        _add(family, f"{command.name}, HOME={home}", wrong, done)
    return answered("faults: no home", "HOME missing, empty, not there", family.points)


def shut_pipe(trials: Trials) -> Row:
    """Close the other end of stdout before anything is written."""
    family = Family()
    for command in trials.commands:
        around = trials.place()
        read, write = os.pipe()
        os.close(read)
        process = begin(command, around, stdout=write)
        os.close(write)
        done = finish(process)
        wrong = trials.judge(command, around, done, (0, _PIPE, _REFUSED))
        _add(family, command.name, wrong)
    return answered("faults: closed pipe", "stdout into a pipe that nobody reads", family.points)


def little_memory(trials: Trials) -> Row:
    """Let a process have 1 GiB of address space."""
    family = Family()
    for command in trials.commands:
        around = replace(trials.place(), limit=(resource.RLIMIT_AS, _GIB))
        done = finish(begin(command, around))
        wrong = trials.judge(command, around, done, (0, _REFUSED))
        _add(family, command.name, wrong, done)
    what = "1 GiB of address space: an answer, or a sentence"
    return answered("faults: little memory", what, family.points, family.refusals)


def two_at_once(trials: Trials) -> Row:
    """Start a command twice at once, with one store and one folder."""
    family = Family()
    for command in trials.commands:
        around = trials.place()
        pair = [finish(process) for process in [begin(command, around) for _ in range(2)]]
        for number, done in enumerate(pair, start=1):
            wrong = ""
            if done.code == 0:
                wrong = trials.compared(command, around, done)
            elif done.code != _REFUSED or not said(done)[0]:
                wrong = f"ended with {done.code}: {done.err[-200:]}"
            _add(family, f"{command.name}, number {number}", wrong, done)
        if any(done.code for done in pair):
            _add(family, f"{command.name}, both", trials.again(command, around))
    what = "the same command twice on one store and one folder"
    return answered("faults: two at once", what, family.points, family.refusals)


def corrupted(trials: Trials, times: int) -> Row:
    """Flip a bit, cut, empty or swap entries of the store."""
    family = Family()
    for turn in range(times):
        command = trials.commands[turn % len(trials.commands)]
        around = trials.place()
        if trials.stores[command.name].exists():  # some commands keep nothing
            shutil.copytree(trials.stores[command.name], around.store)
        entries = sorted(around.store.rglob("*.kept"))
        how = trials.chance.choice(("bit", "cut", "empty", "swapped"))
        for path in entries:
            _spoil(path, trials.chance.choice(entries), how, trials.chance)
        wrong = trials.again(command, around)
        _add(family, f"{command.name}, {len(entries)} entries, {how}", wrong)
    what = "every entry with a bit flipped, cut, emptied, or another's content"
    return answered("faults: corrupted store", what, family.points, family.refusals)


def _spoil(path: Path, other: Path, how: str, chance: random.Random) -> None:
    content = bytearray(path.read_bytes())
    if how == "bit" and content:
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    elif how == "cut":
        del content[len(content) // 2 :]
    elif how == "swapped":
        content = bytearray(other.read_bytes())
    path.write_bytes(b"" if how == "empty" else bytes(content))


def run(asked: Asked) -> Stress:
    """Run all families: half a minute if quick, else some twenty."""
    started = time.perf_counter()
    # kept together: how long the undisturbed runs take steers all that follows
    rows = asked.keep((asked.quick,), lambda: _rows(asked))
    keep_rows(rows, quick=asked.quick)
    return Stress("faults", _STATEMENT, rows, (), (), time.perf_counter() - started)


def _rows(asked: Asked) -> tuple[Row, ...]:
    with tempfile.TemporaryDirectory(prefix="tactgen-faults-") as folder:
        asked.announce("faults: undisturbed runs")
        commands = LIGHT if asked.quick else (*LIGHT, *HEAVY)
        trials = Trials(commands, Path(folder), asked.seed)
        rows = []
        for family in _families(asked.quick):
            asked.announce("faults: more")
            rows.append(family(trials))
            asked.announce(rows[-1].family)
    return tuple(rows)


def _families(quick: bool) -> tuple[Callable[[Trials], Row], ...]:
    times = 6 if quick else 60
    return (
        lambda trials: killed(trials, times),
        lambda trials: terminated(trials, times // 2),
        lambda trials: interrupted(trials, times // 2),
        lambda trials: corrupted(trials, times // 2),
        no_room, read_only, two_at_once, little_memory, shut_pipe, nobody,
    )  # fmt: skip


def keep_rows(rows: tuple[Row, ...], *, quick: bool) -> None:
    """Keep what a run found for the verification book, in place of what an earlier one did."""
    kept(_KIND, (quick,), _CODE, lambda: rows, serves=lambda _: False)


def kept_rows() -> tuple[Row, ...]:
    """Return what this very code was last found to do, of a full run if there was one."""
    for quick in (False, True):
        rows: tuple[Row, ...] | None = recalled(_KIND, (quick,), _CODE)
        if rows is not None:
            return rows
    return ()
