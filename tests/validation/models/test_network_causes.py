"""Why the network is not the field: shares that add up, each by its own assumption."""

import numpy as np
import pytest
from approved import described

from tactgen.fem.reluctance.axisymmetric.actuator import solve_point
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.circuit import FULL, circuit, sleeve_heights
from tactgen.tmm.reluctance.flux_ladder import solve
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.models.reluctance.network_causes import network_causes
from tactgen.validation.models.reluctance.outer_flux import OuterFlux, with_outer_flux

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


def test_flux_outside_is_what_saturation_makes_of_the_shaft(large):
    """With iron of any one permeability all goes with the current: these shares stay.

    Of the pull at 130 mA three quarters of the difference are flux outside; at 13 mA, where the
    shaft carries all of it lightly, next to nothing.
    """
    small = network_causes(Device(), 0.013, GAP)
    for weak, strong in zip(small[:2], large[:2], strict=True):
        # Newton's method stops at 1e-9 of the energy, whose root the field's error is
        assert weak.of == pytest.approx(strong.of, abs=1e-4)
    assert large[-1].name == "flux outside"
    assert abs(small[-1].force) < 0.02
    assert large[-1].force > 0.7 * sum(cause.force for cause in large) > 0.05


def test_network_with_the_flux_outside_is_near_the_field(large):
    """What is left of 12 % of the pull and 11 % of the linkage is how the flux spreads in iron."""
    assert abs(sum(cause.force for cause in large[:-1])) < 0.03
    assert abs(sum(cause.flux_linkage for cause in large[:-1])) < 0.01


@pytest.fixture(scope="module")
def ladder():
    return circuit(Device(), np.array([GAP]), FULL)


def test_no_flux_outside_is_the_network(ladder):
    """The same minimum by two programs: nothing outside, and the gap's own permeance."""
    nothing = OuterFlux(np.zeros(ladder.length.shape[1]), 1.0 / float(ladder.reluctance[0, -1]))
    found, plain = with_outer_flux(ladder, nothing, 0.13), solve(ladder, np.array([0.13]))
    for name in ("flux", "coenergy", "flux_linkage", "force", "incremental_inductance"):
        np.testing.assert_allclose(getattr(found, name), getattr(plain, name), rtol=1e-8)


def test_flux_outside_leaves_one_energy(ladder):
    """Linkage and inductance are slopes of the co-energy: also where some flux is outside."""
    share = np.where(np.isnan(sleeve_heights(Device(), GAP)), 0.0, 0.3)
    outer = OuterFlux(share, 1.3 / float(ladder.reluctance[0, -1]))
    low, here, high = (with_outer_flux(ladder, outer, i) for i in (0.1299, 0.13, 0.1301))
    for slope, of in (("flux_linkage", "coenergy"), ("incremental_inductance", "flux_linkage")):
        difference = (getattr(high, of) - getattr(low, of)) / 2e-4
        # second order in a step of 8e-4 of the current
        np.testing.assert_allclose(getattr(here, slope), difference, rtol=1e-4)


def test_pull_is_the_slope_of_the_coenergy_by_the_gap():
    """The permeance that is added does not know the gap: it changes by the tubes' alone."""
    share = np.where(np.isnan(sleeve_heights(Device(), GAP)), 0.0, 0.3)
    added, step, found = 5e-9, 1e-8, []
    for gap in (GAP - step, GAP, GAP + step):
        at = circuit(Device(), np.array([gap]), FULL)
        outer = OuterFlux(share, added + 1.0 / float(at.reluctance[0, -1]))
        found.append(with_outer_flux(at, outer, 0.13))
    slope = float((found[2].coenergy - found[0].coenergy)[0, 0]) / (2.0 * step)
    assert float(found[1].force[0, 0]) == pytest.approx(-slope, rel=1e-5)


def test_all_that_is_said_of_the_difference(large, ladder, approved):
    share = np.where(np.isnan(sleeve_heights(Device(), GAP)), 0.0, 0.3)
    outer = OuterFlux(share, 1.3 / float(ladder.reluctance[0, -1]))
    approved(described([large, with_outer_flux(ladder, outer, 0.13)]))
