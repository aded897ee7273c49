"""Switching currents by the map and by points: exact where the answer is, whatever the map says."""

import math

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device, Spring
from tactgen.tmm.reluctance import map_range as network_map
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import Samples
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.engine.solve import as_json, solve
from tactgen.validation.models.model import Estimate
from tactgen.validation.models.reluctance.switching import MagneticPoint, switching_currents
from tactgen.validation.scene.load import load_scene

#: A linear actuator: λ = C i/(g + G0), F = C i²/(2 (g + G0)²); its map is off by this factor.
C, G0, OFF = 2e-6, 0.1e-3, 1.05
BAR = 1e-3


def samples(c):
    i, g = np.linspace(0.0, 0.3, 9), np.geomspace(0.015e-3, 0.25e-3, 12)
    linkage = c * i[:, None] / (g + G0)
    return Samples(i, g, linkage, 0.5 * linkage**2 / c)


@pytest.fixture(scope="module")
def pull():
    """A map of a model whose points are 5 % weaker: what interpolation may do, and more."""
    return fit(samples(OFF * C))


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
    """A soft spring: both ends of the stroke to rounding; F ∝ i² makes half the force's bar."""
    found = switching_currents(device(0.1, 100.0), pull, at)
    for current, gap in ((found.pull_in, 0.2e-3), (found.holding, 20e-6)):
        exact = balance(0.1, 100.0, gap)
        assert current.value == pytest.approx(exact, rel=1e-6)
        # what the last step of the secant was stands in the bar, too
        assert 0.5 * BAR * exact <= current.error < 0.6 * BAR * exact
    assert found.lift_off == found.pull_in
    assert found.drop_out == found.holding
    assert not found.floats


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


def test_what_cannot_be_reached_has_no_value(pull):
    """nan for the current, not an error: other quantities keep their values."""
    found = switching_currents(device(1.5, 0.0), pull, at)
    assert math.isnan(found.pull_in.value)
    assert found.holding.value == pytest.approx(balance(1.5, 0.0, 20e-6), rel=1e-6)


def test_no_spring_needs_no_current(pull):
    """Zero with a bar of zero."""
    found = switching_currents(device(0.0, 0.0), pull, at)
    assert found.pull_in == found.holding == found.drop_out == Estimate(0.0, 0.0)


def solved(*overrides, quantities=("pull_in_current", "holding_current", "drop_out_current")):
    return solve(load_scene("reluctance", ["models=network", *overrides])[0], None, quantities)


@pytest.mark.parametrize("current", ["0 A", "5 A", pytest.param("1 kA", marks=pytest.mark.heavy)])
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
    scene, _ = load_scene("reluctance", ["models=network", override])
    solution = solve(scene)
    assert all("modelling error" in text for text in solution.warnings)
    assert all(np.isfinite(q.value).all() for q in solution.quantities)


@pytest.mark.usefixtures("own_store")
def test_a_rod_that_does_not_pull_in_is_said_once(monkeypatch):
    """Null in JSON, one warning with the spring and a remedy; other quantities keep theirs."""
    # in the network more current always pulls more: its map is cut short here
    small = np.linspace(0.0, 0.06, 13), np.geomspace(20e-6, 0.25e-3, 12)
    monkeypatch.setattr("tactgen.tmm.reluctance.map_range.map_grid", lambda _: small)
    # the map that this process may have got already, less its memory
    pull = network_map._network_pull.__wrapped__
    monkeypatch.setattr(network_map, "_network_pull", pull)
    solution = solved(quantities=("pull_in_current", "holding_current", "magnetic_force"))
    pull_in, holding, force = as_json(solution)["quantities"]
    assert pull_in["value"] is None
    assert holding["value"] == pytest.approx(21.59e-3, rel=1e-3)  # measured, as everywhere
    assert force["value"] > 0.1
    (warning,) = (text for text in solution.warnings if "modelling error" not in text)
    for words in (
        "pull_in_current has no value in the model network", "with up to 60 mA",
        "spring.preload = 110 mN", "use a softer spring",
    ):  # fmt: skip
        assert words in warning


def test_a_curve_that_ends_too_early_is_warned_of(tmp_path):
    """The device needs 2 T: a table up to 1.2 T is said to be too short, one to 2.25 T is not."""
    rows = "B (T),H (A/m)\n0,0\n0.4,255\n0.8,405\n1.2,836\n"
    (tmp_path / "short.csv").write_text(rows)
    (tmp_path / "long.csv").write_text(rows + "1.6,3480\n2,26300\n2.2,84300\n2.25,110000\n")
    for name, count in (("short", 1), ("long", 0)):
        curve = f"steel.curve={tmp_path / name}.csv"
        found = solved(curve, quantities=("magnetic_force", "holding_current")).warnings
        short = "of the iron is magnetised beyond the end of steel.curve"
        assert [short in w for w in found].count(True) == count
    # little current, little flux: nothing to say
    little = solved(
        f"steel.curve={tmp_path}/short.csv", "coil.current=5 mA", quantities=("magnetic_force",)
    )
    assert not any(short in w for w in little.warnings)
