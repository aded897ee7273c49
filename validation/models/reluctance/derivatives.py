"""Derivatives of the network at its point: what :mod:`validation.engine.derivatives` asks for.

The network is solved to rounding, so that its differences can be close; what is left is how many
cells its ladder has.  They are taken of ladders of twice and four times the usual cells, and the
bar is how far those of three ladders are apart, in place of what the values' bars would leave open
if they had nothing to do with one another.  As cells pass the knee of the iron's curve two ladders
may agree by chance, so the bar is never less, in relation, than that of the value.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tactgen.geometry.arrays import Floats, Numbers
from tactgen.tmm.reluctance.circuit import CELLS, FULL, circuit
from tactgen.tmm.reluctance.flux_ladder import solve as solve_ladder
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout
from tactgen.validation.engine.derivatives import (
    PLACES,
    Changed,
    Derivatives,
    extrapolated,
    noise,
)
from tactgen.validation.engine.results import Estimate
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.reluctance.point import MagneticPoint
from tactgen.validation.scene.nearby import value_of
from tactgen.validation.scene.scene import Scene

#: Cells of the ladders, in units of those that a value is computed with.
_LADDERS = (4, 2, 1)
#: Relative distance of the values: the truncation, as its fourth power, is then below what
#: rounding leaves open, unless an element of the iron passes a corner of its curve in between.
_DISTANCE = 2e-3
#: A value that counts as none.
_TINY = float(np.finfo(float).tiny)
#: Relative rounding of a value: Newton's residual of 1e-12 through the sums of the energy.
_ROUNDING = 1e-11


def gives_derivatives(scene: Scene, quantity: str) -> bool:
    """Return whether it is a value at one current and gap."""
    return QUANTITIES[quantity].needs == ("magnetic_point",)


def exact_derivatives(
    scene: Scene,
    changed: Changed,
    quantities: Sequence[str],
    keys: Sequence[str],
    announce: Callable[[str], None] = lambda _: None,
) -> list[Derivatives]:
    """Return quantities of the scene by the network, each with its derivatives by `keys`.

    Raises
    ------
    InputError
        If the network does not know the scene, or one next to it makes no device.
    """
    base = solve(scene, ("network",), quantities, announce)
    slopes: dict[str, dict[str, Numbers]] = {name: {} for name in quantities}
    bars: dict[str, dict[str, Floats]] = {name: {} for name in quantities}
    for number, key in enumerate(keys):
        announce(f"network: derivative {number + 1} of {len(keys)}, {key}")
        value = float(value_of(scene, key))
        distance = _DISTANCE * abs(value)
        near = [_ladders(changed(key, value + place * distance)) for place in PLACES]
        for name in quantities:
            levels = [np.array([_read(p[n], name) for p in near]) for n in range(len(_LADDERS))]
            (finest, own), (finer, _), (usual, _) = (extrapolated(at, distance) for at in levels)
            rounding = noise(_ROUNDING * np.abs(levels[0]).max(), distance)
            # what is the same to the last bit does not depend on the key
            same = bool((levels[0] == levels[0][0]).all())
            values = levels[0].mean(), levels[1].mean()
            # in relation to its size a derivative is off by no less than its value
            least = np.abs(finest) * abs(values[0] - values[1]) / max(abs(values[0]), _TINY)
            apart = np.max([abs(finest - finer), abs(finest - usual) / 3.0, least])
            slopes[name][key] = finest
            bars[name][key] = np.asarray(0.0 if same else apart + own + rounding)
    method = (
        f"central differences at {100 * _DISTANCE:g} and {50 * _DISTANCE:g} % of the network "
        "solved to rounding, extrapolated, with four times the cells of its ladder; the bar is "
        "how far those with fewer cells are off, with truncation and rounding; the network's own "
        "error is not included"
    )
    return [
        Derivatives(base.get(name, "network"), slopes[name], bars[name], method)
        for name in quantities
    ]


def _ladders(scene: Scene) -> tuple[MagneticPoint, ...]:
    """Return the network at a scene's point by each of the ladders, without bars."""
    current, gap = scene.coil.current, scene.gap
    found = []
    for times in _LADDERS:
        ladder = circuit(scene.device, np.array([gap]), FULL, times * CELLS)
        at = solve_ladder(ladder, np.array([current]))
        force, linkage, energy, inductance = (
            Estimate(float(values[0, 0]), 0.0)
            for values in (at.force, at.flux_linkage, at.coenergy, at.incremental_inductance)
        )
        found.append(MagneticPoint(current, gap, force, linkage, energy, inductance, "", 0.0))
    return tuple(found)


def _read(point: MagneticPoint, name: str) -> float:
    read = QUANTITIES[name].read
    assert isinstance(read, AnswerReadout)
    return float(read.of(point).value)
