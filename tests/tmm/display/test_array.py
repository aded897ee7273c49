"""Generators on one board under one skin: reciprocal, passive, apart where nothing joins them."""

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Beam, Device, Display, Load, Skin, Support
from tactgen.geometry.display.layout import unit_names
from tactgen.tmm.beam.transfer_matrix import multiport
from tactgen.tmm.display import (
    board,
    joined,
    links,
    plate_waves,
    sheet,
    tilt_compliance,
    tip_motions,
    unit_ports,
)
from tactgen.tmm.generator.equilibrium import held_support
from tactgen.tmm.generator.small_signal import linearised, machine
from tactgen.tmm.ports.elements import ends_of
from tactgen.tmm.ports.multiport import respond, terminate
from tactgen.tmm.reluctance.map_range import network_map

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
