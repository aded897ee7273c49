"""Tapered, stepped and partly electroded bimorphs against closed forms and beam elements."""

import numpy as np
import pytest
from port_distance import distance

from tactgen.fem import beam as elements
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Support
from tactgen.tmm.beam import lumped
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.ports.multiport import respond
from tactgen.tmm.ports.supports_and_loads import attach
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

CLAMPED = Support(kind="clamped")
FREQUENCIES = np.array([0.0, 10.0, 445.0, 1000.0, 5000.0])
TAPERS = {
    "width": {"width_profile": ((0.0, 2.1e-3), (20e-3, 1e-3))},
    "all": {
        "width_profile": ((0.0, 2.1e-3), (20e-3, 1e-3)),
        "piezo_thickness_profile": ((0.0, 0.26e-3), (20e-3, 0.15e-3)),
        "shim_thickness_profile": ((0.0, 0.15e-3), (20e-3, 0.25e-3)),
    },
}
STEPPED = {
    "width": {"width_profile": ((0, 2.1e-3), (8e-3, 2.1e-3), (8e-3, 1e-3), (20e-3, 1e-3))},
    "thickness": {
        "piezo_thickness_profile": ((0, 0.26e-3), (8e-3, 0.26e-3), (8e-3, 0.1e-3), (20e-3, 0.1e-3))
    },
    "electrodes": {"bare_below": 2e-3, "bare_above": 5e-3, "poling": "+x"},
    "glue": {"glue_thickness": 20e-6},
    "tab": {"tab_length": 1.6e-3, "bare_above": 5e-3},
}


def device(**keys):
    return Device(bimorph=Bimorph(**keys))


@pytest.mark.parametrize("case", STEPPED)
@pytest.mark.parametrize("support", [CLAMPED, Support(kind="rod")], ids=lambda s: s.kind)
def test_stepped_rows_equal_beam_elements(case, support):
    """Steps, partial electrodes, glue and tab: two discretisations of one theory, to 1e-8."""
    keys = {"tab_length": 2e-3} | STEPPED[case] if support.kind == "rod" else STEPPED[case]
    fine = elements.multiport(device(**keys), support, Beam(), FREQUENCIES, elements=24)
    exact = tmm.multiport(device(**keys), support, Beam(), FREQUENCIES)
    assert distance(fine.stiffness, exact.stiffness) < 1e-8


@pytest.mark.parametrize("case", TAPERS)
def test_tapers_converge_to_beam_elements(case):
    """Twice the segments, a sixteenth of the error, towards elements that know the taper itself."""
    exact = elements.multiport(device(**TAPERS[case]), CLAMPED, Beam(), FREQUENCIES, elements=32)
    found = (
        tmm.multiport(device(**TAPERS[case]), CLAMPED, Beam(), FREQUENCIES, segments=n)
        for n in (8, 16, 32)
    )
    errors = [distance(port.stiffness, exact.stiffness) for port in found]
    np.testing.assert_allclose(np.log2(errors[:-1]) - np.log2(errors[1:]), 4.0, atol=0.1)
    # the default; 5000 Hz is twice the second pole of the held beam
    assert errors[-1] < 1e-5


def test_partial_electrode_bends_only_itself():
    """Electrodes from a to b: w = −K U/EI (b − a)(l − (a + b)/2), whatever lies outside."""
    l, a, b = 20e-3, 3e-3, 12e-3
    partly = device(bare_below=a, bare_above=l - b)
    port = tmm.multiport(partly, CLAMPED, Beam(), np.zeros(1), lossy=False)
    response = respond(attach(port, Ends()), {"voltage": 1.0})
    moved = response.motion["w_tip"][0]
    ((active, _),) = tmm.sections(device(), CLAMPED, Beam(), lossy=False)
    curvature = active.K / active.EI
    # a dozen roundings
    assert moved == pytest.approx(-curvature * (b - a) * (l - (a + b) / 2), rel=1e-13)
    assert response.effort["voltage"][0] == pytest.approx(
        (active.C + active.K * curvature) * (b - a), rel=1e-13
    )
    model = lumped.multiport(partly, CLAMPED, Beam(), np.zeros(1), lossy=False)
    other = respond(attach(model, Ends()), {"voltage": 1.0}).motion["w_tip"][0]
    assert other == pytest.approx(moved, rel=1e-13)


@pytest.mark.parametrize("model", ["lumped", "tmm"])
def test_error_bar_of_a_taper_covers_it(model):
    """The bar from half as many segments covers the distance to four times as many."""
    settings = [
        "bimorph.piezo_thickness_profile=0 mm: 0.26 mm, 20 mm: 0.1 mm", "support.kind=clamped",
        "load.kind=none", "modes=1", "frequency=500",
    ]  # fmt: skip
    scene, _ = load_scene("paper", settings)
    names = ("short_circuit_frequencies", "capacitance_free", "tip_displacement")
    first, capacitance, tip = solve(scene, [model], names).quantities
    assert "segments of the taper" in tip.method
    fine = tmm.multiport if model == "tmm" else lumped.multiport
    port = fine(
        scene.device, scene.support, scene.beam, np.array([500.0]), segments=4 * tmm.SEGMENTS
    )
    exact = respond(attach(port, Ends()), {"voltage": scene.drive.voltage}).motion["w_tip"][0]
    assert 0.0 < abs(tip.value[0] - exact) < tip.error[0] < 1e-5 * abs(exact)
    assert 0.0 < first.error[0] < 1e-5 * first.value[0]
    assert 0.0 < capacitance.error < 1e-5 * capacitance.value


ENTANGLED = (
    "bimorph.width_profile=0 mm: 2.1 mm, 20 mm: 1 mm",
    "bimorph.piezo_thickness_profile=0 mm: 0.26 mm, 8 mm: 0.2 mm, 8 mm: 0.15 mm, 20 mm: 0.1 mm",
    "bimorph.tab_length=2mm",
    "bimorph.bare_above=2mm",
    "bimorph.glue_thickness=10um",
    "modes=2",
)
RUNNING_OUT = ("bimorph.piezo_thickness_profile=0 mm: 0.26 mm, 20 mm: 0.001 mm", "load.kind=none")


@pytest.mark.parametrize(
    "settings",
    [ENTANGLED, pytest.param(RUNNING_OUT, marks=pytest.mark.heavy)],
    ids=["steps", "runs out"],
)
def test_natural_frequencies_agree_with_beam_elements(settings):
    """Two models of one theory: all modes and the coupling factor agree within their bars."""
    scene, _ = load_scene("paper", list(settings))
    names = ("short_circuit_frequencies", "open_circuit_frequencies", "coupling_factor")
    solution = solve(scene, ["tmm", "beam"], names)
    for name in names:
        ours, theirs = (solution.get(name, model) for model in ("tmm", "beam"))
        apart = np.abs(np.asarray(ours.value) - theirs.value)
        assert (apart < np.asarray(ours.error) + theirs.error).all(), name
