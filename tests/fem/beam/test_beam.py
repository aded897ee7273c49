"""Beam elements against the independent transfer-matrix model."""

import numpy as np
import pytest

from tactgen.fem import beam
from tactgen.fem.beam import row_mesh
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.bimorph.segments import beam_pieces
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Load, Support
from tactgen.tmm.beam import modes, transfer_matrix
from tactgen.tmm.ports.supports_and_loads import ends_of

FREQUENCIES = np.array([0.0, 10.0, 445.0, 1000.0, 5000.0, 20000.0])


@pytest.mark.parametrize("open_circuit", [False, True])
@pytest.mark.parametrize("kind", ["spring", "clamped", "free"])
def test_modes_equal_the_counted_ones(kind, open_circuit):
    """Matrix eigenvalues and Wittrick-Williams counting find the same modes.

    A free beam's rigid motions at 0 Hz are left out, not returned as modes.
    """
    free = kind == "free"
    support = Support() if free else Support(kind=kind)
    ends = Ends(Springs(0.0, 0.0)) if free else ends_of(support, Load(kind="none"))
    matrices = beam.assemble(Device(), support, Beam(), elements=16, lossy=False)
    found = beam.bending_frequencies(matrices, ends, 4, open_circuit=open_circuit)
    pieces = transfer_matrix.sections(Device(), support, Beam(), lossy=False)
    exact = modes.bending_frequencies(pieces, ends, 4, open_circuit=open_circuit)
    # fourth mode: 1e-9 from the mesh; first: rounding of the eigenvalue solver
    assert found == pytest.approx(exact, rel=1e-8)


def test_resolution_follows_the_highest_frequency():
    """More waves on the beam mean more elements, always an even number."""
    low, high = (beam.elements_for(Device(), f) for f in (1e3, 1e6))
    assert low < high
    assert low % 2 == high % 2 == 0


def test_a_halved_mesh_differs_in_every_piece():
    """Also in a tab so short that it has one element whatever their number."""
    bimorph = Bimorph(tab_length=0.1e-3)
    device = Device(bimorph=bimorph)
    pieces = beam_pieces(device, Support(kind="clamped"))
    counts = [np.bincount(row_mesh(pieces, device, 4, halvings)[1]) for halvings in (0, 2)]
    assert counts[0].min() == 1
    assert (counts[1] == 4 * counts[0]).all()


@pytest.mark.parametrize("length", [2e-3, 200e-3])
def test_other_units_change_nothing_but_rounding(length):
    """The same ports and modes, and not to the last digit: what differs shows rounding.

    The longer, the more: bending gets softer than shear, with the length squared.
    """
    bimorph = Device().bimorph.model_copy(update={"length": length})
    device, support = Device().model_copy(update={"bimorph": bimorph}), Support(kind="spring")
    ends = ends_of(support, Load(kind="mass", mass=1e-6))

    def answers(unit):
        of = beam.assemble(device, support, Beam(), elements=8, lossy=False, unit=unit)
        found = beam.bending_frequencies(of, ends, 2, open_circuit=True)
        return np.append(found, beam.condense(of, FREQUENCIES).stiffness[:, 0, 0])

    moved = np.abs(answers(1.7) / answers(1.0) - 1.0).max()
    eps, slenderness = np.finfo(float).eps, length / bimorph.shim_thickness
    assert eps < moved < 100.0 * eps * (10.0 + slenderness**2)


@pytest.mark.parametrize("unit", [1.1, 1.9])
def test_in_other_units_every_sum_is_rounded_anew(unit):
    """A turn of a foil strains nothing: what force is left is rounding, in each unit its own.

    Matrices that were only scaled once they were summed would keep that of the sums (0.97 of it).
    """
    foil = Bimorph(length=60e-3, piezo_thickness=11e-6, shim_thickness=63e-6)

    def left(unit):
        found = beam.assemble(
            Device(bimorph=foil), Support(), Beam(), elements=8, lossy=False, unit=unit
        )
        turn = np.zeros(found.mass.shape[0], np.longdouble)
        for height, w, psi in found.stations:
            turn[[w, psi]] = height, -1.0
        force = np.asarray(found.stiffness.real @ turn, dtype=float)
        return force / np.linalg.norm(force)

    assert abs(left(unit) @ left(1.0)) < 0.5
