"""rod_position, finger_force, contact_force and resting_positions of the normal actuator."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.tmm.generator.equilibrium import axial_forces, resting_place, resting_places
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import MapError
from tactgen.tmm.reluctance.map_range import map_grid, network_map
from tactgen.tmm.reluctance.network import network_samples
from tactgen.tmm.reluctance.switching import switching
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.model import Estimate
from tactgen.validation.models.reluctance.switching import resting_state
from tactgen.validation.scene.load import load_scene

NAMES = ("rod_position", "finger_force", "contact_force", "resting_positions")


def answers(*overrides):
    scene, _ = load_scene("reluctance", overrides)
    return {q.name: q for q in solve(scene, "network", NAMES, modelling=False).quantities}


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
    assert float(force.error) == pytest.approx(float(pull.error), rel=1e-2)


def test_the_bars_cover_the_map_made_finer():
    """All resting places by twice as many samples lie within the bars."""
    found = answers("coil.current=60mA")["resting_positions"]
    device = load_scene("reluctance", ["coil.current=60mA"])[0].device
    finer = fit(network_samples(device, *map_grid(device, 26, 24)))
    places = resting_places(axial_forces(device, finer), 60e-3)
    off = np.abs(found.value - [place.lift for place in places])
    assert (off <= found.error).all()


class Flawed:
    """A map that is off by other shares at either end of the stroke, and knows how far at most."""

    def __init__(self, true, wide, narrow):
        self.true, self.ends, self.gap_limits = true, (narrow, wide), true.gap_limits
        self.interpolation_error = MapError(0.0, max(abs(wide), abs(narrow)))

    def _times(self, gap):
        return 1.0 + np.interp(gap, (5e-5, 15e-5), self.ends)

    def force(self, current, gap):
        return self.true.force(current, gap) * self._times(gap)

    def force_gradient(self, current, gap):
        return self.true.force_gradient(current, gap) * self._times(gap)


@pytest.mark.parametrize(
    ("history", "around"),
    # a stop gives way, so that the rod comes back some percent above the rigid stop's drop-out
    [("rising", (0.97, 0.99, 1.005, 1.03)), ("falling", (1.0, 1.04, 1.07, 1.12))],
)
@pytest.mark.parametrize(("wide", "narrow"), [(0.02, -0.02), (-0.02, 0.02)])
def test_beside_pull_in_and_drop_out_points_decide(wide, narrow, history, around):
    """Around both currents the rod is where the exact pull leaves it, and bears what it does.

    The map is two percent off, at one stop otherwise than at the other: a correction found at one
    would call back a rod that has left, or let one go that is held.
    """
    device = load_scene("reluctance", [])[0].device
    exact = network_map(device)
    switches = switching(device, exact)
    at = switches.pull_in if history == "rising" else switches.drop_out
    kinds = set()
    for current in at * np.array(around):
        coil = device.coil.model_copy(update={"current": current})
        driven = device.model_copy(update={"coil": coil})

        def point(i, gap):
            force = Estimate(float(exact.force(i, gap)), 0.0)
            return SimpleNamespace(force=force, beyond_table=0.0)

        state = resting_state(driven, Flawed(exact, wide, narrow), point, history, 0.0)
        place = resting_place(axial_forces(driven, exact), current, history)
        kinds.add(place.kind)
        assert state.kind == place.kind
        # a thousandth of the spring: the flawed map's slope over the way that a stop gives
        assert state.finger_force.value == pytest.approx(place.finger_force, abs=1e-4)
    assert {"upper stop", "lower stop"} <= kinds
