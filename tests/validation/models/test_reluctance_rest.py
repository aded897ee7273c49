"""rod_position, finger_force, contact_force and resting_positions of the normal actuator."""

import numpy as np
import pytest
from approved import answered

from tactgen.tmm.generator.positions import axial_forces, resting_places
from tactgen.tmm.reluctance.coenergy.fit import fit
from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import load_scene

NAMES = ("rod_position", "finger_force", "contact_force", "resting_positions")


def answers(*overrides, model="network"):
    scene, _ = load_scene("reluctance", overrides)
    solution = solve(scene, [model], NAMES)
    return {q.name: q for q in solution.quantities}


def test_the_upper_place_before_pull_in():
    """At 50 mA from 0: up, what the pull leaves of the preload, and three places in all."""
    found = answers("coil.current=50mA")
    up, held = answers("coil.current=0mA"), answers("coil.current=50mA", "coil.history=falling")
    assert abs(found["rod_position"].value) < 1e-6
    assert found["resting_positions"].classes == ("upper stop", "unstable", "lower stop")
    assert up["finger_force"].value > found["finger_force"].value > 0.0
    assert found["contact_force"].value == pytest.approx(found["finger_force"].value, rel=1e-6)
    assert held["rod_position"].value == pytest.approx(-0.18e-3, abs=2e-6)
    assert held["finger_force"].value == pytest.approx(-held["contact_force"].value, rel=1e-6)


def test_force_is_spring_less_the_models_own_pull():
    """At the upper stop: the point's pull and bar, not the map's."""
    scene, _ = load_scene("reluctance", ["coil.current=50mA"])
    solution = solve(scene, ["network"], ["finger_force", "magnetic_force"])
    force, pull = solution.quantities
    left = scene.spring.preload - float(pull.value)
    # the place is 0.1 um below the nominal gap: 190 N/m of pull and 100 N/m of spring
    assert float(force.value) == pytest.approx(left, abs=1e-4)
    assert float(force.uncertainty) == pytest.approx(float(pull.uncertainty), rel=1e-2)


def test_the_bars_cover_the_map_made_finer():
    """All resting places by twice as many samples lie within the bars."""
    found = answers("coil.current=60mA")["resting_positions"]
    device = load_scene("reluctance", ["coil.current=60mA"])[0].device
    finer = fit(network_samples(device, *map_grid(device, 26, 24)))
    places = resting_places(axial_forces(device, finer), 60e-3)
    off = np.abs(found.value - [place.lift for place in places])
    assert (off <= found.uncertainty).all()


def test_all_that_is_said_of_a_rod_at_rest(approved):
    asked = ("coil.current=50mA", "coil.current=115mA", "coil.current=130mA")
    found = [answers(one, f"coil.history={way}") for one in asked for way in ("rising", "falling")]
    approved("\n".join(answered(each.values()) for each in found))
