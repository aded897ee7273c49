"""Agreement of models: their numbers side by side, and the cheapest model of a wanted accuracy.

:func:`compare` says of each difference whether the error bars cover it, or the measured causes
(:mod:`validation.models.difference`) account for it, or only the model's form can be named.
:func:`choose` measures each model's error of form on the device itself: against the most detailed
theory on its coarsest mesh, whose own error is added.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.readout import ModalReadout
from tactgen.validation.catalogue.models import MODELS, ModelRow, gives, ranked
from tactgen.validation.catalogue.quantities import QUANTITIES, Actuator, QuantityRow, quantities_of
from tactgen.validation.engine.solve import recorded, solve
from tactgen.validation.models.classes import model_class
from tactgen.validation.models.difference import Cause
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.scene import Scene

Verdict = Literal["reference", "agrees", "explained", "model form", "differs"]

#: A difference is explained if the causes account for all but this fraction of the value and what
#: the bars allow: they are told apart on coarser meshes.
UNEXPLAINED = 2e-3
#: Fraction that a shortcut of a model may be worth beside what the bridge follows, where no model
#: of the same theory without it was asked for, whose difference measures it.
_SHORTCUT = 0.01
#: Models of one theory agree to this fraction, whatever their error bars say.
_SAME_THEORY = 1e-8

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

_ONE_DIMENSIONAL = "one-dimensional: uniform field, no Poisson effect, no d32"
_ON_ROD = "joint to the rod: rigid head around the slot, plane sections where tab and ceramic meet"
_TUBES = (
    "flux tubes of assumed shape; not modelled: the field outside the sleeve (except tubes that "
    "start on the head), the field below the flange, leakage from the shaft between collar and head"
)
_SAME_EQUATIONS = (
    "both models solve the same equations, so their error bars should cover the difference"
)


@dataclass(frozen=True)
class Cell:
    """One model's value: number, error bar, difference from the reference, verdict.

    `left` is what measured causes leave of the difference, beyond the bars (a fraction of the
    value): 0 where the bars cover it, nan where no causes were measured.
    """

    model: str
    value: float
    error: float
    difference: float
    verdict: Verdict
    why: str
    left: float = 0.0


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


def compare(
    scene: Scene,
    quantities: Sequence[Quantity],
    actuator: Actuator,
    causes: Sequence[Cause] | None = None,
) -> list[ComparedRow]:
    """Compare all single numbers about an actuator with those of the most detailed model.

    Parameters
    ----------
    causes : sequence of Cause, optional
        Why the simplest theory is not the most detailed one, each with its share, which can
        explain a difference.
    """
    rows = []
    for row in (QUANTITIES[name] for name in quantities_of(actuator)):
        by_model = {q.model: q for q in quantities if q.name == row.name}
        # of a list of modes the first stands for it, of any other list no entry does
        single = isinstance(row.read, ModalReadout) or not any(
            q.value.ndim for q in by_model.values()
        )
        if by_model and single and not row.by_frequency:
            found = [by_model[model] for model in ranked(tuple(by_model))]
            cells = tuple(_cell(scene, row, q, found, causes) for q in found)
            rows.append(ComparedRow(row, cells))
    return rows


def _cell(
    scene: Scene,
    row: QuantityRow,
    q: Quantity,
    found: Sequence[Quantity],
    causes: Sequence[Cause] | None,
) -> Cell:
    reference = found[-1]
    (value, bar), (base, base_bar) = _first(q), _first(reference)
    difference = 0.0 if value == base else np.inf
    if base != 0.0:
        difference = value / base - 1.0
    if q is reference:
        return Cell(q.model, value, bar, difference, "reference", "")
    neither = np.isnan(value) and np.isnan(base)
    if neither or abs(value - base) <= bar + base_bar + 1e-12 * abs(base):
        return Cell(q.model, value, bar, difference, "agrees", "")
    model, size = MODELS[q.model], abs(base) or np.inf
    shortcut = "" if row.static else model.shortcut
    if model.theory == MODELS[reference.model].theory:
        if shortcut:
            return Cell(q.model, value, bar, difference, "model form", shortcut, np.nan)
        if abs(difference) < _SAME_THEORY:
            return Cell(q.model, value, bar, difference, "agrees", "")
        why = f"{_SAME_EQUATIONS}; cause unknown"
        return Cell(q.model, value, bar, difference, "differs", why, np.nan)
    shares = {c.name: c.shares[row.name] for c in causes or () if row.name in c.shares}
    # what the shortcut is worth beside the same theory without it
    plain = (p for p in found if MODELS[p.model].theory == model.theory)
    plain = (p for p in plain if not MODELS[p.model].shortcut)
    whole = next((_first(p)[0] for p in plain), np.nan)
    if shares and shortcut and not np.isnan(whole):
        shares[shortcut], shortcut = (value - whole) / np.copysign(size, base), ""
    bars, granted = (bar + base_bar) / size, _SHORTCUT if shortcut else 0.0
    verdict, why, left = _explained(scene, model, shares, difference, bars, granted)
    why = f"{why}; {shortcut}" if shortcut else why
    return Cell(q.model, value, bar, difference, verdict, why, left)


def _explained(
    scene: Scene,
    model: ModelRow,
    shares: Mapping[str, float],
    difference: float,
    bars: float,
    granted: float,
) -> tuple[Verdict, str, float]:
    """Verdict on a difference (as its bars, a fraction) by measured shares, reason, the rest."""
    on_rod = scene.support.kind == "rod"
    if not shares:
        reason = _TUBES if model.theory == "circuit" else _ONE_DIMENSIONAL
        joint = f"; {_ON_ROD}" if on_rod and model.theory != "circuit" else ""
        return "model form", reason + joint, np.nan
    together = sum(shares.values())
    left = (1.0 + difference) / (1.0 + together) - 1.0
    named = ", ".join(f"{name} {_points(share)}" for name, share in shares.items())
    reason = f"{named}: sum {_points(together)} %, difference {_points(difference)} %"
    beyond = max(abs(left) - bars, 0.0)
    if beyond > UNEXPLAINED and on_rod:  # no step measures the joint
        return "model form", f"{reason}; {_points(left)} % attributed to the {_ON_ROD}", beyond
    if beyond > UNEXPLAINED + granted:
        return "differs", f"{reason}; {_points(left)} % unexplained", beyond
    return "explained", reason, beyond


def _points(share: float) -> str:
    """Fraction in percent, two decimals, without the sign of a nought."""
    return f"{round(100.0 * share, 2) + 0.0:+.2f}"


def _first(q: Quantity) -> tuple[float, float]:
    """Scalar, or the first bending mode in x of a list, with its error bar."""
    if q.classes is None:
        return float(q.value), float(q.error)
    if "bending_x" not in q.classes:
        return float("nan"), float("nan")
    at = q.classes.index("bending_x")
    return float(np.asarray(q.value)[at]), float(np.asarray(q.error)[at])


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
        judge = _judge(actuator, scenes, wanted)
        rungs = _worst([ladder(scene, actuator, wanted, announce, judge) for scene in scenes])
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


def _worst(ladders: Sequence[tuple[FidelityLevel, ...]]) -> tuple[FidelityLevel, ...]:
    """Rungs of several scenes as one ladder, with the largest errors of each model."""
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
    announce: Callable[[str], None],
    judge: str,
) -> tuple[FidelityLevel, ...]:
    """Model hierarchy: known errors in these quantities by a judge, cheapest first."""
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
        rungs.append(FidelityLevel(
            model, form.get(worst, math.inf), numerical,
            sum(found.stages.seconds.values()), total <= scene.accuracy, worst,
        ))  # fmt: skip
    finest = model_class(judge).finest(scene)
    stages = {s for q in quantities for s in MODELS[judge].stages_for(QUANTITIES[q])}
    known = [costs[stage] for stage in stages if stage in costs]
    rungs.append(FidelityLevel(
        judge, 0.0, max(finest, scene.accuracy), sum(known) if known else None,
        finest <= scene.accuracy, "",
    ))  # fmt: skip
    return tuple(rungs)


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


def _error(found: Quantity, reference: Quantity) -> tuple[float, float]:
    """Model's largest relative error of form and numerical error in a quantity.

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
