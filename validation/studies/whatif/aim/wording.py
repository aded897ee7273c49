"""What a study's aims say, in sentences and as plain values."""

from __future__ import annotations

from typing import Any

from tactgen.geometry.formats import with_bar
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.studies.whatif.aim.best import Judged, Verdict, yield_interval
from tactgen.validation.studies.whatif.aim.expression import Aim
from tactgen.validation.studies.whatif.asked.scene_field import scene_field
from tactgen.validation.studies.whatif.run import Study

#: Most points that are listed.
_LISTED = 5


def sentences(study: Study, found: Verdict) -> list[str]:
    """Return how many points meet the aims, and the best of them."""
    total = len(found.judged)
    if not total:
        return ["no point can be judged: at each, what the aims name is missing or not finite"]
    conditions = [aim.text for aim in found.aims if aim.kind == "condition"]
    lines = []
    if conditions:
        share = f"{len(found.met)} of {total} points meet {' and '.join(conditions)}"
        if study.statement.samples:
            low, high = (100.0 * end for end in yield_interval(len(found.met), total))
            share += f": a yield of {100.0 * len(found.met) / total:.3g} % (95 % interval "
            share += f"{low:.3g} to {high:.3g} %, from the count alone)"
        lines.append(share)
        if found.undecided:
            lines.append(
                f"{len(found.undecided)} of them all are nearer to the edge than the numerical "
                "error bar, so either may be true of them"
            )
    if not found.best:
        return lines
    goals = [aim for aim in found.aims if aim.kind == "goal"]
    if len(goals) == 2:
        lines.append(f"{len(found.best)} points cannot be bettered in both {goals[0].text} and "
                     f"{goals[1].text}:")  # fmt: skip
        listed = found.best
    else:
        lines.append("best:" if goals else f"farthest inside {conditions[0]}:")
        listed = found.best[:_LISTED]
    return lines + [f"  {_line(study, found, one)}" for one in listed]


def _line(study: Study, found: Verdict, one: Judged) -> str:
    at = ", ".join(
        f"{key} = {scene_field(key).show(value)}" for key, value in study.points[one.number].items()
    )
    each = zip(found.aims, one.margins, strict=True)
    return f"{at} ({one.models}): {', '.join(shown(aim, *margin) for aim, margin in each)}"


def shown(aim: Aim, margin: float, bar: float) -> str:
    """Return a goal's value, or a condition's margin, with its bar and unit."""
    value = aim.sign * margin if aim.kind == "goal" else margin
    unit = aim.unit
    if unit in {row.unit for row in QUANTITIES.values()}:
        text = with_bar(value, bar, unit)
    else:  # base units take no prefix
        text = f"{with_bar(value, bar, '1')} {unit}"
    return text if aim.kind == "goal" else f"margin {text}"


def as_values(study: Study, found: Verdict) -> dict[str, Any]:
    """Return the verdict as plain JSON values, SI units."""

    def listed(which: tuple[Judged, ...]) -> list[dict[str, Any]]:
        return [
            {"at": study.points[one.number], "models": one.models,
             "margins": [margin for margin, _ in one.margins],
             "bars": [bar for _, bar in one.margins]}
            for one in which
        ]  # fmt: skip

    share = yield_interval(len(found.met), len(found.judged)) if found.judged else None
    return {
        "aims": [aim.text for aim in found.aims], "judged": len(found.judged),
        "met": len(found.met), "undecided": len(found.undecided),
        "yield_interval_95": list(share) if share and study.statement.samples else None,
        "best": listed(found.best),
    }  # fmt: skip
