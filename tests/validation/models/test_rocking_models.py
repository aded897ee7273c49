"""A rocking head under any model of the bimorph: the ports are all that harmonic balance knows."""

import numpy as np
import pytest

from tactgen.tmm.harmonic_balance.continuation import steady_orbit
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.backbone import RESOLUTION, five_port, held_head
from tactgen.validation.scene.scene import load_scene

#: Below the peak, where the moment softens the support a little.
FREQUENCY, VOLTAGE = 380.0, 0.3


def scene_of(model):
    overrides = ["load.kind=none", f"models={model}", "accuracy=0.01", f"frequency={FREQUENCY}",
                 f"drive.voltage={VOLTAGE}V", "quantities=tip_displacement"]  # fmt: skip
    return load_scene("generator", overrides)[0]


def rocking(model):
    """First harmonic of the tip (m)."""
    head = held_head(scene_of(model), model)
    orbit = steady_orbit(head.oscillator, 2.0 * np.pi * FREQUENCY, VOLTAGE, resolution=RESOLUTION)
    return complex(head.response(orbit).motion["w_tip"][1])


def linear(model):
    """The same on the springs of small motions."""
    return complex(solve(scene_of(model)).quantities[0].value[0])


def test_beam_elements_rock_as_the_transfer_matrix_does():
    """Within what the ports differ by and the harmonics leave out."""
    tmm, beam = rocking("tmm"), rocking("beam")
    # elements of order five; the ends of two iterations
    assert beam == pytest.approx(tmm, rel=1e-6)
    assert abs(tmm / linear("tmm") - 1.0) > 1e-3  # and it softens, a thousand times as much


@pytest.mark.heavy
def test_the_solid_rocks_as_it_differs_on_springs():
    """Solid over transfer-matrix, rocking: the ratio on springs, but for the smaller moment."""
    ratios = [of("solid") / of("tmm") for of in (rocking, linear)]
    # softening itself is worth two thousandths here, and goes with the moment
    assert abs(ratios[0]) == pytest.approx(abs(ratios[1]), rel=2e-3)


@pytest.mark.parametrize("model", ["lumped", "tmm", "beam"])
def test_layers_in_series_take_half_the_voltage_each(model):
    """So half the force per volt, a quarter of the charge, and the same stiffness."""
    frequency = np.array([100.0])
    one, other = (
        five_port(load_scene("paper", [f"bimorph.wiring={wiring}"])[0], model)(frequency)
        for wiring in ("parallel", "series")
    )
    share = {"voltage": 0.5}
    for row in one.names:
        for column in one.names:
            expected = one[row, column] * share.get(row, 1.0) * share.get(column, 1.0)
            np.testing.assert_allclose(other[row, column], expected, rtol=1e-9)
