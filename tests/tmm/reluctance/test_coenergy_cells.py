"""The co-energy map cell by cell: the same surface, to rounding."""

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import cells
from tactgen.tmm.reluctance.network import network_samples


@pytest.fixture(scope="module")
def pull():
    currents = 0.2 * (np.arange(9) / 8.0) ** 1.5
    return fit(network_samples(Device(), currents, np.geomspace(20e-6, 250e-6, 8)))


def test_all_derivatives_are_those_of_the_map(pull):
    """At random points, at breaks and at the ends, for either sign of the current."""
    found = cells(pull)
    chosen = np.random.default_rng(5)
    currents = [0.0, 0.2, *found.current_breaks[1:3], *chosen.uniform(-0.2, 0.2, 20)]
    low, high = pull.gap_limits
    gaps = [low, high, *np.exp(found.width_breaks[1:3]) - pull.gap_offset]
    gaps += list(chosen.uniform(low, high, 20))
    for current, gap in zip(currents, gaps, strict=True):
        point = found.at(current, gap)
        for value, method in (
            (point.coenergy, pull.coenergy),
            (point.flux_linkage, pull.flux_linkage),
            (point.force, pull.force),
            (point.inductance, pull.incremental_inductance),
            (point.motional, pull.motional_coefficient),
            (point.force_gradient, pull.force_gradient),
        ):
            expected = float(method(current, gap))
            size = float(np.abs(method(0.2, gap)))
            assert value == pytest.approx(expected, rel=1e-11, abs=1e-13 * size)


def test_beyond_the_ends_it_goes_on_smoothly(pull):
    """An iteration that strays sees no jump."""
    found = cells(pull)
    low, high = pull.gap_limits
    for gap in (low, high):
        inside, outside = (found.at(0.1, gap * (1.0 + d)) for d in (-1e-9, 1e-9))
        assert inside == pytest.approx(outside, rel=1e-6)
    assert np.isfinite(found.at(0.3, -1.0)).all()
