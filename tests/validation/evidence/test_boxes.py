"""Boxes with general supports and loads: patch tests, ties, what is not there."""

import numpy as np
import pytest

from tactgen.fem.piezo.system import Material
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.validation.evidence import boxes
from tactgen.validation.evidence.boxes import even, held, load, statics, together

STEEL = Material(isotropic_stiffness(200e9, 0.3), 7850.0)


def block(*conditions, intervals=2):
    axes = (even(1.0, intervals, 1), even(2.0, intervals, 1), even(3.0, intervals, 1))
    return boxes.block(axes, STEEL, *conditions)


ROLLERS = (held("x", x=0.0), held("y", y=0.0), held("z", z=0.0))


def test_uniform_tension_is_exact():
    """A pull of 1 MPa: strain σ/E along, −ν σ/E across, and the reaction is the load."""
    state = statics(block(*ROLLERS, load("z", 1e6, z=3.0)))
    assert state.mean("z", z=3.0) == pytest.approx(3.0 * 1e6 / 200e9, rel=1e-12)
    assert state.mean("x", x=1.0) == pytest.approx(-0.3 * 1e6 / 200e9, rel=1e-12)
    assert state.force("z", z=0.0) == pytest.approx(-1e6 * 2.0, rel=1e-12)


def test_a_tied_face_stays_plane():
    """A pull on part of a face that moves as one: the same everywhere on it, and the same sum."""
    box = block(*ROLLERS, together("z", z=3.0), load("z", 1e6, y=(0.0, 1.0), z=3.0))
    values = statics(box).values[:, :, -1, 2]
    assert np.ptp(values) == 0.0
    assert values[0, 0] == pytest.approx(0.5 * 3.0 * 1e6 / 200e9, rel=1e-12)  # half the face


def test_no_node_there_is_an_error():
    """A support that holds nothing is a mistake of the case."""
    with pytest.raises(ValueError, match="no node at"):
        statics(block(held("z", z=0.1)))
