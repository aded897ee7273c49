"""The report's first page: headline values, what they rest on, what could be wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator
from operator import itemgetter

import numpy as np

from tactgen.geometry.device.steel_library import curve_in_words
from tactgen.geometry.formats import engineering, percent, share, with_error
from tactgen.validation.catalogue.models import MODELS, ranked
from tactgen.validation.catalogue.quantities import QUANTITIES, TIP_DISPLACEMENT, VOLTAGE_LIMIT
from tactgen.validation.engine.answers import representative
from tactgen.validation.engine.comparison import ComparedRow
from tactgen.validation.engine.warnings import accuracy_warnings
from tactgen.validation.report.report_data import Context, Study
from tactgen.validation.report.sections import gallery
from tactgen.validation.scene.conditions import conditions

#: One result by the most detailed model that ran: label, value with its numerical error, model, and
#: the difference of other theories or the expected band of it.
Headline = tuple[str, str, str, str]


def counted(study: Study) -> Context:
    """Checks of this very scene by result, in words, and how many fail.

    A miss is a miss, whether a reason is stated or not.
    """
    found = [outcome.status for outcome in study.outcomes]
    passed, missed, failed = (found.count(of) for of in ("pass", "explained", "fail"))
    sentence = "No measurement or known answer of this device is in the program."
    if found:
        sentence = (
            f"Of {len(found)} known answers and measurements of this device {passed} are met, "
            f"{missed} are missed for a stated reason and {failed} fail."
        )
    if holds := [row["holds"] for row in study.invariants]:
        sentence += f" Reciprocal and passive: {sum(holds)} of {len(holds)} models."
    return {"sentence": sentence, "failed": failed}


def summary(study: Study) -> Context:
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
        value = with_error(cell.value, cell.error, row.unit)
        modelling = ", ".join(others) or _modelling(cell.model, cell.modelling)
        yield _label(study, row), value, cell.model, modelling


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
        value = with_error(best.value, best.error, best.unit)
        modelling = ", ".join(others) or _modelling(model, best.modelling)
        yield f"{info.label}, {best.what}{where}", value, model, modelling


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
    models = ranked(dict.fromkeys(cell.model for row in study.compared for cell in row.cells))
    return (
        f"Models: {', '.join(models)}. Numerical errors (distance from the exact solution of the "
        f"same model) are {share(widest)} at most in the single numbers{named}; {met} the "
        f"requested {asked}."
    )


def _doubts(study: Study) -> Iterator[str]:
    """Known limits of this report, as sentences."""
    scene = study.scene
    for row in study.compared:
        for cell in row.cells:
            if cell.verdict == "differs":
                other = row.most_detailed.model
                same = MODELS[cell.model].theory == MODELS[other].theory
                yield (
                    f"The models {cell.model} and {other} solve the same equations, but their "
                    f"errors do not cover the difference in {row.info.label}."
                    if same
                    else f"The difference of {cell.model} from {other} in {row.info.label} is "
                    "larger than its modelling error."
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
    for text in accuracy_warnings(scene, study.solution.quantities):
        if text not in study.solution.warnings:  # they are given already
            yield f"{text[0].upper()}{text[1:]}."
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
