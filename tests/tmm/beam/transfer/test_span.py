"""The functions of a whole span: their sizes are true bounds, and extended precision is better."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device
from tactgen.tmm.beam.sections import Section, section
from tactgen.tmm.beam.span import ThroughSpan, extended_span, span

NAMES = tuple(ThroughSpan.__dataclass_fields__)[2:]
EPS = np.finfo(float).eps


def points(seed, n=4000, *, lossy=True):
    """Return random sections, lengths and frequencies over the whole range of use and beyond."""
    random = np.random.default_rng(seed)
    beam = section(Piece("bimorph", 20e-3), Device(), Beam(), lossy=lossy)
    shear, inertia = 10.0 ** random.uniform(-2, 2, n), 10.0 ** random.uniform(-2, 1, n)
    many = Section(np.full(n, beam.EI), beam.GA * shear, np.full(n, beam.m), beam.rhoI * inertia)
    return many, 10.0 ** random.uniform(-4, 1, n), 2 * np.pi * 10.0 ** random.uniform(-2, 6, n)


@pytest.mark.parametrize("lossy", [True, False])
def test_errors_are_as_estimated(lossy):
    """The rounding error of every function is below 4 ε times its roundings and its size."""
    inputs = points(2, lossy=lossy)
    values, sizes, roundings = span(*inputs, ThroughSpan)
    exact, _, _ = extended_span(*inputs, ThroughSpan)
    for name in NAMES:
        error = np.abs(getattr(exact, name) - getattr(values, name)).astype(float)
        size = getattr(sizes, name)
        # what leaves the range of doubles is lost
        assert (error <= 4 * EPS * roundings * size + 1e-290).all(), name
        assert (np.abs(getattr(values, name)) <= 2 * size + 1e-290).all(), name
