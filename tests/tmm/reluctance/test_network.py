"""The normal actuator as a reluctance network: limits with exact answers, energy, bridge."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.reluctance import NOMINAL_GAP
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.magnetic_circuit import (
    CELLS,
    FULL,
    ONE_GAP,
    Refinements,
    pole_area,
    with_fringing,
)
from tactgen.tmm.reluctance.network import network_refinements, network_samples
from tactgen.validation.evidence.cases.actuator import COLLARED, collared

DEVICE = COLLARED
CURRENTS = np.array([0.0, 1e-3, 0.02, 0.13, 1.0])
GAPS = np.array([0.01e-3, 0.05e-3, 0.2e-3, 0.27e-3, 0.4e-3])


def textbook_force(current, gap):
    """F = µ0 N² i² A / (2 g²) (N): all the winding's mmf across one straight gap."""
    return MU0 * (849.0 * current / gap) ** 2 * pole_area(DEVICE) / 2.0


def test_bare_network_is_the_textbook_formula():
    """With every refinement off, F = µ0 N² i² A/(2 g²) and λ = µ0 N² i A/g, exactly."""
    found = network_samples(DEVICE, CURRENTS, GAPS, ONE_GAP)
    force = textbook_force(CURRENTS[:, None], GAPS)
    np.testing.assert_allclose(found.force, force, rtol=1e-12)  # rounding
    linkage = MU0 * 849.0**2 * CURRENTS[:, None] * pole_area(DEVICE) / GAPS
    np.testing.assert_allclose(found.flux_linkage, linkage, rtol=1e-12)


def test_parasitic_gap_in_series():
    """With perfect iron the parasitic gap is that of coaxial cylinders, 2π µ0 l/ln(r2/r1)."""
    found = network_samples(DEVICE, CURRENTS, GAPS, replace(ONE_GAP, parasitic_gap=True))
    side = np.log(0.96 / 0.91) / (2.0 * np.pi * MU0 * 0.9e-3)
    total = GAPS / (MU0 * pole_area(DEVICE)) + side
    # one unit of vacuum, 1e-9 m, is added to every rung: 1e-7 of the side's permeance
    expected = 849.0**2 * CURRENTS[:, None] / total
    np.testing.assert_allclose(found.flux_linkage, expected, rtol=1e-6)


def test_short_flange_overlap_moves_with_the_gap():
    """A flange that reaches out of the sleeve overlaps less as the gap closes, and is pushed."""
    device = collared(sleeve={"length": 3.0e-3})
    bare = replace(ONE_GAP, parasitic_gap=True)
    found = network_samples(device, np.array([0.1]), GAPS, bare)
    per_length = 2.0 * np.pi * MU0 / np.log(0.96 / 0.91)
    overlap = 3.0e-3 - 2.4e-3 + (GAPS - 0.2e-3)
    total = GAPS / (MU0 * pole_area(device)) + 1.0 / (per_length * overlap)
    slope = 1.0 / (MU0 * pole_area(device)) - 1.0 / (per_length * overlap**2)
    force = 0.5 * (84.9 / total) ** 2 * slope
    np.testing.assert_allclose(found.force[0], force, rtol=1e-6)  # as above


def test_very_permeable_iron_is_perfect():
    """µr → ∞ leads to perfect iron, with an error of first order in 1/µr."""
    perfect = network_samples(DEVICE, CURRENTS[1:], GAPS, Refinements("perfect"))
    misses = []
    for permeability in (1e5, 1e6):
        device = collared(steel={"curve": "linear", "relative_permeability": permeability})
        found = network_samples(device, CURRENTS[1:], GAPS)
        misses.append(np.abs(found.force / perfect.force - 1.0).max())
    assert misses[0] < 5e-2  # 10 mm of iron over 1e5 beside some 50 um of gaps
    assert misses[1] == pytest.approx(misses[0] / 10.0, rel=0.05)


@pytest.mark.parametrize(
    "refinements",
    [FULL, ONE_GAP, Refinements("linear"), Refinements(parasitic_gap=False, leakage=False)],
)
def test_force_and_flux_linkage_are_derivatives(refinements):
    """F = −∂W'/∂g, λ = ∂W'/∂i and L = ∂λ/∂i of the network's own co-energy, with any switch."""
    sample = partial(network_samples, DEVICE, refinements=refinements)
    found, h, di = sample(CURRENTS, GAPS), 1e-9, 1e-5
    wide, close = sample(CURRENTS, GAPS + h), sample(CURRENTS, GAPS - h)
    force = -(wide.coenergy - close.coenergy) / (2.0 * h)
    # rounding of W' over the step, 1e-15 W'/h; the largest W'/F is a tenth of a millimetre
    np.testing.assert_allclose(force[1:], found.force[1:], rtol=1e-5)
    up, down = sample(CURRENTS[1:] * (1 + di), GAPS), sample(CURRENTS[1:] * (1 - di), GAPS)
    step = 2.0 * di * CURRENTS[1:, None]
    linkage = (up.coenergy - down.coenergy) / step
    np.testing.assert_allclose(linkage, found.flux_linkage[1:], rtol=1e-7)
    # kinks in the curve's slope: a step across one shows to first order
    inductance = (up.flux_linkage - down.flux_linkage) / step
    np.testing.assert_allclose(inductance, found.incremental_inductance[1:], rtol=1e-4)


@pytest.mark.parametrize("refinements", [FULL, ONE_GAP, Refinements("linear")])
@pytest.mark.parametrize("device", [Device(), DEVICE], ids=["built in", "collared"])
def test_a_coil_that_leaves_the_sleeve_keeps_one_coenergy(device, refinements):
    """Where the coil's top, or all of it, is above the sleeve, F = −∂W'/∂g and λ = ∂W'/∂i hold,
    and nothing jumps on the way; all turns above the sleeve still link the gap."""
    coil = device.coil
    level = NOMINAL_GAP + coil.position
    gaps = level + np.array([0.0, 0.01e-3, 0.1e-3])
    i, h = np.array([0.13]), 1e-9

    def at(gap, current=i):
        return network_samples(device, current, gap, refinements)

    force = -(at(gaps[1:] + h).coenergy - at(gaps[1:] - h).coenergy) / (2.0 * h)
    np.testing.assert_allclose(force, at(gaps[1:]).force, rtol=1e-5)  # as above
    linkage = (at(gaps, i * (1 + 1e-5)).coenergy - at(gaps, i * (1 - 1e-5)).coenergy) / (2e-5 * i)
    np.testing.assert_allclose(linkage, at(gaps).flux_linkage, rtol=1e-7)
    below, above = (at(np.array([level + s * h])).flux_linkage for s in (-1, 1))
    assert above == pytest.approx(below, rel=1e-4)  # 1 nm of 200 um


def test_monotone_to_a_million_ampere_turns():
    """Flux linkage and co-energy rise with the current at any saturation."""
    i = np.geomspace(1e-6, 1e6, 49) / 849.0
    found = network_samples(DEVICE, i, GAPS)
    assert (np.diff(found.flux_linkage, axis=0) > 0.0).all()
    assert (found.incremental_inductance > 0.0).all()
    # far in saturation iron adds a constant flux, and the rest behaves as vacuum
    air = found.incremental_inductance[-1]
    np.testing.assert_allclose(found.incremental_inductance[-2], air, rtol=1e-3)


def test_ladder_converges():
    """Force and flux linkage converge with the square of the cells' length."""
    at = np.array([0.05, 0.13]), np.array([0.1e-3, 0.2e-3])
    runs = [network_samples(DEVICE, *at, cells=n) for n in (12, 24, 48)]
    for name in ("flux_linkage", "coenergy"):
        a, b, c = (getattr(run, name) for run in runs)
        ratio = (a - b) / (b - c)
        # second order; kinks of the magnetisation curve between cells disturb the last digits
        assert ((ratio > 3.5) & (ratio < 4.5)).all(), ratio
    # what is left with the default number of cells
    assert (np.abs(runs[1].force / runs[2].force - 1.0) < 1e-3).all()


@pytest.mark.heavy
def test_force_bar_holds_between_currents():
    """Two ladders' forces cross where the steel saturates; the bar must not vanish there.

    The error falls as the square of the cells, so half as many leave three times the fine error.
    """
    currents, gaps = np.geomspace(0.005, 20.0, 25), np.geomspace(0.02e-3, 0.4e-3, 12)
    fine = network_samples(Device(), currents, gaps)
    exact = network_samples(Device(), currents, gaps, cells=16 * CELLS)
    share = np.abs(fine.force - exact.force) / fine.force_error
    assert 1.0 / 3.0 < share.max() <= 1.0


def test_bridge_leads_from_the_formula_to_the_network():
    """One row per refinement; their changes multiply to the whole difference."""
    rows = network_refinements(DEVICE, 0.13, 0.2e-3)
    full = network_samples(DEVICE, np.array([0.13]), np.array([0.2e-3]))
    assert rows[0].force == pytest.approx(textbook_force(0.13, 0.2e-3), rel=1e-12)
    assert rows[-1].force == full.force[0, 0]
    whole = np.prod([1.0 + row.force_change for row in rows])
    assert whole == pytest.approx(rows[-1].force / rows[0].force, rel=1e-12)
    change = {row.step: row.force_change for row in rows}
    assert change["fringing beside the pole faces"] > 0.0 > change["parasitic gap at the flange"]
    assert change["saturation"] < -0.1


def test_covered_part_of_the_bore():
    """The head takes all of the collar's bore through a small gap to a distant shaft, none
    through a large gap beside a near one."""
    collar = DEVICE.sleeve.collar_thickness
    # 10 um to the head beside 10 um, or 300 um, to the shaft
    far = collared(rod={"radius": 0.1e-3}, sleeve={"collar_thickness": 20e-6})
    assert with_fringing(far, np.array([1e-6]))[1][0] == pytest.approx(20e-6, rel=1e-2)
    near = collared(rod={"radius": 0.895e-3})
    assert with_fringing(near, np.array([1e-3]))[1][0] < 1e-3 * collar


SHORT, WIDE = {"length": 0.1e-3}, {"collar_radius": 0.95e-3}


@pytest.mark.parametrize(
    ("device", "gap", "words"),
    [
        (DEVICE, 0.0, "gap = 0 mm leaves no gap"),
        (collared(rod={"head_radius": 0.8e-3}), 0.2e-3, "rod.head_radius = 0.8 mm"),
        (collared(sleeve={"collar_radius": 0.6e-3}), 0.2e-3, "sleeve.collar_radius = 0.6 mm"),
        (collared(sleeve={"collar_thickness": 2.5e-3}, coil=SHORT), 0.2e-3,
         "gap = 0.2 mm needs the flange .* to pass the collar"),
        (collared(sleeve=WIDE | {"collar_thickness": 2.5e-3}, coil=SHORT), 0.2e-3,
         "gap = 0.2 mm brings sleeve.collar_thickness .*; make the gap smaller or the collar"),
    ],
)  # fmt: skip
def test_impossible_circuits_are_refused(device, gap, words):
    """Dimensions that close no such circuit are refused in one sentence."""
    with pytest.raises(InputError, match=words):
        network_samples(device, np.array([0.1]), np.array([gap]))
