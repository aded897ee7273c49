"""The functions of a whole span: their sizes are true bounds, and extended precision is better."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device
from tactgen.tmm.beam.sections import Section, section
from tactgen.tmm.beam.span import EXTENDED_EPS, Span, ThroughSpan, extended_span, span

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


def test_transmissions_in_halves_and_whole():
    """The functions of the whole span are the stated sums of products of the halves'."""
    values, sizes, _ = extended_span(*points(3), ThroughSpan)
    pairs = (
        (values.through_force, values.beta4 * values.ss * values.odd, values.cc * values.even),
        (values.through_mixed, values.beta4 * values.x * values.odd, values.y * values.even),
        (values.through_moment, values.shear * values.ss * values.even, -values.cc * values.odd),
    )
    for whole, first, second in pairs:
        terms = np.abs(first) + np.abs(second)
        assert (np.abs(2 * whole - (first + second)) <= 200 * EXTENDED_EPS * terms).all()
    assert (sizes.cc > 0.0).all()


def test_minors_by_two_routes():
    """c₁c₂ S₁S₂ + β⁴ X² = E E' and Y² − g S₁S₂ c₁c₂ = O O': the determinants of both parts."""
    v, _, _ = extended_span(*points(4), Span)
    for left, right, terms in (
        (v.cc * v.ss + v.beta4 * v.x**2, v.even * v.even_free,
         np.abs(v.cc * v.ss) + np.abs(v.beta4 * v.x**2)),
        (v.y**2 - v.shear * v.ss * v.cc, v.odd * v.odd_free,
         np.abs(v.y**2) + np.abs(v.shear * v.ss * v.cc)),
    ):  # fmt: skip
        scale = terms + np.abs(right)
        assert (np.abs(left - right) <= 1000 * EXTENDED_EPS * scale).all()
