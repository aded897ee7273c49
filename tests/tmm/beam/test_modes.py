"""Natural frequencies: right to the last digits, and none missed."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs, TipLoad
from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Support
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.beam.modes import _descent, bending_frequencies, natural_frequencies
from tactgen.tmm.beam.sections import Section, section
from tactgen.validation.evidence.cases.exact_beam import offset

CLAMPED = Ends()
UNHELD = Springs(0.0, 0.0)
PAPER_SUPPORT = Ends(Springs(3e6, 0.24, rotational_inertia=1e-12))
BEAM = section(Piece("bimorph", 20e-3), Device(), Beam(), lossy=False)
# angles are rounded to some 1e-15, of frequency some 1e-14
DIGITS = 1e-12


def modes(beam, length, ends, count, *, open_circuit=False):
    return bending_frequencies([(beam, length)], ends, count, open_circuit=open_circuit)


def test_stored_resonances(state_space):
    """Three modes of two lengths, on springs and clamped, short and open: 24 stored values."""
    for stored in state_space["lossless_resonances"]:
        ends = CLAMPED if stored["support"] == "clamped" else PAPER_SUPPORT
        got = modes(BEAM, stored["length"], ends, 3, open_circuit=stored["circuit"] == "open")
        np.testing.assert_allclose(got, stored["hertz"], rtol=DIGITS)


@pytest.mark.parametrize("length", [1e-4, 1e-3, 20e-3, 1.0, 10.0])
def test_free_free_counts_no_rigid_motion(length):
    """A free beam of any size has its two motions at 0 Hz left out, and no elastic one."""
    got = modes(BEAM, length, Ends(UNHELD), 2)
    # slender: (4.730², 7.853²)/2π √(EI/m)/l²; a short one is softer in shear
    classical = np.array([4.730040745, 7.853204624]) ** 2 / (2 * np.pi * length**2)
    classical *= np.sqrt(BEAM.EI.real / BEAM.m)
    if length >= 1.0:
        np.testing.assert_allclose(got, classical, rtol=1e-4)
    assert (got < classical).all()
    assert (got > 1e-3 * classical).all()


def test_simply_supported_closed_form():
    """Pinned at both ends every mode is a sine: both branches of Timoshenko's closed form."""
    beam, length = Section(EI=2e11 * 4 / 3, GA=3e10, m=32e3, rhoI=8e3 * 4 / 3), 10.0
    pinned = Ends(Springs(1e25, 0.0), TipLoad(stiffness=1e25))
    expected = [np.sqrt(beam.GA / beam.rhoI)]  # the section's rotation alone, n = 0
    for n in range(1, 13):
        k2 = (n * np.pi / length) ** 2
        b = beam.m * (beam.EI * k2 + beam.GA) + beam.rhoI * beam.GA * k2
        squares = np.roots([beam.m * beam.rhoI, -b, beam.EI * beam.GA * k2**2])
        expected.extend(np.sqrt(squares))
    expected = np.sort(expected)[:12] / (2 * np.pi)
    got = modes(beam, length, pinned, 12)
    np.testing.assert_allclose(got, expected, rtol=1e-11)  # springs 1e14 times the beam's


THIN = 1e-6
ROWS = {
    "taper, electrodes, tab and glue": {
        "width_profile": ((0, 2.1e-3), (20e-3, 1e-3)),
        "piezo_thickness_profile": (
            (0, 0.26e-3), (8e-3, 0.2e-3), (8e-3, 0.15e-3), (20e-3, 0.1e-3)
        ),
        "tab_length": 2e-3, "bare_above": 2e-3, "glue_thickness": 10e-6,
    },
    "ceramic that runs out": {"piezo_thickness_profile": ((0, 0.26e-3), (20e-3, THIN))},
    "foil as a tip": {
        "piezo_thickness_profile": ((0, 0.26e-3), (8e-3, 0.26e-3), (8e-3, THIN), (20e-3, THIN)),
        "shim_thickness_profile": ((0, 0.25e-3), (8e-3, 0.25e-3), (8e-3, THIN), (20e-3, THIN)),
    },
    "foil as a root": {
        "piezo_thickness_profile": ((0, THIN), (1e-3, THIN), (1e-3, 0.26e-3), (20e-3, 0.26e-3)),
        "shim_thickness_profile": ((0, THIN), (1e-3, THIN), (1e-3, 0.25e-3), (20e-3, 0.25e-3)),
    },
}  # fmt: skip


LOADED = replace(PAPER_SUPPORT, tip=TipLoad(mass=1e-4))


@pytest.mark.parametrize(
    ("case", "support", "ends", "open_circuit"),
    [
        # every other row on one end in one circuit, the rows between on the other end in the
        # other; the rest is heavy
        pytest.param(
            case, "clamped", ends, open_circuit,
            marks=[] if (ends is LOADED) is open_circuit is bool(n % 2) else [pytest.mark.heavy],
        )
        for n, case in enumerate(ROWS)
        for ends in (CLAMPED, LOADED)
        for open_circuit in (False, True)
    ]
    + [("taper, electrodes, tab and glue", "rod", CLAMPED, False)],
)  # fmt: skip
def test_rounding_bar_of_segmented_rows(case, support, ends, open_circuit):
    """Against 60 digits every frequency is inside its rounding error, small where rows are usual.

    Foils, 10⁷ times softer than what they hold, cost digits; the bar says how many.
    """
    device = Device(bimorph=Bimorph(**ROWS[case]))
    row = tmm.sections(device, Support(kind=support), Beam(), lossy=False, segments=2)
    got = natural_frequencies(row, ends, 3, open_circuit=open_circuit)
    shares = [
        abs(offset(row, ends, frequency, open_circuit=open_circuit)) / bar
        for frequency, bar in zip(got.frequencies, got.rounding, strict=True)
    ]
    assert max(shares) < 1.0
    if case.startswith("foil"):  # what is lost is no chance there: the bar is four times as much
        assert 0.1 < max(shares) < 0.4
    # the requirement on what is compared with a second model of 1e-11
    assert got.rounding.max() < (1e-9 if case.startswith("foil") else 1e-12)


def test_rounding_that_cannot_be_told_is_refused():
    """A free beam loses a digit with each decade of φ: at 10¹² none could be vouched for."""
    row = [(Section(EI=1.0, GA=1e-12, m=1.0, rhoI=1e-3), 1.0)]
    with pytest.raises(ArithmeticError, match="lost in rounding"):
        natural_frequencies(row, Ends(UNHELD), 3, open_circuit=False)


def test_an_angle_does_not_jump_where_rounding_leaves_the_lower_half_plane():
    """0 to π through the lower half plane, and a little beyond at either end."""
    angle = np.array([-1e-9, 0.0, 1e-9, 1.0, 3.0, np.pi - 1e-9, np.pi, np.pi + 1e-9])
    np.testing.assert_allclose(_descent(np.exp(-1j * angle)), angle, rtol=0, atol=1e-15)
