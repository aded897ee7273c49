"""The paper's matrix A, corrected: the matrix exponential of the beam's differential equations.

What each misprint does to it is tested with the audit (tests/validation/evidence/test_audit.py).
"""

import mpmath as mp
import numpy as np
import pytest

from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device
from tactgen.tmm.beam.printed_formulas import from_dynamic_stiffness, matrix_a
from tactgen.tmm.beam.sections import section
from tactgen.tmm.beam.span import dynamic_stiffness
from tactgen.validation.evidence.cases import exact_beam as reference

DEVICE = Device()
BEAM = section(Piece("bimorph", 20e-3), DEVICE, Beam(), lossy=True)
LENGTH = 20e-3


def exact_matrix(beam, length, frequency):
    """Paper's A (5, 5): [v, ψ̇, M, F, U] below to [v, ψ̇, M, F, I] above."""
    with mp.workdps(reference.DIGITS):
        omega = 2 * mp.pi * mp.mpf(frequency)
        jw = mp.j * omega
        rates = (jw, jw, 1, 1, jw)  # displacements to velocities, charge to current
        states = (jw, jw, 1, 1, 1)
        t, at = reference.transfer(beam, length, omega), (0, 1, 2, 3, 5)
        return np.array([
            [complex(rates[i] * t[i, at[j]] / states[j]) for j in range(5)] for i in range(5)
        ])  # fmt: skip


@pytest.mark.parametrize("length", [5e-3, 20e-3, 40e-3])
@pytest.mark.parametrize("frequency", [30.0, 1e3, 1e4])
def test_corrected_matrix_is_the_matrix_exponential(length, frequency):
    """All 25 corrected entries equal the matrix exponential of the differential equations.

    1e-10 of each entry; A35 and A52 hold the difference C₅ − 1, which cancels like 1/λ⁴
    and sets the lower end of the range (30 Hz at 5 mm: 1e-11).
    """
    exact = exact_matrix(reference.constants(BEAM), length, frequency)
    got = matrix_a(BEAM, length, np.array([frequency]))[0]
    vanishing = np.abs(exact) < 1e-30  # U does not act on itself, nor v, ψ̇, M, F on U
    assert vanishing.sum() == 0 or not np.abs(got[vanishing]).any()
    assert (np.abs(got - exact)[~vanishing] <= 1e-10 * np.abs(exact[~vanishing])).all()


def test_change_of_variables():
    """Matrix A and the dynamic stiffness are the same statement, both with all losses."""
    f = np.array([100.0, 1e3, 5e3])
    got = from_dynamic_stiffness(dynamic_stiffness(BEAM, LENGTH, 2 * np.pi * f), f)
    # the change of variables divides differences of D by Ω²: 3e-13 at 100 Hz
    np.testing.assert_allclose(got, matrix_a(BEAM, LENGTH, f), rtol=1e-11)
