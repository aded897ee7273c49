"""The machine's quantities by the models of the bimorph."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.generator.small_signal import machine
from tactgen.tmm.ports.multiport import respond
from tactgen.validation.catalogue.quantities import quantities_of
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models.classes import map_of
from tactgen.validation.models.small_signal import machine_of
from tactgen.validation.scene.load import load_scene

UP = ("support.kind=contact", "coil.current=0mA", "frequency=10,100,446,800,1000")
HELD = ("support.kind=contact", "coil.current=50mA", "coil.history=falling", *UP[2:])
NAMES = quantities_of("generator")


@cache
def answers(*overrides, models=("tmm",), quantities=NAMES):
    scene, _ = load_scene("paper", overrides)
    solution = solve(scene, models, quantities, modelling=False)
    return {(q.model, q.name): q for q in solution.quantities}


def test_the_support_and_the_machine_tell_one_lateral_motion():
    """Without the rod's lateral mass, its lever and the lateral damping, which a support's springs
    leave out, the machine is the support to rounding; they are worth 1e-4 up to 100 Hz and, where
    the resonance is passed, some percent."""
    names = ("lateral_tip_per_voltage", "tip_displacement")
    overrides = (*UP, "load.kind=none")
    found = answers(*overrides, quantities=names)
    springs = found["tmm", names[1]].value / 50.0
    scene, _ = load_scene("paper", overrides)
    linear = machine_of(scene, map_of(scene)).fine
    turning, axial = linear.mass[1, 1], linear.mass[2, 2]
    damping = np.diag([0.0, *np.diag(linear.damping)[1:]])
    light = replace(linear, mass=np.diag([0.0, turning, axial]), damping=damping)
    ports = tmm.multiport(scene.device, scene.support, scene.beam, np.array(scene.frequency))
    alone = respond(machine(ports, light), {"voltage": 1.0, "current": 0.0}).motion["w_tip"]
    np.testing.assert_allclose(alone, springs, rtol=1e-9)
    off = np.abs(found["tmm", names[0]].value / springs - 1.0)
    assert (off[:2] > 0.0).all()
    assert (off[:2] < 1e-4).all()
    assert (off < 0.06).all()


def test_models_of_one_theory_agree():
    """Beam elements and tmm within 1e-6 on one map, far below its bars; lumped has statics and one
    mode."""
    found = answers(*HELD, models=("tmm", "beam", "lumped"))
    for name in NAMES:
        exact, beam, lumped = (found[model, name] for model in ("tmm", "beam", "lumped"))
        off = np.abs(beam.value - exact.value)
        assert (off <= 1e-6 * np.abs(exact.value)).all(), name
        at_10_hertz = lumped.value[0] == pytest.approx(exact.value[0], rel=1e-4, abs=1e-30)
        assert at_10_hertz, name


def test_series_wiring_halves_the_voltage_of_a_layer():
    """The coil moves the tip as before when the voltage is held at 0; a volt moves it half."""
    names = ("lateral_tip_per_voltage", "axial_tip_per_current")
    one = answers(*UP, quantities=names)
    two = answers(*UP, "bimorph.wiring=series", quantities=names)
    half = two["tmm", names[0]].value / one["tmm", names[0]].value
    np.testing.assert_allclose(half, 0.5, rtol=1e-9)


def test_a_bimorph_on_springs_is_refused():
    """One sentence with the remedy; the scene paper does not stand on the rod."""
    scene, _ = load_scene("paper", ["frequency=100"])
    with pytest.raises(InputError, match=r"set support\.kind=contact"):
        make_plan(scene, ["tmm"], ["axial_poles"])
