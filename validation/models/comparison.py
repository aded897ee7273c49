"""The models side by side: what the error bars explain, what the bridge does, what is left."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from tactgen.tmm.ports.readout import ModalReadout
from tactgen.validation.catalogue.models import MODELS, ModelRow, ranked
from tactgen.validation.catalogue.needs import Actuator
from tactgen.validation.catalogue.quantities import QUANTITIES, quantities_of
from tactgen.validation.catalogue.row import QuantityRow
from tactgen.validation.engine.results import Quantity
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

_ONE_DIMENSIONAL = "one-dimensional: uniform field, no Poisson effect, no d32"
_ON_ROD = "on the rod: head rigid around the slot, sections plane where tab and ceramic meet"
_TUBES = (
    "flux runs in tubes of assumed shape; left out are the field outside the sleeve but for tubes "
    "that start on the head, the field below the flange, and the shaft between collar and head "
    "as a source of leakage"
)
_SAME_EQUATIONS = "both solve the same equations, so their error bars should cover this"


class Cause(Protocol):
    """A named reason why a simpler model differs, with what it adds to each quantity's ratio."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def of(self) -> Mapping[str, float]:
        """By quantity, what it adds to (simpler / detailed − 1)."""


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
    def remarks(self) -> list[str]:
        """Why models differ beyond their error bars, each reason once."""
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
        if by_model and not row.by_frequency and not _is_list(row, by_model.values()):
            found = [by_model[model] for model in ranked(tuple(by_model))]
            cells = tuple(_cell(scene, row, q, found, causes) for q in found)
            rows.append(ComparedRow(row, cells))
    return rows


def _is_list(row: QuantityRow, found: Iterable[Quantity]) -> bool:
    """Return whether a quantity is a list of which no entry stands for it, unlike modes."""
    return not isinstance(row.read, ModalReadout) and any(q.value.ndim for q in found)


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
    covered = abs(value - base) <= bar + base_bar + 1e-12 * abs(base)
    covered |= np.isnan(value) and np.isnan(base)  # neither model has a value
    verdict: Verdict = "agrees"
    why, left = "", 0.0
    if q is reference:
        verdict = "reference"
    elif not covered:
        models = MODELS[q.model], MODELS[reference.model]
        size = abs(base) or np.inf
        by_shortcut = (value - _without_shortcut(q, found)) / (np.copysign(size, base))
        apart = difference, (bar + base_bar) / size, by_shortcut
        verdict, why, left = _judge(scene, row, models, apart, causes)
    return Cell(q.model, value, bar, difference, verdict, why, left)


def _without_shortcut(q: Quantity, found: Sequence[Quantity]) -> float:
    """Return what a model without shortcut makes of the same theory; nan if none was asked."""
    theory = MODELS[q.model].theory
    plain = [p for p in found if MODELS[p.model].theory == theory and not MODELS[p.model].shortcut]
    return _first(plain[0])[0] if plain else float("nan")


def _judge(
    scene: Scene,
    row: QuantityRow,
    models: tuple[ModelRow, ModelRow],
    apart: tuple[float, float, float],
    causes: Sequence[Cause] | None,
) -> tuple[Verdict, str, float]:
    """Return the verdict on a difference that error bars do not cover, its reason, what is left.

    `apart` holds as fractions the difference, the bars together, and what of it is the shortcut.
    """
    (difference, bars, by_shortcut), (model, reference) = apart, models
    shortcut = "" if row.static else model.shortcut
    if model.theory == reference.theory:
        if shortcut:
            return "model form", shortcut, np.nan
        if abs(difference) < _SAME_THEORY:
            return "agrees", "", 0.0
        return "differs", f"{_SAME_EQUATIONS}; not understood", np.nan
    shares = {c.name: c.of[row.name] for c in causes or () if row.name in c.of}
    if not shares:
        reason = _left_out(scene, model)
        return "model form", f"{reason}; {shortcut}" if shortcut else reason, np.nan
    if shortcut and not np.isnan(by_shortcut):
        shares[shortcut], shortcut = by_shortcut, ""
    together = sum(shares.values())
    left = (1.0 + difference) / (1.0 + together) - 1.0
    named = ", ".join(f"{name} {_points(share)}" for name, share in shares.items())
    reason = f"{named}: together {_points(together)} %, of {_points(difference)} %"
    if shortcut:
        reason += f"; {shortcut}"
    beyond = max(abs(left) - bars, 0.0)
    if beyond > UNEXPLAINED + (_SHORTCUT if shortcut else 0.0):
        return "differs", f"{reason}; {_points(left)} % unexplained", beyond
    return "explained", reason, beyond


def _left_out(scene: Scene, model: ModelRow) -> str:
    """Return in words what a model leaves out, where no causes are told apart."""
    if model.theory == "circuit":
        return _TUBES
    reason = _ONE_DIMENSIONAL
    if scene.support.kind == "rod":
        reason += f"; and {_ON_ROD}"
    return reason


def _points(share: float) -> str:
    """Return a fraction in percent, two decimals, without the sign of a nought."""
    return f"{round(100.0 * share, 2) + 0.0:+.2f}"


def _first(q: Quantity) -> tuple[float, float]:
    """Return a scalar, or the first bending mode in x of a list, with its error bar."""
    if q.classes is None:
        return float(q.value), float(q.error)
    if "bending_x" not in q.classes:
        return float("nan"), float("nan")
    at = q.classes.index("bending_x")
    return float(np.asarray(q.value)[at]), float(np.asarray(q.error)[at])
