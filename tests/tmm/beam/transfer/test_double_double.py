"""Double-double arithmetic against mpmath."""

import mpmath as mp
import numpy as np
import pytest

from tactgen.tmm.beam.span import DoubleDouble

RANDOM = np.random.default_rng(1)
A, B = (RANDOM.normal(size=200) * 10.0 ** RANDOM.uniform(-9, 9, 200) for _ in range(2))
A, B = A + 1j * A[::-1], B - 0.5j * B[::-1]


def exact(pair, i):
    return mp.mpmathify(complex(pair.hi[i])) + mp.mpmathify(complex(pair.lo[i]))


@pytest.mark.parametrize(
    "operation",
    [
        lambda a, b, _: a * b,
        lambda a, b, _: a / b,
        lambda a, b, root: root(a * b),
        lambda a, b, _: (a * a - b * b) / (a + b),
        lambda a, b, _: 2.0 - a / b * 3.0,
    ],
    ids=["product", "quotient", "root", "mixed", "numbers on both sides"],
)
def test_thirty_digits(operation):
    """Products, quotients, roots and sums are right to 30 digits where nothing cancels."""
    got = operation(DoubleDouble(A), DoubleDouble(B), DoubleDouble.sqrt)
    with mp.workdps(60):
        for i in range(A.size):
            a, b = mp.mpmathify(complex(A[i])), mp.mpmathify(complex(B[i]))
            want = operation(a, b, mp.sqrt)
            # the mixed one cancels by no more than the three digits allowed here
            assert abs(exact(got, i) - want) < mp.mpf(10) ** -28 * abs(want)


def test_cancellation_keeps_the_rest():
    """1 − x y with x y next to 1 has its full relative accuracy, as at a beam's cut-off."""
    x = np.array([1.0 + 2.0**-30 + 0j])
    got = 1.0 - DoubleDouble(x) * (2.0 - x)
    assert exact(got, 0) == mp.mpf(2) ** -60
