"""What the reader of the normal actuator's numbers must be told: no value, or a curve too short."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout, Need
from tactgen.validation.models.reluctance.switching import SwitchingCurrents
from tactgen.validation.scene.scene import Scene

#: Share of the iron beyond the end of its curve that is worth a word: less is a corner or two.
WORTH_A_WORD = 0.01


def magnetic_warnings(
    model: str,
    scene: Scene,
    quantities: Sequence[str],
    answer: Callable[[Need], Any],
) -> tuple[str, ...]:
    """Return what a model's answers to these quantities leave to say."""
    found: list[str] = []
    beyond = 0.0
    of_stroke = _read_off("magnetic_map", quantities)
    if of_stroke:
        currents: SwitchingCurrents = answer("magnetic_map")
        beyond = currents.beyond_table
        missing = [name for name, read in of_stroke.items() if np.isnan(read.of(currents).value)]
        if missing:
            found.append(_unreached(model, scene, missing, currents.limit))
    others: tuple[Need, ...] = ("magnetic_point", "rest")
    for need in others:
        if _read_off(need, quantities):
            beyond = max(beyond, answer(need).beyond_table)
    if beyond > WORTH_A_WORD:
        found.append(_too_short(scene, model, beyond))
    return tuple(found)


def _read_off(need: Need, quantities: Sequence[str]) -> dict[str, AnswerReadout]:
    reads = {name: QUANTITIES[name].read for name in quantities}
    return {
        name: read
        for name, read in reads.items()
        if isinstance(read, AnswerReadout) and read.need == need
    }


def _unreached(model: str, scene: Scene, missing: Sequence[str], limit: float) -> str:
    spring = scene.spring
    have = "have" if len(missing) > 1 else "has"
    return (
        f"{' and '.join(missing)} {have} no value in the model {model}: with up to "
        f"{limit * 1e3:.3g} mA the pull does not reach the spring's force everywhere "
        f"(spring.preload = {spring.preload * 1e3:g} mN, spring.stiffness = "
        f"{spring.stiffness:g} N/m); use a softer spring, a smaller gap or more coil.turns"
    )


def _too_short(scene: Scene, model: str, share: float) -> str:
    return (
        f"{100.0 * share:.2g} % of the iron is magnetised beyond the end of steel.curve = "
        f"{scene.steel.curve} (model {model}), which stops before the steel is saturated: beyond "
        "it the iron is taken for saturated; measure or continue the curve to higher B"
    )
