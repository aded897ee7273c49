"""The small system of modes against modes that are solved for on the mesh."""

import numpy as np
import pytest

from tactgen.fem.piezo.modal_reduction import modal_model
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.solid import assemble
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs, TipLoad
from tactgen.geometry.bimorph.bricks import BrickMeshing, bimorph_bricks
from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.geometry.store.values import from_bytes, to_bytes

COARSE = BrickMeshing((2, 2, 2), smallest=0.5)
COUNT = 4


def system(kind):
    device = Device(bimorph=Bimorph(length=12e-3))
    bricks = bimorph_bricks(device, COARSE)
    mesh = bricks if kind == "bricks" else bricks.corner_mesh()
    return assemble(device, mesh, lossy=False)


@pytest.fixture(scope="module", params=["bricks", "whole body"])
def solid(request):
    """A quarter in one class of motion, and a body taken whole, with all classes at once."""
    return system(request.param)


@pytest.fixture(scope="module")
def small(solid):
    return modal_model(solid, COUNT)


ENDS = {
    "clamped": Ends(),
    "clamped, heavy tip": Ends(None, TipLoad(mass=1e-4)),
    "the paper's springs": Ends(Springs(3e6, 0.24, 1e-4, 1e-12)),
    "heavy base": Ends(Springs(1e4, 0.01, 0.0, 1e-8), TipLoad(10.0, 0.1, 1e-6)),
    "stiff springs": Ends(Springs(1e8, 100.0), TipLoad(1e6, 0.0, 1e-7)),
}


@pytest.mark.parametrize("open_circuit", [False, True], ids=["short", "open"])
@pytest.mark.parametrize("ends", ENDS.values(), ids=ENDS)
def test_modes_are_those_of_the_mesh(solid, small, ends, open_circuit):
    """Frequencies to 1e-9, which the direct solution's rounding leaves, and classes."""
    direct = natural_modes(solid, ends, COUNT, open_circuit=open_circuit)
    found = small.modes(ends, COUNT, open_circuit=open_circuit)
    assert [m.kind for m in found] == [m.kind for m in direct]
    frequencies = np.array([[m.frequency for m in modes] for modes in (found, direct)])
    np.testing.assert_allclose(frequencies[0], frequencies[1], rtol=1e-9)


@pytest.mark.parametrize(
    "ends",
    [Ends(Springs(0.0, 1.0)), Ends(Springs(0.0, 0.0)), Ends(Springs(1e6, 0.0), TipLoad(50.0))],
    ids=["slides", "free", "hinged, sprung tip"],
)
def test_loose_bodies_leave_their_rigid_motions_out(solid, small, ends):
    """Where a spring is zero; the direct solution is then right to the rounding of K."""
    direct = natural_modes(solid, ends, COUNT)
    found = small.modes(ends, COUNT)
    for mine, other in zip(found, direct, strict=True):
        mass = solid.node_mass.sum() / 4.0
        rounding = solid.spurious_stiffness / (mass * (2.0 * np.pi * other.frequency) ** 2)
        assert mine.frequency == pytest.approx(other.frequency, rel=1e-9 + rounding)


def test_nothing_holds_a_mode_higher(small):
    """Every ends's modes lie below the highest, one by one."""
    highest = np.array([mode.frequency for mode in small.highest(COUNT)])
    for ends in ENDS.values():
        for circuit in (False, True):
            found = small.modes(ends, COUNT, open_circuit=circuit)
            assert (np.array([mode.frequency for mode in found]) <= highest * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("count", [1, 4])
def test_every_frequency_lies_above_that_of_the_mesh(solid, count):
    """However small the basis: potentials by themselves are no motion that it could have.

    With them in it a bimorph as wide as long had a fourth mode at three quarters of its frequency.
    """
    small = modal_model(solid, count)
    assert np.linalg.eigvalsh(small.stiffness[:-2, :-2]).min() > 0.0
    size = small.charge.size - 2
    for opened in (False, True):
        found = small.modes(Ends(), size, open_circuit=opened)
        assert len(found) == size
        known = natural_modes(solid, Ends(), 9, open_circuit=opened)
        for mine, other in zip(found, known, strict=False):
            assert mine.frequency > other.frequency * (1.0 - 1e-9)


def test_it_can_be_stored(small):
    """And says the same afterwards."""
    again = from_bytes(to_bytes(small))
    springs = ENDS["the paper's springs"]
    assert again.modes(springs, COUNT) == small.modes(springs, COUNT)
