"""Evaluation of aims: points that meet them, the best, the Pareto front."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tactgen.geometry.device.parameters import Threshold
from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.models import ranked
from tactgen.validation.engine.answers import Answer
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.load import checked_scene
from tactgen.validation.scene.variation import value_of
from tactgen.validation.studies.whatif.aims import (
    THRESHOLD,
    Aim,
    Margin,
    at_threshold,
    of_key,
    parse_aim,
)
from tactgen.validation.studies.whatif.axes import shown_point
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.study import Study


@dataclass(frozen=True)
class Judged:
    """A point by one choice of models, with its margins to all aims."""

    number: int
    models: str
    margins: tuple[Margin, ...]

    @property
    def conditions(self) -> list[Margin]:
        """Margins to the conditions."""
        return [margin for margin in self.margins if margin.aim.kind == "condition"]

    @property
    def goals(self) -> list[Margin]:
        """Values of the goals."""
        return [margin for margin in self.margins if margin.aim.kind == "goal"]

    @property
    def values(self) -> dict[str, Any]:
        """Margins, bars and modelling errors as JSON values; nan where one is not known."""
        return {
            "margins": [m.value for m in self.margins], "bars": [m.bar for m in self.margins],
            "peaks": [m.peak and m.peak._asdict() for m in self.margins],
            "modelling_errors": [m.modelling for m in self.margins],
        }  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """Verdict of a study's aims on its points, by one choice of models."""

    models: str  #: The model, or several together where no single one gives what the aims name
    aims: tuple[Aim, ...]  #: Conditions and at most two goals
    judged: tuple[Judged, ...]  #: Points that could be judged
    #: Those that meet all conditions, and those among all that are nearer to the edge of one than
    #: its error bar
    met: tuple[Judged, ...]
    undecided: tuple[Judged, ...]
    #: Of those that meet all: the best first; of two goals the Pareto front
    best: tuple[Judged, ...]


def parse_aims(texts: Sequence[str]) -> tuple[Aim, ...]:
    """Aims; InputError for one that cannot be read, and for more than two goals."""
    aims = tuple(parse_aim(text) for text in texts)
    if sum(aim.kind == "goal" for aim in aims) > 2:
        raise InputError("more than two goals are stated; keep two, and make conditions of others")
    return aims


def named_quantities(aims: Sequence[Aim]) -> tuple[str, ...]:
    """Quantities that aims name, each once."""
    return tuple(dict.fromkeys(name for aim in aims for name in aim.quantities))


def judged(
    statement: Statement,
    aims: tuple[Aim, ...],
    number: int,
    point: Mapping[str, Any],
    answers: Mapping[str, Answer],
) -> list[Judged]:
    """Margins of one point, by every model that gives what the aims name.

    If no single model does, the most detailed of each actuator together.
    """
    known = {m: {q.name: q for q in a.quantities} for m, a in answers.items() if a.status == "ok"}
    if not known:
        return []
    together: dict[str, Any] = {}
    for model in ranked(known):
        together |= known[model]
    wanted = set(named_quantities(aims))
    choices = {m: found for m, found in known.items() if wanted <= set(found)}
    if not choices and wanted <= set(together):
        choices = {" with ".join(known): together}
    felt = threshold_of(Threshold(**statement.scene_at(point).get(THRESHOLD, {})))
    keys = _keys_at(statement, point, aims)
    found = []
    for models, given in choices.items():
        needed = at_threshold({name: given[name] for name in wanted} | keys, felt)
        margins = tuple(aim.judged(needed) for aim in aims)
        if all(math.isfinite(margin.value) for margin in margins):
            found.append(Judged(number, models, margins))
    return found


def verdicts(study: Study, aims: tuple[Aim, ...]) -> tuple[Verdict, ...]:
    """Verdict of each model on every point; none where no point can be judged."""
    each = enumerate(zip(study.points, study.answers, strict=True))
    by_models: dict[str, list[Judged]] = {}
    for n, at in each:
        for one in judged(study.statement, aims, n, *at):
            by_models.setdefault(one.models, []).append(one)
    return tuple(_verdict(models, aims, every) for models, every in by_models.items())


def _verdict(models: str, aims: tuple[Aim, ...], every: Sequence[Judged]) -> Verdict:
    met = [j for j in every if all(m.value >= 0.0 for m in j.conditions)]
    undecided = [j for j in every if any(abs(m.value) <= m.bar for m in j.conditions)]
    if met and len(met[0].goals) == 2:
        first, second = zip(*([(m.value, m.bar) for m in j.goals] for j in met), strict=True)
        best = [met[n] for n in pareto(first, second)]
    else:
        best = sorted(met, key=lambda j: -(j.goals or j.conditions)[0].value)
    return Verdict(models, aims, tuple(every), tuple(met), tuple(undecided), tuple(best))


def _keys_at(
    statement: Statement, point: Mapping[str, Any], aims: Sequence[Aim]
) -> dict[str, Quantity]:
    """Scene keys that aims name, with their values at a point.

    Raises InputError for one that has no value of its own in the scene.
    """
    named = {key for aim in aims for key in aim.keys}
    values = {key: point[key] for key in named & set(point)}
    if others := named - set(point):
        asked = {"models": list(statement.models), "quantities": ["all"]}
        scene = checked_scene({**statement.scene_at(point), **asked})
        values |= {key: value_of(scene, key) for key in others}
    for key, value in values.items():
        if value is None:
            raise InputError(f"an aim names {key}, which follows from other keys here; set {key}")
    return {key: of_key(key, float(value)) for key, value in values.items()}


def pareto(
    first: Sequence[tuple[float, float]], second: Sequence[tuple[float, float]]
) -> list[int]:
    """Places of points that no other betters in both, in descending order of the first.

    Of each point the value, more being better, and its error bar: in the second, a lead within the
    bars is none.
    """
    order = sorted(range(len(first)), key=lambda n: (-first[n][0], -second[n][0]))
    found: list[int] = []
    for n in order:
        (value, bar), (last, last_bar) = second[n], second[found[-1]] if found else (-math.inf, 0.0)
        if value > last + bar + last_bar:
            found.append(n)
    return found


def yield_interval(met: int, of: int) -> tuple[float, float]:
    """95 % interval of a share that was counted (Wilson 1927)."""
    from scipy.stats import binomtest  # slow to import

    low, high = binomtest(met, of).proportion_ci(method="wilson")
    return float(low), float(high)


#: Most points that are listed.
_LISTED = 5


def sentences(study: Study, found: Sequence[Verdict]) -> list[str]:
    """Sentences on the points that meet the aims, and the best of them, model by model."""
    if not found:
        return ["no point can be judged: at each, what the aims name is missing or not finite"]
    return [line for each in found for line in _sentences(study, each)]


def _sentences(study: Study, found: Verdict) -> list[str]:
    total = len(found.judged)
    conditions = [aim.text for aim in found.aims if aim.kind == "condition"]
    lines = []
    if conditions:
        which = "points" if total == len(study.points) else "points that can be judged"
        share = f"{found.models}: {len(found.met)} of {total} {which} meet "
        share += " and ".join(conditions)
        if study.statement.samples:
            low, high = (100.0 * end for end in yield_interval(len(found.met), total))
            share += f": a yield of {100.0 * len(found.met) / total:.3g} % (95 % interval "
            share += f"{low:.3g} to {high:.3g} %, from the count alone)"
        lines.append(share)
        if found.undecided:
            lines.append(
                f"nearer to the edge than the numerical error: {len(found.undecided)} of {total} "
                "points, which may or may not meet it"
            )
        if near := sum(any(m.near for m in one.conditions) for one in found.judged):
            lines.append(
                f"nearer to the edge than the modelling error: {near} of {total} points, on which "
                "the most detailed model may differ"
            )
    if not found.best:
        return lines
    goals = [aim for aim in found.aims if aim.kind == "goal"]
    if len(goals) == 2:
        lines.append(f"{found.models}: {len(found.best)} points cannot be bettered in both "
                     f"{goals[0].text} and {goals[1].text}:")  # fmt: skip
        listed = found.best
    else:
        what = "best" if goals else f"farthest inside {conditions[0]}"
        lines.append(f"{what} by {found.models}:")
        listed = found.best[:_LISTED]
    return lines + [
        f"  {shown_point(study.points[one.number])}: {', '.join(m.text for m in one.margins)}"
        for one in listed
    ]


def as_values(study: Study, found: Verdict) -> dict[str, Any]:
    """Verdict as plain JSON values, SI units."""
    counts, sampled = (len(found.met), len(found.judged)), study.statement.samples
    return {
        "models": found.models, "aims": [aim.text for aim in found.aims],
        "judged": counts[1], "met": counts[0], "undecided": len(found.undecided),
        "yield_interval_95": list(yield_interval(*counts)) if sampled else None,
        "best": [{"at": study.points[one.number], **one.values} for one in found.best],
    }  # fmt: skip
