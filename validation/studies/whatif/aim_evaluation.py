"""Evaluation of aims: points that meet them, the best, the Pareto front."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tactgen.geometry.device.parameters import Threshold
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import FINE, engineering, with_error
from tactgen.validation.catalogue.detection import ThresholdCurve, threshold_of
from tactgen.validation.catalogue.models import ranked
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.answers import Answer
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.load import checked_scene
from tactgen.validation.scene.variation import value_of
from tactgen.validation.studies.whatif.aims import (
    THRESHOLD,
    Aim,
    Peak,
    at_threshold,
    of_key,
    parse_aim,
)
from tactgen.validation.studies.whatif.axes import shown_point
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.study import Study

#: 97.5 % quantile of the normal distribution.
_NORMAL = 1.959963984540054


@dataclass(frozen=True)
class Judged:
    """A point by one choice of models: margins of all aims with their bars, in SI units."""

    number: int
    models: str
    margins: tuple[tuple[float, float], ...]
    #: Modelling error of each margin; nan where it is not known, empty where it was not asked for
    modelling: tuple[float, ...] = ()
    peaks: tuple[Peak | None, ...] = ()  #: Where what each aim asks for is largest over the band

    @property
    def values(self) -> dict[str, Any]:
        """Margins, bars and modelling errors as JSON values; nan where one is not known."""
        found: dict[str, Any] = {
            "margins": [m for m, _ in self.margins], "bars": [bar for _, bar in self.margins],
            "peaks": [peak and peak._asdict() for peak in self.peaks],
        }  # fmt: skip
        return {**found, "modelling_errors": list(self.modelling)} if self.modelling else found

    def near(self, n: int) -> bool:
        """Whether a margin is less than its modelling error, and more than its bar."""
        margin, bar = self.margins[n]
        return bool(self.modelling) and bar < abs(margin) <= self.modelling[n]


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
    felt, keys = _felt_at(statement, point), _keys_at(statement, point, aims)
    found = []
    for models, given in choices.items():
        needed = at_threshold({name: given[name] for name in wanted} | keys, felt)
        margins = tuple(aim.margin_with_bar(needed) for aim in aims)
        if all(math.isfinite(margin) for margin, _ in margins):
            modelling = tuple(aim.modelling_error(needed) for aim in aims)
            peaks = tuple(aim.peak(needed) for aim in aims)
            found.append(Judged(number, models, margins, modelling, peaks))
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
    conditions = [n for n, aim in enumerate(aims) if aim.kind == "condition"]
    met = [j for j in every if all(j.margins[n][0] >= 0.0 for n in conditions)]
    undecided = [
        j for j in every if any(abs(j.margins[n][0]) <= j.margins[n][1] for n in conditions)
    ]
    goals = [n for n, aim in enumerate(aims) if aim.kind == "goal"]
    if len(goals) == 2:
        best = [met[n] for n in pareto(*([j.margins[goal] for j in met] for goal in goals))]
    else:
        by = (goals or conditions)[0]
        best = sorted(met, key=lambda j: -j.margins[by][0])
    return Verdict(models, aims, tuple(every), tuple(met), tuple(undecided), tuple(best))


def _felt_at(statement: Statement, point: Mapping[str, Any]) -> ThresholdCurve:
    """Detection threshold of a point's scene."""
    group = f"{THRESHOLD}."
    stated = dict(statement.values.get(THRESHOLD, {}))
    for key, value in point.items():
        if key.startswith(group):
            stated[key.removeprefix(group)] = value
    return threshold_of(Threshold(**stated))


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
        scene = checked_scene({**statement.scene_at(dict(point)), **asked})
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
    z2 = _NORMAL**2
    share = met / of
    centre = (share + z2 / (2 * of)) / (1.0 + z2 / of)
    half = _NORMAL / (1.0 + z2 / of) * math.sqrt(share * (1 - share) / of + z2 / (4 * of**2))
    return max(0.0, centre - half), min(1.0, centre + half)


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
        asked = [n for n, aim in enumerate(found.aims) if aim.kind == "condition"]
        if near := sum(any(one.near(n) for n in asked) for one in found.judged):
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
    return lines + [f"  {_line(study, found, one)}" for one in listed]


def _line(study: Study, found: Verdict, one: Judged) -> str:
    margins = ", ".join(margin_in_words(aim, one, n) for n, aim in enumerate(found.aims))
    return f"{shown_point(study.points[one.number])}: {margins}"


#: What is said of a peak that the band cuts off.
_AT_END = ", an end of the band"


def margin_in_words(aim: Aim, one: Judged, n: int) -> str:
    """Value of a goal or margin of a condition, the n-th, with both errors."""
    (margin, bar), unit = one.margins[n], aim.unit if takes_prefix(aim) else "1"
    value = aim.sign * margin if aim.kind == "goal" else margin
    fine = bar < FINE * abs(value)
    text = engineering(value, unit) if fine else with_error(value, bar, unit)
    if unit != aim.unit:
        text += f" {aim.unit}"
    if aim.kind == "condition":
        text = f"margin {text}"
    modelling = one.modelling[n] if one.modelling else 0.0
    beside = "?" if math.isnan(modelling) else f"± {engineering(modelling, unit, 2)}"
    text = f"{text} ({beside})" if modelling else text
    peak = one.peaks[n] if one.peaks else None
    if peak is None:
        return text
    return f"{text} at {engineering(peak.frequency, 'Hz', 4)}{_AT_END if peak.at_end else ''}"


def takes_prefix(aim: Aim) -> bool:
    """Whether an aim's unit is one of a quantity: base units take no prefix."""
    return aim.unit in {row.unit for row in QUANTITIES.values()}


def as_values(study: Study, found: Verdict) -> dict[str, Any]:
    """Verdict as plain JSON values, SI units."""
    share = list(yield_interval(len(found.met), len(found.judged)))
    return {
        "models": found.models, "aims": [aim.text for aim in found.aims],
        "judged": len(found.judged), "met": len(found.met), "undecided": len(found.undecided),
        "yield_interval_95": share if study.statement.samples else None,
        "best": [{"at": study.points[one.number], **one.values} for one in found.best],
    }  # fmt: skip
