"""What a study asks, as frozen values and as the file from which it can be gone on with."""

from __future__ import annotations

import copy
import itertools
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.geometry.units import quoted
from tactgen.validation.catalogue.models import MODELS, all_given, gives
from tactgen.validation.catalogue.quantities import QUANTITIES, quantities_of
from tactgen.validation.models.comparison import Choice, choose_for
from tactgen.validation.scene.files import assign, choices
from tactgen.validation.scene.scene import Scene, checked_scene
from tactgen.validation.studies.whatif.axes import MOST, Axis, as_stated, parse_axes

#: Version of the file; another one is refused.
FORMAT = 1
#: File of the statement in a study's folder.
FILE = "study.json"
#: Dimension of values that go hand in hand, and of those that are drawn.
ZIPPED, DRAWN = "point", "sample"


@dataclass(frozen=True)
class Statement:
    """What is asked: a scene, its axes, models and quantities.

    Attributes
    ----------
    scene : str
        The scene's name.
    values : dict
        Its values as they are written, with all overrides.
    vary : tuple of str
        The axes as they are written.
    zipped : bool
        Whether stepped axes go hand in hand instead of being combined.
    samples, seed : int
        How many samples are drawn (0: none), and from which seed.
    models, quantities : tuple of str
        By name.
    by_accuracy : bool
        Whether no model was named, so that the accuracy asked for chooses them.
    """

    scene: str
    values: dict[str, Any]
    vary: tuple[str, ...]
    models: tuple[str, ...]
    quantities: tuple[str, ...]
    zipped: bool = False
    samples: int = 0
    seed: int = 1
    by_accuracy: bool = False

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """The axes; refusals as :func:`validation.studies.whatif.axes.parse_axes`."""
        return parse_axes(self.vary, sampled=self.samples > 0)

    @cached_property
    def columns(self) -> dict[str, tuple[str, tuple[Any, ...]]]:
        """Of each axis by key: the dimension that it lies along, and its values.

        Raises
        ------
        InputError
            If axes that go hand in hand differ in length, or there are too many points.
        """
        stepped = [axis for axis in self.axes if axis.drawn is None]
        if self.zipped:
            sizes = {axis.key: len(axis.values) for axis in stepped}
            if len(set(sizes.values())) > 1:
                listed = ", ".join(f"{key} has {size}" for key, size in sizes.items())
                raise InputError(
                    f"--zip takes axes of equal length, but {listed}; give each as many values, "
                    "or leave --zip out"
                )
        found = {}
        for axis in self.axes:
            if axis.drawn is not None:
                drawn = axis.drawn.draw(self.samples, self.seed, axis.key)
                found[axis.key] = (DRAWN, tuple(float(value) for value in drawn))
            else:
                found[axis.key] = (ZIPPED if self.zipped else axis.key, axis.values)
        return found

    @cached_property
    def shape(self) -> dict[str, int]:
        """Dimensions in order, each with its size.

        Raises
        ------
        InputError
            If they make too many points.
        """
        found = {dimension: len(values) for dimension, values in self.columns.values()}
        count = 1
        for size in found.values():
            count *= size
        if count > MOST:
            raise InputError(f"the axes make {count} points; ask for at most {MOST}")
        return found

    @property
    def size(self) -> int:
        """How many points there are."""
        count = 1
        for size in self.shape.values():
            count *= size
        return count

    def points(self) -> Iterator[dict[str, Any]]:
        """Yield the values of all axes at each point; the last dimension runs fastest."""
        dimensions = list(self.shape)
        for index in itertools.product(*(range(size) for size in self.shape.values())):
            at = dict(zip(dimensions, index, strict=True))
            yield {key: values[at[dimension]] for key, (dimension, values) in self.columns.items()}

    def scene_at(self, point: dict[str, Any]) -> dict[str, Any]:
        """Return the values of the scene at a point, as they would be written."""
        values = copy.deepcopy(self.values)
        for key, value in point.items():
            assign(values, key, as_stated(key, value))
        return values


def write_statement(folder: Path, statement: Statement) -> Path:
    """Write a study's statement into its folder, whole or not at all."""
    stated = {f.name: getattr(statement, f.name) for f in fields(statement)}
    content = {"format": FORMAT, "written_by": f"tactgen {version('tactgen')}", **stated}
    return write_text(folder / FILE, json.dumps(content, indent=1, default=str) + "\n")


def read_statement(folder: Path) -> Statement:
    """Return the statement that a study's folder holds.

    Raises
    ------
    InputError
        If there is none, or not one of this version.
    """
    path = folder / FILE
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(
            f"{folder} holds no study that can be read ({FILE}: {reason}); name a folder that "
            "tactgen whatif --out has written"
        ) from None
    except ValueError:
        raise InputError(
            f"{path} is damaged (it is not JSON); state the study again with --vary, its points "
            "are kept"
        ) from None
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        stated = content.get("format") if isinstance(content, dict) else None
        raise InputError(
            f"{path} has format = {quoted(stated)}, and this version reads {FORMAT}; state the "
            "study again with --vary in another folder"
        )
    known = {f.name for f in fields(Statement)}
    try:
        stated = {key: _frozen(value) for key, value in content.items() if key in known}
        return Statement(**stated)
    except TypeError as error:
        raise InputError(
            f"{path} is damaged ({error}); state the study again with --vary"
        ) from None


def _frozen(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


#: Quick, and exact within their theories: of what the first gives it, of the rest the second.
_USUAL = ("tmm", "network")


def names_models(values: dict[str, Any], models: Sequence[str] | None, before: Statement) -> bool:
    """Return whether options, the study that is gone on with, or the scene name a model."""
    return bool(models or values.get("models") or (before.models and not before.by_accuracy))


def chosen(
    values: dict[str, Any],
    models: Sequence[str] | None,
    quantities: Sequence[str] | None,
    before: Statement,
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return models and quantities by name.

    As the options say; else as the study says that is gone on with, or the scene; else the
    headline quantities of the lateral actuator, by the quick model that is exact within its
    theory.

    Raises
    ------
    InputError
        For an unknown name, or models that give none of the quantities.
    """
    earlier = () if before.by_accuracy else before.models
    stated_models = models or earlier or values.get("models")
    stated_quantities = quantities or before.quantities or values.get("quantities")
    by_name = _names(stated_models, tuple(MODELS), "model", "models") if stated_models else ()
    if stated_quantities:
        wanted = _names(stated_quantities, tuple(QUANTITIES), "quantity", "quantities")
        if wanted == tuple(QUANTITIES):
            wanted = all_given(by_name or _USUAL)
        elif by_name:
            wanted = tuple(q for q in wanted if any(gives(m, q) for m in by_name)) or wanted
    else:
        actuators = {MODELS[m].actuator for m in by_name} or {"bimorph"}
        wanted = tuple(
            q for actuator in ("bimorph", "reluctance") if actuator in actuators
            for q in quantities_of(actuator) if QUANTITIES[q].headline
        )  # fmt: skip
    if not by_name:
        by_name = tuple(dict.fromkeys(m for q in wanted for m in _USUAL if gives(m, q)))
    idle = [m for m in by_name if not any(gives(m, q) for q in wanted)]
    if idle:
        raise InputError(
            f"model {idle[0]} gives none of {', '.join(wanted)}; leave it out, or ask for "
            f"something that it gives, such as {all_given((idle[0],))[0]}"
        )
    return by_name, wanted


def _names(stated: Any, known: tuple[str, ...], kind: str, key: str) -> tuple[str, ...]:
    return choices(",".join(stated) if not isinstance(stated, str) else stated, known, kind, key)


def asks_accuracy(statement: Statement) -> bool:
    """Return whether an accuracy is stated, in the scene or as an axis."""
    return "accuracy" in statement.values or any(a.key == "accuracy" for a in statement.axes)


def under_contract(
    statement: Statement, announce: Callable[[str], None] = lambda _: None
) -> tuple[Statement, Choice]:
    """Return the statement with the models that the accuracy asks for, and why these.

    The models are judged at :func:`judged_points`, once for the whole study.

    Raises
    ------
    InputError
        If no model is known to meet the accuracy there, or none of these points makes a scene.
    """
    scenes: list[Scene] = []
    refused = ""
    for point in judged_points(statement):
        try:
            scenes.append(checked_scene(statement.scene_at(point)))
        except InputError as error:
            refused = refused or str(error)
    if not scenes:
        raise InputError(f"no point at the study's edges makes a scene: {refused}")
    choice = choose_for(scenes, statement.quantities, announce)
    return replace(statement, models=choice.models), choice


def judged_points(statement: Statement) -> list[dict[str, Any]]:
    """Return the points at which models are judged: the middle, and from it the end of each axis.

    Of an axis of choices every one, of what is drawn the least and the largest of the samples.
    What a model leaves out grows or falls along an axis, so that it is largest at an end.
    """
    shape = statement.shape
    middle = {dimension: size // 2 for dimension, size in shape.items()}
    places = [middle]
    for dimension, values in statement.columns.values():
        if any(isinstance(value, str) for value in values):
            ends = list(range(len(values)))
        else:
            ends = [min(range(len(values)), key=values.__getitem__),
                    max(range(len(values)), key=values.__getitem__)]  # fmt: skip
        places += [{**middle, dimension: end} for end in ends]
    different = {tuple(place.values()): place for place in places}
    return [
        {key: values[place[dimension]] for key, (dimension, values) in statement.columns.items()}
        for place in different.values()
    ]
