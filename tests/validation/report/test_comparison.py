"""Verdicts on models side by side: what the bars cover agrees, and nothing else does."""

import numpy as np
import pytest

from tactgen.validation.catalogue.quantities import Actuator
from tactgen.validation.engine.comparison import compare
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.difference import (
    HEADLINE,
    beam_to_solid,
    causes,
    causes_on_rod,
    chain,
)
from tactgen.validation.models.model import Quantity
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


def steps(*entries):
    return chain((name, "", of, of, "") for name, of in entries)


def test_causes_add_up_to_the_difference():
    """Each cause's share of (beam / solid − 1), and their sum is all of it, to rounding."""
    made = steps(
        ("TMM", {"capacitance_free": 2.0, "coupling_factor": 0.27}),
        ("field", {"capacitance_free": 1.95, "coupling_factor": 0.268}),
        ("d32", {"capacitance_free": 1.8, "coupling_factor": 0.265}),
    )
    found = causes(made)
    assert [c.name for c in found] == ["field", "d32"]
    assert found[0].shares["capacitance_free"] == pytest.approx(0.05 / 1.8)
    for name, last in made[-1].values.items():
        whole = made[0].values[name] / last - 1.0
        assert sum(c.shares[name] for c in found) == pytest.approx(whole, rel=1e-13)


@pytest.mark.parametrize(
    ("beside", "verdict", "said"),
    [
        # 4 % by the field, 1 % by the shortcut: together all of it
        ({"tmm": 1.04}, "explained", "static shapes +1.00: sum +5.00 %, difference +5.00 %"),
        # the shortcut is worth 0.2 %, which leaves 0.8 % of it
        ({"tmm": 1.048}, "differs", "static shapes +0.20: sum +4.20 %, difference +5.00 %"),
        (
            {},
            "explained",
            "sum +4.00 %, difference +5.00 %; the inertia is that of the static shapes",
        ),
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
    f1 = "short_circuit_frequencies"
    field = causes(steps(("TMM", {f1: 1.04}), ("field", {f1: 1.0})))
    (row,) = compare(scene, found, LATERAL, field)
    assert row.cells[0].model == "lumped"
    assert row.cells[0].verdict == verdict
    assert said in row.cells[0].why


def compared(scene, found, models):
    """Return the rows of the headline quantities."""
    solution = solve(scene, models)
    rows = compare(scene, solution.quantities, LATERAL, found)
    return {row.quantity: row for row in rows if row.quantity in HEADLINE}


@pytest.mark.heavy
def test_named_causes_are_the_difference_of_ones_own_device():
    """Brass, PZT-5H, 18 mm on a clamp: the shares add up to tmm against solid within the bars."""
    scene, _ = load_scene("paper", [*OWN, "support.kind=clamped", "mesh.level=2"])
    found = causes(beam_to_solid(scene, lambda _: None))
    for name, row in compared(scene, found, ("tmm", "solid")).items():
        beam, solid = row.cells
        # what the solid's own bar allows, and the coarser bricks of the steps the same again
        allowed = 2.0 * solid.error / abs(solid.value)
        summed = sum(cause.shares[name] for cause in found)
        assert summed == pytest.approx(beam.difference, abs=allowed)
        assert beam.verdict == "explained"
        for said in ("field varies", "d32", "Poisson's effect", "sum"):
            assert said in beam.why


@pytest.mark.heavy
def test_named_causes_leave_the_joint_in_the_rod():
    """The same bimorph in the rod: the shim's clamp and the tab are named, the rest is the joint.

    The joint is soft in bending: it matters to the frequency, hardly to a static deflection.
    """
    scene, _ = load_scene("bimorph_on_rod", [*OWN, "accuracy=3e-3"])
    found = causes_on_rod(scene, lambda _: None)
    rows = compared(scene, found, ("tmm", "cad"))
    for name in ("static_tip_displacement", "short_circuit_frequencies", "capacitance_free"):
        beam, _ = rows[name].cells
        left = beam.difference - sum(cause.shares[name] for cause in found)
        assert abs(left) < (0.03 if "freq" in name else 0.01)
        for said in ("field varies", "Poisson's effect", "the shim alone clamped"):
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
    for said in ("no d32", "no Poisson effect", "uniform field", "rigid head around the slot"):
        assert said in row.cells[0].why
