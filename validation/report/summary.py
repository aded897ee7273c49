"""The report's first page: headline values, what they rest on, what could be wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import numpy as np

from tactgen.geometry.device.material_library import curve_in_words
from tactgen.geometry.formats import engineering, percent, with_error
from tactgen.validation.catalogue.models import MODELS, ranked
from tactgen.validation.catalogue.quantities import QUANTITIES, TIP_DISPLACEMENT, VOLTAGE_LIMIT
from tactgen.validation.engine.answers import representative
from tactgen.validation.engine.comparison import ComparedRow
from tactgen.validation.engine.warnings import accuracy_warnings
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections import gallery
from tactgen.validation.scene.conditions import conditions


@dataclass(frozen=True)
class Headline:
    """One result by the most detailed model that ran."""

    label: str
    value: str  #: With its numerical error
    model: str
    modelling: str  #: Difference of other theories, or its expected band


@dataclass(frozen=True)
class Counts:
    """Checks of a scene by result: a miss is a miss, whether a reason is stated or not."""

    passed: int
    missed: int
    failed: int
    consistent: int  #: Models whose ports are reciprocal and passive
    inconsistent: int

    @property
    def sentence(self) -> str:
        """Counts in words."""
        total = self.passed + self.missed + self.failed
        known = (
            f"Of {total} known answers and measurements of this device {self.passed} are met, "
            f"{self.missed} are missed for a stated reason and {self.failed} fail."
            if total
            else "No measurement or known answer of this device is in the program."
        )
        models = self.consistent + self.inconsistent
        return known + (
            f" Reciprocal and passive: {self.consistent} of {models} models." if models else ""
        )


def counted(study: Study) -> Counts:
    """Results of the checks that are about this very scene."""
    found = [outcome.status for outcome in study.outcomes]
    holds = [row["holds"] for row in study.invariants]
    return Counts(
        passed=found.count("pass"),
        missed=found.count("explained"),
        failed=found.count("fail"),
        consistent=sum(holds),
        inconsistent=len(holds) - sum(holds),
    )


def summary(study: Study) -> dict[str, Any]:
    """Context of the first page."""
    uncertain = study.parameter_uncertainty if study.lateral else []
    figure, values = _figure(study)
    return {
        "conditions": conditions(study.scene),
        "steel": curve_in_words(study.scene.steel.curve),
        "pictures": gallery.pictures(study),
        "headlines": [*_numbers(study), *_extremes(study)],
        "figure": figure,
        "values": values,
        "rests_on_models": _rests_on_models(study),
        "known": [u for u in uncertain if u.target.quantity.headline],
        "parameters": study.parameters,
        "doubts": list(_doubts(study)),
        "reconstructed": study.normal is not None and study.normal.is_papers,
    }


def _numbers(study: Study) -> Iterator[Headline]:
    """Headline numbers of the comparison, by its reference."""
    for row in study.compared:
        cell = row.most_detailed
        if not row.info.headline or not math.isfinite(cell.value):
            continue
        others = [
            f"{c.model} {percent(c.difference, 1)}"
            for c in row.cells[:-1]
            if MODELS[c.model].theory != MODELS[cell.model].theory and math.isfinite(c.difference)
        ]
        yield Headline(
            _label(study, row),
            with_error(cell.value, cell.error, row.unit),
            cell.model,
            ", ".join(others) or _modelling(cell.model, cell.modelling),
        )


def _modelling(model: str, error: str) -> str:
    """Modelling error of the value, where no other theory stands beside it."""
    return "none: most detailed theory" if MODELS[model].detailed else error


def _label(study: Study, row: ComparedRow) -> str:
    if study.normal is None or "magnetic_point" not in row.info.needs:
        return row.info.label
    current = engineering(study.normal.current, "A")
    return f"{row.info.label} at {current}, {engineering(study.scene.gap, 'm')}"


def _extremes(study: Study) -> Iterator[Headline]:
    """Largest displacement, least voltage limit and what was named over the band."""
    scene = study.scene
    limit = (VOLTAGE_LIMIT,) if scene.circuit.kind == "source" else ()
    named = (row for name in scene.quantities if (row := QUANTITIES[name]).by_name)
    for info in (TIP_DISPLACEMENT, *limit, *named):
        by_model = study.solution.by_model(info.name)
        shown = {
            m: r
            for m in ranked(by_model)
            if not math.isnan((r := representative(by_model[m])).value)
        }
        if not shown or all(r.at is None for r in shown.values()):
            continue
        model, best = list(shown.items())[-1]
        others = [
            f"{m} {percent(r.value / best.value - 1.0, 1)}"
            for m, r in shown.items()
            if MODELS[m].theory != MODELS[model].theory and best.value
        ]
        where = "" if best.at is None else f" at {engineering(best.at, 'Hz', 4)}"
        yield Headline(
            f"{info.label}, {best.what}{where}",
            with_error(best.value, best.error, best.unit),
            model,
            ", ".join(others) or _modelling(model, best.modelling),
        )


def _figure(study: Study) -> tuple[str, str]:
    """Responses of the bimorph, or force families of the normal actuator; values to point at."""
    if study.lateral:
        from tactgen.validation.report.sections.bimorph import response_curves
        from tactgen.validation.report.sections.bimorph_figures import (
            magnitude_plot,
            response_values,
        )

        frequency, curves = np.asarray(study.scene.frequency), response_curves(study)
        several = len(frequency) > 1
        return magnitude_plot(frequency, curves), response_values(frequency, curves) * several
    return study.shown["characteristics"]["forces"], ""


def _rests_on_models(study: Study) -> str:
    """Models, and the widest numerical error."""
    errors = study.relative_errors
    what, widest = max(errors.items(), key=itemgetter(1), default=("", 0.0))
    wide = sum(error > study.scene.accuracy for error in errors.values())
    asked = f"{100.0 * study.scene.accuracy:g} %"
    met = f"{wide or 'none'} exceed{'s' if wide < 2 else ''}"
    named = f" ({what})" if what else ""
    models = ranked({cell.model for row in study.compared for cell in row.cells})
    return (
        f"Models: {', '.join(models)}. Numerical errors (distance from the exact solution of the "
        f"same model) are {100.0 * widest:.2g} % at most in the single numbers{named}; {met} the "
        f"requested {asked}."
    )


def _doubts(study: Study) -> Iterator[str]:
    """Known limits of this report, as sentences."""
    scene = study.scene
    for row in study.compared:
        for cell in row.cells:
            if cell.verdict == "differs":
                yield (
                    f"The models {cell.model} and {row.most_detailed.model} solve the same "
                    f"equations, but their errors do not cover the difference in {row.info.label}."
                )
    for actuator, detailed in (("bimorph", "solid"), ("reluctance", "axisymmetric")):
        estimated = [
            row.info.label for row in study.compared
            if not row.info.by_frequency and MODELS[row.most_detailed.model].quick
            and MODELS[row.most_detailed.model].actuator == actuator
            and row.most_detailed.modelling != "not known"
        ]  # fmt: skip
        if estimated:
            yield (
                f"No detailed model was solved for {', '.join(estimated)}. The modelling errors "
                f"are estimated from random devices; add --model {detailed}."
            )
    yield from (f"{text[0].upper()}{text[1:]}." for text in _inaccurate(study))
    if study.machine:
        yield (
            "This report is about the machine. The reports of its bimorph (support.kind = clamped) "
            "and of its reluctance actuator (models = network, axisymmetric) have more about each."
        )
    if study.lateral and scene.support.kind == "spring":
        yield (
            "The support is linear. The scene generator has a head that rocks on its stop at "
            "larger drive."
        )


def _inaccurate(study: Study) -> list[str]:
    """Warnings of errors beyond the accuracy that the solution has not given already."""
    found = accuracy_warnings(study.scene, study.solution.quantities)
    return [text for text in found if text not in study.solution.warnings]
