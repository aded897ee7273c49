"""The accuracy contract: the cheapest model whose known error meets what is asked answers.

What a model leaves out is measured on the device itself: against the next more detailed theory,
on its coarsest mesh, whose own error bar is added.  The bridge (:mod:`validation.models.bimorph.
bridge`) tells what such a difference is made of.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS, gives
from tactgen.validation.catalogue.needs import Actuator
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.costs import recorded
from tactgen.validation.engine.model import model_class
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import Scene

#: By actuator: models from the cheapest on, the last of them of the most detailed theory.
_LADDERS: Mapping[Actuator, tuple[str, ...]] = {
    "bimorph": ("lumped", "tmm", "solid"),
    "reluctance": ("network", "axisymmetric"),
    "generator": ("lumped", "tmm", "solid"),
    "display": ("lumped", "tmm", "solid"),
}
#: The last one where the first choice cannot take the scene.
_INSTEAD = {"solid": "cad"}
#: Accuracy at which the last one judges the others: its coarsest mesh.
_COARSE = 0.1


def share(value: float) -> str:
    """Return an error as people write it."""
    return f"{100.0 * value:.2g} %" if math.isfinite(value) else "not known"


@dataclass(frozen=True)
class Rung:
    """One model with what is known of its error.

    Attributes
    ----------
    model : str
        Its name.
    form : float
        Largest relative error of the equations that it solves; 0 of the most detailed theory.
    numerical : float
        Largest relative numerical error; of a model that refines its mesh, what is asked for.
    seconds : float or None
        Recorded cost of its stages; None if they never ran on this machine.
    meets : bool
        Whether both together are within the accuracy asked for.
    worst : str
        The quantity that decides.
    """

    model: str
    form: float
    numerical: float
    seconds: float | None
    meets: bool
    worst: str

    @property
    def sentence(self) -> str:
        """What is known of the model, for the reader."""
        cost = "cost not recorded yet" if self.seconds is None else f"about {self.seconds:.2g} s"
        verdict = "meets" if self.meets else "does not meet"
        where = f" ({self.worst})" if self.worst else ""
        return (
            f"{self.model} {verdict} it: model form {share(self.form)}{where}, numerical "
            f"{share(self.numerical)}, {cost}"
        )


@dataclass(frozen=True)
class Choice:
    """The models that answer, with the ladders that they were chosen from.

    `scenes` is in how many scenes each model was judged; the ladders have the worst of them.
    """

    models: tuple[str, ...]
    ladders: tuple[tuple[Rung, ...], ...]
    accuracy: float
    scenes: int = 1

    @property
    def sentences(self) -> tuple[str, ...]:
        """Why these models answer."""
        return tuple(
            f"accuracy {share(self.accuracy)} is asked for{_where(self.scenes)}: "
            + "; ".join(rung.sentence for rung in ladder)
            for ladder in self.ladders
        )


def choose(
    scene: Scene, quantities: Sequence[str], announce: Callable[[str], None] = lambda _: None
) -> Choice:
    """Return the cheapest models whose known error meets the scene's accuracy.

    Raises
    ------
    InputError
        If none does, with what each would give.
    """
    return choose_for((scene,), quantities, announce)


def choose_for(
    scenes: Sequence[Scene],
    quantities: Sequence[str],
    announce: Callable[[str], None] = lambda _: None,
) -> Choice:
    """Return the cheapest models whose known error meets the accuracy in every one of the scenes.

    Raises
    ------
    InputError
        If none does, with what each would give at worst.
    """
    actuators = dict.fromkeys(QUANTITIES[name].actuator for name in quantities)
    accuracy = min(scene.accuracy for scene in scenes)
    ladders, models = [], []
    for actuator in actuators:
        wanted = tuple(q for q in quantities if QUANTITIES[q].actuator == actuator)
        judge = _judge(actuator, scenes, wanted)
        rungs = _worst([ladder(scene, actuator, wanted, announce, judge) for scene in scenes])
        meeting = [rung.model for rung in rungs if rung.meets]
        if not meeting:
            raise InputError(
                f"accuracy = {accuracy:g} is met by no model{_where(len(scenes))}: "
                + "; ".join(rung.sentence for rung in rungs)
                + "; ask for less, or name a --model and judge its error bar"
            )
        ladders.append(rungs)
        models.append(meeting[0])
    return Choice(tuple(dict.fromkeys(models)), tuple(ladders), accuracy, len(scenes))


def _where(scenes: int) -> str:
    return "" if scenes == 1 else f" (each model at the worst of {scenes} points tried)"


def _worst(ladders: Sequence[tuple[Rung, ...]]) -> tuple[Rung, ...]:
    """Return the rungs of several scenes as one ladder, with the largest errors of each model."""
    found = []
    for rungs in zip(*ladders, strict=True):
        worst = max(rungs, key=lambda rung: (not rung.meets, rung.form + rung.numerical))
        costs = [rung.seconds for rung in rungs if rung.seconds is not None]
        found.append(replace(worst, seconds=max(costs, default=None)))
    return tuple(found)


def ladder(
    scene: Scene,
    actuator: Actuator,
    quantities: tuple[str, ...],
    announce: Callable[[str], None] = lambda _: None,
    judge: str = "",
) -> tuple[Rung, ...]:
    """Return what is known of each model's error in these quantities, cheapest first.

    The most detailed model, `judge`, is that which can take the scene if none is given.
    """
    judge = judge or _judge(actuator, (scene,), quantities)
    simple = [m for m in _LADDERS[actuator][:-1] if all(gives(m, q) for q in quantities)]
    level = {"mesh": scene.mesh.model_copy(update={"level": 0}), "accuracy": _COARSE}
    announce(f"{judge} on its coarsest mesh, to judge the others")
    reference = solve(scene.model_copy(update=level), (judge,), quantities, announce)
    costs, rungs = recorded(), []
    for model in simple:
        found = solve(scene, (model,), quantities, announce)
        errors = {
            q: _error(found.get(q, model), reference.get(q, judge))
            for q in quantities
        }  # fmt: skip
        form = {q: both[0] for q, both in errors.items() if not math.isnan(both[0])}
        numerical = max((both[1] for both in errors.values()), default=0.0)
        worst = max(form, key=form.__getitem__, default="")
        total = form.get(worst, math.inf) + numerical
        rungs.append(Rung(
            model, form.get(worst, math.inf), numerical,
            sum(found.stages.seconds.values()), total <= scene.accuracy, worst,
        ))  # fmt: skip
    finest = model_class(judge).finest(scene)
    stages = {s for q in quantities for s in MODELS[judge].stages_for(QUANTITIES[q])}
    known = [costs[stage] for stage in stages if stage in costs]
    rungs.append(Rung(
        judge, 0.0, max(finest, scene.accuracy), sum(known) if known else None,
        finest <= scene.accuracy, "",
    ))  # fmt: skip
    return tuple(rungs)


def _judge(actuator: Actuator, scenes: Sequence[Scene], quantities: Sequence[str]) -> str:
    """Return the model that judges the others, or the one in its place if that takes the scenes.

    Raises
    ------
    InputError
        If neither takes all scenes, or does not give a quantity.
    """
    judge = _LADDERS[actuator][-1]
    for name in quantities:
        if not gives(judge, name):
            raise InputError(
                f"accuracy without a model is judged by {judge}, which does not compute {name}; "
                "name a --model and judge its error bar"
            )
    try:
        for scene in scenes:
            model_class(judge).check(scene)
    except InputError:
        if judge not in _INSTEAD:
            raise
        judge = _INSTEAD[judge]
        for scene in scenes:
            model_class(judge).check(scene)
    return judge


def _error(found: Quantity, reference: Quantity) -> tuple[float, float]:
    """Return a model's largest relative error of form and numerical error in a quantity.

    Of modes those of bending in x are compared, which every theory knows; infinite if a model
    has fewer than were asked for, nan if there is nothing to compare.
    """
    if found.value.ndim > 1:  # entries of a matrix have no common scale
        return math.nan, 0.0
    value, bar = _comparable(found)
    judged, judged_bar = _comparable(reference)
    if value.size < judged.size:  # a one-mode circuit does not know the second
        return math.inf, 0.0
    count = judged.size
    value, bar, judged, judged_bar = (a[:count] for a in (value, bar, judged, judged_bar))
    known = np.isfinite(judged) & np.isfinite(value) & (np.abs(judged) > 0.0)
    if not known.any():
        return math.nan, 0.0
    size = np.abs(judged[known])
    form = (np.abs(value - judged)[known] + judged_bar[known]) / size
    return float(form.max()), float((bar[known] / size).max())


def _comparable(q: Quantity) -> tuple[np.ndarray, np.ndarray]:
    value, bar = np.atleast_1d(q.value), np.atleast_1d(q.error)
    if q.classes is not None:
        bends = np.array(q.classes) == "bending_x"
        value, bar = value[bends], bar[bends]
    return value, bar
