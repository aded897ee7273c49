"""What bricks lack, by their residual alone, against bricks of one degree more that are solved."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.fem.piezo.brick_error import BrickEstimator
from tactgen.fem.piezo.bricks import assemble_bricks, brick_matrices
from tactgen.fem.piezo.krylov import reduce_to_ports
from tactgen.fem.piezo.modal_reduction import modal_model
from tactgen.fem.piezo.modes import eigenpairs, natural_modes
from tactgen.fem.piezo.ports import static_multiport, static_multiports
from tactgen.fem.piezo.system import materials
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs, TipLoad
from tactgen.geometry.bimorph.bricks import BrickMeshing, bimorph_bricks
from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.tmm.ports.multiport import respond
from tactgen.tmm.ports.supports_and_loads import attach

DEVICE = Device(bimorph=Bimorph(length=9e-3, tab_length=1e-3))
MESHING = BrickMeshing((2, 2, 3), smallest=0.5, tip=1.0, longest=8.0, richness=1.5)
BRICKS = bimorph_bricks(DEVICE, MESHING)
RICHER = bimorph_bricks(DEVICE, replace(MESHING, degree=(3, 3, 4)))
ENDS = {
    "clamped": Ends(),
    "heavy tip": Ends(None, TipLoad(mass=1e-5)),
    "sprung tip": Ends(None, TipLoad(3e3)),
    "springs": Ends(Springs(3e6, 0.24, 1e-4, 1e-12)),
}


@pytest.fixture(scope="module")
def surplus():
    return BrickEstimator(DEVICE, BRICKS)


@pytest.fixture(scope="module")
def both():
    """The solid on the bricks, and on those of one degree more."""
    own, richer = (assemble_bricks(DEVICE, b, lossy=False) for b in (BRICKS, RICHER))
    return own, richer


def test_rows_that_are_tested_are_those_of_the_whole_matrix():
    known = materials(DEVICE, RICHER.regions, DEVICE.piezo.ceramic(), lossy=False)
    tested = RICHER.products() & (np.arange(RICHER.shape[2]) % 3 == 1)
    rows = np.repeat(tested.ravel(), 4)
    for some, every in zip(
        brick_matrices(RICHER, known, 1.0, tested), brick_matrices(RICHER, known, 1.0), strict=True
    ):
        # alike to the last digits: a processor may sum fewer rows in another order
        assert abs(some[rows] - every[rows]).max() <= 1e-14 * abs(every).max()
        assert some[~rows].nnz == 0 < some.nnz


def test_what_is_missing_at_rest_is_most_of_what_one_degree_more_finds(surplus, both):
    """Compliance, motion per volt, capacitances; on all of D symmetric as D is."""
    own, richer = both
    fine, *judges = static_multiports(own, surplus.of("bending_x"))
    assert (fine.stiffness == static_multiport(own).stiffness).all()
    known = static_multiport(richer)

    def sizes(port):
        d = port.stiffness[0].real[2:, 2:]
        compliance = np.linalg.inv(d[:2, :2])
        moved = compliance @ d[:2, 2]
        return np.array([*compliance[np.triu_indices(2)], *moved, d[2, 2]])

    share = sum(sizes(judge) - sizes(fine) for judge in judges) / (sizes(known) - sizes(fine))
    assert (share > 0.3).all()
    assert (share < 1.2).all()
    for judge in judges:
        d = judge.stiffness[0].real
        size = np.sqrt(np.abs(np.outer(np.diag(d), np.diag(d))))
        assert (np.abs(d[:4, :4] - d[:4, :4].T) / size[:4, :4]).max() < 1e-8
        assert (np.abs(d[4, :4] + d[:4, 4]) / size[4, :4]).max() < 1e-8


@pytest.mark.parametrize("open_circuit", [False, True], ids=["short", "open"])
@pytest.mark.parametrize("ends", ENDS.values(), ids=ENDS)
def test_what_modes_miss_is_most_of_what_one_degree_more_finds(surplus, both, ends, open_circuit):
    own, richer = both
    small = modal_model(own, 2, surplus.of("bending_x"))

    def squares(modes):
        return np.array([m.frequency for m in modes]) ** 2

    plain = squares(small.modes(ends, 2, open_circuit=open_circuit))
    moved, charged = (
        plain - squares(replace(small, missing=m).modes(ends, 2, open_circuit=open_circuit))
        for m in small.surplus
    )
    assert (charged >= 0.0).all()
    known = squares(natural_modes(richer, ends, 2, open_circuit=open_circuit))
    share = (moved - charged) / (plain - known)
    assert (share > 0.3).all()
    assert (share < 1.2).all()


@pytest.mark.parametrize("ends", ENDS.values(), ids=ENDS)
def test_what_an_open_circuit_misses_is_bounded_by_what_its_factors_miss(surplus, both, ends):
    """Of (f_open / f_short)²: the change is what each circuit's own says, the bound no less."""
    own, richer = both
    small = modal_model(own, 1, surplus.of("bending_x"))

    def ratio(modes):
        short, opened = (modes(ends, 1, open_circuit=circuit)[0] for circuit in (False, True))
        return (opened.frequency / short.frequency) ** 2

    plain = ratio(small.modes)
    # the modes' judges move by potentials as they do by displacements
    moved, charged = (ratio(replace(small, missing=m).modes) for m in small.surplus)
    change, most = small.opened(ends)
    assert change == pytest.approx((moved - charged) / plain, abs=2e-2 * most)
    known = ratio(lambda *a, **k: natural_modes(richer, *a, **k)) / plain - 1.0
    assert abs(change) < most
    assert 0.05 * most < abs(known) < most


@pytest.mark.parametrize("motion", ["bending_y", "torsion", "axial"])
def test_other_classes_of_motion_miss_as_much(surplus, both, motion):
    own, richer = (system.related(motion) for system in both)
    (value,), (vector,) = eigenpairs(own, Ends(), 1)
    lacking = surplus.of(motion)
    stiffness, mass = lacking.residuals(np.append(vector, np.zeros(3))[:, None])
    moved, charged = lacking.products(stiffness - value * mass)
    assert charged[0, 0] >= 0.0
    missing = (moved - charged)[0, 0]
    known = eigenpairs(richer, Ends(), 1)[0][0]
    assert 0.3 * (value - known) < missing < 1.2 * (value - known)


def test_losses_hardly_change_what_responses_miss(surplus):
    """Displacement and potential apart: each differs by about the loss angle from the lossless.

    Below and between resonances, of the tip and of the charge.
    """
    at = np.array([10.0, 3e3, 1e4])
    missed = []
    for lossy in (False, True):
        solid = assemble_bricks(DEVICE, BRICKS, lossy=lossy)
        lacking = BrickEstimator(DEVICE, BRICKS, lossy=lossy).of("bending_x")
        reduced = reduce_to_ports(solid, at, surplus=lacking)
        plain, *judges = (
            respond(attach(port, Ends()), {"voltage": 1.0})
            for port in (reduced.multiport(at), *reduced.richer_multiports(at))
        )
        for judge in judges:
            for name, of in (("w_tip", "motion"), ("voltage", "effort")):
                was, now = (getattr(response, of)[name] for response in (plain, judge))
                missed.append(now / was - 1.0)
    lossless, with_losses = np.split(np.array(missed), 2)
    # 3 % of the permittivity and 1/60 of the stiffness, several of which meet in a coupled answer
    assert (np.abs(with_losses / lossless - 1.0) < 0.25).all()


def test_a_reduced_solid_misses_at_rest_what_the_whole_does(surplus, both):
    """Displacement and potential apart; the states are those of the solid, without losses."""
    lacking, at = surplus.of("bending_x"), np.array([0.0, 1e4])
    rest, *judges = static_multiports(both[0], lacking)
    reduced = reduce_to_ports(both[0], at, surplus=lacking)
    size = np.sqrt(np.abs(np.diag(rest.stiffness[0])))
    for judge, found in zip(judges, reduced.richer_multiports(at), strict=True):
        known = (judge.stiffness - rest.stiffness)[0]
        change = (found.stiffness - reduced.multiport(at).stiffness)[0]
        # of what is missing the ports at rest keep the square as well
        assert (np.abs(change - known) / np.outer(size, size)).max() < 2e-3
        assert np.linalg.norm(change - known) < 0.1 * np.linalg.norm(known)
