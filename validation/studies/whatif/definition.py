"""Definition of a study, and its file."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.geometry.units import quoted
from tactgen.validation.scene.conditions import conditions
from tactgen.validation.scene.files import NEUTRAL, OF_THE_COIL
from tactgen.validation.scene.load import checked_scene
from tactgen.validation.scene.variation import ScenesNearby
from tactgen.validation.studies.whatif.axes import MOST, Axis, as_stated, parse_axes

#: Version of the file; another one is refused.
FORMAT = 1
#: Groups of conditions, beside those that every scene has.
_CONDITIONS = ("support", "load", "circuit", "drive")
#: File of the statement in a study's folder.
FILE = "study.json"
#: Dimension of values that go hand in hand, and of those that are drawn.
ZIPPED, DRAWN = "point", "sample"


@dataclass(frozen=True)
class Statement:
    """Definition of a study: a scene, axes, models and quantities."""

    scene: str = ""  #: The scene's name
    #: Its values as they are written, with all overrides
    values: dict[str, Any] = field(default_factory=dict)
    vary: tuple[str, ...] = ()  #: The axes as they are written
    #: By name
    models: tuple[str, ...] = ()
    quantities: tuple[str, ...] = ()
    zipped: bool = False  #: Whether stepped axes go hand in hand instead of being combined
    #: How many samples are drawn (0: none), and from which seed
    samples: int = 0
    seed: int = 1
    #: Whether no model was named, so that the accuracy asked for chooses them
    by_accuracy: bool = False

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """The axes; refusals as :func:`validation.studies.whatif.axes.parse_axes`."""
        return parse_axes(self.vary, sampled=self.samples > 0)

    @cached_property
    def columns(self) -> dict[str, tuple[str, tuple[Any, ...]]]:
        """Of each axis by key: the dimension that it lies along, and its values.

        Raises InputError if axes that go hand in hand differ in length.
        """
        found = {}
        for axis in self.axes:
            if axis.drawn is not None:
                drawn = axis.drawn.draw(self.samples, self.seed, axis.key)
                found[axis.key] = DRAWN, tuple(map(float, drawn))
            else:
                found[axis.key] = ZIPPED if self.zipped else axis.key, axis.values
        sizes = {key: len(values) for key, (along, values) in found.items() if along == ZIPPED}
        if len(set(sizes.values())) > 1:
            listed = ", ".join(f"{key} has {size}" for key, size in sizes.items())
            raise InputError(
                f"--zip takes axes of equal length, but {listed}; give each as many values, or "
                "leave --zip out"
            )
        return found

    @cached_property
    def shape(self) -> dict[str, int]:
        """Dimensions in order, each with its size.

        Raises InputError if they make too many points.
        """
        found = {dimension: len(values) for dimension, values in self.columns.values()}
        if math.prod(found.values()) > MOST:
            raise InputError(
                f"the axes make {math.prod(found.values())} points; ask for at most {MOST}"
            )
        return found

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape.values())

    def point(self, at: dict[str, int]) -> dict[str, Any]:
        """Values of all axes at a place of each dimension."""
        return {key: values[at[dimension]] for key, (dimension, values) in self.columns.items()}

    def points(self) -> Iterator[dict[str, Any]]:
        """Yield the values of all axes at each point; the last dimension runs fastest."""
        for index in itertools.product(*map(range, self.shape.values())):
            yield self.point(dict(zip(self.shape, index, strict=True)))

    def scene_at(self, point: Mapping[str, Any]) -> dict[str, Any]:
        """Values of the scene at a point, as they would be written."""
        return ScenesNearby(self.values).values(as_stated(point))

    @property
    def conditions(self) -> str:
        """Conditions of the study's scene, and which of them the axes vary; "" of none."""
        try:
            scene = checked_scene({**self.values, "models": list(self.models or ("tmm",))})
        except InputError:  # a scene at its points only
            return ""
        told = (*NEUTRAL, *OF_THE_COIL)
        varied = [
            k
            for k in (axis.key for axis in self.axes)
            if k in told or k.partition(".")[0] in _CONDITIONS
        ]
        return conditions(scene) + (f" Varied: {', '.join(varied)}." if varied else "")


def write_statement(folder: Path, statement: Statement) -> Path:
    """Write a study's statement into its folder, whole or not at all."""
    content = {"format": FORMAT, "written_by": f"tactgen {version('tactgen')}", **asdict(statement)}
    return write_text(folder / FILE, json.dumps(content, indent=1, default=str) + "\n")


def read_statement(folder: Path) -> Statement:
    """Statement that a study's folder holds.

    Raises InputError if there is none, or not one of this version.
    """
    path = folder / FILE
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        stated_format = content.get("format")
        if stated_format == FORMAT:
            stated = {f.name: content[f.name] for f in fields(Statement)}
            return TypeAdapter(Statement).validate_python(stated)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(
            f"{folder} holds no study that can be read ({FILE}: {reason}); name a folder that "
            "tactgen whatif --out has written"
        ) from None
    except (ValueError, KeyError, AttributeError):
        raise InputError(
            f"{path} is damaged; state the study again with --vary, its points are kept"
        ) from None
    raise InputError(
        f"{path} has format = {quoted(stated_format)}, and this version reads {FORMAT}; state "
        "the study again with --vary in another folder"
    )
