"""Generators on one board under one skin, and the network's estimate of the field between them."""

import math

import numpy as np
import pytest

from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.device.parameters import Beam, Device, Display, Load, Skin, Support
from tactgen.geometry.display.layout import unit_names
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.transfer_matrix import multiport
from tactgen.tmm.display import (
    CELLS,
    NEIGHBOURS,
    beside,
    between_heads,
    board,
    joined,
    links,
    network_forces,
    plate_waves,
    sheet,
    tilt_compliance,
    tip_motions,
    unit_ports,
)
from tactgen.tmm.generator.equilibrium import held_support
from tactgen.tmm.generator.small_signal import linearised, machine
from tactgen.tmm.ports.multiport import respond, terminate
from tactgen.tmm.ports.supports_and_loads import ends_of
from tactgen.tmm.reluctance.flux_ladder import solve
from tactgen.tmm.reluctance.magnetic_circuit import FULL, circuit
from tactgen.tmm.reluctance.map_range import network_map
from tactgen.tmm.reluctance.network import network_samples

F = np.array([10.0, 100.0, 430.0, 1000.0])
DEVICE, DISPLAY = Device(), Display(rows=2, columns=2)
UNITS = unit_names(DISPLAY)
BOARD_MASS = 5e-3


@pytest.fixture(scope="module")
def bimorph():
    return multiport(DEVICE, Support(), Beam(), F)


@pytest.fixture(scope="module")
def held():
    return held_support(DEVICE, None, 0.0, "rising")


@pytest.fixture(scope="module")
def unit(bimorph, held):
    return unit_ports(bimorph, DEVICE, held[0], ends_of(held[1], Load()).tip)


def array(unit, display=DISPLAY, skin=None):
    names = unit_names(display)
    over = sheet(skin, display, F, names) if skin else None
    on = board(DEVICE, display, F, names, BOARD_MASS)
    return joined(dict.fromkeys(names, unit), on, over)


def others(whole, driven="r1c1", units=UNITS):
    motions = np.abs(tip_motions(whole, driven, units))
    return np.delete(motions, units.index(driven), axis=1) / motions.max(axis=1, keepdims=True)


def test_nothing_passes_where_nothing_joins(unit):
    """On a board that is held still and without skin the others are at rest, exactly."""
    still = joined(dict.fromkeys(UNITS, unit), None, None)
    assert not others(still).any()


def test_alone_on_a_still_board_it_is_the_machine(unit, bimorph, held):
    """The small-signal machine without current, whose lift is apart: 1e-9, two ways of joining."""
    place, _ = held
    linear = linearised(DEVICE, Beam(), place, 0.0, network_map(DEVICE))
    load = {"w_tip": ends_of(held[1], Load()).tip(F)}
    whole = terminate(machine(bimorph, linear), load)
    expected = respond(whole, {"voltage": 1.0, "current": 0.0}).motion["w_tip"]
    alone = joined({"r1c1": unit}, None, None)
    np.testing.assert_allclose(tip_motions(alone, "r1c1", ("r1c1",))[:, 0], expected, rtol=1e-9)


def test_alone_on_its_own_board_it_differs_by_what_the_board_gives_under_its_head(unit):
    """A unit far apart and without skin is not the machine on a still board, by its board's tilt.

    The board in its plane has a hundredth of that; both go when the board gives no more.
    """
    one = Display(rows=1, columns=1)
    still = tip_motions(joined({"r1c1": unit}, None, None), "r1c1", ("r1c1",))[:, 0]

    def apart(**stiffer):
        whole = array(unit, one.model_copy(update=stiffer))
        return np.abs(tip_motions(whole, "r1c1", ("r1c1",))[:, 0] / still - 1.0)

    own = tilt_compliance(plate_waves(DEVICE, one), F, one.board_loss)[:, 0, 0]
    assert (apart(board_modulus=1e20) < 0.01 * apart()).all()
    # what is left is that compliance alone, under the head
    tilted = terminate(unit.block("w_tip", "voltage", "psi_board"), {"psi_board": 1.0 / own})
    expected = respond(tilted, {"voltage": 1.0}).motion["w_tip"]
    np.testing.assert_allclose(
        apart(lateral_stiffness=1e20), np.abs(expected / still - 1.0), rtol=1e-6
    )
    # in proportion to the compliance, so nothing but the board is in it
    stiff = apart(board_modulus=1e6 * one.board_modulus, lateral_stiffness=1e20)
    assert (stiff < 1e-6 * 3.0).all()


def test_skin_is_a_sheet(unit):
    """Moved together its tips feel nothing; neighbours feel the strip between them."""
    over = sheet(Skin(loss_factor=0.0), DISPLAY, F, UNITS)
    np.testing.assert_allclose(over.stiffness @ np.ones(4), 0.0, atol=1e-12)
    along_x, along_y = links(Skin())
    assert over["w_r1c1", "w_r1c2"][0] == pytest.approx(-along_x)
    assert over["w_r1c1", "w_r2c1"][0] == pytest.approx(-along_y)
    assert over["w_r1c1", "w_r2c2"][0] == 0.0
    # E t / (1 - nu²) and G t of 1 mm of 0.1 MPa
    assert along_x == pytest.approx(100.0 / (1.0 - 0.48**2))
    assert along_y == pytest.approx(100.0 / (2.0 * 1.48))
    assert others(array(unit, skin=Skin())).max() > others(array(unit)).max()


def test_the_board_tilts_as_a_plate():
    """Beside a point moment on a large plate the tilt is that of the logarithmic field.

    Two heads along y, far from the edges: the difference of their tilts under one's moment at two
    distances is M (ln(r2/r1) - R²/2 (1/r1² - 1/r2²)) / (4 pi D), from w = M x (2 ln r + 1) /
    (8 pi D) spread over both rings.  1 %: the edges, 12 times as far away.
    """
    tilts = []
    for pitch in (4e-3, 8e-3):
        large = Display(
            rows=2, columns=1, pitch=pitch, width=0.2, length=0.25, board_length=0.2, board_loss=0.0
        )
        compliance = tilt_compliance(plate_waves(DEVICE, large), np.zeros(1), 0.0)[0].real
        assert compliance[0, 0] == pytest.approx(compliance[1, 1])
        tilts.append(compliance[0, 1])
    stiffness = DISPLAY.board_modulus * 1e-9 / (12.0 * (1.0 - 0.14**2))
    rings = 0.5 * DEVICE.rod.head_radius**2 * (4e-3**-2 - 8e-3**-2)
    expected = (np.log(2.0) - rings) / (4.0 * np.pi * stiffness)
    assert tilts[0] - tilts[1] == pytest.approx(expected, rel=0.01)


def test_the_board_has_its_first_resonance():
    """pi/2 sqrt(D / (rho h)) (1/a² + 1/b²) of a simply supported plate, between its spacers."""
    one = Display(rows=1, columns=2, board_loss=0.0)
    waves = plate_waves(DEVICE, one)
    first = np.sqrt(waves.stiffness / waves.mass).min() / (2.0 * np.pi)
    bending = one.board_modulus * 1e-9 / (12.0 * (1.0 - 0.14**2))
    a, b = 42e-3, 48e-3
    expected = 0.5 * np.pi * np.sqrt(bending / (1850.0 * 1e-3)) * (1.0 / a**2 + 1.0 / b**2)
    assert first == pytest.approx(expected, rel=1e-12)


GAP, CURRENT = 0.2e-3, 0.05


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
