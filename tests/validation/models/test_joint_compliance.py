"""What holds the bimorph: the support's compliance from solids, against beams and limits."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.bimorph.rod_bricks import RodMeshing
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.models.bimorph import joint_compliance
from tactgen.validation.models.bimorph.beam_values import beam_row, beam_values
from tactgen.validation.models.bimorph.bridge import generator
from tactgen.validation.models.bimorph.bridge.generator import GeneratorChain
from tactgen.validation.models.bimorph.bridge.solid_values import SolidCase, solve_solid
from tactgen.validation.models.bimorph.joint_compliance import (
    fitted_springs,
    frequency_on,
    joint_by_beam,
    joint_by_solids,
    support_compliance,
    support_study,
    tab_by_beam,
    tab_by_bricks,
    tab_for_frequency,
)
from tactgen.validation.scene.scene import load_scene


def scene(*overrides):
    return load_scene("paper", ["load.kind=none", "support.kind=clamped", *overrides])[0]


def static(row) -> Multiport:
    return transfer_matrix.chain(row, np.zeros(1))


def test_tab_of_a_beam_is_got_back():
    """From the ports of two beams, one on a tab, comes the tab's own compliance."""
    plain, on_tab = scene(), scene("bimorph.tab_length=1.6 mm")
    found = support_compliance(static(beam_row(on_tab)), static(beam_row(plain)), 20e-3)
    np.testing.assert_allclose(found.matrix, tab_by_beam(plain, 1.6e-3).matrix, rtol=1e-8)
    assert found.matrix[0, 1] == pytest.approx(found.matrix[1, 0], rel=1e-8)


def test_centre_uncouples():
    """At its centre, half-way down a tab, force turns nothing; there it is stiffest sideways."""
    tab = tab_by_beam(scene(), 1.6e-3)
    assert tab.centre == pytest.approx(0.8e-3, rel=1e-12)
    there = tab.moved_up(-tab.centre)
    assert abs(there.matrix[0, 1]) < 1e-12 * np.sqrt(there.matrix[0, 0] * there.matrix[1, 1])
    assert there.lateral_stiffness == pytest.approx(tab.lateral_stiffness_at_centre, rel=1e-12)
    assert tab.lateral_stiffness_at_centre > tab.lateral_stiffness


@pytest.fixture(scope="module")
def tabs():
    lengths = (0.0, 0.8e-3, 1.6e-3, 2.4e-3)
    return lengths, tab_by_bricks(scene(), lengths, lambda _: None, level=0)


def test_solid_tab_grows_as_a_beam(tabs):
    """Per added length the solid's tab turns as EI says, but for Poisson's effect; its root adds.

    The shim's ν stiffens a strip towards a plate by at most ν² E_y/E = 0.8 %.
    """
    lengths, found = tabs
    rotations = np.array([tab.matrix[1, 1] for tab in found])
    slope = (rotations[3] - rotations[1]) / (lengths[3] - lengths[1])
    beam = tab_by_beam(scene(), 1e-3).matrix[1, 1] / 1e-3
    assert 0.99 * beam < slope < 1.001 * beam
    root = rotations[1] - slope * lengths[1]
    assert 0.05 * rotations[2] < root < 0.25 * rotations[2]


def test_solid_compliance_is_one(tabs):
    """Symmetric and positive definite: the difference of two solids is a passive support."""
    for tab in tabs[1]:
        m = tab.matrix
        assert m[0, 1] == pytest.approx(m[1, 0], rel=1e-6)
        assert np.linalg.eigvalsh(m / np.sqrt(np.outer(np.diag(m), np.diag(m))))[0] > 0.0


def test_whatever_holds_the_bimorph_the_tab_is_clamped(tabs):
    """In the rod as on springs: the tab alone is meant."""
    lengths, known = tabs
    for kind in ("rod", "spring"):
        held = scene(f"support.kind={kind}", "bimorph.tab_length=2.5 mm")
        found = tab_by_bricks(held, lengths[:2], lambda _: None, level=0)
        for one, other in zip(found, known, strict=False):
            np.testing.assert_array_equal(one.matrix, other.matrix)


def test_length_of_the_ceramic_does_not_matter():
    """The support is a property of the root: seen through 20 mm of ceramic it is the same."""
    long, short = scene("bimorph.tab_length=1.6 mm"), scene()
    ports = [solve_solid(SolidCase(s, level=0)).static for s in (long, short)]
    through = support_compliance(*ports, 20e-3)
    root = tab_by_bricks(short, (1.6e-3,), lambda _: None, level=0)[0]
    # differences of compliances hundreds of times larger
    assert through.rotational_stiffness == pytest.approx(root.rotational_stiffness, rel=2e-3)
    assert through.centre == pytest.approx(root.centre, rel=5e-3)


def test_a_study_has_a_joint_where_the_solids_of_a_generator_are(monkeypatch):
    """Of the bricks' tabs, and of the solids' compliance the whole; without them no free tab."""
    plain, asked = scene(), []
    monkeypatch.setattr(joint_compliance, "tab_by_bricks", lambda *given: asked.append(given) or ())
    monkeypatch.setattr(joint_compliance, "joint_by_solids", lambda chain: {"whole": chain.name})
    alone = support_study(plain, print)
    assert asked == [(plain, joint_compliance.TAB_LENGTHS, print)]
    assert (alone.scene, alone.joint) == (plain, None)
    assert alone.lengths.tolist() == list(joint_compliance.TAB_LENGTHS)
    assert np.isnan(alone.free_tab)
    found = support_study(plain, print, SimpleNamespace(free_tab=2e-3, name="joint"))
    assert (found.joint, found.free_tab) == ("joint", 2e-3)


def test_beam_on_a_support_is_the_whole():
    """A beam on the compliance of a tab vibrates as the beam with that tab, its mass apart."""
    plain, on_tab = scene(), scene("bimorph.tab_length=1.6 mm")
    whole = beam_values(on_tab).first_frequency
    found = frequency_on(plain, tab_by_beam(plain, 1.6e-3))
    # the tab's mass is 0.8 mg of 190 mg, near the node at the root
    assert found == pytest.approx(whole, rel=1e-4)
    coupled = tab_by_beam(plain, 1.6e-3)
    assert frequency_on(plain, coupled.uncoupled()) > 1.03 * found


def test_fitted_springs_are_the_sprung_beam():
    """The paper's two springs as a compliance give the frequency on its support."""
    sprung = load_scene("paper", ["load.kind=none"])[0]
    # the support's inertia is no compliance
    support = sprung.support.model_copy(update={"rotational_inertia": 0.0})
    sprung = sprung.model_copy(update={"support": support})
    found = frequency_on(sprung, fitted_springs(sprung))
    assert found == pytest.approx(beam_values(sprung).first_frequency, rel=1e-9)


def test_softer_glue_turns_more():
    """The joint's rotation falls with the glue's modulus to what the rod itself gives way."""
    chain = GeneratorChain(scene(), lambda _: None)
    turned = [joint_by_beam(chain, e, rod=True).matrix[1, 1] for e in (1e9, 3e9, 1e10)]
    assert turned[0] > turned[1] > turned[2]
    rigid_rod = joint_by_beam(chain, 3e9, rod=False)
    assert 0.0 < turned[1] - rigid_rod.matrix[1, 1] < 0.2 * turned[1]


def test_glue_and_rod_soften_as_beams_say(monkeypatch):
    """On the fewest bricks: every step is softer, and of the size that beams give it."""
    few = (RodMeshing((2, 2, 2), smallest=1.0, side=1.5, tip=2.0),)
    monkeypatch.setattr(generator, "ROD_LEVELS", few)
    chain = GeneratorChain(scene(), lambda _: None, level=0, rod_level=0)
    rungs = {rung.name: rung for rung in chain.rungs()}
    assert every_change_softens(rungs)
    for name in ("glue", "elastic rod"):
        step = rungs[name].step.first_frequency
        assert step == pytest.approx(rungs[name].predicted.first_frequency, rel=0.5)
    parts = joint_by_solids(chain)
    assert all(part.matrix[1, 1] > 0.0 for part in parts.values())
    # the slot that is full of rod holds the tab by more than its faces
    assert parts["faces"].matrix[1, 1] > 0.1 * parts["whole"].matrix[1, 1]


def every_change_softens(rungs):
    """Return whether each step lowers the frequency, but the one to other bricks."""
    return all(r.step.first_frequency < 0.0 for n, r in rungs.items() if n in CHANGES)


#: Steps that change the device.
CHANGES = (
    "the shim alone clamped", "a tab of 1.60 mm", "the tab in a slot", "glue", "elastic rod",
)  # fmt: skip


@pytest.mark.heavy
def test_generator_in_steps():
    """Solids and beams tell one story from the clamp to the elastic rod."""
    chain = GeneratorChain(scene(), lambda _: None)
    assert 1e-3 < chain.error < 1e-2
    rungs = {rung.name: rung for rung in chain.rungs()}
    assert every_change_softens(rungs)
    # other bricks, not another device: within what both are off
    assert abs(rungs["bricks of the rod"].step.first_frequency) < chain.error
    for name in ("glue", "elastic rod"):
        rung = rungs[name]
        # beams have a rigid head and the tab on springs: a third of the step
        assert rung.step.first_frequency == pytest.approx(rung.predicted.first_frequency, rel=0.35)
        assert abs(rung.step.deflection) < 1e-3  # nothing there strains under voltage
    for rung in chain.branches():
        assert rung.step == pytest.approx(rung.predicted, abs=0.015)
    study = support_study(scene(), lambda _: None, chain)
    whole, tab, beam_tab, rod, beam_rod = turning(chain)
    assert study.joint.matrix[1, 1] == whole
    # faces add to the solid's tab, less where they count little: see the next test
    assert tab == pytest.approx(beam_tab, rel=0.07)
    # the beam takes the head for rigid around the slot; the rod below is the same
    assert 0.02 * whole < rod - beam_rod < 0.06 * whole
    assert 0.7e-3 < study.tab_for(0.24, joint=study.joint.matrix[1, 1]) < 1.2e-3
    built = study.at(chain.free_tab, in_rod=True)
    # the beam bimorph on the solid's support is the solid, as near as on a clamp
    last = rungs["elastic rod"].first_frequency
    assert frequency_on(scene(), built) == pytest.approx(last, rel=0.01)
    assert 0.0 < tab_for_frequency(study, in_rod=True) < 0.9e-3


def turning(chain):
    """Return the joint's rotation per moment: whole, and of tab and rod by solid and by beam."""
    found = {name: part.matrix[1, 1] for name, part in joint_by_solids(chain).items()}
    modulus = chain.device.glue.youngs_modulus
    beam_tab, beam = (joint_by_beam(chain, modulus, rod=rod).matrix[1, 1] for rod in (False, True))
    return found["whole"], found["faces"] + found["glue"], beam_tab, found["rod"], beam - beam_tab


@pytest.mark.heavy
def test_why_the_joint_of_solids_turns_more():
    """A slot holds the tab by its faces, which no beam knows: it counts less in softer glue.

    In the softest the beam's bond lines, which give way each by itself, are the softer ones.
    """
    excess, faces = [], []
    for glue in ("0.03 GPa", "0.3 GPa", "3 GPa", "10 GPa"):
        chain = GeneratorChain(scene(f"glue.youngs_modulus={glue}"), lambda _: None, rod_level=0)
        whole, tab, beam_tab, _, _ = turning(chain)
        excess.append(tab / beam_tab)
        faces.append(joint_by_solids(chain)["faces"].matrix[1, 1] / whole)
    assert excess == sorted(excess)
    assert faces == sorted(faces)
    assert faces[0] < 0.02
    assert 0.9 < excess[0] < 1.0 < excess[2]
