"""Modelling errors: how far a model's answer may be from that of the most detailed one.

What is known of the difference is computed by a calibrated model on the same scene; how far that
may be off it says itself.  Nothing is solved on a mesh.  Nature is another question.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES, DrivenReadout, Need
from tactgen.validation.engine.extremes import extreme
from tactgen.validation.engine.readout import read
from tactgen.validation.models.bimorph.calibrated import CalibratedModel
from tactgen.validation.models.model import Estimate, Model, Modelling, Quantity, Stages
from tactgen.validation.scene.scene import Scene

#: Analyses that the pull of the coil takes part in.
_OF_THE_MACHINE: tuple[Need, ...] = ("small_signal", "machine_poles", "crosstalk", "spread")
#: What beam theory reads off any model's motion: how far the field is from it is not known.
_OF_BEAM_THEORY = Modelling(np.nan, np.nan, "beam theory reads it off every model's motion")
#: Quantities that are looked up in the network's map alone.
_BY_MAP = ("resting_positions",)


def with_modelling(
    scene: Scene, found: Sequence[Quantity], models: Mapping[str, Model]
) -> tuple[Quantity, ...]:
    """Quantities with their modelling errors, as far as one is known."""
    of_beam = cache(lambda: _calibrated(scene))
    judges: dict[str, Callable[[], Model | None]] = {
        "beam": of_beam, "calibrated": of_beam,
        "circuit": cache(lambda: _corrected(models.get("network"))),
    }  # fmt: skip
    estimate = cache(lambda name, judge: read(QUANTITIES[name], judge))

    def judged(q: Quantity) -> Quantity:
        if isinstance(QUANTITIES[q.name].read, DrivenReadout):
            return replace(q, modelling=_OF_BEAM_THEORY)
        made = judges.get(MODELS[q.model].theory)
        judge = made() if made is not None and _asked(scene, q) else None
        return q if judge is None else _judged(q, estimate(q.name, judge), judge)

    return tuple(map(judged, found))


def _asked(scene: Scene, q: Quantity) -> bool:
    """Whether the quantity depends on nothing that no calibration knows."""
    pulled = MODELS[q.model].actuator == "bimorph" and scene.map_model == "network"
    of_machine = QUANTITIES[q.name].needs[0] in _OF_THE_MACHINE
    held = scene.support.kind == "contact" and scene.coil.current != 0.0
    return q.name not in _BY_MAP and not (pulled and (of_machine or held))


def _calibrated(scene: Scene) -> Model | None:
    """Calibrated model whose errors say how far the solid may be; None where it has no answer."""
    try:
        CalibratedModel.check(scene)
    except InputError:
        return None
    stages = Stages({f"calibrated.{stage}": "" for stage in MODELS["calibrated"].stages})
    return CalibratedModel(scene, stages, against_solid=True)


def _corrected(network: Model | None) -> Model | None:
    """Network whose errors say how far the field may be."""
    from tactgen.validation.models.reluctance.model import CalibratedNetwork, NetworkModel

    return CalibratedNetwork(network) if isinstance(network, NetworkModel) else None


def _judged(q: Quantity, found: Estimate, judge: Model) -> Quantity:
    """Quantity with what the most detailed model is expected to answer."""
    value, error = np.asarray(found.value), np.asarray(found.error)
    if value.ndim and q.classes is not None:  # a one-mode circuit has the first alone
        value, error = value[: q.value.size], error[: q.value.size]
    if value.shape != np.shape(q.value):  # such as poles of which another model has more
        return q
    peak = q.extreme
    top = extreme(QUANTITIES[q.name], judge, peak.frequency) if peak else None
    if peak and top:
        peak = replace(peak, expected=top.value, expected_error=top.error)
    return replace(q, modelling=Modelling(value, error, found.method), extreme=peak)
