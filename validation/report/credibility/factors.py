"""The factors of credibility, each computed from the evidence of a report."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.report.credibility.evidence import Evidence, speaks_for
from tactgen.validation.report.credibility.levels import Criterion, Factor

if TYPE_CHECKING:
    from tactgen.validation.checks.verification import Verified
    from tactgen.validation.models.comparison import Cell, ComparedRow

#: Share of a headline number's variance (Sobol's total index) from which a parameter counts as
#: one that the number rests on.
IMPORTANT = 0.05
#: Shares of the parameters read that have been varied: "many" and "most" of the standard.
MANY, MOST = 0.5, 0.9
_VERIFY = "tactgen verify"


def factors(evidence: Evidence) -> tuple[Factor, ...]:
    """Return all factors, in the order of the standard."""
    return (
        code_verification(evidence),
        solution_verification(evidence),
        validation(evidence),
        input_pedigree(evidence),
        uncertainty(evidence),
        robustness(evidence),
        use_history(evidence),
    )


def code_verification(evidence: Evidence) -> Factor:
    """Are the equations solved right?  Known answers, by the models of this report."""
    rows = evidence.known
    run = [row for row in rows if row.outcome is not None]
    held = [row for row in run if row.verdict == "pass"]
    failed = [row.check.id for row in run if row.verdict == "fail"]
    spoken_for = {name for row in held for name in speaks_for(row)}
    silent = [name for name in evidence.models if name not in spoken_for]
    light = [row.check.id for row in rows if not row.check.heavy and row.outcome is None]
    heavy = [row.check.id for row in rows if row.check.heavy and row.outcome is None]
    ids = _ids(held)
    return Factor(
        "Verification of the code",
        (
            Criterion(
                "Known answers are reproduced by models of this report.",
                f"{len(held)} of {len(rows)} rows that concern them ran with this code and hold.",
                bool(held), f"run {_VERIFY}", ids,
            ),
            Criterion(
                "Each model has a known answer of its own, and none fails.",
                _either(failed, "failed", _either(silent, "without one", "Each has.")),
                not silent and not failed,
                f"mend what fails; {_VERIFY} runs the rows, and a model without one needs a case",
                ids,
            ),
            Criterion(
                "All light rows were run with this very code.",
                _either(light, "not run", "All were."), not light, f"run {_VERIFY}",
            ),
            Criterion(
                "All heavy rows, with fine meshes, were run with it too.",
                _either(heavy, "not run", "All were."), not heavy, f"run {_VERIFY} --heavy",
            ),
        ),
    )  # fmt: skip


def solution_verification(evidence: Evidence) -> Factor:
    """Are these numbers solved finely enough?  Error bars of the numbers of this report."""
    rows = [row for row in evidence.compared if math.isfinite(row.cells[-1].value)]
    cells = [(row, cell) for row in rows for cell in row.cells if math.isfinite(cell.value)]
    barless = _named((r, c) for r, c in cells if not math.isfinite(c.error))
    differ = _named((r, c) for r, c in cells if c.verdict == "differs")
    best = [(row, row.cells[-1]) for row in rows]
    wide = [(r, c) for r, c in best if not c.error <= evidence.accuracy * abs(c.value)]
    headline = _named((r, c) for r, c in wide if r.info.headline)
    accuracy = f"{100.0 * evidence.accuracy:g} %"
    remedy = "a finer mesh (--set accuracy or mesh.level), or a coarser accuracy that is enough"
    return Factor(
        "Verification of the solution",
        (
            Criterion(
                "Every number carries a numerical error bar.",
                _either(barless, "without one", f"All {len(cells)} do."),
                bool(cells) and not barless, "name models that give one", ("SV",),
            ),
            Criterion(
                "Models that solve the same equations agree within their bars.",
                _either(differ, "beyond them", "No number differs that should not."),
                not differ, "find the cause, or mend the bar", ("Models side by side",),
            ),
            Criterion(
                f"The headline numbers of the most detailed model reach the {accuracy} asked for.",
                _either(headline, "wider", "All do."), not headline, remedy, ("SV",),
            ),
            Criterion(
                f"All {len(best)} numbers of the most detailed model reach it.",
                _either(_named(wide), "wider", "All do."), not wide, remedy, ("SV",),
            ),
        ),
    )  # fmt: skip


def validation(evidence: Evidence) -> Factor:
    """Is it the right model?  Other theories, and what was measured on this device."""
    theories = sorted({MODELS[name].theory for name in evidence.models})
    cells = [(row, cell) for row in evidence.compared for cell in row.cells]
    differ = _named((r, c) for r, c in cells if c.verdict == "differs")
    form = _named((r, c) for r, c in cells if c.verdict == "model form")
    about = [o for o in evidence.outcomes if o.check.tier == "validation"]
    by = {
        status: [o.check.id for o in about if o.status == status]
        for status in ("pass", "explained", "fail")
    }
    told = (
        f"{len(by['pass'])} rows hold, {len(by['explained'])} are explained, "
        f"{len(by['fail'])} fail."
    )
    remedy = "measure this device, and add what was measured as rows"
    if not evidence.as_it_stands:
        told = "The scene is not one that was measured: it is changed, or one's own."
    ids = tuple(o.check.id for o in about)
    return Factor(
        "Validation",
        (
            Criterion(
                "More than one theory was asked, and no difference is left without a reason.",
                f"Theories: {', '.join(theories)}. "
                + _either(differ, "without a reason", "Every difference has one."),
                len(theories) > 1 and not differ,
                "ask models of another theory (--model all)", ("Models side by side",),
            ),
            Criterion(
                "Each difference between theories is measured cause by cause.",
                _either(form, "explained by the theory's form alone", "All are."),
                len(theories) > 1 and not form,
                "bridges for these quantities", ("From the beam to the solid",),
            ),
            Criterion(
                "Measurements on this very device agree, or are explained.",
                told, bool(by["pass"]) and not by["fail"], remedy, ids,
            ),
            Criterion(
                "All measurements agree, none for a constant that was chosen so that they do.",
                told, bool(by["pass"]) and not (by["fail"] or by["explained"]), remedy, ids,
            ),
        ),
    )  # fmt: skip


def input_pedigree(evidence: Evidence) -> Factor:
    """Where do the parameters come from?  Their sources, and how much the numbers rest on each."""
    parameters = evidence.parameters
    assumed = {row.key for row in parameters if row.assumed}
    nameless = [row.key for row in parameters if not row.source]
    rests = _rests_on(evidence)
    most = [label for label, shares in rests.items() if _assumed_share(shares, assumed) > 0.5]
    important = sorted(
        {k for shares in rests.values() for k in _above(shares, IMPORTANT) if k in assumed}
    )
    share = f"{100.0 * IMPORTANT:g} %"
    unknown = "No number's spread was traced to its parameters."
    return Factor(
        "Input pedigree",
        (
            Criterion(
                "Every parameter says where its value comes from.",
                _either(nameless, "without a source", f"All {len(parameters)} do."),
                bool(parameters) and not nameless, "state the source", ("Parameters",),
            ),
            Criterion(
                "Documents, not assumptions, carry most of each headline number's spread.",
                _either(most, "rest mostly on assumptions", "They do.") if rests else unknown,
                bool(rests) and not most,
                "measure what these rest on: see Sobol's indices", ("Uncertainty",),
            ),
            Criterion(
                f"No assumed parameter carries {share} or more of any of them.",
                _either(important, "they carry that much", "None does.") if rests else unknown,
                bool(rests) and not important,
                "measure these, or take them from a data sheet", ("Uncertainty",),
            ),
            Criterion(
                "No parameter is assumed at all.",
                f"{len(assumed)} of {len(parameters)} are.",
                bool(parameters) and not assumed, "measure every dimension and constant",
                ("Parameters",),
            ),
        ),
    )  # fmt: skip


def uncertainty(evidence: Evidence) -> Factor:
    """How uncertain are the numbers?  Numerical bars, and the parameters' ranges."""
    cells = [c for row in evidence.compared for c in row.cells if math.isfinite(c.value)]
    bars = [c for c in cells if math.isfinite(c.error)]
    found = evidence.uncertainties
    sampled = [row for row in found if row.total]
    remedy = "tactgen sensitivity --sobol, for scenes of the lateral actuator"
    return Factor(
        "Uncertainty of the results",
        (
            Criterion(
                "Numerical uncertainty is stated.",
                f"{len(bars)} of {len(cells)} numbers have a bar.", bool(bars),
                "name models that give one", ("SV",),
            ),
            Criterion(
                "What the parameters' ranges do to the headline numbers is stated.",
                f"It is for {len(found)} numbers.", bool(found), remedy, ("Uncertainty",),
            ),
            Criterion(
                "All ranges were sampled at once, and the spread apportioned.",
                f"It is for {len(sampled)} of {len(found)} numbers.",
                bool(found) and len(sampled) == len(found), remedy, ("Uncertainty",),
            ),
            Criterion(
                "The most detailed model gives each of these numbers its own numerical bar.",
                f"It does for {evidence.both_bars} of {len(found)}.",
                bool(found) and evidence.both_bars >= len(found),
                "ask the detailed model at these frequencies", ("Uncertainty",),
            ),
        ),
    )  # fmt: skip


def robustness(evidence: Evidence) -> Factor:
    """Do small changes keep the numbers?  Numerics driven to their limits; sensitivities."""
    stressed = evidence.stressed
    broken = [row.family for row in stressed if row.verdict == "fails"]
    varied = {key for row in evidence.uncertainties for key in row.slopes}
    read = len(evidence.parameters)
    share = len(varied) / read if read else 0.0
    told = f"{len(varied)} of {read} parameters were varied ({100.0 * share:.0f} %)."
    remedy = "give more parameters a range (tactgen sensitivity --key)"
    return Factor(
        "Robustness of the results",
        (
            Criterion(
                "The numerics were driven far beyond this scene and held, or said why not.",
                _either(broken, "failed", f"{len(stressed)} families of hard cases."),
                bool(stressed) and not broken, "tactgen stress, and mend what fails",
                tuple(row.family for row in stressed),
            ),
            Criterion(
                "Sensitivities to some parameters are known.", told, bool(varied), remedy,
                ("Uncertainty",),
            ),
            Criterion(
                f"Sensitivities to at least {100.0 * MANY:g} % of the parameters are known.", told,
                share >= MANY, remedy, ("Uncertainty",),
            ),
            Criterion(
                f"Sensitivities to at least {100.0 * MOST:g} % of them are known.", told,
                share >= MOST, remedy, ("Uncertainty",),
            ),
        ),
    )  # fmt: skip


def use_history(evidence: Evidence) -> Factor:
    """Has it served before?  A program knows its tests only, not what was decided by it."""
    held = [o.check.id for o in evidence.outcomes if o.status == "pass"]
    failed = [o.check.id for o in evidence.outcomes if o.status == "fail"]
    known = [row.check.id for row in evidence.known if row.verdict == "pass"]
    return Factor(
        "Use history",
        (
            Criterion(
                "It passes simple tests.",
                _either(failed, "fail", f"{len(held) + len(known)} rows hold."),
                bool(held or known) and not failed, f"run {_VERIFY}", tuple(held or known),
            ),
            Criterion(
                "Decisions were made by it before, and turned out well.",
                "This program keeps no record of that, and claims none.",
                False, "the record of whoever used it: state it beside this report",
            ),
        ),
    )  # fmt: skip


def _rests_on(evidence: Evidence) -> dict[str, dict[str, float]]:
    """Return each headline number's total indices by parameter."""
    return {
        row.target.label: {key: index for key, (index, _) in row.total.items()}
        for row in evidence.uncertainties
        if row.total
    }


def _assumed_share(shares: dict[str, float], assumed: set[str]) -> float:
    whole = sum(max(s, 0.0) for s in shares.values())
    part = sum(max(s, 0.0) for key, s in shares.items() if key in assumed)
    return part / whole if whole else 0.0


def _above(shares: dict[str, float], least: float) -> list[str]:
    return [key for key, share in shares.items() if share >= least]


def _named(cells: Iterable[tuple[ComparedRow, Cell]]) -> list[str]:
    return [f"{row.info.label} by {cell.model}" for row, cell in cells]


def _ids(rows: Sequence[Verified]) -> tuple[str, ...]:
    return tuple(row.check.id for row in rows)


def _either(found: Sequence[str], what: str, otherwise: str) -> str:
    """Return what was found with its count, or the sentence for when nothing was."""
    if not found:
        return otherwise
    shown = ", ".join(found[:4])
    more = f" and {len(found) - 4} more" if len(found) > 4 else ""
    return f"{what[0].upper()}{what[1:]}: {shown}{more}."
