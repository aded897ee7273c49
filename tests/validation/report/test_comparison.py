"""Verdicts on models side by side: what the bars cover agrees, and nothing else does."""

import numpy as np
import pytest

from tactgen.validation.engine.comparison import compare
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.difference import HEADLINE, causes, chain
from tactgen.validation.models.model import Modelling, Quantity
from tactgen.validation.scene.load import load_scene


def given(name, model, value, bar=0.0, modelling=None):
    """Return a model's value of a quantity."""
    return Quantity(np.asarray(value), np.asarray(bar), name=name, model=model, unit="",
                    modelling=modelling)  # fmt: skip


@pytest.mark.parametrize(("off", "expected"), [(0.9e-8, "agrees"), (1.1e-8, "differs")])
def test_one_theory_leaves_nothing_to_explain(off, expected):
    """Transfer matrices and beam elements solve one equation: 1e-8, or something is wrong."""
    scene, _ = load_scene("paper")
    name = "static_tip_displacement"
    found = given(name, "tmm", 1.0 + off), given(name, "beam", 1.0)
    (row,) = compare(scene, found, "bimorph")
    assert [cell.verdict for cell in row.cells] == [expected, "reference"]


#: Own layers: a brass shim and a soft ceramic of the trade.
OWN = (
    "bimorph.length=18mm", "bimorph.piezo_thickness=0.2mm", "bimorph.shim_thickness=0.1mm",
    "piezo.material=PZT-5H", "shim.material=brass", "drive.voltage=40V", "load.kind=none",
)  # fmt: skip


@pytest.mark.parametrize(
    ("expected", "error", "verdict"),
    [(1.0, 0.001, "explained"), (1.02, 0.021, "explained"), (1.045, 0.004, "differs")],
)
def test_a_modelling_error_explains_what_it_covers(expected, error, verdict):
    """The model gives 1.05, the solid 1: within the known difference and its error, or not."""
    scene, _ = load_scene("paper")
    modelling = Modelling(np.asarray(expected), np.asarray(error), "stated")
    found = [
        given("capacitance_free", m, v, modelling=of)
        for m, v, of in (("tmm", 1.05, modelling), ("solid", 1.0, None))
    ]
    (row,) = compare(scene, found, "bimorph")
    assert row.cells[0].verdict == verdict


def test_causes_add_up_to_the_difference():
    """Each cause's share of (beam / solid − 1), and their sum is all of it, to rounding."""
    made = [
        ("TMM", {"capacitance_free": 2.0, "coupling_factor": 0.27}),
        ("field", {"capacitance_free": 1.95, "coupling_factor": 0.268}),
        ("d32", {"capacitance_free": 1.8, "coupling_factor": 0.265}),
    ]
    steps = chain((name, "", of, of, "") for name, of in made)
    found = causes(steps)
    assert [c.name for c in found] == ["field", "d32"]
    assert found[0].shares["capacitance_free"] == pytest.approx(0.05 / 1.8)
    for name, last in steps[-1].values.items():
        whole = steps[0].values[name] / last - 1.0
        assert sum(c.shares[name] for c in found) == pytest.approx(whole, rel=1e-13)


@pytest.mark.heavy
def test_own_device_is_explained():
    """Brass, PZT-5H, 18 mm on a clamp: every difference of tmm and solid."""
    scene, _ = load_scene("paper", [*OWN, "support.kind=clamped", "mesh.level=2"])
    rows = compare(scene, solve(scene, ("tmm", "solid")).quantities, "bimorph")
    assert {row.quantity for row in rows} >= set(HEADLINE)
    assert {row.cells[0].verdict for row in rows} <= {"explained", "agrees"}


def test_on_the_rod_no_cause_replaces_another():
    """Without numbers both kinds are named."""
    scene, _ = load_scene("bimorph_on_rod", list(OWN))
    found = [given("capacitance_free", m, v) for m, v in (("tmm", 1.1), ("cad", 1.0))]
    (row,) = compare(scene, found, "bimorph")
    for said in ("no d32", "no Poisson effect", "uniform field", "rigid head around the slot"):
        assert said in row.cells[0].why
