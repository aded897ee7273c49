"""Reduction to ports: against direct solutions at every peak and dip."""

import numpy as np
import pytest

from tactgen.fem.piezo import krylov as projection
from tactgen.fem.piezo.krylov import port_error, reduce_to_ports
from tactgen.fem.piezo.port_model import _GRID, extremes, motions, standard_ends
from tactgen.fem.piezo.ports import direct_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.bimorph.bricks import LEVELS, BrickMeshing, bimorph_bricks
from tactgen.geometry.device.parameters import Device, Piezo
from tactgen.tmm.ports.multiport import passivity_margin, reciprocity_error

BOUNDS = (10.0, 20000.0)
SWEEP = np.geomspace(*BOUNDS, 1000)
#: A direct solution is itself uncertain by this much at a peak or dip: from one step of
#: refinement to the next it moves by 5e-8 on coarse meshes, by 1.8e-7 on the default one.
DIRECT, DIRECT_DEFAULT = 2e-7, 5e-7
#: What rounding leaves of D(Ω): little on coarse meshes; on finer ones 6e-10, which D's own
#: poles, both ends held, magnify by Q = 60.
PORTS, PORTS_FINER = 1e-8, 60 * 6e-10


@pytest.fixture(scope="module")
def system():
    meshing = BrickMeshing((2, 2, 2), smallest=0.5)
    return assemble(Device(), bimorph_bricks(Device(), meshing), lossy=True)


@pytest.fixture(scope="module")
def reduced(system):
    return reduce_to_ports(system, SWEEP)


def compare(system, reduced, at, direct_bar=DIRECT, ports_bar=PORTS):
    """Check errors at frequencies; the wanted accuracy is 1e-6, dips and peaks included."""
    exact, found = direct_multiport(system, at), reduced.multiport(at)
    assert port_error(exact, found).max() < ports_bar
    worst = np.zeros(at.size)
    for end in standard_ends(reduced.fine):
        direct = motions(exact, end)
        worst = np.maximum(worst, (np.abs(motions(found, end) / direct - 1.0)).max(axis=0))
    assert worst.max() < 1e-6
    # not optimistic: the estimate covers the error as far as the reference can tell
    assert np.all(worst < reduced.error_estimate(at) + direct_bar)


def test_peaks_and_dips_are_right(system, reduced):
    """At every third turning point of the responses, the hardest places, the error is below 1e-6.

    The heavy test takes all of them.
    """
    at = extremes(reduced.fine, *BOUNDS, standard_ends(reduced.fine))
    assert at.size > 20
    compare(system, reduced, at[::3])


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("level", "direct_bar", "ports_bar"),
    [(0, DIRECT, PORTS), (1, DIRECT, PORTS_FINER), (2, DIRECT_DEFAULT, PORTS_FINER)],
)
def test_hundred_frequencies_on_daily_meshes(level, direct_bar, ports_bar):
    """Up to the default mesh, 10 Hz to 20 kHz, more than 100 check frequencies."""
    system = assemble(Device(), bimorph_bricks(Device(), LEVELS[level]), lossy=True)
    reduced = reduce_to_ports(system, SWEEP)
    assert reduced.error < 1e-6
    turning = extremes(reduced.fine, *BOUNDS, standard_ends(reduced.fine))
    at = np.union1d(turning, np.geomspace(*BOUNDS, 80))
    compare(system, reduced, at, direct_bar, ports_bar)


def test_turning_points_are_found(reduced):
    """No sample of a far finer grid beats a peak or dip by more than the grid can resolve."""
    (clamped, _) = standard_ends(reduced.fine)
    at = extremes(reduced.fine, 500.0, 20000.0, (clamped,))
    grid = np.linspace(500.0, 20000.0, 40001)
    size = np.abs(motions(reduced.multiport(grid), clamped)[0])
    rise = np.sign(np.diff(size))
    for i in np.flatnonzero(rise[1:] != rise[:-1]):
        assert np.abs(at - grid[i + 1]).min() <= grid[1] - grid[0]
    # a range that ends just above the last of them still holds it
    last = at[-1]
    again = extremes(reduced.fine, 500.0, last * (1.0 + 1.2 / _GRID), (clamped,))
    assert again[-1] == pytest.approx(last, rel=1e-4)


def test_poor_basis_is_seen(system):
    """Asked for hardly anything, the estimate still tells what the error is."""
    narrow = reduce_to_ports(system, np.array([100.0]), tolerance=1.0)
    far = np.array([150e3, 200e3])
    exact = direct_multiport(system, far)
    error = port_error(exact, narrow.multiport(far))
    assert np.all(error > 1e-6)  # it is poor indeed
    assert np.all(narrow.error_estimate(far) > error)


def test_no_more_is_solved_than_the_range_needs(system, monkeypatch):
    """A few hundred hertz take three blocks; before another shift come more blocks of the first."""
    made = []

    def counted(*args, **kwargs):
        made.append(1)
        return factorise(*args, **kwargs)

    monkeypatch.setattr("tactgen.fem.piezo.system.factorise", counted)
    models = [reduce_to_ports(system, np.array([10.0, top])) for top in (500.0, 7000.0)]
    assert all(model.error <= 1e-6 for model in models)
    assert len(made) == 2  # one shift each
    at = np.array([10.0, 120.0, 440.0, 500.0])
    assert port_error(direct_multiport(system, at), models[0].multiport(at)).max() < PORTS


def test_reduced_solid_is_passive_and_reciprocal(reduced):
    """The projection is real and symmetric, so neither property can be lost."""
    port = reduced.multiport(SWEEP)
    assert reciprocity_error(port).max() < 1e-9
    # rigid motion loses nothing at 10 Hz: rounding around zero, 2e-9 in the direct solution too
    assert passivity_margin(port).min() > -1e-8


def test_passive_ceramic_is_reduced_too():
    """Without coupling the voltage moves nothing, and the reduction says so, exactly."""
    device = Device(piezo=Piezo(d31=0.0))
    frequencies = np.linspace(100.0, 5000.0, 9)
    system = assemble(device, bimorph_bricks(device, LEVELS[0]), lossy=True)
    stiffness = reduce_to_ports(system, frequencies).multiport(frequencies).stiffness
    assert np.isfinite(stiffness).all()
    assert np.abs(stiffness[:, 4, :4]).max() == 0.0
    assert (stiffness[:, 4, 4].real > 0.0).all()


@pytest.mark.parametrize("last", [0, 2])
def test_potentials_are_eliminated_by_what_they_follow(last):
    """A, b, bᵀ, c with x = −c⁻¹ bᵀ y, so that the rest sees A − b c⁻¹ bᵀ; none is no change."""
    root = np.random.default_rng(2).normal(size=(6, 6))
    matrix = (root + root.T + 0.1j * np.eye(6)).astype(complex)
    rest, follows = projection._condensed(matrix, last)
    assert follows.shape == (last, 6 - last)
    y = np.linspace(-1.0, 1.0, 6 - last)
    efforts = matrix @ np.concatenate([y, follows @ y])
    np.testing.assert_allclose(efforts, [*(rest @ y), *np.zeros(last)], atol=1e-13)
