"""What a search found, as values and in sentences."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tactgen.validation.studies.whatif.aim.best import Judged
from tactgen.validation.studies.whatif.aim.expression import Aim
from tactgen.validation.studies.whatif.aim.wording import shown
from tactgen.validation.studies.whatif.asked.scene_field import scene_field
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.search.ranges import Range

#: Share of a range that counts as its end.
_END = 1e-4


@dataclass(frozen=True)
class Tried:
    """A point of the ranges: its values by key, and what the aims say, None if nothing."""

    values: dict[str, float]
    judged: Judged | None
    reason: str


@dataclass(frozen=True)
class Found:
    """What a search gave.

    Attributes
    ----------
    statement : Statement
        What was asked, scene and models among it.
    ranges : tuple of Range
    aims : tuple of Aim
    best : Tried
        The best point, or, if none meets all conditions, the one that comes nearest.
    met : bool
        Whether it meets them.
    present : Tried
        The scene's own values, or their nearest within the ranges.
    tried, interpolated : int
        Number of points, and of answers from a surrogate among them.
    """

    statement: Statement
    ranges: tuple[Range, ...]
    aims: tuple[Aim, ...]
    best: Tried
    met: bool
    present: Tried
    tried: int
    interpolated: int

    @property
    def at_end(self) -> tuple[str, ...]:
        """Keys whose best value is an end of the range."""
        shares = {r.key: r.share(self.best.values[r.key]) for r in self.ranges}
        return tuple(key for key, share in shares.items() if min(share, 1.0 - share) < _END)


def as_values(found: Found) -> dict[str, Any]:
    """Return the result as plain JSON values, SI units."""

    def point(one: Tried) -> dict[str, Any]:
        margins = one.judged.margins if one.judged else ()
        return {
            "at": one.values,
            "margins": [margin for margin, _ in margins],
            "bars": [bar for _, bar in margins],
        }

    return {
        "scene": found.statement.scene, "models": list(found.statement.models),
        "ranges": {r.key: [r.low, r.high] for r in found.ranges},
        "aims": [aim.text for aim in found.aims], "met": found.met, "best": point(found.best),
        "present": point(found.present), "ends": list(found.at_end), "points": found.tried,
        "interpolated": found.interpolated,
    }  # fmt: skip


def sentences(found: Found) -> list[str]:
    """Return the result in sentences."""
    models = ", ".join(found.statement.models)
    if not found.met:
        head = f"No point of the ranges meets all aims by {models}; this one comes nearest:"
    elif any(aim.kind == "goal" for aim in found.aims):
        head = f"Best by {models}:"
    else:
        head = f"Nearest to the scene's own that meets all aims by {models}:"
    lines = [
        head,
        *(f"  {key} = {scene_field(key).show(v)}" for key, v in found.best.values.items()),
    ]
    present = found.present.judged
    assert found.best.judged is not None
    for n, aim in enumerate(found.aims):
        margin, bar = found.best.judged.margins[n]
        near = aim.kind == "condition" and abs(margin) <= bar
        edge = ", nearer to the edge than the error bar" if near else ""
        before = shown(aim, *present.margins[n]) if present else "unknown"
        lines.append(f"  {aim.text}: {shown(aim, margin, bar)}{edge}; before: {before}")
    lines += [f"{key} is at an end of its range, beyond which there may be better"
              for key in found.at_end if any(aim.kind == "goal" for aim in found.aims)]  # fmt: skip
    among = f", {found.interpolated} of their answers interpolated" if found.interpolated else ""
    lines.append(f"{found.tried} points tried{among}.")
    return lines
