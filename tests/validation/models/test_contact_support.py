"""support.kind = contact: the scene's springs from the rod's resting place, for every model."""

from functools import cache

import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.device.parameters import Support
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.sections import section_across
from tactgen.tmm.beam.transfer_matrix import sections
from tactgen.tmm.generator.contact import contact_of, moving_rod
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.scene.load import load_scene

UP = ("support.kind=contact", "coil.current=0mA")


@cache
def frequency(*overrides):
    made, _ = load_scene("prototype", ["modes=1", *overrides])
    found = solve(made, ["tmm"], ["short_circuit_frequencies"], modelling=False)
    return float(found.quantities[0].value[0])


def test_the_rated_preload_is_the_papers_support():
    """The paper's c_s with the inertia of rod and coil, some 1000 times the paper's, and the
    stiffness along the surfaces, a tenth of the paper's; the guide adds 4e-4 to c_s, of which the
    frequency sees less than half.  Both take from the paper's 782 Hz."""
    device = load_scene("prototype")[0].device
    inertia = moving_rod(device).mass_matrix[1, 1]
    along = contact_of(device, "upper").tangential_stiffness(device.spring.preload)
    fitted = frequency(
        f"support.rotational_inertia={inertia:.10e}kg*m^2", f"support.lateral_stiffness={along}N/m"
    )
    assert frequency(*UP) == pytest.approx(fitted, rel=2e-4)
    assert fitted < frequency()


def test_the_grub_screw_tunes_the_resonance_by_the_papers_300_hertz():
    """Section 6: about 300 Hz by the springs' preload.  By the law that takes more than a tenth
    either way of the rated preload, and less than a third of it to three times as much."""

    def tuned(low, high):
        ends = (f"spring.preload={n}mN" for n in (low, high))
        first, last = (frequency(*UP, end, "load.kind=none") for end in ends)
        return last - first

    assert tuned(99, 121) < 300.0 < tuned(37, 330)


def test_held_by_the_coil_it_is_stiffer_and_says_so():
    """50 mA after a pull-in; the sentence says where the rod is and how it is pressed."""
    held, _ = load_scene(
        "prototype", ["support.kind=contact", "coil.current=50mA", "coil.history=falling"]
    )
    answer = solve(held, ["tmm"], ["short_circuit_frequencies"])
    assert float(answer.quantities[0].value[0]) > 1.2 * frequency(*UP)
    (sentence,) = [w for w in answer.warnings if "coil.current" in w]
    assert "at its lower stop" in sentence


def test_keys_follow_the_load_of_the_contact_and_nothing_else():
    """Without current a coil's turns turn nothing stale; the preload turns the modes stale."""

    def keys(*overrides):
        scene, _ = load_scene("paper", [*UP, *overrides])
        return make_plan(scene, ["tmm"], ["short_circuit_frequencies", "admittance"]).keys

    usual = keys()
    assert keys("coil.turns=700") == usual
    changed = keys("spring.preload=120mN")
    assert changed["tmm.modes"] != usual["tmm.modes"]
    assert changed["tmm.ports"] == usual["tmm.ports"]


@pytest.mark.usefixtures("own_store", "coarse_bricks")
@pytest.mark.parametrize("state", [("0mA", "rising"), ("50mA", "falling")])
def test_the_solid_rocks_about_both_axes(state):
    """Across its width the bimorph is a stiff beam on the same springs of the ring: its first
    frequency there is that of the springs, not of a clamp at 3.3 kHz."""
    asked = ("support.kind=contact", "load.kind=none", "models=solid", "mesh.level=2", "modes=2",
             "quantities=short_circuit_frequencies", f"coil.current={state[0]}",
             f"coil.history={state[1]}")  # fmt: skip
    scene, _ = load_scene("paper", asked)
    found = solve(scene).quantities[0]
    across = found.value[list(found.classes).index("bending_y")]
    held = scene.held
    row = sections(scene.device, Support(kind="clamped"), scene.beam, lossy=False,
                   section_of=section_across)  # fmt: skip
    springs = Springs(held.lateral_stiffness, held.rotational_stiffness,
                      rotational_inertia=held.rotational_inertia)  # fmt: skip
    exact = bending_frequencies(row, Ends(springs), 1, open_circuit=False)[0]
    # nearly a rigid body: its own bending lowers the frequency by a hundredth, known to a tenth
    assert across == pytest.approx(exact, rel=1e-3)
