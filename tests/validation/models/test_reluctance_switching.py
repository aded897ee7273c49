"""Where the rod switches and rests, by map and points: exact where the answer is."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device, Spring
from tactgen.tmm.generator.equilibrium import axial_forces, resting_place, resting_places
from tactgen.tmm.reluctance import map_range
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import MapError, Samples
from tactgen.tmm.reluctance.network import network_samples
from tactgen.tmm.reluctance.switching import switching
from tactgen.validation.engine.solve import as_json, solve
from tactgen.validation.models.model import Estimate
from tactgen.validation.models.reluctance.switching import (
    MagneticPoint,
    resting_state,
    switching_currents,
)
from tactgen.validation.scene.load import load_scene

#: A linear actuator: λ = C i/(g + G0), F = C i²/(2 (g + G0)²); its map is off by this factor.
C, G0, OFF = 2e-6, 0.1e-3, 1.05
BAR = 1e-3


@pytest.fixture(scope="module")
def pull():
    """A map of a model whose points are 5 % weaker: what interpolation may do, and more."""
    i, g = np.linspace(0.0, 0.3, 9), np.geomspace(0.015e-3, 0.25e-3, 12)
    linkage = OFF * C * i[:, None] / (g + G0)
    return fit(Samples(i, g, linkage, 0.5 * linkage**2 / (OFF * C)))


def at(current, gap):
    force = C * current**2 / (2.0 * (gap + G0) ** 2)
    none = Estimate(0.0, 0.0)
    return MagneticPoint(
        current, gap, Estimate(force, BAR * force), none, none, none, "closed form", 0.0
    )


def device(preload, stiffness):
    return Device(spring=Spring(preload=preload, stiffness=stiffness, stop_gap=20e-6))


def balance(preload, stiffness, gap):
    return (gap + G0) * math.sqrt(2.0 * (preload + stiffness * (0.2e-3 - gap)) / C)


def test_currents_are_those_of_the_points(pull):
    """A soft spring: both ends of the stroke to rounding; F ∝ i² makes half the force's bar.

    Without a spring they are zero with a bar of zero; what cannot be reached is no number.
    """
    found = switching_currents(device(0.1, 100.0), pull, at)
    for current, gap in ((found.pull_in, 0.2e-3), (found.holding, 20e-6)):
        exact = balance(0.1, 100.0, gap)
        assert current.value == pytest.approx(exact, rel=1e-6)
        # what the last step of the secant was stands in the bar, too
        assert 0.5 * BAR * exact <= current.error < 0.6 * BAR * exact
    assert (found.lift_off, found.drop_out) == (found.pull_in, found.holding)
    assert not found.floats
    none = switching_currents(device(0.0, 0.0), pull, at)
    assert none.pull_in == none.holding == none.drop_out == Estimate(0.0, 0.0)
    strong = switching_currents(device(1.5, 0.0), pull, at)
    assert math.isnan(strong.pull_in.value)
    assert strong.holding.value == pytest.approx(balance(1.5, 0.0, 20e-6), rel=1e-6)


def test_a_floating_place_is_found_by_its_own_points(pull):
    """A stiff spring: the fold of the balance current, within the bar, which holds the place's."""
    preload, stiffness = 0.02, 1500.0
    found = switching_currents(device(preload, stiffness), pull, at)
    fold = 2.0 / 3.0 * (preload / stiffness + 0.2e-3 + G0) - G0
    exact = balance(preload, stiffness, fold)
    assert abs(found.pull_in.value - exact) <= found.pull_in.error
    assert found.pull_in.value == pytest.approx(exact, rel=1e-3)
    assert found.lift_off.value == pytest.approx(balance(preload, stiffness, 0.2e-3), rel=1e-6)
    assert found.floats


SWITCHING = ("pull_in_current", "holding_current", "drop_out_current")
RESTING = ("rod_position", "finger_force", "contact_force", "resting_positions")


def solved(*overrides, quantities=SWITCHING):
    scene, _ = load_scene("reluctance", ["models=network", *overrides])
    return solve(scene, None, quantities)


def answers(*overrides):
    return {q.name: q for q in solved(*overrides, quantities=RESTING).quantities}


@pytest.mark.parametrize("current", ["0 A", pytest.param("1 kA", marks=pytest.mark.heavy)])
def test_the_network_switches_where_its_force_balances(current):
    """At the current found the network pulls with the spring's force, whatever coil.current is."""
    solution = solved(f"coil.current={current}")
    built = Device()
    for name, gap, against in (
        ("pull_in_current", 0.2e-3, 0.11),
        ("holding_current", 20e-6, 0.11 + 100.0 * 180e-6),
    ):
        q = solution.get(name, "network")
        force = network_samples(built, np.array([float(q.value)]), np.array([gap])).force[0, 0]
        assert force == pytest.approx(against, rel=1e-5)
        assert float(q.error) < 2e-3 * float(q.value)
    assert float(solution.get("drop_out_current", "network").value) == float(
        solution.get("holding_current", "network").value
    )


@pytest.mark.parametrize("override", ["coil.current=0 A", "gap=0.45 mm"])
def test_nothing_else_falls_with_a_current(override):
    """All quantities of the scene are answered, at any current and gap that the network takes."""
    solution = solved(override, quantities=None)
    assert all("modelling error" in text for text in solution.warnings)
    assert all(np.isfinite(q.value).all() for q in solution.quantities)


@pytest.mark.usefixtures("own_store")
def test_a_rod_that_does_not_pull_in_is_said_once(monkeypatch):
    """Null in JSON, one warning with the spring and a remedy; other quantities keep theirs."""
    # in the network more current always pulls more: its map is cut short here
    small = np.linspace(0.0, 0.06, 13), np.geomspace(20e-6, 0.25e-3, 12)
    monkeypatch.setattr(map_range, "map_grid", lambda _: small)
    # the map that this process may have got already, less its memory
    monkeypatch.setattr(map_range, "_network_pull", map_range._network_pull.__wrapped__)
    solution = solved(quantities=("pull_in_current", "holding_current", "magnetic_force"))
    pull_in, holding, force = as_json(solution)["quantities"]
    assert pull_in["value"] is None
    assert holding["value"] == pytest.approx(21.59e-3, rel=1e-3)  # measured, as everywhere
    assert force["value"] > 0.1
    (warning,) = (text for text in solution.warnings if "modelling error" not in text)
    for words in ("pull_in_current has no value in the model network", "with up to 60 mA",
                  "spring.preload = 110 mN", "use a softer spring"):  # fmt: skip
        assert words in warning


def test_a_curve_that_ends_too_early_is_warned_of(tmp_path):
    """The device needs 2 T: a table up to 1.2 T is said to be too short, one to 2.25 T is not."""
    rows = "B (T),H (A/m)\n0,0\n0.4,255\n0.8,405\n1.2,836\n"
    (tmp_path / "short.csv").write_text(rows)
    (tmp_path / "long.csv").write_text(rows + "1.6,3480\n2,26300\n2.2,84300\n2.25,110000\n")
    for name, current, count in (
        ("short", "130 mA", 1), ("long", "130 mA", 0), ("short", "5 mA", 0),  # little flux
    ):  # fmt: skip
        curve = f"steel.curve={tmp_path / name}.csv"
        found = solved(curve, f"coil.current={current}", quantities=("magnetic_force",)).warnings
        short = "of the iron is magnetised beyond the end of steel.curve"
        assert [short in w for w in found].count(True) == count


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
    solution = solved("coil.current=50mA", quantities=("finger_force", "magnetic_force"))
    force, pull = solution.quantities
    left = solution.scene.spring.preload - float(pull.value)
    # the place is 0.1 um below the nominal gap: 190 N/m of pull and 100 N/m of spring
    assert float(force.value) == pytest.approx(left, abs=1e-4)
    assert float(force.error) == pytest.approx(float(pull.error), rel=1e-2)


def test_the_bars_cover_the_map_made_finer():
    """All resting places by twice as many samples lie within the bars."""
    found = answers("coil.current=60mA")["resting_positions"]
    device = load_scene("reluctance", ["coil.current=60mA"])[0].device
    finer = fit(network_samples(device, *map_range.map_grid(device, 26, 24)))
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
    exact = map_range.network_map(device)
    switches = switching(device, exact)
    limit = switches.pull_in if history == "rising" else switches.drop_out
    kinds = set()
    for current in limit * np.array(around):
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
