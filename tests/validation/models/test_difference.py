"""Steps from the beam to the solid and from the formula to the field; clamp, rod and tab."""

import math

import numpy as np
import pytest

from tactgen.geometry.bimorph import bricks as bimorph_bricks
from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.parameters import Device, Piezo
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.layerwise import layerwise_beam
from tactgen.tmm.beam.sections import Joint
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph.rod_joint import (
    choices,
    support_compliance,
    tab_by_beam,
    tab_by_bricks,
)
from tactgen.validation.models.difference import (
    BEAM_ASSUMPTIONS,
    CAPACITANCE,
    DEFLECTION,
    FIRST_FREQUENCY,
    HEADLINE,
    SolidCase,
    beam_row,
    beam_to_solid,
    beam_values,
    change,
    clamped,
    formula_to_field,
    remaining,
    row_values,
    solid_values,
    without,
)
from tactgen.validation.scene.load import load_scene

CLAMPED = ["support.kind=clamped", "load.kind=none"]


def paper(*overrides):
    return load_scene("paper", [*CLAMPED, *overrides])[0]


def with_energy_shear(scene):
    factor = layerwise_beam(scene.device).shear_correction
    return scene.model_copy(
        update={"beam": scene.beam.model_copy(update={"shear_correction": factor})}
    )


def beam_like(scene):
    return solid_values(without(scene, BEAM_ASSUMPTIONS[:1], level=0))


def test_beam_like_solid_is_the_beam():
    """With a beam's constants and a linear potential a slender solid is TMM, to 1e-3.

    What is left is the ends: at 60 mm far less than asked for, even on the coarsest bricks.  On a
    short beam, where shear counts, 5/6 is off by far more than the energy's factor.
    """
    scene = with_energy_shear(paper("bimorph.length=60 mm", "piezo.material=PZT-5H"))
    apart = change(beam_like(scene), beam_values(scene))
    assert max(map(abs, apart.values())) < 1e-3
    assert abs(apart[DEFLECTION]) < 1e-5
    assert abs(apart[FIRST_FREQUENCY]) < 1e-5
    short = paper("bimorph.length=10 mm")
    solid = beam_like(short)[FIRST_FREQUENCY]
    mended, usual = (
        abs(solid / beam_values(s)[FIRST_FREQUENCY] - 1.0)
        for s in (with_energy_shear(short), short)
    )
    assert usual > 5e-3
    assert mended < 0.1 * usual


@pytest.fixture(scope="module", params=[0, pytest.param(1, marks=pytest.mark.heavy)])
def level(request):
    """How fine the bricks of the steps are."""
    return request.param


@pytest.fixture(scope="module")
def steps(level):
    return beam_to_solid(paper(), lambda _: None, level=level)


def test_steps_add_up(steps, level):
    """The product of all steps leads from TMM to the scene's own solid."""
    solid = solid_values(SolidCase(paper(), level=level))
    for quantity in HEADLINE:
        product = math.prod(1.0 + step.change[quantity] for step in steps[1:])
        whole = steps[-1].values[quantity] / steps[0].values[quantity]
        assert product == pytest.approx(whole, rel=1e-12)
        # the shear factor, which only beams have, is all that differs
        assert steps[-1].values[quantity] == pytest.approx(solid[quantity], rel=1e-9)


def test_steps_are_what_theory_says(steps):
    """A varying field: layers stiffened by 1/(1 − k31²); no constant through the thickness matters;
    those across the width lie between none and those of a wide plate."""
    by_name = {step.name: step for step in steps}
    varies = by_name["field varies"]
    assert varies.change == pytest.approx(varies.predicted, abs=2e-4)
    assert varies.change[DEFLECTION] < -0.01
    assert max(map(abs, by_name["three dimensions"].change.values())) < 1e-3
    for step in steps[-2:]:
        for quantity in (DEFLECTION, CAPACITANCE):
            assert step.predicted[quantity] < step.change[quantity] < 0.0


def test_where_a_set_cannot_be_or_has_no_theory(monkeypatch, few_bricks):
    """A set on the way that could not exist: its change is made with the next.  With glue between
    the layers steps are measured and no closed form is made up."""
    monkeypatch.setattr(bimorph_bricks, "LEVELS", few_bricks)
    strong = paper().model_copy(update={"piezo": Piezo(eps33=4500.0)})
    with pytest.raises(ValueError, match="negative energy"):
        without(strong, BEAM_ASSUMPTIONS[:4]).ceramic.check_admissible()
    found = beam_to_solid(strong, lambda _: None, level=0)
    assert found[-1].name == "d32 and Poisson's effect"
    assert all(map(math.isfinite, found[-1].change.values()))
    glued = beam_to_solid(paper("bimorph.glue_thickness=20 um"), lambda _: None, level=0)
    assert all(math.isnan(step.predicted[DEFLECTION]) for step in glued[2:])


def test_shim_alone_lowers_the_frequency():
    """Of job J1 a clamp of the shim alone takes a tenth of f1, of the paper's soft shim a fifth."""
    lost = []
    for name in ("j1", "paper"):
        scene = clamped(load_scene(name)[0])
        whole, shim = (
            solid_values(SolidCase(scene, held=part, level=0))[FIRST_FREQUENCY]
            for part in ("layers", "shim")
        )
        lost.append(1.0 - shim / whole)
    # a corner singularity: one division finer changes the second by 0.01, as does a second one
    assert lost[0] == pytest.approx(0.10, abs=0.01)
    assert lost[1] == pytest.approx(0.19, abs=0.02)


def test_the_formula_leads_to_the_field():
    """Each refinement of the network, then what it still is off the field."""
    network = formula_to_field(Device(), 0.13, 0.2e-3)
    field = {name: 0.9 * value for name, value in network[-1].values.items()}
    found = formula_to_field(Device(), 0.13, 0.2e-3, field)
    assert [step.name for step in found[:-1]] == [step.name for step in network]
    assert found[-1].values == field
    assert remaining(found)[-2] == pytest.approx(dict.fromkeys(field, 1.0 / 0.9 - 1.0))


def test_a_bimorph_shorter_than_thick_is_no_beam():
    """No one-dimensional model answers; a little longer, each does, and says how far it is off."""
    scene = paper("bimorph.length=1um")
    for model in ("lumped", "tmm", "beam"):
        with pytest.raises(InputError, match=r"length = 0.001 mm .*0.77 mm: that is not a beam"):
            solve(scene, (model,), ("static_tip_displacement",))
    scene = paper("bimorph.length=2mm")
    for q in solve(scene, ("lumped", "tmm"), ("static_tip_displacement",)).quantities:
        assert 0.01 < q.modelling_error / abs(q.value) < 1.0


def test_tab_of_a_beam_is_got_back():
    """From the ports of two beams, one on a tab, comes the tab's own compliance; and on it a beam
    vibrates as the beam with that tab, its mass apart."""
    plain, on_tab = paper(), paper("bimorph.tab_length=1.6 mm")
    ports = [transfer_matrix.chain(beam_row(of), np.zeros(1)) for of in (on_tab, plain)]
    found, tab = support_compliance(*ports, 20e-3).matrix, tab_by_beam(plain, 1.6e-3).matrix
    np.testing.assert_allclose(found, tab, rtol=1e-8)
    alone, whole = clamped(plain), beam_values(on_tab)[FIRST_FREQUENCY]
    frequency = row_values(alone, [(Joint(tab), 0.0), *beam_row(alone)])[FIRST_FREQUENCY]
    # the tab's mass is 0.8 mg of 190 mg, near the node at the root
    assert frequency == pytest.approx(whole, rel=1e-4)


def test_solid_tab_grows_as_a_beam():
    """Per added length the solid's tab turns as EI says, but for Poisson's effect; its root adds.

    The shim's ν stiffens a strip towards a plate by at most ν² E_y/E = 0.8 %.  The difference of
    two solids is a passive support: symmetric and positive definite.
    """
    lengths = (0.0, 0.8e-3, 1.6e-3, 2.4e-3)
    found = [tab.matrix for tab in tab_by_bricks(paper(), lengths, lambda _: None, level=0)]
    rotations = np.array([m[1, 1] for m in found])
    slope = (rotations[3] - rotations[1]) / (lengths[3] - lengths[1])
    beam = tab_by_beam(paper(), 1e-3).matrix[1, 1] / 1e-3
    assert 0.99 * beam < slope < 1.001 * beam
    root = rotations[1] - slope * lengths[1]
    assert 0.05 * rotations[2] < root < 0.25 * rotations[2]
    for m in found:
        assert m[0, 1] == pytest.approx(m[1, 0], rel=1e-6)
        assert np.linalg.eigvalsh(m / np.sqrt(np.outer(np.diag(m), np.diag(m))))[0] > 0.0


@pytest.mark.parametrize("name", ["M1876", "PZT-5A"])
def test_choices_of_a_full_tensor_keep_the_reduced_set(name):
    """All that a one-dimensional model knows stays, unless the row says otherwise."""
    ceramic = LIBRARY[name]
    rows = list(choices(ceramic))
    assert len({row[0] for row in rows}) == len(rows) >= 10
    for label, changed in rows:
        if not label.startswith(("eps33", "d31")):
            assert changed.reduced() == pytest.approx(ceramic.reduced(), rel=1e-14)
