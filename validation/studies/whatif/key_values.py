"""One key of a scene by itself: how its values are read, checked and shown."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from tactgen.geometry import units as u
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import Unit, WholeNumber
from tactgen.validation.scene.files import parse_frequencies, sentence
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.tolerances import unit_of


@dataclass(frozen=True)
class SceneField:
    """Reader of the values of one scene key."""

    key: str  #: The scene key
    info: FieldInfo  #: Its declaration
    scale: Unit | None  #: Its unit, if it is a number on a scale

    @property
    def unit(self) -> str:
        """SI unit of its numbers, empty if there is none."""
        return self.scale.si if self.scale else ""

    @property
    def whole(self) -> bool:
        """Whether its values are whole numbers."""
        return any(
            isinstance(part, WholeNumber)
            for validator in self.info.metadata
            for part in (validator, getattr(validator, "func", None))
        )

    @property
    def numeric(self) -> bool:
        """Whether its values are numbers."""
        return self.scale is not None or self.whole

    @property
    def has_commas(self) -> bool:
        """Whether one value may hold commas, so that a semicolon parts two."""
        return self.key.endswith("_profile")

    def read(self, text: str) -> Any:
        """Value as SI number, whole number or choice.

        Raises ValueError with what is wrong, to follow the value in a sentence.
        """
        if self.key == "frequency":
            return parse_frequencies([text])[0]
        if self.has_commas:  # what it must fit, the length, is known at the point only
            return text
        try:
            found = self._adapter.validate_python(text, context={"units_required": True})
        except ValidationError as error:
            cause = error.errors()[0].get("ctx", {}).get("error")
            words = sentence(error) if cause is None else str(cause)
            raise ValueError(words.removeprefix(f" = {u.quoted(text)} ")) from None
        return found if self.numeric else text

    def parse(self, text: str) -> float:
        """Number in SI units that need not be a possible value: a deviation.

        Raises ValueError as :meth:`read`.
        """
        assert self.scale is not None
        return self.scale.parse(text)

    def checked(self, value: float, where: str) -> float | int:
        """Value between two that were read; of whole numbers it must be one.

        Raises InputError if it is not.
        """
        if not self.whole:
            return value
        if abs(value - round(value)) > 1e-9:
            raise InputError(
                f"{where} has the value {value:g}, but {self.key} is a whole number; choose as "
                "many values as there are whole numbers in the range"
            )
        return round(value)

    def show(self, value: Any) -> str:
        """Value as people write it."""
        return self.scale.show(value) if self.scale and value is not None else str(value)

    @property
    def _adapter(self) -> TypeAdapter[Any]:
        return _adapter(self.key)


@cache
def scene_field(key: str) -> SceneField:
    """Field of a scene key that exists."""
    info = _info(key)
    if key == "frequency":
        return SceneField(key, info, u.FREQUENCY)
    return SceneField(key, info, unit_of(info))


@cache
def _adapter(key: str) -> TypeAdapter[Any]:
    info = _info(key)
    kind: Any = info.annotation
    for part in info.metadata:
        kind = Annotated[kind, part]
    return TypeAdapter(kind)


def _info(key: str) -> FieldInfo:
    owner: Any = Scene
    *groups, name = key.split(".")
    for group in groups:
        owner = owner.model_fields[group].annotation
    found: FieldInfo = owner.model_fields[name]
    return found


def as_stated(key: str, value: Any) -> Any:
    """Value of an axis as a scene takes it: numbers as SI, whatever asks for units."""
    if key == "frequency":
        return [value]
    return u.SI(value) if isinstance(value, float) else value
