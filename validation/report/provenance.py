"""The numbers of a report as a file, with the scene and the program that gave them."""

from __future__ import annotations

import datetime as dt
import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import read_text, write_text
from tactgen.validation.engine.answers import quantity_from_json, quantity_json
from tactgen.validation.engine.origin import Origin, this_origin
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.scene import Scene

#: Name of the file, what its first line says it is, and name of the list of checksums.
FILE, FORMAT, SUMS = "report.json", "tactgen report 1", "SHA256SUMS"


@dataclass(frozen=True)
class Record:
    """Record of a report: inputs and results."""

    made_by: Origin  #: The program and the machine
    written: str  #: When, in UTC (ISO 8601)
    scene: dict[str, Any]  #: All values of the scene, in SI units
    tolerances: dict[str, Any]  #: What the scene states of how well a value is known, by key
    inputs: dict[str, str]  #: Files that the scene names, with their SHA-256
    #: As :func:`validation.engine.answers.quantity_json`; no number is null
    quantities: tuple[dict[str, Any], ...]


def recorded(solution: Solution) -> Record:
    """Record of a solution."""
    values = solution.scene.model_dump(mode="json")
    groups = (group.values() for group in values.values() if isinstance(group, dict))
    named = [value for group in groups for value in group if isinstance(value, str)]
    return Record(
        this_origin(),
        dt.datetime.now(dt.UTC).isoformat(timespec="seconds"),
        values,
        {key: asdict(tolerance) for key, tolerance in solution.scene.tolerances.items()},
        {name: checksum(Path(name)) for name in named if Path(name).is_file()},
        tuple(quantity_json(q) for q in solution.quantities),
    )


def record_text(record: Record) -> str:
    """Content of the file."""
    # field by field: asdict of the whole would copy every number of every response
    plain = {field.name: getattr(record, field.name) for field in fields(record)}
    plain["made_by"] = asdict(record.made_by)
    return json.dumps({"format": FORMAT, **plain}, allow_nan=False) + "\n"


def read_record(folder: Path) -> Record:
    """Record beside a report.

    Raises InputError if there is none, or none of this version.
    """
    path = folder / FILE
    try:
        content = json.loads(read_text(path))
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not JSON"
        raise InputError(
            f"{path} cannot be read ({str(reason).lower()}); name a folder that tactgen report "
            "has written"
        ) from None
    if not isinstance(content, dict) or content.pop("format", None) != FORMAT:
        raise InputError(
            f"{path} was written by another version of tactgen, whose reports this one does not "
            "read; reproduce it with the version that wrote it"
        )
    content["made_by"] = Origin(**content["made_by"])
    content["quantities"] = tuple(content["quantities"])
    return Record(**content)


def recorded_scene(record: Record) -> Scene:
    """Scene of a record.

    Raises InputError if a file that it names is gone or has changed.
    """
    for name, digest in record.inputs.items():
        path = Path(name)
        if not path.is_file():
            raise InputError(f"{name}, which the report's scene reads, is gone; put it back there")
        if checksum(path) != digest:
            raise InputError(
                f"{name}, which the report's scene reads, has changed since; put back the file "
                "that it was"
            )
    return Scene.model_validate(record.scene)


def seal(folder: Path, made: Record, pages: Sequence[str]) -> None:
    """Write numbers and checksums beside a report's pages.

    The checksums come last: where they are, the rest is whole.

    Raises InputError if a file cannot be written.
    """
    write_text(folder / FILE, record_text(made))
    lines = [f"{checksum(folder / name)}  {name}\n" for name in (*pages, FILE)]
    write_text(folder / SUMS, "".join(lines))


def checksum(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def check(folder: Path) -> None:
    """Verify the checksums of a folder's files.

    Raises InputError if there is no list, or a file is missing or was altered.
    """
    path = folder / SUMS
    try:
        lines = read_text(path).splitlines()
    except (OSError, ValueError):
        raise InputError(
            f"{folder} has no list of checksums ({SUMS}), so nothing in it can be trusted; name a "
            "folder that tactgen report has written whole"
        ) from None
    listed = [line.partition("  ") for line in lines]
    if not listed or not all(len(digest) == 64 and name for digest, _, name in listed):
        raise InputError(f"{path} is not a list of checksums; write the report again")
    for digest, _, name in listed:
        try:
            same = checksum(folder / Path(name).name) == digest
        except OSError:
            raise InputError(
                f"{folder / name} is missing, though {SUMS} lists it; write the report again"
            ) from None
        if not same:
            raise InputError(
                f"{folder / name} was altered after the report was written (its SHA-256 is not "
                f"that of {SUMS}); take the original, or write the report again"
            )


Verdict = Literal["identical", "within bars", "differs"]


@dataclass(frozen=True)
class Compared:
    """One quantity of one model, then and now."""

    name: str
    model: str
    verdict: Verdict
    #: Largest difference over the largest magnitude; nan where the two cannot be compared
    difference: float
    #: Largest difference over the sum of the two error bars; infinite without bars
    over_bars: float


@dataclass(frozen=True)
class Reproduction:
    """A report that was computed again."""

    scene: str
    rows: tuple[Compared, ...]  #: Every quantity of either run
    elsewhere: tuple[str, ...]  #: What of the machine and the libraries is another than then

    @property
    def holds(self) -> bool:
        """Whether nothing differs beyond its bars."""
        return all(row.verdict != "differs" for row in self.rows)


def reproduce(path: Path, announce: Callable[[str], None]) -> Reproduction:
    """Compute a report (its folder, or a file in it) again, from nothing, and compare it.

    Raises InputError if there is no whole report, if it was altered, or if another version wrote
    it.
    """
    folder = path if path.is_dir() else path.parent
    if not path.exists():
        raise InputError(f"{path} does not exist; name the folder of a report or a file in it")
    check(folder)
    record = read_record(folder)
    here = this_origin()
    made = record.made_by
    if (made.version, made.code) != (here.version, here.code):
        raise InputError(
            f"the report was written by tactgen {made.version} with code {made.code[:12]} (commit "
            f"{made.commit}), and this is {here.version} with code {here.code[:12]}; reproduce it "
            "with the version that wrote it"
        )
    scene = recorded_scene(record)
    with _own_store():
        again = solve(scene, announce=announce)
    then = [quantity_from_json(plain) for plain in record.quantities]
    return Reproduction(scene.name, compared(then, again.quantities), _elsewhere(record, here))


def compared(then: Sequence[Quantity], now: Sequence[Quantity]) -> tuple[Compared, ...]:
    """Every quantity of two runs with the verdict on it."""
    before = {(q.name, q.model): q for q in then}
    after = {(q.name, q.model): q for q in now}
    return tuple(
        _compared(key, before.get(key), after.get(key)) for key in dict.fromkeys([*before, *after])
    )


def _compared(key: tuple[str, str], then: Quantity | None, now: Quantity | None) -> Compared:
    if then is None or now is None or not _alike(then, now):
        return Compared(*key, "differs", np.nan, np.inf)
    known = ~np.isnan(then.value)
    apart = np.abs(now.value - then.value)[known]
    bars = np.broadcast_to(then.error + now.error, then.value.shape)[known]
    size = float(np.max(np.abs(then.value[known]), initial=0.0))
    largest = float(np.max(apart, initial=0.0))
    difference = largest / size if size else largest
    if largest == 0.0:
        return Compared(*key, "identical", 0.0, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(apart == 0.0, 0.0, np.where(bars > 0.0, apart / bars, np.inf))
    worst = float(np.max(shares))
    return Compared(*key, "within bars" if worst <= 1.0 else "differs", difference, worst)


def _alike(then: Quantity, now: Quantity) -> bool:
    """Whether two answers are numbers about the same things."""
    return (
        then.value.shape == now.value.shape
        and then.classes == now.classes
        and then.frequency == now.frequency
        and bool(np.array_equal(np.isnan(then.value), np.isnan(now.value)))
    )


def _elsewhere(record: Record, here: Origin) -> tuple[str, ...]:
    then = record.made_by
    pairs = {
        **{name: (then.libraries.get(name, "none"), v) for name, v in here.libraries.items()},
        "linear solver": (then.solver, here.solver),
        "Python": (then.python, here.python),
        "machine": (then.machine, here.machine),
    }
    return tuple(f"{name}: {a} then, {b} now" for name, (a, b) in pairs.items() if a != b)


@contextmanager
def _own_store() -> Iterator[None]:
    """Let nothing that was kept answer: an empty store for as long as this lasts."""
    before = os.environ.get("TACTGEN_CACHE")
    with tempfile.TemporaryDirectory(prefix="tactgen-") as folder:
        os.environ["TACTGEN_CACHE"] = folder
        try:
            yield
        finally:
            if before is None:
                del os.environ["TACTGEN_CACHE"]
            else:
                os.environ["TACTGEN_CACHE"] = before
