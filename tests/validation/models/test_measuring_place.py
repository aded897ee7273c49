"""Motion measured below the tip: a clamped beam's shape, and all models against each other."""

from itertools import product

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.parametric import Actuator
from tactgen.tmm.beam.port_quantities import evaluate
from tactgen.tmm.harmonic_balance.continuation import steady_orbit
from tactgen.tmm.ports.multiport import reduce
from tactgen.tmm.ports.readout import measured
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.backbone import RESOLUTION, five_port, held_head
from tactgen.validation.models.transient import scene_modes
from tactgen.validation.scene.load import load_scene

CLAMPED = ("support.kind=clamped", "load.kind=none")
#: A row of many parts, loaded, in which places lie in an extension, a taper and a tab.
STEPPED = (
    "bimorph.width_profile=0 mm: 2.1 mm, 20 mm: 1 mm", "bimorph.tab_length=2 mm",
    "bimorph.tip_extension=3 mm", "bimorph.bare_above=1 mm",
)  # fmt: skip


def scene_of(below, *overrides, models="tmm", quantities="tip_displacement"):
    stated = f"measurement.below_tip={below} mm", f"models={models}", f"quantities={quantities}"
    return load_scene("paper", [*stated, *overrides])[0]


def answers(scene):
    found = solve(scene, scene.models, scene.quantities, modelling=False)
    return {q.model: q for q in found.quantities}


def test_a_clamped_beam_bends_as_a_parabola():
    """A voltage is a constant moment: w goes with the square of the height, by any beam theory."""
    tip, *places = (
        answers(scene_of(at, *CLAMPED, models="tmm,beam", quantities="static_tip_displacement"))
        for at in (0, 0.001, 19.5)
    )
    for (below, low), model in product(zip((0.001, 19.5), places, strict=True), ("tmm", "beam")):
        found, whole = low[model], tip[model].value * (1.0 - below / 20.0) ** 2
        # a port a micron below the tip costs digits, which the bar says; the last ones are rounding
        assert abs(found.value - whole) <= found.error + 1e-13 * abs(tip[model].value)
        assert found.error < 1e-6 * whole


@pytest.mark.parametrize("below", [3.0, 9.0, 24.0])
def test_transfer_matrices_and_beam_elements_agree(below):
    """At the edge of an extension, in a taper and in a tab; on springs, with a finger."""
    scene = scene_of(below, *STEPPED, "frequency=10 Hz,400 Hz,2 kHz", models="tmm,beam")
    tmm, beam = answers(scene).values()
    assert (np.abs(tmm.value - beam.value) <= tmm.error + beam.error).all()
    assert (tmm.error + beam.error < 1e-4 * np.abs(tmm.value)).all()


def test_the_place_takes_no_part():
    """Without its port the actuator is what it is without the place."""
    place, plain = (
        five_port(scene_of(b, *STEPPED[1:]), "tmm")(np.array([300.0])) for b in (5.0, 0.0)
    )
    kept = reduce(place, plain.names).stiffness
    size = np.sqrt(np.abs(np.einsum("nii->ni", plain.stiffness)))
    # condition of the row when it is divided
    assert (np.abs(kept - plain.stiffness) <= 1e-9 * size[:, :, None] * size[:, None]).all()


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_the_solid_reads_its_own_field():
    """Close to the parabola, less what the clamped end adds, and beyond the width's own bending."""
    tip, *places = (
        answers(scene_of(at, *CLAMPED, models="solid", quantities="static_tip_displacement"))
        for at in (0, 0.5, 7.0)
    )
    for below, low in zip((0.5, 7.0), places, strict=True):
        found, whole = low["solid"], tip["solid"].value
        # Saint-Venant: the end adds some hundredths of the thickness to the length
        assert found.value / whole == pytest.approx((1.0 - below / 20.0) ** 2, rel=1e-2)
        assert found.error < 2e-2 * found.value


@pytest.mark.heavy
@pytest.mark.parametrize("overrides", [(), ("bimorph.tab_length=3 mm",), CLAMPED])
@pytest.mark.parametrize("below", [0.3, 5.0, 15.0])
def test_bricks_and_tetrahedra_agree(overrides, below):
    """Within their bars, as their own field at the place is no more certain than at the tip."""
    asked = (*overrides, "accuracy=1%", "frequency=20 Hz,500 Hz,1.5 kHz")
    scene = scene_of(below, *asked, models="solid,cad")
    solid, cad = answers(scene).values()
    assert (np.abs(solid.value - cad.value) <= solid.error + cad.error).all()
    assert (solid.error + cad.error < 5e-2 * np.abs(solid.value)).all()


def test_studies_read_the_same_place():
    """The transfer matrices with varied parameters, at the scene's own values and at another."""
    usual = scene_of(6.0, "frequency=200 Hz")
    parts = (usual.device, usual.support, usual.load, usual.beam, usual.drive)
    read = QUANTITIES["tip_displacement"].port_readout
    for length in (20, 23):
        scene = scene_of(6.0, f"bimorph.length={length} mm", "frequency=200 Hz")
        values = {"bimorph.length": np.array([1e-3 * length])}
        found = evaluate(Actuator(*parts), read, values, np.array(scene.frequency))
        assert found == pytest.approx(answers(scene)["tmm"].value, rel=1e-9)


def test_the_machine_in_time_reads_there():
    """The head's rocking counts by the height of the place above it."""
    low, tip = (scene_modes(scene_of(at, "support.kind=contact")) for at in (8.0, 0.0))
    assert low.seen[:2] == pytest.approx([1.0, -12e-3])
    assert tip.seen[:2] == pytest.approx([1.0, -20e-3])
    np.testing.assert_array_equal(tip.seen, tip.tip)
    # a static deflection under the voltage is a parabola
    at_rest = [float(m.seen[2:] @ (m.coupling / m.omega**2)) for m in (low, tip)]
    assert at_rest[0] / at_rest[1] == pytest.approx(0.36, rel=1e-6)


def test_a_rocking_head_is_read_there():
    """The first harmonic 5 mm below the tip of the machine, close to small motions."""
    overrides = [
        "load.kind=none", "measurement.below_tip=5 mm", "models=tmm", "frequency=380 Hz",
        "drive.voltage=0.3 V", "quantities=lateral_tip_per_voltage",
    ]  # fmt: skip
    scene = load_scene("generator", overrides)[0]
    head = held_head(scene, "tmm")
    orbit = steady_orbit(head.oscillator, 2.0 * np.pi * 380.0, 0.3, resolution=RESOLUTION)
    linear = 0.3 * answers(scene)["tmm"].value[0]
    # the moment softens the support by some thousandths
    found = measured(head.response(orbit).motion)[1]
    assert abs(found) == pytest.approx(abs(linear), rel=2e-2)


def test_what_cannot_be_read_is_refused():
    """A place off the bimorph, and one in a model without a shape; which all the others have."""
    with pytest.raises(InputError, match=r"below_tip = 20 mm is not on the bimorph, whose tip is"):
        scene_of(20)
    with pytest.raises(InputError, match=r"unknown to the model lumped.*ask for models=tmm"):
        answers(scene_of(1, models="lumped"))
    assert "lumped" not in load_scene("paper", ["measurement.below_tip=1 mm"])[0].models
