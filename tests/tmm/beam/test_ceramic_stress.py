"""Stress, field and current of the driven ceramic, against closed forms and reactions."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends, TipLoad
from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Support
from tactgen.tmm.beam import ceramic_stress as ceramic
from tactgen.tmm.beam.sections import section
from tactgen.tmm.beam.span import wavenumbers
from tactgen.tmm.beam.transfer_matrix import multiport
from tactgen.tmm.ports.excitation_and_circuit import UNIT_VOLTAGE, Excitation, excited
from tactgen.tmm.ports.multiport import in_series, respond
from tactgen.tmm.ports.supports_and_loads import attach, load_tip, tip_matrix

DEVICE, BEAM = Device(), Beam()
FREQUENCIES = np.array([1.0, 300.0, 1044.0, 7000.0])


def driven(ends, frequencies=FREQUENCIES, device=DEVICE):
    port = multiport(device, Support(), BEAM, frequencies)
    if device.bimorph.wiring == "series":
        port = in_series(port)
    response = respond(attach(port, ends), {"voltage": 1.0})
    return ceramic.driven_ceramic(device, BEAM, ends, frequencies, response, UNIT_VOLTAGE)


def test_a_bimorph_at_rest_has_the_stress_of_its_layers():
    """Free, ψ' = K U/EI and σ = Y (x ψ' − d31 U/h) at the faces of the layer; under a force, in
    short circuit, σ = Y x F L/EI at the outer face."""
    b, cross = DEVICE.bimorph, section(Piece("bimorph", 20e-3), DEVICE, BEAM, lossy=True)
    modulus = (1.0 + 1j / DEVICE.piezo.quality_factor) / DEVICE.piezo.s11
    free = cross.K / (modulus * b.width * (b.shim_thickness + b.piezo_thickness))
    faces = np.array([0.5 * b.thickness, 0.5 * b.shim_thickness])
    expected = np.abs(modulus * (faces * cross.K / cross.EI - free / b.piezo_thickness)).max()
    # at 0.01 Hz inertia is 1e-9 of it
    at, pushed = np.array([0.01]), Excitation(force=0.1)
    assert driven(Ends(), at).stress[0] == pytest.approx(expected, rel=1e-8)
    moved = excited(multiport(DEVICE, Support(kind="clamped"), BEAM, at), Ends(), pushed)
    found = ceramic.driven_ceramic(DEVICE, BEAM, Ends(), at, moved, pushed).stress[0]
    expected = np.abs(modulus * 0.5 * b.thickness * pushed.force * b.length / cross.EI)
    assert found == pytest.approx(expected, rel=1e-8)


def assert_root_moment(device, tip, at, **within):
    """The moment at the root, found from the tip alone, is the reaction of what holds the base."""
    port = multiport(device, Support(kind="clamped"), BEAM, at)
    response = respond(load_tip(port, tip), {"w_base": 0.0, "psi_base": 0.0, "voltage": 1.0})
    moved = np.stack([response.motion["w_tip"], response.motion["psi_tip"]], axis=1)
    effort = -(tip_matrix(tip, at) @ moved[:, :, None])[:, :, 0]
    found = ceramic._below(port.stiffness, moved, effort, port.stiffness[..., 4])[1][:, 1]
    np.testing.assert_allclose(found, -response.effort["psi_base"], **within)


@pytest.mark.parametrize(
    "tip", [TipLoad(500.0, 0.5), TipLoad(mass=1e-5, offset=2e-3, inertia=3e-12)]
)
def test_the_moment_at_the_root_is_the_clamp_s(tip):
    # at 1 Hz the moment is what is left of K U, 1e-6 N m, to its rounding
    assert_root_moment(DEVICE, tip, FREQUENCIES, rtol=1e-9, atol=1e-19)


def test_series_wiring_halves_field_and_stress():
    """Each layer takes half the voltage; the current is a quarter's."""
    series = DEVICE.model_copy(update={"bimorph": Bimorph(wiring="series")})
    one, half = driven(Ends()), driven(Ends(), device=series)
    np.testing.assert_allclose(half.stress, 0.5 * one.stress, rtol=1e-9)
    np.testing.assert_allclose(half.current, 0.25 * one.current, rtol=1e-9)
    assert half.field == pytest.approx(0.5 * one.field)


def other(**keys):
    return DEVICE.model_copy(update={"bimorph": Bimorph(**keys)})


@pytest.mark.parametrize(
    ("same", "relative"),
    [
        # the same bimorph in other words
        ({"width_profile": ((0.0, 2.1e-3), (20e-3, 2.1e-3))}, 1e-9),
        ({"layers": "piezo 0.26 mm -x; CFRP 0.25 mm; piezo 0.26 mm -x"}, 1e-9),
        # a hair more of it
        ({"tip_extension": 1e-9}, 1e-5),
        ({"bare_above": 1e-9}, 1e-5),
    ],
)
def test_the_same_ceramic_in_other_words_has_the_same_stress(same, relative):
    """Tapers, listed layers, a tip extension and bare ends are values of one row."""
    np.testing.assert_allclose(
        driven(Ends(), device=other(**same)).stress, driven(Ends()).stress, rtol=relative
    )


@pytest.mark.parametrize("waist", [5e-3, 0.5e-3])
def test_the_upper_end_of_a_patch_counts(waist, monkeypatch):
    """Of a force at the tip at rest, also where a waist strains it most: more heights find no more.

    But for the moment between two heights, which is 1 % of that at the root.
    """
    device = other(
        layers="PZT-5A 0.2 mm to 10 mm +x; brass 0.3 mm; PZT-5A 0.2 mm from 12 mm -x",
        width_profile=((0.0, 5e-3), (10e-3, waist), (20e-3, 5e-3)),
    )

    def largest():
        force, nothing = np.array([[0.1, 0.0]], complex), np.zeros((1, 2), complex)
        return ceramic._stress(
            device, BEAM, np.array([1e-3]), nothing, force, np.zeros(1, complex), 0.0
        )

    found = largest()
    monkeypatch.setattr(ceramic, "_HEIGHTS", 160)
    assert found == pytest.approx(largest(), rel=0.01)


def test_a_taper_has_its_force_s_moment_over_its_section():
    """A wedge in plan under a force at its tip at rest: F z / W is the same at all heights."""
    device = other(width_profile=((0.0, 4e-3), (20e-3, 1e-6)), poling="+x")
    root = section(Piece("bimorph", 20e-3), other(width=4e-3), BEAM, lossy=True)
    row = ceramic._down_to_the_ceramic(device, BEAM)
    force, stress = 1e-3, []
    motion, on_top = np.zeros((1, 2), complex), np.array([[force, 0.0]], complex)
    for part in row:
        for element, length in part.beams[::-1]:
            matrix = ceramic.element_stiffness(element, length, np.zeros(1))
            motion, on_top = ceramic._below(matrix, motion, on_top, np.zeros((1, 5)))
        (per_curvature, _) = part.stresses[-1]
        stress.append(abs(on_top[0, 1] / part.section.EI * per_curvature))
    expected = force * 20e-3 * abs(row[0].stresses[-1][0] / root.EI)
    # the micron at the tip is 0.5 % of the width of the highest slice
    np.testing.assert_allclose(stress[1:], expected, rtol=6e-3)


def test_stress_is_unknown_where_waves_die_out_along_the_ceramic():
    """A bimorph of 237 mm at 20 kHz: no guess, and no failure; at 100 Hz it is known.

    Just below the limit the moment at the root, from the tip alone, is the clamp's reaction.
    """
    long = Device(bimorph=Bimorph(length=237e-3))
    found = driven(Ends(), np.array([100.0, 20e3]), long).stress
    assert found[0] > 0.0
    assert np.isnan(found[1])
    cross = section(Piece("bimorph", 237e-3), long, BEAM, lossy=True)
    grid = np.geomspace(10.0, 20e3, 400)
    decay = wavenumbers(cross, 237e-3, 2.0 * np.pi * grid)[1]
    at = grid[decay < ceramic._DECAY][-1:]
    assert_root_moment(long, TipLoad(), at, rtol=1e-6)  # e^20 of rounding


def test_a_moving_base_strains_as_seen_from_outside():
    """Motions relative to the base and absolute ones, with a mass on an arm."""
    tip = TipLoad(mass=1e-5, offset=2e-3, inertia=3e-12)
    moved, ends = Excitation(acceleration=2.0), Ends(tip=tip)
    at = np.array([1e-3, 1.0, *FREQUENCIES[1:]])
    port = multiport(DEVICE, Support(kind="clamped"), BEAM, at)
    found = ceramic.driven_ceramic(DEVICE, BEAM, ends, at, excited(port, ends, moved), moved)
    base = -2.0 / (2.0 * np.pi * at) ** 2
    absolute = respond(load_tip(port, tip), {"w_base": base, "psi_base": 0.0, "voltage": 0.0})
    right = ceramic.driven_ceramic(DEVICE, BEAM, ends, at, absolute, Excitation())
    # slower, the base moves 1e5 times as far as the tip bends, and digits of that are lost
    np.testing.assert_allclose(found.stress[2:], right.stress[2:], rtol=1e-7)
    # the square of 1 Hz over the first resonance
    assert found.stress[0] == pytest.approx(found.stress[1], rel=3e-6)
