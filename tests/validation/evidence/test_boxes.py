"""Boxes with general supports and loads: patch tests, ties, what is not there."""

import numpy as np
import pytest

from tactgen.fem.piezo.system import Material
from tactgen.geometry.bimorph.bricks import Slab
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.validation.evidence.boxes import (
    Box,
    Held,
    Load,
    Together,
    Where,
    even,
    natural_frequencies,
    statics,
)

STEEL = Material(isotropic_stiffness(200e9, 0.3), 7850.0)


def block(*held, intervals=2, together=(), loads=()):
    axes = (even(1.0, intervals, 1), even(2.0, intervals, 1), even(3.0, intervals, 1))
    slab = Slab("steel", (0, intervals), (0, intervals))
    return Box(*axes, ((slab, STEEL),), held, together, loads)


ROLLERS = (Held(Where(x=0.0), ("x",)), Held(Where(y=0.0), ("y",)), Held(Where(z=0.0), ("z",)))


def test_uniform_tension_is_exact():
    """A pull of 1 MPa: strain σ/E along, −ν σ/E across, and the reaction is the load."""
    state = statics(block(*ROLLERS, loads=(Load(Where(z=3.0), "z", 1e6),)))
    assert state.mean(Where(z=3.0), "z") == pytest.approx(3.0 * 1e6 / 200e9, rel=1e-12)
    assert state.mean(Where(x=1.0), "x") == pytest.approx(-0.3 * 1e6 / 200e9, rel=1e-12)
    assert state.force(Where(z=0.0), "z") == pytest.approx(-1e6 * 2.0, rel=1e-12)


def test_a_tied_face_stays_plane():
    """A pull on part of a face that moves as one: the same everywhere on it, and the same sum."""
    load = Load(Where(y=(0.0, 1.0), z=3.0), "z", 1e6)
    box = block(*ROLLERS, together=(Together(Where(z=3.0), "z"),), loads=(load,))
    values = statics(box).values[:, :, -1, 2]
    assert np.ptp(values) == 0.0
    assert values[0, 0] == pytest.approx(0.5 * 3.0 * 1e6 / 200e9, rel=1e-12)  # half the face


@pytest.mark.parametrize("intervals", [2, 6])
def test_rigid_motions_cost_nothing(intervals):
    """Six motions of a free body at 0 Hz, small (dense) and large (Lanczos)."""
    found = natural_frequencies(block(intervals=intervals), 8, loose=0, near=10.0)
    elastic = found[6]
    assert (found[:6] < 1e-3 * elastic).all()
    assert elastic > 100.0


def test_no_node_there_is_an_error():
    """A support that holds nothing is a mistake of the case."""
    with pytest.raises(ValueError, match="no node at"):
        statics(block(Held(Where(z=0.1), ("z",))))
