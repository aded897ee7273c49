"""Magnetisation curves: the monotone cubic, its exact energy, its inverse, files."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from tactgen.geometry.device.magnetisation import MU0, TEAM20, MagnetisationCurve, linear
from tactgen.geometry.device.parameters import Steel
from tactgen.geometry.device.steel_table import magnetisation_curve, read_curve
from tactgen.geometry.errors import InputError

#: Rounding of a few operations.
ROUNDING = 1e-13


def _mirrored(values):
    return np.concatenate([-values[:0:-1], values])


def test_it_is_the_pchip_of_the_mirrored_table():
    """H, dH/dB and the energy are those of SciPy's monotone cubic through the odd table."""
    cubic = PchipInterpolator(_mirrored(TEAM20.flux_density), _mirrored(TEAM20.field))
    b = np.linspace(0.0, 2.3, 2001)[:-1]
    energy = cubic.antiderivative()
    for ours, theirs in (
        (TEAM20.field_strength(b), cubic(b)),
        (TEAM20.slope(b), cubic.derivative()(b)),
        (TEAM20.energy_density(b), energy(b) - energy(0.0)),
    ):
        assert ours == pytest.approx(theirs, rel=ROUNDING, abs=ROUNDING * theirs.max())


def test_points_are_met_and_vacuum_takes_over_above():
    """The curve passes through its table and rises by 1/µ0 beyond it."""
    assert TEAM20.field_strength(TEAM20.flux_density) == pytest.approx(TEAM20.field, rel=ROUNDING)
    b = np.array([2.3, 3.0, 50.0])
    expected = TEAM20.field[-1] + (b - 2.3) / MU0
    assert TEAM20.field_strength(b) == pytest.approx(expected, rel=ROUNDING)
    assert TEAM20.slope(b) == pytest.approx(1.0 / MU0, rel=ROUNDING)


def test_energies_are_the_integrals_of_the_same_curve():
    """Energy plus coenergy is HB; beyond the table, too, where H is a straight line."""
    b = np.array([1e-3, 1.0, 2.29, 2.5, 10.0])
    h = TEAM20.field_strength(b)
    both = TEAM20.energy_density(b) + TEAM20.coenergy_density(b)
    assert both == pytest.approx(h * b, rel=ROUNDING)
    beyond = np.diff(TEAM20.energy_density(b[3:]))[0]
    assert beyond == pytest.approx(0.5 * (h[3] + h[4]) * (b[4] - b[3]), rel=ROUNDING)


@given(st.floats(1e-12, 1e9))
def test_inverse(h):
    """B(H) undoes H(B) from far below the first point to far beyond the last."""
    assert TEAM20.field_strength(TEAM20.flux_density_at(np.array(h))) == pytest.approx(
        h, rel=ROUNDING
    )


def test_reluctivity_at_the_origin():
    """H/B tends to dH/dB at zero field, without dividing by zero."""
    b = np.array([0.0, 1e-300, 1e-9])
    assert TEAM20.reluctivity(b) == pytest.approx(TEAM20.slope(np.zeros(3)), rel=1e-6)
    b = np.array([0.004, 0.01, 1.0, 4.0])
    assert TEAM20.reluctivity(b) == pytest.approx(TEAM20.field_strength(b) / b, rel=ROUNDING)


@given(st.lists(st.tuples(st.floats(1e-3, 1.0), st.floats(1e-3, 1e6)), min_size=1, max_size=20))
def test_any_increasing_table_gives_an_increasing_curve(steps):
    """Between the points of any increasing table, H(B) never falls."""
    b, h = (np.concatenate([[0.0], np.cumsum(column)]) for column in zip(*steps, strict=True))
    curve = MagnetisationCurve(b, h)
    samples = np.linspace(0.0, 1.2 * b[-1], 400)
    assert np.diff(curve.field_strength(samples)).min() >= -1e-12 * h[-1]
    assert curve.slope(samples).min() >= -1e-9 * h[-1]
    assert curve.slope(np.zeros(1))[0] > 0.0


def test_linear():
    """B = µ0 µr H at all fields, energy B²/(2µ)."""
    curve = linear(500.0)
    b = np.array([0.0, 1e-9, 0.7, 40.0])
    assert curve.field_strength(b) == pytest.approx(b / (500.0 * MU0), rel=ROUNDING)
    assert curve.energy_density(b) == pytest.approx(b**2 / (1000.0 * MU0), rel=ROUNDING)
    for none in (0.5, np.inf, np.nan):
        with pytest.raises(InputError, match="at least 1"):
            linear(none)


def test_a_file_gives_the_curve_it_holds(tmp_path):
    """A written table comes back; comments and further columns do no harm."""
    path = tmp_path / "steel.csv"
    rows = "\n".join(
        f"{i},{float(b)!r},{float(h)!r}"
        for i, (b, h) in enumerate(zip(TEAM20.flux_density, TEAM20.field, strict=True))
    )
    path.write_text(f"# measured\nno,B (T),H (A/m)\n{rows}\n")
    curve = magnetisation_curve(Steel(curve=str(path)))
    b = np.linspace(0.0, 3.0, 100)
    assert np.array_equal(curve.field_strength(b), TEAM20.field_strength(b))
    assert curve.name == "steel.csv"


def test_columns_are_converted(tmp_path):
    """In the units of the table's header and in any order."""
    path = tmp_path / "old.csv"
    path.write_text("H (A/cm), B (mT)\n0, 0\n2, 1000\n80, 1700\n")
    curve = read_curve(path)
    assert curve.flux_density == pytest.approx([0.0, 1.0, 1.7])
    assert curve.field == pytest.approx([0.0, 200.0, 8000.0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("B (A),H (A/m)\n0,0\n1,100\n", "which is not that of a flux density"),
        ("B (T),H (A/m)\n0,0\n", "at least 2"),
        ("B (T),H (A/m)\n0.1,20\n1,100\n", "start the curve at 0, 0"),
        ("B (T),H (A/m)\n0,0\n1,100\n0.5,200\n", "line 4 has B = 0.5 T after 1 T"),
        ("B (T),H (A/m)\n0,0\n1e-7,1\n", "less than vacuum's mu0"),
        ('B (T),H (A/m)\n0,0\n1,"80\n0"\n2,1e6\n', "line 3 is not CSV"),
        ("B (T),H (A/m)\n0,0\n1,100\n1.5,100.00000001\n", "line 4 has B = 1.5 T at H = 100 A/m"),
        ("B (T),H (A/m)\n0,0\n1e308,1e308\n", "check the unit of B"),
    ],
)
def test_bad_files_are_refused_in_one_sentence(tmp_path, text, words):
    """The message names the file or the line, what is wrong, and the remedy."""
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_curve(path)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("rows", "early"),
    [
        ("0,0\n0.6,300\n1.2,800\n", True),  # 0.6 T in 500 A/m: a permeability of 950 at the end
        ("0,0\n1.2,800\n2.2,90000\n2.25,117000\n", False),  # 1.5 of vacuum's at the end
    ],
)
def test_a_table_that_ends_before_saturation_is_known(tmp_path, rows, early):
    """What follows a table is vacuum's slope: too soon if the table still rises twice as fast."""
    path = tmp_path / "steel.csv"
    path.write_text(f"B (T),H (A/m)\n{rows}")
    assert read_curve(path).ends_early is early
    assert not TEAM20.ends_early
    assert not linear(1000.0).ends_early  # straight for ever, by definition
