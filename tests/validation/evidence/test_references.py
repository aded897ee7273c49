"""The references of the cases, computed once more from their own formulas.

Those are left out that a light row's solver meets to 1e-5 and closer: it shares nothing with them.
"""

import math

import mpmath as mp
import numpy as np
import pytest
from exact_laminate import Laminate, Layer, natural_frequency, static_state
from scipy.linalg import eigh
from scipy.special import ellipe, ellipk

from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.magnetisation import MU0, TEAM20
from tactgen.geometry.device.materials import EPS0
from tactgen.validation.evidence.cases import (
    beams,
    coils,
    elastic,
    iron,
    laminates,
    resonators,
)  # fmt: skip
from tactgen.validation.evidence.cases.ball import exact_flux_density
from tactgen.validation.evidence.cases.laminates import ply


def references(module, case):
    (found,) = [c for c in module.CASES if c.id == case]
    return [row.reference for row in found.rows]


def bimorph(thickness):
    ceramic = LIBRARY["PZT-5A"]
    t = ceramic.tensors(lossy=False)
    low, high = (Layer(thickness, ceramic.density, t.c, sign * t.e, t.eps) for sign in (1, -1))
    return Laminate((low, high), 20e-3)


def test_parabolic_height():
    """VM148: ∫ F x²/(E I) dx with I = b h³/12 (x/L)^(3/2), which is 8 F L³/(E b h³)."""
    exact = mp.quad(lambda x: 1000 * x**2 / (30e6 * 0.2 * 8 / 12 * (x / 4) ** 1.5), [0, 4])
    assert references(beams, "VM148") == [pytest.approx(float(exact), rel=1e-12)]


def test_shear_beam():
    """VM202: Blevins' formula with Cowper's factor; the third row is the misprint."""
    speed = math.sqrt(20 * 1.27 / (48 + 39 * 0.27) * 200e9 / (2 * 1.27) / 7860)
    first, second, printed = references(beams, "VM202")
    assert [first, second] == pytest.approx([speed / 120, 3 * speed / 120], rel=3e-5)
    assert printed != pytest.approx(3 * first, rel=5e-4)


def test_ideal_gap():
    """Pull k (g0 − g) balances most at g = 2/3 g0: I² = 8 k g0³ / (27 µ0 N² A)."""
    current, travel = references(iron, "SNAP")
    assert current**2 == pytest.approx(8 * 100 * 0.2e-3**3 / (27 * MU0 * 500**2 * 4e-6), rel=1e-8)
    assert travel == pytest.approx(0.2e-3 / 3)


@pytest.mark.parametrize(
    ("case", "thickness"),
    [
        pytest.param("CYL1", 0.385e-3, marks=pytest.mark.heavy),
        ("CYL2", 1.0e-3),
        pytest.param("CYL3", 2.5e-3, marks=pytest.mark.heavy),
    ],
)
def test_cylindrical_bending(case, thickness):
    """Frequencies by the state-space solution, thin and thick."""
    short, free = references(laminates, case)
    exact = bimorph(thickness)
    assert natural_frequency(exact, short) == pytest.approx(short, rel=1e-9)
    assert natural_frequency(exact, free, grounded=(False, False)) == pytest.approx(free, rel=1e-9)


def test_driven_cylindrical_bending():
    """The state at the lower face with a wave of 1 V on the upper one: [.., w, .., D] there."""
    low, _ = static_state(bimorph(2.5e-3), pressure=(0.0, 0.0), faces=(0.0, 1.0))
    assert [float(low[1]), float(low[5])] == pytest.approx(references(laminates, "CYL5"), rel=1e-12)


def test_pagano():
    """The middle of the laminate; Pagano printed 2.887 and 0.932."""
    found = []
    none, vacuum = np.zeros((3, 6)), np.eye(3)
    for slenderness in (4.0, 10.0, 20.0, 50.0):
        plies = [Layer(1 / 3, 1.0, ply(along).c, none, vacuum) for along in "zyz"]
        low, _ = static_state(Laminate(tuple(plies), slenderness), pressure=(0, 1), faces=(0, 0))
        half = Laminate((plies[0], Layer(1 / 6, 1.0, plies[1].c, none, vacuum)), slenderness)
        found.append(float(100 * (half.transfer(0) * low)[1]) / slenderness**4)
    assert found == pytest.approx(references(laminates, "PAG"), rel=1e-12)
    assert [round(v, 3) for v in found[:2]] == [2.887, 0.932]


def test_wedge():
    """Kirchhoff: with x = 2 sqrt(ω L² sqrt(ρA/EI)), J1(x) I2(x) + J2(x) I1(x) = 0."""
    for value in references(beams, "WEDGE"):
        x = mp.findroot(
            lambda x: mp.besselj(1, x) * mp.besseli(2, x) + mp.besselj(2, x) * mp.besseli(1, x),
            2 * mp.sqrt(value),
        )
        assert float(x**2 / 4) == pytest.approx(value, rel=1e-8)


def test_breadth():
    """(x w″)″ = λ² x w from the tip, where w and w′ are free, to w(1) = w′(1) = 0."""

    def at_root(square, first, second):
        series = [mp.mpf(first), mp.mpf(second), 0, 0]
        for n in range(4, 100):
            series.append(square * series[n - 4] / (n * (n - 1) ** 2 * (n - 2)))
        return mp.fsum(series), mp.fsum(n * a for n, a in enumerate(series))

    def determinant(value):
        (w0, slope0), (w1, slope1) = (at_root(value**2, *end) for end in ((1, 0), (0, 1)))
        return w0 * slope1 - w1 * slope0

    for value in references(beams, "BREADTH"):
        assert float(mp.findroot(determinant, value)) == pytest.approx(value, rel=2e-9)


def thin_plate(clamped, terms):
    """Return ω a² √(ρh/D) of a square plate, ν = 0.3: Ritz with Legendre's polynomials.

    All edges are free, or that at 0 is clamped: there the polynomials are multiplied by y².
    """
    points, weights = np.polynomial.legendre.leggauss(2 * terms)
    points, weights = 0.5 * (points + 1), 0.5 * weights
    rows = [np.polynomial.Legendre.basis(k, domain=[0, 1]) for k in range(terms)]
    x = [np.array([row.deriv(n)(points) for row in rows]) for n in range(3)]
    y = x
    if clamped:
        low, high = 2 * points * x[0] + points**2 * x[1], 2 * x[0] + 4 * points * x[1]
        y = [points**2 * x[0], low, high + points**2 * x[2]]

    def product(i, j, k, l):
        return np.kron((x[i] * weights) @ x[j].T, (y[k] * weights) @ y[l].T)

    stiffness = product(2, 2, 0, 0) + product(0, 0, 2, 2) + 1.4 * product(1, 1, 1, 1)
    stiffness += 0.3 * (product(2, 0, 0, 2) + product(0, 2, 2, 0))
    squares = eigh(stiffness, product(0, 0, 0, 0), eigvals_only=True)
    return np.sqrt(squares[0 if clamped else 3 :])


def test_free_thin_plate():
    """FV12, in hertz: the series has converged to six digits."""
    scale = math.sqrt(200e9 * 0.05**2 / (12 * 0.91 * 8000)) / (2 * math.pi * 100)
    assert references(elastic, "FV12") == pytest.approx(scale * thin_plate(False, 14)[:8], rel=4e-6)


def test_cantilevered_thin_plate():
    """FV16: where the clamp ends the series converges as a power, so they agree to 1e-4."""
    assert references(elastic, "FV16") == pytest.approx(thin_plate(True, 18)[:6], rel=1e-4)


def test_supported_plate():
    """P13H: a solid plate whose edges slide in themselves bends in antisymmetric Lamb waves.

    With a² = k² − ω²/c_l² and b² = k² − ω²/c_t²: (b² + k²)² tanh(a h/2) = 4 k² a b tanh(b h/2).
    """
    half, speed2 = 0.025, 200e9 / 2.6 / 8000  # of shear; that of pressure is 3.5 times as large
    for value, squares in zip(references(elastic, "P13H"), (2, 5, 8, 10, 13), strict=True):
        k2 = squares * (mp.pi / 10) ** 2

        def lamb(frequency, k2=k2):
            omega2 = (2 * mp.pi * frequency) ** 2
            a, b = mp.sqrt(k2 - omega2 / (3.5 * speed2)), mp.sqrt(k2 - omega2 / speed2)
            left = (b**2 + k2) ** 2 * mp.tanh(a * half)
            return left - 4 * k2 * a * b * mp.tanh(b * half)

        with mp.workdps(40):
            exact = mp.findroot(lamb, (value * (1 - 1e-4), value * (1 + 1e-4)))
        assert float(exact) == pytest.approx(value, rel=2e-8)


def test_bars():
    """IEEE 176: f_s or f_p is 1/(2 L √(ρ s)), the other follows from the coupling factor."""
    s11, s33, d31, d33, eps, rho, length = (
        16.4e-12,
        18.8e-12,
        -171e-12,
        374e-12,
        1700 * EPS0,
        7750,
        0.01,
    )
    series, parallel = references(resonators, "BAR31")
    k2 = d31**2 / (s11 * eps)
    assert series == pytest.approx(1 / (2 * length * math.sqrt(rho * s11)), rel=4e-6)  # six digits
    q = 0.5 * math.pi * parallel / series
    assert k2 / (1 - k2) == pytest.approx(-q / math.tan(q), rel=1e-4)
    series, parallel = references(resonators, "BAR33")
    k2 = d33**2 / (s33 * eps)
    stiffened = s33 * (1 - k2)
    assert parallel == pytest.approx(1 / (2 * length * math.sqrt(rho * stiffened)), rel=4e-6)
    q = 0.5 * math.pi * series / parallel
    assert k2 == pytest.approx(q / math.tan(q), rel=1e-4)


def test_admittance():
    """IEEE 176: a bar driven across its length."""
    s11, d31, eps, rho = 16.4e-12, -171e-12, 1700 * EPS0, 7750
    length, ratio = 10e-3, 4.0  # width over height
    k2 = d31**2 / (s11 * eps)
    for value, f in zip(references(resonators, "YBAR"), (100e3, 160e3), strict=True):
        q = math.pi * f * length * math.sqrt(rho * s11)
        c = eps * (1 - k2) * ratio * length * (1 + k2 / (1 - k2) * math.tan(q) / q)
        assert 2 * math.pi * f * c == pytest.approx(value, rel=1e-8)


def test_bent_strip():
    """Constants at constant strain turned into compliances: a bar that only its bending stresses.

    The manual's compliances have six digits, and its targets follow from them to five.
    """
    tensors = resonators.STRIP_MATERIAL.piezo
    strain = np.linalg.inv(
        np.block([[tensors.c, -tensors.e.T], [tensors.e, tensors.eps]])
    )  # of [stress, charge], with no charge: [strain, field]
    stretch, thin, field = strain[2, 2], strain[0, 2], strain[6, 2]
    h, l, slope = resonators.STRIP_HEIGHT, resonators.STRIP_LENGTH, resonators.STRIP_SLOPE
    along = stretch * slope * h * l
    across = 0.5 * slope * (thin * h**2 - stretch * l**2)
    potential = -0.5 * field * slope * h**2
    assert references(resonators, "VM231") == pytest.approx([along, across, potential], rel=5e-5)


def test_torsion():
    """Saint-Venant's series."""
    for ratio, value in zip((1, 2, 5), references(elastic, "TOR"), strict=True):
        terms = [math.tanh((2 * k + 1) * math.pi * ratio / 2) / (2 * k + 1) ** 5 for k in range(99)]
        exact = (1 - 192 / (math.pi**5 * ratio) * sum(terms)) / 3
        assert exact == pytest.approx(value, rel=4e-9)  # nine digits


def test_loops():
    """Maxwell: mutual inductance and force at 1 A; Grover prints 0.24878 uH."""
    functions = (coils.mutual_inductance, coils.mutual_inductance_slope)
    assert float(functions[0](0.20, 0.25, 0.10)) == pytest.approx(0.24878e-6, rel=4e-5)
    # the mean over the sections of 1 mm by Simpson's rule
    low, high, up = (np.array([-0.5e-3, 0.0, 0.5e-3]) + at for at in (0.20, 0.25, 0.10))
    a, b, d, zero = np.meshgrid(low, high, up, up - 0.10)
    shares = np.array([1.0, 4.0, 1.0]) / 6.0
    exact = [np.einsum("abcd,a,b,c,d", f(a, b, d - zero), *[shares] * 4) for f in functions]
    assert references(coils, "LOOPS") == pytest.approx(exact, rel=1e-10)


def test_saturated_ball():
    """SATBALL: the linear ball of the permeability that the steel has at that flux density."""
    for b in references(iron, "SATBALL"):
        permeability = float(b / (MU0 * TEAM20.field_strength(np.array(b))))
        assert b == pytest.approx(600e3 * exact_flux_density(permeability), rel=1e-12)


def test_driven_plate():
    """P13HD: its first mode alone is 16 q/(π² ρ h ω² 2 ζ); the others take 5e-5 in the middle."""
    omega = math.pi**2 * 2 * math.sqrt(200e9 * 0.05**2 / (12 * 0.91 * 8000)) / 100
    alone = 16 * 100 / (math.pi**2 * 8000 * 0.05 * omega**2 * 0.04)
    (value,) = references(elastic, "P13HD")
    assert value == pytest.approx(alone, rel=1e-4)
    assert value == pytest.approx(45.42e-3, rel=4e-4)  # as printed


def test_nagaoka():
    """Lorenz: the factor in complete elliptic integrals."""
    for ratio, value in zip((0.2, 0.5, 1.0, 2.0, 5.0), references(coils, "NAGAOKA"), strict=True):
        m = ratio**2 / (1 + ratio**2)
        k, e = ellipk(m), ellipe(m)
        exact = (
            4
            / (3 * math.pi * math.sqrt(1 - m))
            * ((1 - m) / m * k - (1 - 2 * m) / m * e - math.sqrt(m))
        )
        assert exact == pytest.approx(value, rel=1e-8)


def test_field_on_the_axis():
    """A current sheet: (cos α1 + cos α2)/2 of an endless one's field."""
    half, radius = 2.5 * 25.4e-3, 0.5 * 25.4e-3
    for value, z in zip(references(coils, "VM168"), (0.0, 0.1905), strict=True):
        cosines = sum(s / math.hypot(s, radius) for s in (half - z, half + z))
        assert MU0 * 115.5 / (4 * half) * cosines == pytest.approx(value, rel=1e-10)


def test_hollow_ball():
    """SHELL: Jackson's formula, which for large µr is 9/(2 µr (1 − a³/b³))."""
    mu, shares = 1000.0, (1.0 / 1.1) ** 3
    exact = 9 * mu / ((2 * mu + 1) * (mu + 2) - 2 * shares * (mu - 1) ** 2)
    assert references(iron, "SHELL") == [pytest.approx(exact, rel=1e-8)]


def test_spheroid():
    """SPHEROID: N = (1 − e²)/e³ (artanh e − e), to the digits given."""
    for ratio, said in zip((2.0, 4.0), references(iron, "SPHEROID"), strict=True):
        e = math.sqrt(1.0 - 1.0 / ratio**2)
        assert said == pytest.approx((1.0 - e**2) / e**3 * (math.atanh(e) - e), abs=1e-7)


def test_slot():
    """CARTER: σ = 2/π [atan(b/2g) − g/b ln(1 + (b/2g)²)]."""
    for ratio, said in zip((0.5, 1.0, 2.0, 5.0), references(iron, "CARTER"), strict=True):
        half = ratio / 2.0
        exact = 2.0 / math.pi * (math.atan(half) - math.log1p(half**2) / ratio)
        assert said == pytest.approx(exact, rel=1e-7)
