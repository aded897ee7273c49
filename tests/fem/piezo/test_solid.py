"""The piezoelectric solid: exact cases, invariants, reduction to ports, modes."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.piezo import ports
from tactgen.fem.piezo.krylov import reduce_to_ports
from tactgen.fem.piezo.modal_model import classify
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import direct_multiport, static_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.system import SolidSystem
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs, TipLoad
from tactgen.geometry.bimorph.bricks import LEVELS, BrickMeshing, bimorph_bricks
from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.tmm.ports import multiport
from tactgen.tmm.ports.supports_and_loads import attach, base_stiffness
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

COARSE = BrickMeshing((2, 2, 2), smallest=0.5)


SWEEP = np.linspace(0.0, 20000.0, 101)


@pytest.fixture(scope="module")
def lossless():
    return assemble(Device(), bimorph_bricks(Device(), LEVELS[0]), lossy=False)


@pytest.fixture(scope="module")
def lossy():
    """On so few bricks as a reduction can still be wrong about."""
    bricks = BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=10.0, pieces=(4.0, 10.0))
    return assemble(Device(), bimorph_bricks(Device(), bricks), lossy=True)


def test_a_factor_of_few_digits_is_refined_to_rounding(lossy, monkeypatch):
    """Two digits a step, of every load whatever its unit, until nothing is left."""
    omega2 = (2.0 * np.pi * 700.0) ** 2
    exact, whole = ports._states(lossy, omega2), SolidSystem.dynamic_factor

    def poor(system, omega2):
        factor = whole(system, omega2)
        return SimpleNamespace(solve=lambda right: 1.01 * factor.solve(right))

    monkeypatch.setattr(SolidSystem, "dynamic_factor", poor)
    missed = ports._norms(ports._states(lossy, omega2) - exact)
    # two digits a step: four steps would miss it by 1e-8, and rounding of K − Ω² M is 1e-12
    assert (missed < 1e-10 * ports._norms(exact)).all()


def test_poling_turns_the_sign():
    """Poling the other way reverses motion per volt and leaves the capacitance alone."""
    mesh = bimorph_bricks(Device(), COARSE)
    a, b = (
        static_multiport(assemble(Device(bimorph=Bimorph(poling=p)), mesh, lossy=False))
        .stiffness[0]
        .real
        for p in ("-x", "+x")
    )
    assert a[:4, 4] == pytest.approx(-b[:4, 4], rel=1e-9)
    assert a[4, 4] == pytest.approx(b[4, 4], rel=1e-12)


def test_positive_voltage_bends_towards_plus_x():
    """Convention: poled along -x with d31 < 0, positive U moves the tip towards +x."""
    d = static_multiport(assemble(Device(), bimorph_bricks(Device(), COARSE), lossy=False))
    assert multiport.respond(attach(d, Ends()), {"voltage": 1.0}).motion["w_tip"][0].real > 0.0


def test_wide_sweep_adds_shifts(lossy):
    """A request from 10 Hz to 100 kHz is as good at its ends as two narrow ones.

    One shift near the top is worthless at the bottom; the estimate must see that.
    """
    wide = np.array([10.0, 500.0, 1065.0, 3300.0, 6600.0, 100000.0])
    got = reduce_to_ports(lossy, wide).multiport(wide).stiffness
    for i in (0, 2, 5):  # the ends, and the first resonance
        exact = direct_multiport(lossy, wide[i]).stiffness[0]
        size = np.sqrt(np.abs(np.diag(exact)))
        # the tolerance asked for is 1e-6 in the estimate
        assert (np.abs(got[i] - exact) / np.outer(size, size)).max() < 1e-5


def test_static_ports_are_the_limit_of_the_dynamic_ones(lossless):
    """The static solution is the 0 Hz value of the reduced lossless model."""
    static = static_multiport(lossless).stiffness[0]
    limit = reduce_to_ports(lossless, np.array([0.0, 3000.0])).multiport(np.zeros(1)).stiffness[0]
    size = np.sqrt(np.abs(np.diag(static)))
    assert (np.abs(static - limit) / np.outer(size, size)).max() < 1e-6


def test_open_circuit_stiffens_bending_in_x_only():
    """At open circuit the driven bending modes rise; those the electrodes do not see stay.

    The whole body by scikit-fem's hexahedra, where no class of motion is taken for granted.
    """
    meshing = BrickMeshing((1, 1, 1), smallest=2.0, tip=2.0, longest=2.0)
    whole = bimorph_bricks(Device(), meshing).corner_mesh()
    system = assemble(Device(), whole, lossy=False)
    short, opened = (natural_modes(system, Ends(), 4, open_circuit=c) for c in (False, True))
    for a, b in zip(short, opened, strict=True):
        assert a.kind == b.kind
        if a.kind == "bending_x":
            assert b.frequency > 1.01 * a.frequency
        else:
            assert b.frequency == pytest.approx(a.frequency, rel=1e-9)


def test_modes_are_where_the_port_matrix_is_singular(lossless):
    """Eigenvalues and port reduction are two routes to one resonance on the paper's springs."""
    springs = Springs(3e6, 0.24, rotational_inertia=1e-12)
    mode = natural_modes(lossless, Ends(springs), 1)[0]
    around = mode.frequency * np.array([1.0 - 1e-6, 1.0 + 1e-6])
    d = reduce_to_ports(lossless, around).multiport(around).stiffness[:, :4, :4].real
    lateral, rotational = base_stiffness(springs, around)
    d[:, 0, 0] += lateral.real
    d[:, 1, 1] += rotational.real
    signs = np.sign(np.linalg.det(d / np.array([1.0, 1e-3, 1.0, 1e-3])[:, None]))
    assert signs[0] != signs[1]


def test_tip_mass_and_spring_enter_the_modes(lossless):
    """Rayleigh: a tip spring raises the first mode, a tip mass lowers it, both by formula.

    First order in the change, and lumped masses for the modal mass, hence 5 % of the change.
    """
    plain = natural_modes(lossless, Ends(), 1)[0]
    moved = plain.values[:, :3]
    tip = np.average(moved[lossless.nodes[:, 2] > 19.999e-3, 0])
    modal = (lossless.node_mass[:, None] * moved**2).sum()
    omega2 = (2 * np.pi * plain.frequency) ** 2
    for ends, shift in (
        (Ends(tip=TipLoad(stiffness=5.0)), 5.0 * tip**2 / modal),
        (Ends(tip=TipLoad(mass=1e-7)), -1e-7 * omega2 * tip**2 / modal),
    ):
        loaded = natural_modes(lossless, ends, 1)[0]
        change = (2 * np.pi * loaded.frequency) ** 2 - omega2
        assert change == pytest.approx(shift, rel=0.05)


@pytest.mark.parametrize(
    ("motion", "kind"),
    [
        (lambda x, y, z: (z**2, 0 * z, -2 * x * z), "bending_x"),
        (lambda x, y, z: (0 * z, z**2, -2 * y * z), "bending_y"),
        (lambda x, y, z: (-y * z, x * z, 0 * z), "torsion"),
        (lambda x, y, z: (0 * z, 0 * z, z), "axial"),
    ],
)
def test_modes_are_named_by_their_motion(motion, kind):
    """Synthetic section motions are recognised, and hold nearly all of the energy."""
    rng = np.random.default_rng(3)
    nodes = rng.uniform([-4e-4, -1e-3, 0.0], [4e-4, 1e-3, 2e-2], (4000, 3))
    displacement = np.column_stack(motion(*nodes.T))
    found, share = classify(nodes, np.ones(4000), displacement)
    assert found == kind
    assert share > 0.95


def test_tip_mass_stays_out_of_motions_without_ports():
    """Torsion and axial motion leave the tip's mean displacement at rest: the quarter knows."""
    system = assemble(Device(), bimorph_bricks(Device(), COARSE), lossy=False)
    for motion in ("bending_y", "torsion", "axial"):
        plain, loaded = (
            natural_modes(system.related(motion), Ends(tip=TipLoad(mass=mass)), 2)
            for mass in (0.0, 1e-3)
        )
        assert [m.frequency for m in loaded] == [m.frequency for m in plain]


@pytest.mark.usefixtures("own_store", "coarse_bricks")
@pytest.mark.parametrize(
    ("springs", "tip_stiffness"),
    [
        pytest.param(springs, tip, marks=[pytest.mark.heavy] * ((n + m) % 2))
        for n, springs in enumerate([(0.0, 0.24), (3e6, 0.0), (0.0, 0.0)])
        for m, tip in enumerate([0.0, 1e3])
    ],
)
def test_only_motions_that_no_spring_resists_are_left_out(springs, tip_stiffness):
    """Where springs of the base are missing, the solid has as many modes as the beam has."""
    scene, _ = load_scene(
        "prototype",
        [
            f"support.lateral_stiffness={springs[0]:g}N/m",
            f"support.rotational_stiffness={springs[1]:g}N*m/rad",
            "load.kind=spring_damper",
            f"load.stiffness={tip_stiffness:g}N/m",
            "mesh.level=2",
        ],
    )
    found = solve(scene, ("solid", "tmm", "beam"), ["short_circuit_frequencies"]).quantities
    solid, tmm, beam = (
        [f for f, k in zip(q.value, q.classes, strict=True) if k == "bending_x"] for q in found
    )
    # the solid is no beam: shear, Poisson effect and d33, a few percent
    assert solid[0] == pytest.approx(tmm[0], rel=0.03)
    assert beam[0] == pytest.approx(tmm[0], rel=1e-6)


def test_a_factor_that_is_given_back_is_made_again(few_bricks):
    """Kept while it is wanted; then another with the same answers."""
    system = assemble(Device(), bimorph_bricks(Device(), few_bricks[0]), lossy=False)
    first = system.held_factor
    assert system.held_factor is first
    system.drop_factor()
    again = system.held_factor
    assert again is not first
    right = np.linspace(0.0, 1.0, system.inner)
    np.testing.assert_allclose(again.solve(right), first.solve(right), rtol=1e-9)
