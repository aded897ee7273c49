"""The way from a clamp to the rod where every solid is a beam: what is left is the bookkeeping."""

import numpy as np
import pytest

from tactgen.tmm.beam import transfer_matrix
from tactgen.validation.models.bimorph.beam_values import (
    Steps,
    Values,
    beam_row,
    beam_values,
    values_of_row,
)
from tactgen.validation.models.bimorph.bridge import causes, generator
from tactgen.validation.models.bimorph.bridge.causes import in_the_rod, total
from tactgen.validation.models.bimorph.bridge.end_effect import EndEffect
from tactgen.validation.models.bimorph.bridge.generator import GeneratorChain
from tactgen.validation.models.bimorph.bridge.rung import Rung
from tactgen.validation.models.bimorph.bridge.solid_values import SolvedSolid
from tactgen.validation.scene.scene import load_scene


@pytest.fixture
def solved(monkeypatch):
    """Put beams in place of solids; return each case that was asked for.

    Coarser bricks of the rod are 1 % off in deflection and 2 % in frequency.
    """
    asked = []

    def solve_solid(case):
        asked.append(case)
        scene = case.scene
        row = beam_row(scene)
        values = values_of_row(scene, row)
        if case.mesh is not None and case.mesh[0] == 0:
            values = values._replace(
                deflection=1.01 * values.deflection, first_frequency=0.98 * values.first_frequency
            )
        return SolvedSolid(values, transfer_matrix.chain(row, np.zeros(1)))

    monkeypatch.setattr(generator, "solve_solid", solve_solid)
    monkeypatch.setattr(generator, "rod_bricks", lambda device, level, filled: (level, filled))
    monkeypatch.setattr(generator, "ROD_LEVELS", (0, 1))
    return asked


def chain():
    return GeneratorChain(load_scene("bimorph_on_rod")[0], lambda _: None)


def test_each_step_changes_what_it_says(solved):
    """Held at the mouth and in the slot glue and rod are rigid; then the glue, then the rod."""
    made = chain()
    plain = made.device
    for name, glue, rod, filled in (
        ("at_mouth", 1e3, 1e3, True), ("in_rigid_slot", 1e3, 1e3, False),
        ("on_glue", 1.0, 1e3, False), ("on_rod", 1.0, 1.0, False),
    ):  # fmt: skip
        getattr(made, name)
        case = solved[-1]
        assert case.scene.glue.youngs_modulus == pytest.approx(glue * plain.glue.youngs_modulus)
        assert case.scene.rod.youngs_modulus == pytest.approx(rod * plain.rod.youngs_modulus)
        assert (case.mesh, case.scene.support.kind) == ((1, filled), "rod")
        getattr(made, name)
        assert solved[-1] is case  # each is solved once
    assert made.by_shim.values == beam_values(made.clamped_scene)
    assert solved[-1].held == "shim"


def test_the_bar_is_what_coarser_bricks_are_off(solved):
    """Of the worst of deflection, frequency and capacitance."""
    assert chain().bar == pytest.approx(generator.ROD_FACTOR * 0.02)


def test_what_a_clamp_is_not_told_changes_beam_and_solid_alike(solved):
    """Margins, and glue between the layers: each from the plain clamp, not from one another."""
    made = chain()
    margins, bonded = made.branches()
    for rung, change in (
        (margins, {"bare_below": generator.MARGIN, "bare_above": generator.MARGIN}),
        (bonded, {"glue_thickness": generator.BOND}),
    ):
        bimorph = made.clamped_scene.bimorph.model_copy(update=change)
        other = beam_values(made.clamped_scene.model_copy(update={"bimorph": bimorph}))
        step = other.step_from(beam_values(made.clamped_scene))
        assert rung.step == pytest.approx(step, rel=1e-9)
        assert rung.predicted == pytest.approx(step, rel=1e-9)
        assert abs(rung.step.first_frequency) > 1e-3
        assert rung.values == other


def test_pairs_lead_from_the_clamp_to_the_beams_generator(solved):
    """Seven of them, the first alike; the last beam is that of the whole rod."""
    made = chain()
    pairs = made.pairs()
    assert [name for name, *_ in pairs] == [rung.name for rung in made.rungs()]
    assert pairs[0][1] == pairs[0][2] == beam_values(made.clamped_scene)
    assert pairs[-1][1] == made.beam_values
    glue, rod = pairs[-2][1], pairs[-1][1]
    assert rod.first_frequency < glue.first_frequency < pairs[0][1].first_frequency


def values(*factors):
    plain = Values(1e-6, 400.0, 1e-8, 420.0, 0.3, 0.9e-8)
    return Values(*(a * f for a, f in zip(plain, factors, strict=True)))


def test_causes_in_the_rod_add_up_to_the_whole_difference(monkeypatch):
    """Beam over solid less one, of every value; the clamp again is on finer bricks."""
    beam, clamp = values(1, 1, 1, 1, 1, 1), values(1.1, 0.98, 1.01, 0.97, 1.02, 1.03)
    fine, held = values(1.2, 0.96, 1.02, 0.95, 1.01, 1.05), values(1.5, 0.9, 1.1, 0.8, 1.1, 1.2)
    in_rod = values(1.3, 0.93, 1.07, 0.85, 1.2, 1.1)
    rungs = [Rung("beam", "", beam), Rung("width", "", clamp)]
    asked = []

    def bridge(scene, announce, *, sections):
        asked.append((scene, sections))
        return rungs

    monkeypatch.setattr(causes, "bridge", bridge)

    class Chain:
        clamped_scene = "clamped scene"
        clamped = SolvedSolid(fine, None)

        @staticmethod
        def pairs():
            return [("all layers clamped", beam, fine), ("a tab", in_rod, held)]

    found = in_the_rod(Chain, lambda _: None)
    assert [cause.name for cause in found] == ["width", "finer bricks", "a tab"]
    expected = [a / b - 1.0 for a, b in zip(in_rod, held, strict=True)]
    assert total(found) == pytest.approx(expected, abs=1e-12)
    by_name = {cause.name: cause.share for cause in found}
    assert by_name["width"].deflection == pytest.approx((1.0 - 1.1) / 1.1)
    assert by_name["finer bricks"].deflection == pytest.approx(1.0 / 1.2 - 1.0 / 1.1)
    assert asked == [("clamped scene", False)]


def test_the_ends_have_what_falls_with_the_length():
    whole = Steps(*np.arange(1.0, 7.0))
    ends = EndEffect(whole, Steps(*(0.25 * value for value in whole))).ends
    assert ends == pytest.approx([0.75 * value for value in whole])
