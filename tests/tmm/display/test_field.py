"""The network's estimate of the field between units: a permeance beside the working gap."""

import math

import numpy as np
import pytest

from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.device.parameters import Device, Display
from tactgen.geometry.errors import InputError
from tactgen.tmm.display import CELLS, NEIGHBOURS, beside, between_heads, network_forces
from tactgen.tmm.reluctance.circuit import FULL, circuit
from tactgen.tmm.reluctance.flux_ladder import solve
from tactgen.tmm.reluctance.network import network_samples

DEVICE, GAP, CURRENT = Device(), 0.2e-3, 0.05


def test_two_cylinders():
    """Nearly touching: µ0 π l sqrt(R / s), s the gap between them; far: µ0 π l / ln(p / R)."""
    radius, length = DEVICE.rod.head_radius, DEVICE.rod.head_thickness
    near = between_heads(DEVICE, 2.0 * radius + 1e-9)
    assert near == pytest.approx(MU0 * math.pi * length * math.sqrt(radius / 1e-9), rel=1e-5)
    far = between_heads(DEVICE, 1.0)
    assert far == pytest.approx(MU0 * math.pi * length / math.log(1.0 / radius), rel=1e-5)
    with pytest.raises(InputError, match=r"display\.pitch = 2\.2 mm lets heads"):
        between_heads(DEVICE, 2.2e-3)


def test_what_is_beside_the_gap_pulls_nothing_itself():
    """The pull is the co-energy's slope by the gap, the permeance beside it held: 1e-4 by
    central differences over a micrometre."""
    step, over = 1e-6, 5e-8
    at = np.array([GAP - step, GAP, GAP + step])
    found = solve(beside(circuit(DEVICE, at, FULL, 20), over), np.array([CURRENT]))
    slope = (found.coenergy[0, 2] - found.coenergy[0, 0]) / (2.0 * step)
    assert -slope == pytest.approx(found.force[0, 1], rel=1e-4)


def test_of_two_units_the_other_is_a_permeance_in_series():
    """At a small current, where iron is linear: what is beside the gap leads over the air to the
    other's own permeance, which the pull of units driven in turn tells.
    """
    small = 1e-4
    over = between_heads(DEVICE, Display().pitch)
    alone = circuit(DEVICE, np.array([GAP]), FULL, CELLS)

    def pull(permeance):
        return solve(beside(alone, permeance), np.array([small])).force[0, 0]

    alternating = network_forces(DEVICE, Display(), small, GAP).alternating
    own = 2.0 * NEIGHBOURS * over / (math.sqrt(pull(0.0) / alternating) - 1.0)
    found = network_forces(DEVICE, Display(rows=1, columns=2), small, GAP).single
    # the steel's permeability at the start rises with its flux
    assert found == pytest.approx(pull(over * own / (over + own)), rel=1e-3)


def test_equal_units_pull_as_one_alone():
    """All driven alike, or where there is no other; far apart is a row of the case NEI."""
    near = network_forces(DEVICE, Display(), CURRENT, GAP)
    alone = network_samples(DEVICE, CURRENT, GAP).force[0, 0]
    assert near.same == pytest.approx(alone, rel=1e-12)
    assert network_forces(DEVICE, Display(rows=1, columns=1), CURRENT, GAP).single == near.same
    assert network_forces(DEVICE, Display(), 0.0, GAP).single == 0.0
