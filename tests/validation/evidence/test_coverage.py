"""The coverage study: its references, and that its parts hold."""

import itertools

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.magnetic_circuit import CELLS
from tactgen.tmm.reluctance.map_range import network_map
from tactgen.tmm.reluctance.network import DirectForce
from tactgen.validation.evidence import coverage_actuator as axisymmetric
from tactgen.validation.evidence import coverage_bimorph as solid
from tactgen.validation.evidence import random_devices as scenes
from tactgen.validation.evidence.coverage import PARTS
from tactgen.validation.evidence.judgement import run_parts


def test_the_networks_own_pull_is_the_maps():
    """Arrays of any shape, slopes with the map's signs, as far as the steel's corners let them."""
    surface = network_map(Device())
    exact = DirectForce(Device(), CELLS, surface.gap_limits)
    current, gap = np.array([[0.05], [0.12]]), np.array([0.1e-3, 0.2e-3, 0.24e-3])
    for name in ("force", "incremental_inductance", "force_gradient", "motional_coefficient"):
        by_map, found = (getattr(pull, name)(current, gap) for pull in (surface, exact))
        assert found.shape == (2, 3)
        assert found == pytest.approx(by_map, rel=0.02), name
    with pytest.raises(InputError, match="outside the map"):
        surface.force(1.01 * surface.current_limit, surface.gap_limits[0])


def test_references_of_the_solid_are_per_volt_of_the_drive(monkeypatch, few_bricks):
    """At 3 V: three times the deflection, and the same capacitances and frequencies."""
    monkeypatch.setattr(solid.Case, "reference", few_bricks[0])
    one, three = (
        solid.reference(solid.Case((f"drive.voltage={volts} V", "modes=1")), ()) for volts in (1, 3)
    )
    deflection = ("static_tip_displacement", "")
    assert three.pop(deflection) == pytest.approx([3.0 * one.pop(deflection)[0]], rel=1e-9)
    assert one.keys() == three.keys()
    for name, values in one.items():
        assert three[name] == pytest.approx(values, rel=1e-9), name
    free, blocked = (abs(one[f"capacitance_{how}", ""][0]) for how in ("free", "blocked"))
    assert blocked < free < 1e-6


def test_a_model_that_refuses_all_ends_the_draws(monkeypatch):
    """One sentence, with what was said of the last of them."""
    calls = itertools.count(1)

    def refuse(*_, **__):
        raise InputError(f"no {next(calls)}")

    monkeypatch.setattr(axisymmetric, "solve_point", refuse)
    monkeypatch.setattr(scenes, "MOST_DRAWS", 3)
    with pytest.raises(InputError, match=r"all 3 random devices were refused; .* no 3$"):
        axisymmetric.judge_axisymmetric(np.random.default_rng(0))


@pytest.mark.heavy
@pytest.mark.parametrize("part", [part for part in PARTS if part not in ("solid", "cad")])
def test_bars_hold(part):
    """As many devices as the command takes; solid and cad have tests of their own."""
    (found,) = run_parts("coverage", [part], 1, lambda _: None)
    assert found.holds, found.rows
