"""Largest values of responses over the whole band, at the resonances between the frequencies asked.

A resonance of quality factor Q is 1/Q wide, so a sweep steps over its top.  The reciprocal of a
response is smooth there: its size is least near the same point of any grid, and is followed in.
So is that of each result that judges the model's, whose resonance may be at another frequency.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tactgen.geometry.arrays import Bools, Floats
from tactgen.validation.catalogue.quantities import QUANTITIES, QuantityRow
from tactgen.validation.engine.readout import read
from tactgen.validation.models.bimorph.model import BimorphModel
from tactgen.validation.models.model import Extreme, Model

#: Frequencies from which on a request is a sweep, whose band is searched.
_SWEEP = 8
#: Trial frequencies over the band, at least.
_TRIALS = 400
#: Rounds of the search, frequencies of a round, and how much narrower the next one is.
_ROUNDS, _OF_A_ROUND, _NARROWER = 4, 65, 32.0
#: Tops that are followed in after the first round, the highest.
_FOLLOWED = 8
#: How far two models' resonances may be apart, relative: half the width of a coarse grid's step.
_AROUND = 0.2


def extreme(row: QuantityRow, model: Model, around: float | None = None) -> Extreme | None:
    """Largest size of a response in the band of the scene's sweep, of a limit the least.

    Or its size where another response is largest, if it counts there (`peak_of`).  None of what is
    no scalar response of the bimorph, and of fewer than eight frequencies.

    It is searched about the frequency (Hz) of another model's extreme alone, if that is given
    (`around`); at an end of the band that is taken for the one of this model.
    """
    asked = np.unique(np.asarray(model.scene.frequency, dtype=float))
    if not row.is_response or not isinstance(model, BimorphModel) or asked.size < _SWEEP:
        return None
    sought = QUANTITIES.get(row.peak_of, row)
    best = _top(sought, partial(model.at, judged=False), asked, around)
    if best is None:
        return None
    found = read(row, model.at(np.array([best]), judged=False))
    value, error = float(np.abs(found.value[0])), float(found.error[0])
    for n, (_, factor) in enumerate(model.at(np.array([best])).versions):

        def version(frequencies: Floats, n: int = n) -> BimorphModel:
            return model.at(frequencies).versions[n][0]

        top = _top(sought, version, asked, best)
        error += factor * abs(value - abs(read(row, version(np.array([top]))).value[0]))
    return Extreme(best, value, float(error))


def _top(
    row: QuantityRow, at: Callable[[Floats], Model], asked: Floats, around: float | None
) -> float | None:
    """Frequency of the extreme, of a model at any frequencies of the band; None if it has none."""

    def level(frequencies: Floats) -> Floats:
        size = np.abs(read(row, at(frequencies.ravel())).value)
        with np.errstate(divide="ignore"):
            found = np.log(size).reshape(frequencies.shape)
        return np.asarray(np.where(np.isnan(found), -np.inf, -found if row.is_limit else found))

    if around in (asked[0], asked[-1]):
        return around
    if around is None:
        centre, reach = _tops(asked, level)
    else:
        centre, reach = np.array([around]), np.array([_AROUND * around])
    best = float(centre[0]) if centre.size else None
    for number in range(_ROUNDS):
        if not centre.size:
            break
        near = centre[:, None] + reach[:, None] * np.linspace(-1.0, 1.0, _OF_A_ROUND)
        near = np.clip(near, asked[0], asked[-1])
        levels = level(near)
        best = float(near.flat[levels.argmax()])
        # at first all tops, as those of short and open electrodes may lie close together
        tops = _is_top(levels) if number == 0 else levels == levels.max(axis=1, keepdims=True)
        highest = np.argsort(levels[tops])[: -_FOLLOWED - 1 : -1]
        centre = near[tops][highest]
        reach = (np.broadcast_to(reach[:, None], near.shape)[tops] / _NARROWER)[highest]
    return best


def _tops(asked: Floats, level: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
    """Local maxima of a level between the frequencies asked for, and the reach of each."""
    parts = -(-_TRIALS // asked.size)
    places = np.arange(parts * (asked.size - 1) + 1) / parts
    trials = np.interp(places, np.arange(asked.size), asked)
    found = level(trials)
    tops = _is_top(found)
    return trials[tops], 2.0 * np.gradient(trials)[tops]


def _is_top(levels: Floats) -> Bools:
    """Whether each of levels (..., n) is no lower than its neighbours, and finite."""
    ends = np.full((*levels.shape[:-1], 1), True)
    rises = np.concatenate([ends, levels[..., 1:] > levels[..., :-1]], axis=-1)
    falls = np.concatenate([levels[..., :-1] >= levels[..., 1:], ends], axis=-1)
    return np.asarray(rises & falls & np.isfinite(levels))
