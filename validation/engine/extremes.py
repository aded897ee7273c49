"""Largest values of responses over the whole band, at the resonances between the frequencies asked.

A resonance of quality factor Q is 1/Q wide, so a sweep steps over its top.  The reciprocal of a
response is smooth there: its size is least near the same point of any grid, and is followed in.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.catalogue.quantities import QuantityRow
from tactgen.validation.engine.readout import read
from tactgen.validation.models.bimorph.model import BimorphModel
from tactgen.validation.models.model import Extreme, Model

#: Frequencies from which on a request is a sweep, whose band is searched.
_SWEEP = 8
#: Trial frequencies over the band, at least.
_TRIALS = 400
#: Rounds of the search, frequencies of a round, and how much narrower the next one is.
_ROUNDS, _OF_A_ROUND, _NARROWER = 3, 65, 32.0
#: How far two models' resonances may be apart, relative: half the width of a coarse grid's step.
_AROUND = 0.2


def extreme(row: QuantityRow, model: Model, around: float | None = None) -> Extreme | None:
    """Largest size of a response in the band of the scene's sweep, of a limit the least.

    None of what is no scalar response of the bimorph, and of fewer than eight frequencies.

    Parameters
    ----------
    around : float, optional
        Frequency (Hz) of another model's extreme, about which alone it is searched; at an end of
        the band it is taken for that of this model.
    """
    asked = np.unique(np.asarray(model.scene.frequency, dtype=float))
    if not row.is_response or not isinstance(model, BimorphModel) or asked.size < _SWEEP:
        return None

    def level(at: Floats) -> Floats:
        there = model.at(at.ravel(), judged=False)
        with np.errstate(divide="ignore"):
            found = np.log(np.abs(read(row, there).value)).reshape(at.shape)
        found = np.where(np.isnan(found), -np.inf, -found if row.is_limit else found)
        return np.asarray(found)

    centre: Floats
    reach: Floats
    if around in (asked[0], asked[-1]):
        centre, reach, rounds = np.array([around]), np.zeros(1), 0
    elif around is not None:
        centre, rounds = np.array([around]), _ROUNDS - 1
        reach = _AROUND * centre
    else:
        centre, reach = _tops(asked, level)
        rounds = _ROUNDS
    if not centre.size:
        return None
    best = float(centre[0])
    for _ in range(rounds):
        near = centre[:, None] + reach[:, None] * np.linspace(-1.0, 1.0, _OF_A_ROUND)
        near = np.clip(near, asked[0], asked[-1])
        levels = level(near)
        centre = near[np.arange(centre.size), levels.argmax(axis=1)]
        reach = reach / _NARROWER
        best = float(centre[levels.max(axis=1).argmax()])
    found = read(row, model.at(np.array([best])))
    return Extreme(best, float(np.abs(found.value[0])), float(found.error[0]))


def _tops(asked: Floats, level: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
    """Local maxima of a level between the frequencies asked for, and the reach of each."""
    parts = -(-_TRIALS // asked.size)
    places = np.arange(parts * (asked.size - 1) + 1) / parts
    trials = np.interp(places, np.arange(asked.size), asked)
    found = level(trials)
    rises = np.concatenate([[True], found[1:] > found[:-1]])
    falls = np.concatenate([found[:-1] >= found[1:], [True]])
    tops = np.flatnonzero(rises & falls & np.isfinite(found))
    return trials[tops], np.gradient(trials)[tops]
