"""What a report has in hand about its own credibility, gathered from its study."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactgen.validation.catalogue.models import ranked
from tactgen.validation.checks.verification import Verified, recalled_rows, verify

if TYPE_CHECKING:
    from tactgen.validation.checks.row import Outcome
    from tactgen.validation.checks.stress.result import Row as StressRow
    from tactgen.validation.models.comparison import ComparedRow
    from tactgen.validation.report.study import Study
    from tactgen.validation.scene.parameter_list import ParameterRow
    from tactgen.validation.studies.parameter_uncertainty import Uncertainty

#: Whose equations the known answers of a group are solved by: for cases by their id, for the
#: group's others under "".
SPEAKS_FOR: dict[str, dict[str, tuple[str, ...]]] = {
    "beams": {"": ("lumped", "tmm"), "P5H": ("solid",), "FV5S": ("solid",)},
    "laminates": {"": ("solid",)},
    "resonators": {"": ("solid",)},
    "elastic": {"": ("solid",)},
    "coils": {"": ("axisymmetric",)},
    "iron": {"": ("magnetic3d",)},
    "orders": {
        "": ("solid",), "MMSC": ("cad",), "MMSE": ("cad",), "BEAMO": ("beam",),
        "AXIO": ("axisymmetric",), "MAGO": ("magnetic3d",),
    },
    "bimorph": {"TMM": ("tmm",), "FIN": ("tmm",), "BEA": ("beam",), "SOL": ("solid",)},
    "reluctance": {
        "COI": ("axisymmetric",), "SOL": ("axisymmetric",), "ACT": ("axisymmetric",),
        "VM213": ("network",), "LOOP": ("network", "axisymmetric"),
        "EULER": ("axisymmetric",),
        "BALL": ("magnetic3d",), "VM188": ("magnetic3d",),
    },
    "motion": {}, "amplitude": {}, "display": {}, "misprints": {},
}  # fmt: skip


@dataclass(frozen=True)
class Evidence:
    """All that the levels are computed from.

    Attributes
    ----------
    models : tuple of str
        The models of the report.
    accuracy : float
        The relative numerical error that the scene asks for.
    known : tuple of Verified
        Answers known from elsewhere to what these models solve.
    compared : tuple of ComparedRow
        The scene's numbers by all models.
    outcomes : tuple of Outcome
        The suite's rows about this very scene.
    as_it_stands : bool
        Whether the scene is a built-in one that nothing was changed of.
    parameters : tuple of ParameterRow
        What the models read, with sources.
    uncertainties : tuple of Uncertainty
        What the parameters' ranges do to the headline numbers.
    both_bars : int
        To how many of these numbers the most detailed model gives its own bar.
    stressed : tuple of StressRow
        How far beyond use the numerics hold.
    """

    models: tuple[str, ...]
    accuracy: float
    known: tuple[Verified, ...] = ()
    compared: tuple[ComparedRow, ...] = ()
    outcomes: tuple[Outcome, ...] = ()
    as_it_stands: bool = False
    parameters: tuple[ParameterRow, ...] = ()
    uncertainties: tuple[Uncertainty, ...] = ()
    both_bars: int = 0
    stressed: tuple[StressRow, ...] = ()


def gathered(study: Study) -> Evidence:
    """Return the evidence of a study, once its other sections are there.

    A quick report runs no answer known from elsewhere: it counts those that ``tactgen verify``
    has left in the store for this very code.
    """
    shown = study.shown
    models = tuple(ranked(tuple(study.solution.models)))
    uncertainty, stress = shown.get("uncertainty", {}), shown.get("stress", {})
    return Evidence(
        models=models,
        accuracy=study.scene.accuracy,
        known=known_rows(models, quick=study.quick, announce=study.announce),
        compared=tuple(study.compared),
        outcomes=tuple(study.outcomes),
        as_it_stands=study.as_it_stands,
        parameters=tuple(study.parameters),
        uncertainties=tuple(uncertainty.get("uncertainties", ())),
        both_bars=len(uncertainty.get("detailed", ())),
        stressed=tuple(row for part in stress.get("stress", ()) for row in part.rows),
    )


def speaks_for(row: Verified) -> tuple[str, ...]:
    """Return the models whose equations a known answer is solved by."""
    named = SPEAKS_FOR.get(row.group, {})
    return named.get(row.case.id, named.get("", ()))


def known_rows(
    models: tuple[str, ...], *, quick: bool, announce: Callable[[str], None]
) -> tuple[Verified, ...]:
    """Return the code verification of the models, as far as it was run with this code."""
    groups = [
        group
        for group, named in SPEAKS_FOR.items()
        if any(set(of_case) & set(models) for of_case in named.values())
    ]
    ran = {} if quick else {
        (row.group, row.check.id): row for row in verify(groups, extent="quick", announce=announce)
    }  # fmt: skip
    return tuple(
        ran.get((row.group, row.check.id), row) if row.outcome is None else row
        for row in recalled_rows(groups)
        if row.check.tier == "code verification" and set(speaks_for(row)) & set(models)
    )
