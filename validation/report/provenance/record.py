"""The numbers of a report as a file, with the scene and the program that gave them."""

from __future__ import annotations

import datetime as dt
import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import read_text
from tactgen.validation.engine.answers import quantity_json
from tactgen.validation.engine.origin import Origin, this_origin
from tactgen.validation.engine.solve import Solution
from tactgen.validation.scene.scene import Scene

#: Name of the file, and what its first line says it is.
FILE = "report.json"
FORMAT = "tactgen report 1"


@dataclass(frozen=True)
class Record:
    """What a report was computed from, and what came out.

    Attributes
    ----------
    made_by : Origin
        The program and the machine.
    written : str
        When, in UTC (ISO 8601).
    scene : dict
        All values of the scene, in SI units.
    tolerances : dict
        What the scene states of how well a value is known, by key.
    inputs : dict of str to str
        Files that the scene names, with their SHA-256.
    quantities : tuple of dict
        As :func:`validation.engine.answers.quantity_json`; no number is null.
    """

    made_by: Origin
    written: str
    scene: dict[str, Any]
    tolerances: dict[str, Any]
    inputs: dict[str, str]
    quantities: tuple[dict[str, Any], ...]

    @property
    def name(self) -> str:
        """Name of the scene."""
        return str(self.scene["name"])


def recorded(solution: Solution) -> Record:
    """Return the record of a solution."""
    values = solution.scene.model_dump(mode="json")
    return Record(
        this_origin(),
        dt.datetime.now(dt.UTC).isoformat(timespec="seconds"),
        values,
        {key: asdict(tolerance) for key, tolerance in solution.scene.tolerances.items()},
        {name: _digest(Path(name)) for name in _files(values)},
        tuple(quantity_json(q) for q in solution.quantities),
    )


def record_text(record: Record) -> str:
    """Return the content of the file."""
    # field by field: asdict of the whole would copy every number of every response
    plain = {field.name: getattr(record, field.name) for field in fields(record)}
    plain["made_by"] = asdict(record.made_by)
    return json.dumps({"format": FORMAT, **plain}, allow_nan=False) + "\n"


def read_record(folder: Path) -> Record:
    """Return the record beside a report.

    Raises
    ------
    InputError
        If there is none, or none of this version.
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
    """Return the scene of a record.

    Raises
    ------
    InputError
        If a file that it names is gone or has changed.
    """
    for name, digest in record.inputs.items():
        path = Path(name)
        if not path.is_file():
            raise InputError(f"{name}, which the report's scene reads, is gone; put it back there")
        if _digest(path) != digest:
            raise InputError(
                f"{name}, which the report's scene reads, has changed since; put back the file "
                "that it was"
            )
    return Scene.model_validate(record.scene)


def _files(values: dict[str, Any]) -> Iterator[str]:
    """Yield what a scene's groups name that is a file."""
    for group in values.values():
        if isinstance(group, dict):
            yield from (v for v in group.values() if isinstance(v, str) and Path(v).is_file())


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
