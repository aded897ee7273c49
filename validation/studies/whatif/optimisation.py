"""The values of some keys, each within a range, that meet all aims and serve the goal best.

A few points spread over the ranges show where to begin; from the best of them scipy's COBYQA goes
on, which takes bounds and conditions and needs no derivatives, since aims may have kinks.  Every
point is an answer of the study: kept, or by a surrogate over the whole range of a model that takes
long.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import quoted
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.solve import check_models
from tactgen.validation.scene.load import checked_scene
from tactgen.validation.scene.variation import value_of
from tactgen.validation.studies.whatif.aim_evaluation import Judged, judged
from tactgen.validation.studies.whatif.aims import Aim
from tactgen.validation.studies.whatif.axes import Distribution, scene_field
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.study import StudySolver

#: Share of a range that counts as its end.
_END = 1e-4
#: Most points, for each range, that a search takes from one start.
_STEPS = 40
#: Share of the ranges to which the place is found.
_FINE = 1e-5
#: Points that are spread over one range, and over more for each of them.
_ALONE, _EACH = 17, 16
#: From how many of them the search goes on at most.
_STARTS = 2
#: Starts closer than this in shares of the ranges would lead to the same place.
_NEIGHBOUR = 0.25
_SEED = 1
#: Two ends, perhaps with their spacing, and no count.
_RANGE = re.compile(r"[^:]+:[^:]+(:\s*log\s*)?")


def _ranges_of(statement: Statement) -> dict[str, Distribution]:
    """Ranges that a statement's axes state, by key.

    Raises InputError for an axis that is not a range of a number.
    """
    texts = {text: text.partition("=")[2] for text in statement.vary}
    no_range = [text for text, stated in texts.items() if stated and not _RANGE.fullmatch(stated)]
    found = {}
    for axis in () if no_range else statement.axes:
        if axis.drawn is None or scene_field(axis.key).whole:  # words may hold a colon
            no_range.append(f"{axis.key}={axis.text}")
        else:
            found[axis.key] = axis.drawn
    if no_range:
        raise InputError(
            f"--vary {quoted(no_range[0])} is not a range to search; write KEY=LOW:HIGH of a "
            "continuous key, for example --vary bimorph.length=14mm:22mm"
        )
    return found


@dataclass(frozen=True)
class Tried:
    """Tried point: values by key, and the aims' margins."""

    values: dict[str, float]
    judged: Judged | None
    reason: str
    warnings: tuple[str, ...] = ()  #: Limits of the validity of its answers


@dataclass
class Search:
    """A search, with all points that were tried by their shares of the ranges."""

    statement: Statement
    aims: tuple[Aim, ...]
    announce: Callable[[str], None]
    tried: dict[tuple[float, ...], Tried] = field(default_factory=dict)
    scales: Sequence[float] = ()
    present: Tried = field(init=False)  #: The scene's own values, within the ranges or not

    def __post_init__(self) -> None:
        stated, models = self.statement, list(self.statement.models)
        self.ranges = _ranges_of(stated)
        scene = checked_scene({**stated.values, "models": models, "quantities": ["all"]})
        self.own = {key: float(value_of(scene, key)) for key in self.ranges}
        self.here = np.array([of.share(self.own[key]) for key, of in self.ranges.items()])
        self.solver = StudySolver(
            stated,
            announce=lambda text: self.announce(f"{len(self.tried)} points tried: {text}"),
            ranges={key: (of.first, of.second) for key, of in self.ranges.items()},
        )

    @property
    def best(self) -> Tried:
        """The best point, or, if none meets all conditions, the one that comes nearest."""
        return self.tried[self.ranked()[0]]

    @property
    def met(self) -> bool:
        """Whether the best point meets all conditions."""
        judged = self.best.judged
        return judged is not None and self.shortfall(judged) == 0.0

    @property
    def at_end(self) -> tuple[str, ...]:
        """Keys whose best value is an end of the range."""
        best = self.best.values
        shares = {key: of.share(best[key]) for key, of in self.ranges.items()}
        return tuple(key for key, share in shares.items() if min(share, 1.0 - share) < _END)

    def ask(self, shares: Floats) -> list[Tried]:
        """Results at points (n, ranges), solving the new ones."""
        places = [tuple(float(v) for v in row) for row in np.clip(shares, 0.0, 1.0)]
        new = [place for place in dict.fromkeys(places) if place not in self.tried]
        if new:
            values = [
                {key: of.at(v) for (key, of), v in zip(self.ranges.items(), place, strict=True)}
                for place in new
            ]
            answers = self.solver.answers(values)
            for place, at, given in zip(new, values, answers, strict=True):
                self.tried[place] = self._tried(at, given)
        return [self.tried[place] for place in places]

    def outside(self, values: dict[str, float]) -> Tried:
        """Result at values that need not lie within the ranges."""
        solver = StudySolver(self.statement, announce=self.announce)
        return self._tried(values, solver.answers([values])[0])

    def _tried(self, at: dict[str, float], given: Mapping[str, Answer]) -> Tried:
        found = judged(self.statement, self.aims, 0, at, given)
        reason = "; ".join(a.reason for a in given.values() if a.reason)
        warnings = tuple(dict.fromkeys(words for a in given.values() for words in a.warnings))
        reason = reason or "a quantity has no value there"
        return Tried(at, found[0] if found else None, reason, warnings)

    def rescale(self) -> None:
        """Set each aim's scale to what its margin differs by over the points, 1 if it does not."""
        found = (one.judged for one in self.tried.values() if one.judged)
        over = np.ptp([[m.value for m in one.margins] for one in found], axis=0)
        self.scales = [float(scale) if scale > 0.0 else 1.0 for scale in over]

    def shortfall(self, found: Judged) -> float:
        """By how much the conditions are missed, in scales, 0 if all are met."""
        return sum(max(-margin, 0.0) for margin in self._scaled(found, "condition"))

    def ranked(self) -> list[tuple[float, ...]]:
        """Places of all points that have answers, the best first."""
        order = {
            place: (self.shortfall(one.judged), -self._worth(np.array(place), one.judged))
            for place, one in self.tried.items() if one.judged
        }  # fmt: skip
        return sorted(order, key=order.__getitem__)

    def go_on(self, start: tuple[float, ...]) -> None:
        """Search on from a point."""
        from scipy.optimize import NonlinearConstraint, minimize

        conditions = sum(aim.kind == "condition" for aim in self.aims)

        def cost(shares: Floats) -> float:
            found = self.ask(shares[None])[0].judged
            return -self._worth(np.clip(shares, 0.0, 1.0), found) if found else 1.0

        def margins(shares: Floats) -> Sequence[float]:
            found = self.ask(shares[None])[0].judged
            return self._scaled(found, "condition") if found else [-1.0] * conditions

        held = [NonlinearConstraint(margins, 0.0, np.inf)] if conditions else []
        minimize(
            cost,
            np.array(start),
            method="COBYQA",
            bounds=[(0.0, 1.0)] * len(self.ranges),
            constraints=held,
            options={"maxfev": _STEPS * len(self.ranges), "initial_tr_radius": 0.05,
                     "final_tr_radius": _FINE},
        )  # fmt: skip

    def _scaled(self, found: Judged, kind: str) -> list[float]:
        """Margins of the conditions, or values of the goals, in scales."""
        each = zip(found.margins, self.scales, strict=True)
        return [margin.value / scale for margin, scale in each if margin.aim.kind == kind]

    def _worth(self, shares: Floats, found: Judged) -> float:
        """Merit of a point: by the goal, or by its nearness to the scene's own."""
        goals = self._scaled(found, "goal")
        return goals[0] if goals else -float(((shares - self.here) ** 2).sum())


def search(
    statement: Statement, aims: tuple[Aim, ...], announce: Callable[[str], None] = lambda _: None
) -> Search:
    """Values that meet the aims best.

    Without a goal those are wanted that differ least, in shares of the ranges, from the
    scene's own.

    Raises InputError if the ranges cannot be searched, two goals are stated, or no point has an
    answer.
    """
    if sum(aim.kind == "goal" for aim in aims) > 1:
        raise InputError(
            "two goals cannot both be best; keep one and make a condition of the other, or take "
            "tactgen whatif, which gives the points that cannot be bettered in both"
        )
    check_models(statement.models, statement.quantities)
    actuators = [MODELS[model].actuator for model in statement.models]
    if len(set(actuators)) < len(actuators):
        raise InputError(
            f"the models {', '.join(statement.models)} would each have a best of their own; name "
            "one --model"
        )
    found = Search(statement, aims, announce)
    spread = found.ask(_spread(found.here))
    if all(one.judged is None for one in spread):
        raise InputError(f"no point of the ranges has an answer: {spread[0].reason}")
    found.rescale()
    for start in _apart(found.ranked()):
        found.go_on(start)
    inside = all(of.first <= found.own[key] <= of.second for key, of in found.ranges.items())
    found.present = spread[0] if inside else found.outside(found.own)
    return found


def _apart(places: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """First places, the best, that are no neighbours."""
    found = [places[0]]
    for place in places:
        near = min(np.abs(np.subtract(place, other)).max() for other in found)
        if len(found) < _STARTS and near > _NEIGHBOUR:
            found.append(place)
    return found


def _spread(here: Floats) -> Floats:
    """Where a search looks first (n, ranges): the scene itself, then all over."""
    count = here.size
    if count == 1:
        return np.vstack([here, np.linspace(0.0, 1.0, _ALONE)[:, None]])
    from scipy.stats import qmc

    power = math.ceil(math.log2(_EACH * count))
    every = qmc.Sobol(count, seed=_SEED).random_base2(power)
    return np.vstack([here, every])


def as_values(found: Search) -> dict[str, Any]:
    """Result as plain JSON values, SI units."""

    def point(one: Tried) -> dict[str, Any]:
        unknown: dict[str, Any] = {"margins": [], "bars": [], "peaks": []}
        return {"at": one.values, **(one.judged.values if one.judged else unknown)}

    stated = found.statement
    return {
        "scene": stated.scene, "conditions": stated.conditions, "models": list(stated.models),
        "ranges": {key: [of.first, of.second] for key, of in found.ranges.items()},
        "aims": [aim.text for aim in found.aims], "met": found.met, "best": point(found.best),
        "present": point(found.present), "ends": list(found.at_end), "points": len(found.tried),
        "interpolated": found.solver.counts["interpolated"],
    }  # fmt: skip


def sentences(found: Search) -> list[str]:
    """Result in sentences."""
    stated = found.statement
    models, has_goal = ", ".join(stated.models), any(aim.kind == "goal" for aim in found.aims)
    if not found.met:
        head = f"No point of the ranges meets all aims by {models}; this one comes nearest:"
    elif has_goal:
        head = f"Best by {models}:"
    else:
        head = f"Nearest to the scene's own that meets all aims by {models}:"
    lines = [
        *filter(None, [stated.conditions]),
        head,
        *(f"  {key} = {scene_field(key).show(v)}" for key, v in found.best.values.items()),
    ]
    best, present = found.best.judged, found.present.judged
    assert best is not None
    for n, margin in enumerate(best.margins):
        edge = ""
        if margin in best.conditions and (abs(margin.value) <= margin.bar or margin.near):
            kind = "modelling" if margin.near else "numerical"
            edge = f", nearer to the edge than the {kind} error"
        before = present.margins[n].text if present else "unknown"
        lines.append(f"  {margin.aim.text}: {margin.text}{edge}; before: {before}")
    lines += [f"{key} is at an end of its range, beyond which there may be better"
              for key in found.at_end if has_goal]  # fmt: skip
    interpolated = found.solver.counts["interpolated"]
    lines += [f"warning: {words}" for words in found.best.warnings]
    among = f", {interpolated} of their answers interpolated" if interpolated else ""
    lines.append(f"{len(found.tried)} points tried{among}.")
    return lines
