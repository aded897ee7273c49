"""Verdicts on models side by side: what the bars cover agrees, and nothing else does."""

import numpy as np
import pytest

from tactgen.validation.catalogue.needs import Actuator
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph.beam_values import Values
from tactgen.validation.models.bimorph.bridge import Rung, bridge
from tactgen.validation.models.bimorph.bridge.causes import (
    BRIDGED,
    in_the_rod,
    on_a_clamp,
    total,
)
from tactgen.validation.models.bimorph.bridge.generator import GeneratorChain
from tactgen.validation.models.comparison import compare
from tactgen.validation.scene.scene import load_scene


def verdict(model, value, bar, reference, reference_bar=0.0, name="static_tip_displacement"):
    """Return the verdict on a model's value beside the reference's 1."""
    scene, _ = load_scene("paper")
    found = [
        Quantity(
            name=name,
            model=m,
            value=np.asarray(v),
            unit="m",
            error=np.asarray(b),
            method="",
            seconds=0.0,
        )
        for m, v, b in ((model, value, bar), (reference, 1.0, reference_bar))
    ]
    (row,) = compare(scene, found, LATERAL)
    assert row.cells[-1].verdict == "reference"
    return row.cells[0].verdict


LATERAL: Actuator = "bimorph"


@pytest.mark.parametrize(
    ("bar", "reference_bar", "expected"),
    [
        (0.011, 0.0, "agrees"),
        (0.0, 0.011, "agrees"),
        (0.006, 0.005, "agrees"),
        (0.009, 0.0, "model form"),
        (0.0, 0.009, "model form"),
        (0.001, 0.001, "model form"),
    ],
)
def test_both_bars_cover_or_the_models_differ(bar, reference_bar, expected):
    """1 % apart: the bars together must reach."""
    assert verdict("tmm", 1.01, bar, "solid", reference_bar) == expected


@pytest.mark.parametrize(("off", "expected"), [(0.9e-8, "agrees"), (1.1e-8, "differs")])
def test_one_theory_leaves_nothing_to_explain(off, expected):
    """Transfer matrices and beam elements solve one equation: 1e-8, or something is wrong."""
    assert verdict("tmm", 1.0 + off, 0.0, "beam") == expected


#: Own layers: a brass shim and a soft ceramic of the trade.
OWN = (
    "bimorph.length=18mm", "bimorph.piezo_thickness=0.2mm", "bimorph.shim_thickness=0.1mm",
    "piezo.material=PZT-5H", "shim.material=brass", "drive.voltage=40V", "load.kind=none",
)  # fmt: skip


def rung(name, *values):
    return Rung(name, "", Values(*values))


def test_causes_add_up_to_the_difference():
    """Each cause's share of (beam / solid − 1), and their sum is all of it, to rounding."""
    rungs = [
        rung("TMM", 1.0, 500.0, 2.0, 520.0, 0.27, 1.8),
        rung("field", 0.98, 505.0, 1.95, 524.0, 0.268, 1.8),
        rung("d32", 0.9, 510.0, 1.8, 529.0, 0.265, 1.7),
    ]
    causes = on_a_clamp(rungs)
    assert [c.name for c in causes] == ["field", "d32"]
    whole = [a / b - 1.0 for a, b in zip(rungs[0].values, rungs[-1].values, strict=True)]
    assert total(causes) == pytest.approx(whole, rel=1e-13)
    assert causes[0].share.deflection == pytest.approx(0.02 / 0.9)


@pytest.mark.parametrize(
    ("beside", "verdict", "said"),
    [
        # 4 % by the field, 1 % by the shortcut: together all of it
        ({"tmm": 1.04}, "explained", "static shapes +1.00: together +5.00 %, of +5.00 %"),
        # the shortcut is worth 0.2 %, which leaves 0.8 % of it
        ({"tmm": 1.048}, "differs", "static shapes +0.20: together +4.20 %, of +5.00 %"),
        ({}, "explained", "together +4.00 %, of +5.00 %; the inertia is that of the static shapes"),
    ],
)
def test_a_shortcut_is_measured_by_a_model_without_it(beside, verdict, said):
    """Of one theory, with and without: its share; unmeasured, 1 % is granted."""
    scene, _ = load_scene("paper")
    values = {"lumped": [1.05], "solid": [1.0]} | {m: [v] for m, v in beside.items()}
    found = [
        Quantity(
            name="short_circuit_frequencies",
            model=m,
            value=np.array(v),
            unit="Hz",
            error=np.zeros(1),
            classes=("bending_x",),
        )
        for m, v in values.items()
    ]
    causes = on_a_clamp([rung("TMM", 1.0, 1.04, 1.0, 1.0, 1.0, 1.0), rung("field", *([1.0] * 6))])
    (row,) = compare(scene, found, LATERAL, causes)
    assert row.cells[0].model == "lumped"
    assert row.cells[0].verdict == verdict
    assert said in row.cells[0].why


def compared(scene, causes, models):
    """Return the cells of the values that a bridge follows, by quantity."""
    solution = solve(scene, models)
    rows = compare(scene, solution.quantities, LATERAL, causes)
    return {row.quantity: row for row in rows if row.quantity in BRIDGED}


@pytest.mark.heavy
def test_named_causes_are_the_difference_of_ones_own_device():
    """Brass, PZT-5H, 18 mm on a clamp: the shares add up to tmm against solid within the bars."""
    scene, _ = load_scene("paper", [*OWN, "support.kind=clamped", "mesh.level=2"])
    causes = on_a_clamp(bridge(scene, lambda _: None, sections=False))
    summed = total(causes)
    for name, row in compared(scene, causes, ("tmm", "solid")).items():
        beam, solid = row.cells
        # what the solid's own bar allows, and the bridge's coarser bricks the same again
        allowed = 2.0 * solid.error / abs(solid.value)
        assert getattr(summed, BRIDGED[name]) == pytest.approx(beam.difference, abs=allowed)
        assert beam.verdict == "explained"
        for said in ("field varies", "d32", "Poisson's effect", "together"):
            assert said in beam.why


@pytest.mark.heavy
def test_named_causes_add_up_in_the_rod():
    """The same bimorph in the rod: what holds it comes besides, and replaces nothing."""
    scene, _ = load_scene("bimorph_on_rod", [*OWN, "accuracy=3e-3"])
    causes = in_the_rod(GeneratorChain(scene, lambda _: None), lambda _: None)
    summed = total(causes)
    for name, row in compared(scene, causes, ("tmm", "cad")).items():
        beam, cad = row.cells
        allowed = 2.0 * cad.error / abs(cad.value)
        assert getattr(summed, BRIDGED[name]) == pytest.approx(beam.difference, abs=allowed)
        if beam.verdict == "agrees":  # the bars of the derived three may cover it: nothing to say
            assert BRIDGED[name] in ("open_frequency", "coupling", "blocked_capacitance")
            continue
        for said in ("field varies", "Poisson's effect", "the shim alone clamped", "elastic rod"):
            assert said in beam.why


def test_on_the_rod_no_cause_replaces_another():
    """Without numbers both kinds are named."""
    scene, _ = load_scene("bimorph_on_rod", list(OWN))
    found = [
        Quantity(
            name="capacitance_free",
            model=m,
            value=np.asarray(v),
            unit="F",
            error=np.asarray(0.0),
            method="",
            seconds=0.0,
        )
        for m, v in (("tmm", 1.1), ("cad", 1.0))
    ]
    (row,) = compare(scene, found, LATERAL)
    for said in ("no d32", "no Poisson effect", "uniform field", "head rigid around the slot"):
        assert said in row.cells[0].why
