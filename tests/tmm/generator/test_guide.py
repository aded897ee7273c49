"""The rod in its bore: without play a spring, within the play nothing, beyond it a spring again."""

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Beam, Device, Guide, Spring
from tactgen.tmm.generator.contact import Play, contact_of, lateral_guide, tilt_guide
from tactgen.tmm.generator.equilibrium import axial_forces, held_support, resting_place
from tactgen.tmm.generator.small_signal import linearised, resting_tilt
from tactgen.tmm.harmonic_balance.continuation import steady_orbit
from tactgen.tmm.reluctance.map_range import network_map
from tactgen.validation.models.backbone import held_head
from tactgen.validation.models.transient import scene_machine
from tactgen.validation.scene.load import load_scene

MOTIONS = np.array([-3e-4, -1e-4, -2e-5, 0.0, 5e-5, 1e-4, 2e-4])


def test_the_law():
    """Without play a spring to the last bit; its slope is the force's; far from it nothing acts."""
    assert (Play(7.0, 0.0).force(MOTIONS) == 7.0 * MOTIONS).all()
    assert (Play(7.0, 0.0).slope(MOTIONS) == 7.0).all()
    assert not Play(7.0, 1.0).force(MOTIONS).any()
    bore = Play(7.0, 9e-5)
    np.testing.assert_allclose(
        bore.force(MOTIONS), 7.0 * np.array([-2.1e-4, -1e-5, 0, 0, 0, 1e-5, 1.1e-4]), atol=1e-18
    )
    by = 1e-9
    slope = (bore.force(MOTIONS + by) - bore.force(MOTIONS - by)) / (2.0 * by)
    np.testing.assert_allclose(bore.slope(MOTIONS), slope, rtol=1e-6)


def test_play_follows_from_clearance_and_guided_length():
    """10 um of diameter: 5 um either way, and 10 um over 4 mm of tilt."""
    device = Device(guide=Guide(clearance=10e-6, guided_length=4e-3))
    assert lateral_guide(device).play == pytest.approx(5e-6, rel=1e-15)
    assert tilt_guide(device).play == pytest.approx(2.5e-3, rel=1e-15)


def test_an_upright_head_has_only_its_contact_once_there_is_play():
    """Support and small motions, both over w and ψ."""
    tight, loose = Device(), Device(guide=Guide(clearance=1e-6))
    (_, held), (place, free) = (held_support(d, None, 0.0, "rising") for d in (tight, loose))
    law = contact_of(tight, "upper")
    assert free.rotational_stiffness == float(law.stiffness_under(place.contact_force))
    assert free.lateral_stiffness == float(law.tangential_stiffness(place.contact_force))
    assert held.rotational_stiffness - free.rotational_stiffness == pytest.approx(1e-4, rel=1e-9)
    pull = network_map(tight)
    two = [linearised(d, Beam(), place, 0.0, pull).stiffness for d in (tight, loose)]
    gone = np.diag([tight.guide.lateral_stiffness, tight.guide.rotational_stiffness, 0.0])
    # what is left of the difference of two contacts of 3e5 N/m: rounding
    np.testing.assert_allclose(two[0] - two[1], gone, atol=1e-9)


def test_a_spring_off_the_axis_tilts_the_head_as_far_as_the_bore_lets_it():
    """Contact and bore balance the moment; a stiff bore stops it at clearance over length."""

    def tilted(clearance, stiffness):
        guide = Guide(clearance=clearance, rotational_stiffness=stiffness, guided_length=4e-3)
        device = Device(guide=guide, spring=Spring(eccentricity=0.4e-3))
        place = resting_place(axial_forces(device, None), 0.0, "rising")
        tilt = resting_tilt(device, place)
        applied = 0.4e-3 * (device.spring.preload - device.spring.stiffness * place.lift)
        borne = contact_of(device, "upper").moment_under(place.contact_force, tilt)
        assert borne + tilt_guide(device).force(tilt) == pytest.approx(applied, rel=1e-9)
        return tilt, linearised(device, Beam(), place, 0.0, network_map(device)).stiffness[1, 1]

    free, soft = tilted(1e-3, 10.0)
    edge, stiff = tilted(0.4e-6, 10.0)
    upright, held = tilted(0.0, 10.0)
    assert upright < 1e-5 < edge < free
    assert edge == pytest.approx(0.4e-6 / 4e-3, rel=0.1)  # the bore bears the rest
    # the bore's 10 N m/rad are there or not
    assert soft < 1.0 < 10.0 < min(stiff, held)


@pytest.mark.parametrize(("clearance", "guide"), [("0 mm", 1.0), ("0.2 um", None), ("1 mm", 0.0)])
def test_a_rocking_head_meets_the_bore(clearance, guide):
    """Of a stiff guide the motion feels all without play, nothing in a wide bore, else a part."""

    def tilt(*overrides):
        scene, _ = load_scene("prototype", [
            "support.kind=contact", "coil.current=0mA", "models=tmm", "guide.guided_length=4mm",
            "guide.lateral_stiffness=0 N/m",
            *overrides,
        ])  # fmt: skip
        orbit = steady_orbit(held_head(scene).oscillator, 2.0 * np.pi * 300.0, 40.0)
        return abs(orbit.spectrum[1, 1])

    found = tilt(f"guide.clearance={clearance}", "guide.rotational_stiffness=1 N*m/rad")
    if guide is None:
        assert tilt("guide.rotational_stiffness=1 N*m/rad") < 0.9 * found
        assert found < 0.9 * tilt("guide.rotational_stiffness=0 N*m/rad")
    else:
        same = tilt(f"guide.rotational_stiffness={guide:g} N*m/rad")
        assert found == pytest.approx(same, rel=1e-9)  # what Newton's method leaves


def test_in_time_both_sides_of_the_bore_push():
    """The system's elements give the law's force; without play there are none."""
    scene, _ = load_scene("generator", ["guide.clearance=4 um", "load.kind=none"])
    system = scene_machine(scene, coil="current", volts=1.0).system
    assert system.stiffness[2, 2] == 0.0
    bores = [e for e in system.elements if e.name == "bore"]
    for element, bore, at in zip(
        bores, (lateral_guide(scene), tilt_guide(scene)), (1, 2), strict=True
    ):
        for share in (-3.0, -0.5, 0.5, 1.5):
            x = np.eye(system.mass.shape[0])[at] * share * bore.play
            deformed = (element.direction @ x + element.offset).tolist()
            pushed = element.law.means(deformed, [0.0, 0.0], 1.0)[0]
            along = element.direction.T @ pushed
            assert along[at] == pytest.approx(float(bore.force(x[at])), rel=1e-12, abs=1e-18)
    tight, _ = load_scene("generator", ["load.kind=none"])
    assert len(scene_machine(tight, coil="current", volts=1.0).system.elements) == 2
