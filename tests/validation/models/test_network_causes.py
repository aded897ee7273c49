"""Why the network is not the field: shares that add up, each by its own assumption."""

import numpy as np
import pytest

from tactgen.fem.reluctance.axisymmetric.actuator import solve_point
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.models.reluctance.network_causes import network_causes

GAP = 0.2e-3


@pytest.fixture(scope="module")
def large():
    return network_causes(Device(), 0.13, GAP)


def test_shares_are_the_whole_difference(large):
    """Network over the model's own field, less 1: the reading of both does not enter the sum."""
    field = solve_point(Device(), 0.13, GAP)
    network = network_samples(Device(), np.array([0.13]), np.array([GAP]))
    whole = float(network.force[0, 0]) / field.force - 1.0
    # one grid, one order: the same numbers
    assert sum(cause.force for cause in large) == pytest.approx(whole, abs=1e-9)
    linkage = float(network.flux_linkage[0, 0]) / field.flux_linkage - 1.0
    assert sum(cause.flux_linkage for cause in large) == pytest.approx(linkage, abs=1e-9)


def test_only_saturation_knows_the_current(large):
    """With iron of any one permeability all goes with the current: its shares stay."""
    small = network_causes(Device(), 0.013, GAP)
    for weak, strong in zip(small[:2], large[:2], strict=True):
        # Newton's method stops at 1e-9 of the energy, whose root the field's error is
        assert weak.of == pytest.approx(strong.of, abs=1e-4)
    assert abs(small[2].force) < 0.02 < large[2].force
