"""Agreement of models: their numbers side by side, and the cheapest model of a wanted accuracy.

:func:`compare` says of each difference whether the numerical errors cover it, or the modelling
error does, or only the model's form can be named.
:func:`choose` takes the cheapest model whose modelling and numerical error together are small
enough, without a field solution.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.readout import ModalReadout
from tactgen.validation.catalogue.models import MODELS, gives, ranked
from tactgen.validation.catalogue.quantities import QUANTITIES, Actuator, QuantityRow, quantities_of
from tactgen.validation.engine.answers import NONE, NOT_KNOWN, modelling_at
from tactgen.validation.engine.solve import recorded, solve
from tactgen.validation.models.classes import model_class
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.scene import Scene

Verdict = Literal["reference", "agrees", "explained", "model form", "differs"]

#: Models of one theory agree to this fraction, whatever their error bars say.
_SAME_THEORY = 1e-8

#: By actuator: models from the cheapest on, the last of them of the most detailed theory.
_LADDERS: Mapping[Actuator, tuple[str, ...]] = {
    "bimorph": ("lumped", "tmm", "calibrated", "solid"),
    "reluctance": ("network", "axisymmetric"),
    "generator": ("lumped", "tmm", "calibrated", "solid"),
    "display": ("lumped", "tmm", "calibrated", "solid"),
}
#: The last one where the first choice cannot take the scene.
_INSTEAD = {"solid": "cad"}

_ONE_DIMENSIONAL = "one-dimensional: uniform field, no Poisson effect, no d32"
_ON_ROD = "joint to the rod: rigid head around the slot, plane sections where tab and ceramic meet"
_TUBES = (
    "flux tubes of assumed shape; not modelled: the field outside the sleeve (except tubes that "
    "start on the head), the field below the flange, leakage from the shaft between collar and head"
)
_BEYOND = "more than numerical and modelling error together"
_SAME_EQUATIONS = (
    "both models solve the same equations, so their error bars should cover the difference"
)


@dataclass(frozen=True)
class Cell:
    """One model's value: number, errors, difference from the reference, verdict."""

    model: str
    value: float
    error: float  #: Numerical
    modelling: str  #: Modelling error as people read it
    difference: float
    verdict: Verdict
    why: str


@dataclass(frozen=True)
class ComparedRow:
    """One quantity by all models; the first bending mode in x stands for a list of modes."""

    info: QuantityRow
    cells: tuple[Cell, ...]

    @property
    def quantity(self) -> str:
        """Name of the quantity."""
        return self.info.name

    @property
    def unit(self) -> str:
        """SI unit of the values."""
        return self.info.unit

    @property
    def most_detailed(self) -> Cell:
        """Value by the most detailed of the models that ran: what a report heads."""
        return self.cells[-1]

    @property
    def remarks(self) -> list[str]:
        """Reasons why models differ beyond their errors."""
        named: dict[str, list[str]] = {}
        for cell in self.cells:
            if cell.why:
                named.setdefault(cell.why, []).append(cell.model)
        return [f"{', '.join(models)}: {why}" for why, models in named.items()]


def compare(scene: Scene, quantities: Sequence[Quantity], actuator: Actuator) -> list[ComparedRow]:
    """Compare all single numbers about an actuator with those of the most detailed model."""
    rows = []
    for row in (QUANTITIES[name] for name in quantities_of(actuator)):
        by_model = {q.model: q for q in quantities if q.name == row.name}
        # of a list of modes the first stands for it, of any other list no entry does
        single = isinstance(row.read, ModalReadout) or not any(
            q.value.ndim for q in by_model.values()
        )
        if by_model and single and not row.by_frequency:
            found = [by_model[model] for model in ranked(tuple(by_model))]
            rows.append(ComparedRow(row, tuple(_cell(scene, row, q, found[-1]) for q in found)))
    return rows


def _cell(scene: Scene, row: QuantityRow, q: Quantity, reference: Quantity) -> Cell:
    (value, bar, modelling, words), (base, base_bar, *_) = _first(q), _first(reference)
    difference = 0.0 if value == base else np.inf
    if base != 0.0:
        difference = value / base - 1.0

    def cell(verdict: Verdict, why: str = "") -> Cell:
        return Cell(q.model, value, bar, words, difference, verdict, why)

    if q is reference:
        return cell("reference")
    bars, apart = bar + base_bar, abs(value - base)
    if (np.isnan(value) and np.isnan(base)) or apart <= bars + 1e-12 * abs(base):
        return cell("agrees")
    model = MODELS[q.model]
    shortcut = "" if row.static else model.shortcut
    if model.theory == MODELS[reference.model].theory:
        if shortcut:
            return cell("model form", shortcut)
        if abs(difference) < _SAME_THEORY:
            return cell("agrees")
        return cell("differs", f"{_SAME_EQUATIONS}; cause unknown")
    if math.isfinite(modelling):
        covered = apart <= bars + modelling
        return cell("explained") if covered else cell("differs", _BEYOND)
    reason = _TUBES if model.theory == "circuit" else _ONE_DIMENSIONAL
    on_rod = scene.support.kind == "rod" and model.theory != "circuit"
    return cell("model form", f"{reason}; {_ON_ROD}" if on_rod else reason)


def _first(q: Quantity) -> tuple[float, float, float, str]:
    """Scalar, or the first bending mode in x of a list; nan if there is none.

    With its numerical and its modelling error, the latter in words, too.
    """
    if q.classes is not None and "bending_x" not in q.classes:
        return math.nan, math.nan, math.nan, NONE if MODELS[q.model].detailed else NOT_KNOWN
    place = () if q.classes is None else (q.classes.index("bending_x"),)
    parts = (q.value, q.error, q.modelling_error)
    value, error, modelling = (float(np.asarray(one)[place]) for one in parts)
    return value, error, modelling, modelling_at(q, place)


# The cheapest model of a wanted accuracy


def share(value: float) -> str:
    """Error as people write it."""
    return f"{100.0 * value:.2g} %" if math.isfinite(value) else "not known"


@dataclass(frozen=True)
class FidelityLevel:
    """Model with its known error."""

    model: str  #: Its name
    #: Largest relative error of the equations that it solves; 0 of the most detailed theory
    form: float
    #: Largest relative numerical error; of a model that refines its mesh, what is asked for
    numerical: float
    seconds: float | None  #: Recorded cost of its stages; None if they never ran on this machine
    meets: bool  #: Whether both together are within the accuracy asked for
    worst: str  #: The quantity that decides

    @property
    def sentence(self) -> str:
        """Known error of the model, as a sentence."""
        cost = "cost not recorded yet" if self.seconds is None else f"about {self.seconds:.2g} s"
        verdict = "meets it" if self.meets else "does not meet it"
        where = f" ({self.worst})" if self.worst else ""
        return (
            f"{self.model} {verdict}: modelling error {share(self.form)}{where}, numerical error "
            f"{share(self.numerical)}, {cost}"
        )


@dataclass(frozen=True)
class Choice:
    """The models that answer, with the ladders that they were chosen from.

    `scenes` is in how many scenes each model was judged; the ladders have the worst of them.
    """

    models: tuple[str, ...]
    ladders: tuple[tuple[FidelityLevel, ...], ...]
    accuracy: float
    scenes: int = 1

    @property
    def sentences(self) -> tuple[str, ...]:
        """Reasons for the choice of models."""
        return tuple(
            f"requested accuracy {share(self.accuracy)}{_where(self.scenes)}: "
            + "; ".join(rung.sentence for rung in ladder)
            for ladder in self.ladders
        )


def choose(
    scenes: Sequence[Scene],
    quantities: Sequence[str],
    announce: Callable[[str], None] = lambda _: None,
) -> Choice:
    """Cheapest models whose known error meets the accuracy in every one of the scenes.

    Raises InputError if none does, with what each would give at worst.
    """
    actuators = dict.fromkeys(QUANTITIES[name].actuator for name in quantities)
    accuracy = min(scene.accuracy for scene in scenes)
    ladders, models = [], []
    for actuator in actuators:
        wanted = tuple(q for q in quantities if QUANTITIES[q].actuator == actuator)
        rungs = ladder(scenes, actuator, wanted, announce)
        meeting = [rung.model for rung in rungs if rung.meets]
        if not meeting:
            raise InputError(
                f"no model meets accuracy = {accuracy:g}{_where(len(scenes))}: "
                + "; ".join(rung.sentence for rung in rungs)
                + "; set a larger accuracy, or name a --model and check its error bar"
            )
        ladders.append(rungs)
        models.append(meeting[0])
    return Choice(tuple(dict.fromkeys(models)), tuple(ladders), accuracy, len(scenes))


def _where(scenes: int) -> str:
    return "" if scenes == 1 else f" (worst of {scenes} points for each model)"


def ladder(
    scenes: Sequence[Scene],
    actuator: Actuator,
    quantities: tuple[str, ...],
    announce: Callable[[str], None] = lambda _: None,
) -> tuple[FidelityLevel, ...]:
    """Model hierarchy with the largest errors of each in these quantities, cheapest first.

    The last is the judge; a model that does not take one of the scenes is left out.
    """
    judge = _judge(actuator, scenes, quantities)
    every = []
    for model in (m for m in _LADDERS[actuator][:-1] if all(gives(m, q) for q in quantities)):
        with contextlib.suppress(InputError):  # of a scene that it does not take
            every.append([_level(scene, model, quantities, announce) for scene in scenes])
    stages = {s for q in quantities for s in MODELS[judge].stages_for(QUANTITIES[q])}
    known = [cost for stage, cost in recorded().items() if stage in stages]
    cost = sum(known) if known else None
    finest = [(model_class(judge).finest(scene), scene.accuracy) for scene in scenes]
    every.append([FidelityLevel(judge, 0.0, max(f, of), cost, f <= of, "") for f, of in finest])
    return tuple(map(_worst, every))


def _level(
    scene: Scene, model: str, quantities: tuple[str, ...], announce: Callable[[str], None]
) -> FidelityLevel:
    """Model that is no judge, with its errors on one scene."""
    found = solve(scene, (model,), quantities, announce)
    errors = {q.name: _errors(q, scene) for q in found.quantities}
    form = {name: both[0] for name, both in errors.items() if not math.isnan(both[0])}
    numerical = max((both[1] for both in errors.values()), default=0.0)
    worst = max(form, key=form.__getitem__, default="")
    largest, seconds = form.get(worst, math.inf), sum(found.stages.seconds.values())
    meets = largest + numerical <= scene.accuracy
    return FidelityLevel(model, largest, numerical, seconds, meets, worst)


def _worst(levels: Sequence[FidelityLevel]) -> FidelityLevel:
    """One model's level over several scenes."""
    worst = max(levels, key=lambda level: (not level.meets, level.form + level.numerical))
    costs = [level.seconds for level in levels if level.seconds is not None]
    return replace(worst, seconds=max(costs, default=None))


def _judge(actuator: Actuator, scenes: Sequence[Scene], quantities: Sequence[str]) -> str:
    """Model that judges the others, or the one in its place if that takes the scenes.

    Raises InputError if neither takes all scenes, or does not give a quantity.
    """
    judge = _LADDERS[actuator][-1]
    for name in quantities:
        if not gives(judge, name):
            raise InputError(
                f"accuracy without a model is judged by {judge}, which does not compute {name}; "
                "name a --model and check its error bar"
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


def _errors(q: Quantity, scene: Scene) -> tuple[float, float]:
    """Largest relative modelling and numerical error of a quantity.

    Of modes those of bending in x count, which every theory knows.  Infinite where an error is not
    known or modes are missing, nan where there is nothing to compare.
    """
    if q.value.ndim > 1:  # entries of a matrix have no common scale
        return math.nan, 0.0
    if q.classes is not None and q.value.size < scene.modes:  # a one-mode circuit
        return math.inf, 0.0
    value, bar, modelling = (np.atleast_1d(a) for a in (q.value, q.error, q.modelling_error))
    if q.classes is not None:
        bends = np.array(q.classes) == "bending_x"
        value, bar, modelling = value[bends], bar[bends], modelling[bends]
    known = np.isfinite(value) & (np.abs(value) > 0.0)
    if not known.any():
        return math.nan, 0.0
    size = np.abs(value[known])
    form = np.where(np.isfinite(modelling[known]), modelling[known] / size, np.inf)
    return float(form.max()), float((bar[known] / size).max())
