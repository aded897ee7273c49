"""Declaration of parameters: default, unit, source and range, in frozen groups."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field
from pydantic.fields import FieldInfo

from tactgen.geometry.device.materials import PRINTED, Own, Spread

#: Where the numbers that the paper gives stand.
PAPER_2 = "paper table 2"
PAPER_4 = "paper section 4"
PAPER_5 = "paper section 5.1"
PAPER_52 = "paper section 5.2"
RECONSTRUCTED = (
    "assumed: normal actuator reconstructed by search (the paper gives 2.3 mm, the gap, 41 mm "
    "total height, force and currents)"
)


def field(
    default: Any,
    source: str,
    description: str,
    spread: tuple[float, float, str] | Spread | None = None,
    own: Own | None = None,
) -> Any:
    """Declare a parameter; `spread` is (low, high, reason), a tenth for a reconstructed size.

    A number other than the default is not the source's; `own` says how far it may lie from what
    is said of it.  Without `own` the default's range moves along.
    """
    if spread is None and source == RECONSTRUCTED:
        spread = (0.9 * default, 1.1 * default, "assumed: a reconstruction, a tenth either way")
    extra: dict[str, Any] = {
        "source": source,
        "spread": list(spread) if spread else None,
        "own": list(own) if own else None,
    }
    return Field(default, description=description, json_schema_extra=extra)


def printed(default: float, source: str, description: str, half_a_unit: float, *, own: Own) -> Any:
    """Declare a parameter that is known to the digits printed, trailing zeros not counted."""
    spread = Spread(default - half_a_unit, default + half_a_unit, PRINTED, absolute=True)
    return field(default, source, description, spread, own)


#: What a scene writes for an empty list.
NONE = "none"


def read_list(
    value: Any, kind: type[Any], item: type[Any], read: Callable[[str], Any], remedy: str
) -> Any:
    """Tuple of class `kind` from ``"one; two"``, a list of such texts, or what a store has of it.

    Raises ValueError with the remedy, and what `read` raises of a text.
    """
    if isinstance(value, kind):
        return value
    if isinstance(value, str):
        texts = [] if value.strip().lower() in ("", NONE) else re.split(r"[;,]", value)
        return kind(read(text.strip()) for text in texts)
    if isinstance(value, Sequence) and all(isinstance(part, str) for part in value):
        return kind(read(text.strip()) for text in value)
    if isinstance(value, Sequence) and all(isinstance(part, list | tuple) for part in value):
        return kind(item(*part) for part in value)
    raise ValueError(f"is not a list; {remedy}")


class Parameters(BaseModel):
    """Base of all parameter groups: immutable, no unknown keys, finite values."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @classmethod
    def declaration(cls, name: str) -> FieldInfo:
        """Declaration of a parameter by the part of its scene key after the group."""
        return cls.model_fields[name]

    def value(self, name: str) -> Any:
        """Value of a parameter by the same name."""
        return getattr(self, name)

    def changed(self, values: Mapping[str, Any]) -> Self:
        """Group with other values, unchecked: arrays and complex ones pass."""
        return self.model_copy(update=dict(values))
