"""The values of some keys, each within a range, that meet all aims and serve the goal best.

A few points spread over the ranges show where to begin; from the best of them scipy's COBYQA
goes on, which takes bounds and conditions and needs no derivatives, since aims may have
kinks.  Every point is an answer of the study: kept, and by a surrogate over the whole range
of a model that takes long.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.plan import check_models
from tactgen.validation.studies.whatif.aim.expression import Aim
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.search.found import Found
from tactgen.validation.studies.whatif.search.points import Points
from tactgen.validation.studies.whatif.search.ranges import ranges_of

#: Points that are spread over one range, and over more for each of them.
_ALONE, _EACH = 17, 16
#: From how many of them the search goes on at most.
_STARTS = 2
#: Starts closer than this in shares of the ranges would lead to the same place.
_NEIGHBOUR = 0.25
_SEED = 1


def search(
    statement: Statement,
    aims: tuple[Aim, ...],
    present: dict[str, float],
    announce: Callable[[str], None] = lambda _: None,
) -> Found:
    """Return the values that meet the aims best.

    Without a goal those are wanted that differ least, in shares of the ranges, from the
    scene's own.

    Parameters
    ----------
    present : dict of str to float
        The scene's own values of the keys (SI).

    Raises
    ------
    InputError
        If the ranges cannot be searched, two goals are stated, or no point has an answer.
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
    ranges = ranges_of(statement)
    here = np.array([r.share(present[r.key]) for r in ranges])
    points = Points(statement, ranges, aims, here, announce)
    spread = points.ask(_spread(here))
    if all(one.judged is None for one in spread):
        raise InputError(f"no point of the ranges has an answer: {spread[0].reason}")
    scales = points.scales()
    for start in _apart(points.best(scales)):
        points.go_on(start, scales)
    best = points.best(scales)[0]
    found = points.tried[best]
    assert found.judged is not None
    met = points.shortfall(found.judged, scales) == 0.0
    return Found(statement, ranges, aims, found, met, spread[0], len(points.tried),
                 points.solver.interpolated)  # fmt: skip


def _apart(places: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """Return the first places, the best, that are no neighbours."""
    found = [places[0]]
    for place in places:
        near = min(np.abs(np.subtract(place, other)).max() for other in found)
        if len(found) < _STARTS and near > _NEIGHBOUR:
            found.append(place)
    return found


def _spread(here: Floats) -> Floats:
    """Return where a search looks first (n, ranges): the scene itself, then all over."""
    count = here.size
    if count == 1:
        return np.vstack([here, np.linspace(0.0, 1.0, _ALONE)[:, None]])
    from scipy.stats import qmc

    power = math.ceil(math.log2(_EACH * count))
    every = qmc.Sobol(count, seed=_SEED).random_base2(power)
    return np.vstack([here, every])


def with_aims(statement: Statement, aims: Sequence[Aim]) -> Statement:
    """Return the statement that asks what the aims name and nothing else."""
    wanted = dict.fromkeys(name for aim in aims for name in aim.quantities)
    return replace(statement, quantities=tuple(wanted))
