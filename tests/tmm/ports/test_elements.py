"""Springs, and rods and masses of the tests: closed forms, and invariants of whatever they join."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.ports.elements import attach, spring
from tactgen.tmm.ports.multiport import (
    AXIAL,
    LATERAL,
    ROTATION,
    Multiport,
    Pair,
    Port,
    connect,
    hold,
    passivity_margin,
    reciprocity_error,
    reduce,
    respond,
)

FREQUENCIES = np.array([0.0, 10.0, 500.0, 2e4])
OMEGA = 2.0 * np.pi * FREQUENCIES
HEAD = {"w_high": "w_low", "psi_high": "psi_low"}
HEAD_TO_BASE = {"w_high": "w_base", "psi_high": "psi_base"}

#: The force through a rigid link, answered by the gap it would leave; free, it closes the gap.
LINK_FORCE = Pair("F", "N", "gap", "m")
#: The moment through a rigid link, answered by the kink it would leave.
LINK_MOMENT = Pair("M", "N m", "kink", "rad")
#: Both ends of a rod that moves in the bending plane, and what goes through it.
_ROD = (
    Port("w_low", LATERAL),
    Port("psi_low", ROTATION),
    Port("w_high", LATERAL),
    Port("psi_high", ROTATION),
    Port("link_force", LINK_FORCE),
    Port("link_moment", LINK_MOMENT),
)

sizes = st.floats(1e-4, 1e-1)
masses = st.floats(1e-9, 1e-1)


def rigid_rod(frequencies, *, length, mass=0.0, inertia=0.0, centre=None):
    """Return a rigid body in the bending plane, with ports at two heights.

    Its ends have one motion, w_high = w_low − l ψ_low and ψ_high = ψ_low, which no stiffness
    can say.  So the force and the moment through it are ports too, answered by gap and kink,
    w_low − l ψ_low − w_high and ψ_low − ψ_high; left free they close both (a Lagrange
    multiplier).
    """
    f = np.atleast_1d(np.asarray(frequencies, dtype=float))
    c = 0.5 * length if centre is None else centre
    at_rest, masses = np.zeros((6, 6)), np.zeros((6, 6))
    # w = w_low − c ψ_low at the centre of mass
    masses[:2, :2] = [[mass, -c * mass], [-c * mass, inertia + c * c * mass]]
    arm = np.array([[1.0, -length], [0.0, 1.0]])
    at_rest[4:, :4] = np.hstack([arm, -np.eye(2)])
    at_rest[:4, 4:] = at_rest[4:, :4].T
    omega2 = (2.0 * np.pi * f)[:, None, None] ** 2
    return Multiport(f, at_rest - omega2 * masses + 0j, _ROD)


def lumped_mass(frequencies, pair, mass):
    """Return a mass (kg) that moves along, or an inertia (kg m²) that turns about, one port."""
    value = -((2.0 * np.pi * np.atleast_1d(frequencies)) ** 2) * mass + 0j
    return Multiport(np.atleast_1d(frequencies), value[:, None, None], (Port("mass", pair),))


def rod(length, mass=0.0, inertia=0.0, **keys):
    return rigid_rod(FREQUENCIES, length=length, mass=mass, inertia=inertia, **keys)


def bimorph(frequencies=FREQUENCIES, *, lossy=True):
    return tmm.multiport(Device(), Support(), Beam(), frequencies, lossy=lossy)


def on_top(lower, upper):
    """Return one rod that stands on another, with the ports of a rod."""
    joined = connect(lower, upper, HEAD, prefixes=("below", "above"))
    ports = [f"above.{name}" for name in ("w_high", "psi_high", "link_force", "link_moment")]
    found = reduce(joined, ("w_low", "psi_low", *ports))
    return found.renamed({name: name.removeprefix("above.") for name in ports})


def distance(one, other):
    """Return the largest difference of two D, relative to the size of their rows and columns."""
    size = np.sqrt(np.abs(other).max(axis=2))
    return (np.abs(one - other) / (size[:, :, None] * size[:, None, :])).max()


@given(st.tuples(sizes, masses, sizes), st.tuples(sizes, masses, sizes))
def test_two_rods_are_one(lower, upper):
    """Masses add, inertias by Steiner about the common centre, and the arm is the whole length."""
    (l0, m0, r0), (l1, m1, r1) = lower, upper
    j0, j1 = m0 * r0**2, m1 * r1**2
    mass = m0 + m1
    centre = (m0 * 0.5 * l0 + m1 * (l0 + 0.5 * l1)) / mass
    inertia = j0 + m0 * (centre - 0.5 * l0) ** 2 + j1 + m1 * (l0 + 0.5 * l1 - centre) ** 2
    joined = on_top(rod(l0, m0, j0), rod(l1, m1, j1))
    assert distance(joined.stiffness, rod(l0 + l1, mass, inertia, centre=centre).stiffness) < 1e-14


@given(sizes, masses, sizes, st.floats(-1.0, 2.0))
def test_a_driven_rod_moves_as_one_body(length, mass, radius, share):
    """A force and a moment at the foot: the centre accelerates, the body turns about it."""
    c, inertia = share * length, mass * radius**2
    f = np.array([10.0, 2e4])
    body = rigid_rod(f, length=length, mass=mass, inertia=inertia, centre=c)
    moved = respond(body, {}, {"w_low": 1.0, "psi_low": length}).motion
    o2 = (2.0 * np.pi * f) ** 2
    # about the centre the force has the moment c F: w' ≈ −ψ, so a push below turns by +
    psi = -(length + c) / (inertia * o2)
    w = -1.0 / (mass * o2) + c * psi
    # rounding: of the parts, times the condition of translation against rotation
    bound = 1e-13 * (1.0 + (length**2 + c**2) / radius**2)
    turned = bound * (length + np.abs(c)) / (inertia * o2)
    shifted = bound / (mass * o2) + (length + np.abs(c)) * turned
    assert (np.abs(moved["psi_low"] - psi) < turned).all()
    assert (np.abs(moved["w_low"] - w) < shifted).all()
    # both ends have one rotation, and the head is behind by the arm
    assert (np.abs(moved["psi_high"] - psi) < turned).all()
    assert (np.abs(moved["w_high"] - (w - length * psi)) < shifted).all()


def test_a_clamped_rod_holds_what_stands_on_it():
    """A bimorph on a rod whose foot is held is clamped, and the link carries its reaction."""
    machine = connect(rod(3e-3, 1e-3, 1e-9), bimorph(), HEAD_TO_BASE)
    held = respond(hold(machine, "w_low", "psi_low"), {"voltage": 50.0})
    alone = respond(bimorph(), {"voltage": 50.0, "w_base": 0.0, "psi_base": 0.0})
    np.testing.assert_allclose(held.motion["w_tip"], alone.motion["w_tip"], rtol=1e-12)
    # the rod's own ends are at rest, so what the link carries is what holds the base; at rest
    # that is the difference of equal moments, so it is judged above 0 Hz
    for link, base in (("link_force", "w_base"), ("link_moment", "psi_base")):
        np.testing.assert_allclose(held.motion[link][1:], alone.effort[base][1:], rtol=1e-6)


def test_a_rod_is_a_beam_that_does_not_bend():
    """Under a bimorph it does what a stretch of ever stiffer beam tends to in the row."""
    length, m, rho_i = 3e-3, 0.05, 1e-7
    ((section, above),) = tmm.sections(Device(), Support(), Beam(), lossy=True)
    body = rod(length, m * length, m * length**3 / 12.0 + rho_i * length)
    joined = connect(body, bimorph(), HEAD_TO_BASE)
    found = reduce(joined, ("w_low", "psi_low", "w_tip", "psi_tip", "voltage"))
    left = []
    for times in (1e4, 1e6):
        stiff = Section(EI=times * section.EI.real, GA=times * section.GA, m=m, rhoI=rho_i)
        row = tmm.chain([(stiff, length), (section, above)], FREQUENCIES)
        left.append(distance(found.stiffness, row.stiffness))
    # nothing is left but the beam's compliance, and that is a hundred times less
    assert left[0] / left[1] == pytest.approx(100.0, rel=1e-2)
    assert left[1] < 1e-5


def test_a_rod_on_springs_is_an_oscillator():
    """A rigid rod on a rotational spring at its foot: Ω² = c/(J + m c²)."""
    length, mass, inertia, stiffness = 4e-3, 2e-4, 3e-10, 0.24
    expected = np.sqrt(stiffness / (inertia + mass * (0.5 * length) ** 2))
    f = expected / (2.0 * np.pi) * np.array([1.0 - 1e-6, 1.0 + 1e-6])
    body = hold(rigid_rod(f, length=length, mass=mass, inertia=inertia), "w_low")
    foot = hold(spring(f, ROTATION, stiffness=stiffness), "low")
    mounted = reduce(connect(body, foot, {"psi_low": "high"}), ["psi_low"])
    below, above = mounted["psi_low", "psi_low"].real
    assert below > 0.0 > above


def test_the_machine_loses_only_where_there_are_losses():
    """Rod, bimorph and damped springs: the source's power is the sum of what each one takes."""
    f = np.array([20.0, 400.0, 900.0])
    body = rigid_rod(f, length=3e-3, mass=1e-4, inertia=1e-10)
    parts = {
        "bimorph": bimorph(f),
        "foot": spring(f, ROTATION, stiffness=0.24, damping=4.46e-6, ends=("ground", "psi_foot")),
        "slide": spring(f, LATERAL, stiffness=3e6, damping=0.1, ends=("wall", "w_foot")),
    }
    machine = connect(body, parts["bimorph"], HEAD_TO_BASE)
    machine = connect(machine, parts["foot"], {"psi_low": "psi_foot"})
    machine = connect(machine, parts["slide"], {"w_low": "w_foot"})
    assert reciprocity_error(machine).max() < 1e-13
    assert passivity_margin(machine).min() > -1e-13
    r = respond(hold(machine, "ground", "wall"), {"voltage": 50.0})
    half = 0.5 * 2.0 * np.pi * f
    source = half * (1j * 50.0 * r.effort["voltage"]).real
    turned, slid = (np.abs(r.motion[name]) ** 2 for name in ("psi_low", "w_low"))
    dampers = half * 2.0 * np.pi * f * (4.46e-6 * turned + 0.1 * slid)
    renamed = {"w_base": "w_high", "psi_base": "psi_high"}
    motions = {n: r.motion[renamed.get(n, n)] for n in parts["bimorph"].names}
    ceramic = respond(parts["bimorph"], motions)
    signs = {p.name: p.pair.sign for p in parts["bimorph"].ports}
    taken = sum(signs[n] * (ceramic.motion[n].conj() * ceramic.effort[n]).imag for n in motions)
    np.testing.assert_allclose(source, dampers + half * taken, rtol=1e-10)
    assert (dampers > 0.0).all()


def test_springs_to_the_ground_are_the_paper_support():
    """Springs joined to the base by name are what the ends attach."""
    springs = Springs(3e6, 0.24, rotational_damping=4.46e-6)
    lateral = spring(FREQUENCIES, LATERAL, stiffness=3e6, ends=("wall", "w"))
    turning = spring(FREQUENCIES, ROTATION, stiffness=0.24, damping=4.46e-6, ends=("floor", "psi"))
    machine = connect(connect(bimorph(), lateral, {"w_base": "w"}), turning, {"psi_base": "psi"})
    found = hold(machine, "wall", "floor")
    expected = attach(bimorph(), Ends(springs))
    assert found.ports == expected.ports
    assert distance(found.stiffness, expected.stiffness) < 1e-15


@given(st.floats(1e-2, 1e8), st.floats(1e-2, 1e8), st.floats(0.0, 1.0))
def test_springs_in_series(first, second, damping):
    """Compliances add, dampers and all; force goes through unchanged."""
    a = spring(FREQUENCIES, AXIAL, stiffness=first, damping=damping)
    b = spring(FREQUENCIES, AXIAL, stiffness=second, ends=("low", "top"))
    chain = reduce(connect(a, b.renamed({"low": "middle"}), {"high": "middle"}), ["low", "top"])
    one = first + 1j * OMEGA * damping
    expected = one * second / (one + second)
    np.testing.assert_allclose(chain["top", "low"], -expected, rtol=1e-14)
    # what the stiff end of a soft chain answers is the small difference of its own stiffness
    lost = np.abs(chain["low", "low"] - expected)
    assert (lost < 4.0 * np.finfo(float).eps * np.abs(one)).all()
    assert chain.names == ("low", "top")


def test_what_is_joined_must_be_of_one_kind():
    """An axial spring is none across the axis."""
    with pytest.raises(ValueError, match="different kinds"):
        connect(rod(1e-3), spring(FREQUENCIES, AXIAL, stiffness=1.0), {"w_low": "low"})


def test_a_mass_on_a_spring_resonates():
    """It has Ω² = k/m, and there the damper alone answers."""
    stiffness, mass = 2e5, 1e-3
    f = np.sqrt(stiffness / mass) / (2.0 * np.pi) * np.array([1.0 - 1e-9, 1.0, 1.0 + 1e-9])
    held = hold(spring(f, AXIAL, stiffness=stiffness, damping=0.3), "low")
    force = connect(held, lumped_mass(f, AXIAL, mass), {"high": "mass"})["high", "high"]
    assert force.real[0] > 0.0 > force.real[2]
    assert force[1].imag == pytest.approx(2.0 * np.pi * f[1] * 0.3, rel=1e-15)


@given(st.floats(0.0, 1e9), st.floats(0.0, 1e3), sizes, masses)
def test_every_element_is_reciprocal_and_passive(stiffness, damping, length, mass):
    """Whatever its values, an element takes in no negative power, and 0 Hz is finite."""
    elements = [
        rod(length, mass, mass * length**2, centre=2.0 * length),
        spring(FREQUENCIES, LATERAL, stiffness=stiffness, damping=damping),
        lumped_mass(FREQUENCIES, ROTATION, mass),
    ]
    for element in elements:
        assert np.isfinite(element.stiffness).all()
        assert (reciprocity_error(element) == 0.0).all()
        # a pair of equal and opposite entries has an eigenvalue 0, found to a rounding
        assert (passivity_margin(element) >= -1e-15).all()
