"""The paper's matrix A: right when corrected, and each misprint convicted by its effect.

A is compared with the 60-digit matrix exponential of the beam's differential equations,
and carried to the tip of the loaded 20 mm actuator with the boundary conditions written
out here, so that nothing but the paper's own formulas is at work.
"""

import numpy as np
import pytest

from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.tmm.beam.printed_formulas import (
    FORMULAS,
    MISPRINTS,
    PLACES,
    from_dynamic_stiffness,
    matrix_a,
    printed_section,
)
from tactgen.tmm.beam.sections import section
from tactgen.tmm.beam.span import dynamic_stiffness
from tactgen.tmm.ports.loads import finger_impedance
from tactgen.validation.evidence.cases import exact_beam as reference

DEVICE = Device()
BEAM = section(Piece("bimorph", 20e-3), DEVICE, Beam(), lossy=True)
LENGTH = 20e-3
FREQUENCIES = np.array([10.0, 100.0, 250.0, 500.0, 1000.0])


def printed(equation, frequencies=FREQUENCIES):
    """Return A with one equation as printed, or several."""
    equations = frozenset({equation} if isinstance(equation, int) else equation)
    beam = printed_section(BEAM, DEVICE, equations)
    return matrix_a(beam, LENGTH, frequencies, equations)


def tip_velocity_and_current(a, frequencies=FREQUENCIES, voltage=50.0):
    """Solve paper eqs 6-12: M₁ = R32 ψ̇₁ and F₁ = R41 v₁ below, M₂ = 0 and F₂ = −Z v₂ above."""
    jw, support = 2j * np.pi * frequencies, Support()
    below = np.zeros((frequencies.size, 5, 3), dtype=complex)  # state per v₁, ψ̇₁, U
    below[:, 0, 0] = below[:, 1, 1] = below[:, 4, 2] = 1.0
    below[:, 2, 1] = (
        support.rotational_stiffness / jw
        + support.rotational_damping
        + jw * support.rotational_inertia
    )
    below[:, 3, 0] = support.lateral_stiffness / jw
    above = a @ below
    left_over = above[:, 2:4].copy()
    left_over[:, 1] += finger_impedance(frequencies)[:, None] * above[:, 0]
    motion = np.linalg.solve(left_over[:, :, :2], -left_over[:, :, 2:])[:, :, 0]
    state = np.concatenate([motion, np.ones((frequencies.size, 1))], axis=1) * voltage
    return np.einsum("nij,nj->ni", above, state)[:, [0, 4]].T


def effect(a):
    """Return the relative change (n,) of tip velocity and of current."""
    right = tip_velocity_and_current(matrix_a(BEAM, LENGTH, FREQUENCIES))
    return np.abs(tip_velocity_and_current(a) / right - 1.0)


@pytest.mark.parametrize("length", [5e-3, 14e-3, 20e-3, 40e-3])
@pytest.mark.parametrize("frequency", [30.0, 300.0, 1e3, 2e3, 1e4])
def test_corrected_matrix_is_the_matrix_exponential(length, frequency):
    """All 25 corrected entries equal the matrix exponential of the differential equations.

    1e-10 of each entry; A35 and A52 hold the difference C₅ − 1, which cancels like 1/λ⁴
    and sets the lower end of the range (30 Hz at 5 mm: 1e-11).
    """
    exact = reference.matrix_a(reference.constants(BEAM), length, frequency)
    got = matrix_a(BEAM, length, np.array([frequency]))[0]
    vanishing = np.abs(exact) < 1e-30  # U does not act on itself, nor v, ψ̇, M, F on U
    assert vanishing.sum() == 0 or not np.abs(got[vanishing]).any()
    assert (np.abs(got - exact)[~vanishing] <= 1e-10 * np.abs(exact[~vanishing])).all()


def test_stored_solutions_follow_from_a(state_space):
    """The corrected A gives the stored 60-digit tip velocity and current under the finger."""
    cases = [c for c in state_space["cases"] if c["load"] == "finger" and c["length"] == LENGTH]
    assert len(cases) == 4
    for case in cases:
        f = np.array([case["frequency"]])
        v, i = tip_velocity_and_current(matrix_a(BEAM, LENGTH, f), f, case["voltage"])
        # A cancels to 1e-12 at 10 Hz, the boundary system adds a digit
        assert v[0] == pytest.approx(complex(*case["v_tip"]), rel=1e-10)
        assert i[0] == pytest.approx(complex(*case["current"]), rel=1e-10)


def test_change_of_variables():
    """Matrix A and the dynamic stiffness are the same statement, both with all losses."""
    f = np.array([100.0, 1e3, 5e3])
    got = from_dynamic_stiffness(dynamic_stiffness(BEAM, LENGTH, 2 * np.pi * f), f)
    # the change of variables divides differences of D by Ω²: 3e-13 at 100 Hz
    np.testing.assert_allclose(got, matrix_a(BEAM, LENGTH, f), rtol=1e-11)


def invariants(a):
    """Return |det A4 − 1|, and how far A4 is from symplectic, over (n,) frequencies."""
    mechanical = a[:, :4, :4]
    det = np.abs(np.linalg.det(mechanical) - 1.0)
    j = np.zeros((4, 4))  # v goes with F, ψ̇ with M
    j[0, 3] = j[1, 2] = 1.0
    j[3, 0] = j[2, 1] = -1.0
    form = mechanical.transpose(0, 2, 1) @ j @ mechanical
    size = np.abs(mechanical).transpose(0, 2, 1) @ np.abs(j) @ np.abs(mechanical)
    return det, (np.abs(form - j) / size).max(axis=(1, 2))


def electrical_reciprocity(a):
    """Return how far the U column and the I row are from determining each other (n,).

    In a reciprocal A the row is the column turned by J A4: what a voltage does to the
    state is what the state does to the charge.
    """
    j = np.zeros((4, 4))
    j[0, 3] = j[1, 2] = 1.0
    j[3, 0] = j[2, 1] = -1.0
    from_column = a[:, :4, 4][:, None, :] @ j @ a[:, :4, :4]
    row = a[:, 4:, :4]
    size = np.abs(a[:, :4, 4])[:, None, :] @ np.abs(j) @ np.abs(a[:, :4, :4]) + np.abs(row)
    return (np.abs(from_column - row) / size).max(axis=(1, 2))


def test_corrected_matrix_is_lossless_in_form():
    """The corrected A4 has determinant one, is symplectic, and A is reciprocal."""
    a = matrix_a(BEAM, LENGTH, FREQUENCIES)
    det, symplectic = invariants(a)
    # a dozen products of entries, cancelling by up to λ⁴ at 10 Hz
    assert det.max() < 1e-12
    assert symplectic.max() < 1e-12
    assert electrical_reciprocity(a).max() < 1e-11


def test_all_misprints_are_known_here():
    """Every misprint that the module lists is convicted below."""
    assert set(MISPRINTS) == {24, 36, 39, 41, 47, 49, 55}


def test_every_equation_is_listed_once():
    """Eqs 6 to 55 each have their row; the entries of A stand where their names say."""
    assert [f.equation for f in FORMULAS] == list(range(6, 56))
    names = {f.equation: f.symbol for f in FORMULAS}
    assert all(names[eq] == f"A{i + 1}{j + 1}" for eq, (i, j) in PLACES.items())
    assert sorted(PLACES.values()) == [(i, j) for i in range(5) for j in range(5)]


def test_eq_24_extra_factor():
    """The extra C₃ in A14 breaks det A4 = 1 and takes away 5/6 of the beam's compliance."""
    a, right = printed(24), matrix_a(BEAM, LENGTH, FREQUENCIES)
    # C₃ → 1/6 as Ω → 0; its next term is of order β⁴/5040
    assert a[0, 0, 3] / right[0, 0, 3] == pytest.approx(1 / 6, rel=1e-3)
    velocity, _ = effect(a)
    assert velocity[0] == pytest.approx(0.0124, abs=5e-5)  # 1.2 % at 10 Hz
    assert velocity[-1] == pytest.approx(3.453, abs=5e-3)  # 345 % at 1 kHz
    assert invariants(a)[0].max() > 1.0


def test_eq_36_sign():
    """The minus sign in A45 makes A non-reciprocal and turns the piezo force round."""
    a, right = printed(36), matrix_a(BEAM, LENGTH, FREQUENCIES)
    np.testing.assert_array_equal(a[:, 3, 4], -right[:, 3, 4])
    assert electrical_reciprocity(a).max() > 0.1
    velocity, _ = effect(a)
    # the error is twice A45, inertial (∝ Ω²) against a static moment: 0.1 % at 10 Hz, 1 at 300 Hz
    assert velocity[1] / velocity[0] == pytest.approx(100.0, rel=0.02)
    assert velocity[1] == pytest.approx(0.109, abs=1e-3)
    assert velocity[-1] > 50.0


def test_eqs_39_and_41_denominators():
    """Exchanged denominators make σ and τ dimensionally wrong and the result useless."""
    # GA/EI is 3.4e6 m⁻²: σ comes out as many times too large, τ too small; nothing is left
    velocity, _ = effect(printed((39, 41)))
    assert velocity.min() > 0.99
    # σ alone does that; τ alone makes the rotary inertia vanish, which hardly matters
    assert effect(printed(39))[0].min() > 0.99
    assert effect(printed(41))[0].max() < 1e-2


def test_eq_47_signs():
    """(σ − τ)/2 outside the root is a small error that grows with frequency: easy to miss."""
    a = printed(47)
    velocity, _ = effect(a)
    assert velocity[0] < 1e-5  # invisible at 10 Hz
    assert velocity[-1] == pytest.approx(0.0337, abs=2e-4)  # 3.4 % at 1 kHz
    assert (np.diff(velocity) > 0.0).all()
    # the wave numbers are then wrong by τ, of first order in Ω²; the determinant tells
    assert invariants(a)[0][-1] > 1e-3


def test_eq_49_layer_distance():
    """h_s/s for h_s/2 makes the rotary inertia 2.36 times too large."""
    wrong = printed_section(BEAM, DEVICE, frozenset({49}))
    b, hp, hs = (getattr(DEVICE.bimorph, n) for n in ("width", "piezo_thickness", "shim_thickness"))
    extra = 2 / 3 * b * DEVICE.piezo.density * ((hp + hs) ** 3 - (hp + hs / 2) ** 3)
    assert wrong.rhoI - BEAM.rhoI == pytest.approx(extra)
    assert wrong.rhoI / BEAM.rhoI == pytest.approx(2.362, abs=5e-4)
    velocity, _ = effect(printed(49))
    # rotary inertia matters by (r/l)² λ² only, here 4e-4 at 1 kHz
    assert 1e-4 < velocity[-1] < 1e-3


def test_eq_55_sign():
    """ε(1 + j tan δ) with e^{+jΩt} is a capacitor that gives off power."""
    wrong = printed_section(BEAM, DEVICE, frozenset({55}))
    assert BEAM.C.imag < 0.0 < wrong.C.imag
    _, current = effect(printed(55))
    # twice tan δ of the current into ε^T, which exceeds the beam's capacitance by up to 5 %
    tangent = DEVICE.piezo.loss_tangent
    assert (np.abs(current / (2 * tangent) - 1.0) < 0.06).all()
    _, i = tip_velocity_and_current(printed(55))
    _, i_right = tip_velocity_and_current(matrix_a(BEAM, LENGTH, FREQUENCIES))
    # power taken from the source at 10 Hz, ½ U Re I
    assert i[0].real < 0.0 < i_right[0].real
