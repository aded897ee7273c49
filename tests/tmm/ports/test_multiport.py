"""Port algebra: joining, wiring, driving, and the invariants of every passive reciprocal model."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from port_distance import distance

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Load, Piezo, Shim, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import lumped
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.beam.printed_formulas import printed_section
from tactgen.tmm.ports.multiport import (
    AXIAL,
    BIMORPH,
    LATERAL,
    ROTATION,
    balanced,
    connect,
    hold,
    passivity_margin,
    reciprocity_error,
    reduce,
    respond,
    round_off,
)
from tactgen.tmm.ports.supports_and_loads import attach, ends_of, spring

FREQUENCIES = np.array([0.0, 10.0, 500.0, 2e3, 2e4])
SPRING = Support()
PAPER = ends_of(SPRING, Load())

devices = st.builds(
    Device,
    bimorph=st.builds(
        Bimorph,
        length=st.floats(2e-3, 0.1), width=st.floats(1e-4, 1e-2),
        piezo_thickness=st.floats(1e-4, 1e-3), shim_thickness=st.floats(1e-4, 1e-3),
        tab_length=st.sampled_from([0.0, 1e-3, 5e-3]), poling=st.sampled_from(["-x", "+x"]),
    ),
    piezo=st.builds(
        Piezo,
        material=st.sampled_from(["M1876", "PZT-5H", "PZT-5A"]),
        quality_factor=st.floats(5.0, 1e3), loss_tangent=st.floats(0.0, 0.1),
    ),
    shim=st.builds(Shim, youngs_modulus=st.floats(1e10, 4e11), density=st.floats(1e3, 9e3)),
)  # fmt: skip


def paper(frequencies=FREQUENCIES, *, lossy=True, **bimorph):
    return tmm.multiport(
        Device(bimorph=Bimorph(**bimorph)), SPRING, Beam(), frequencies, lossy=lossy
    )


def driven(port, ends, voltage=50.0):
    return respond(attach(port, ends), {"voltage": voltage})


@given(devices)
def test_reciprocity_and_passivity(device):
    """Work done by one port on another is mutual, also across joints of unequal beams; no model of
    a passive device gives off power, whatever its ports are driven with.
    """
    for model in (tmm, lumped):
        port = model.multiport(device, SPRING, Beam(), FREQUENCIES)
        # condensing a joint costs its condition number, 1e3 for a thin tab under a thick beam
        assert (reciprocity_error(port) < 1e-11).all()
        # smallest eigenvalue relative to the largest: rounding of D, 1e-16, over losses of 1e-3
        # at least, times the condition number of the joint, 1e3
        assert (passivity_margin(port) > -1e-10).all()


def test_an_active_capacitor_and_a_broken_symmetry_are_caught():
    """The passivity margin turns negative for eq 55 as printed; the reciprocity error shows one
    wrong sign in the coupling."""
    ((beam, length),) = tmm.sections(Device(), SPRING, Beam(), lossy=True)
    wrong = printed_section(beam, Device(), frozenset({55}))
    good, bad = (tmm.chain([(b, length)], FREQUENCIES) for b in (beam, wrong))
    assert (passivity_margin(good) > -1e-12).all()
    assert (passivity_margin(bad) < -1e-5).all()

    port = paper()
    d = port.stiffness.copy()
    d[:, 4, 3] *= -1.0
    assert (reciprocity_error(port) < 1e-14).all()
    assert (reciprocity_error(replace(port, stiffness=d)) > 0.1).all()


def test_round_off_bound_is_what_a_last_digit_does_at_worst():
    """The matrix off by machine epsilon of its norm, in the direction that matters most."""
    port = attach(paper(np.array([100.0]), lossy=False), Ends())
    matrix = balanced(hold(port, "voltage").stiffness)[0]
    left, values, right = np.linalg.svd(matrix)
    many = 1e6  # last digits, so that the change is not itself rounding
    off = many * np.finfo(float).eps * values[0] * np.outer(left[:, -1], right[-1])
    motion, moved = (np.linalg.solve(m, left[:, -1]) for m in (matrix, matrix + off))
    change = np.linalg.norm(moved - motion) / np.linalg.norm(motion)
    # second order in a change of 1e-7
    assert change == pytest.approx(many * round_off(port)[0], rel=1e-5)


JOINTS = {"w_tip": "w_base", "psi_tip": "psi_base", "voltage": "voltage"}


def end_to_end(lower, upper):
    """Return two bimorphs joined, with the ports of one."""
    tip = {"w_tip": "upper.w_tip", "psi_tip": "upper.psi_tip"}
    joined = connect(lower, upper.renamed(tip), JOINTS)
    kept = ("w_base", "psi_base", "upper.w_tip", "upper.psi_tip", "voltage")
    return reduce(joined, kept).renamed({"upper.w_tip": "w_tip", "upper.psi_tip": "psi_tip"})


@given(st.floats(0.02, 0.98), st.booleans())
def test_it_does_not_matter_where_a_bimorph_is_cut(share, lossy):
    """Any two parts that make up the length: all 25 entries, with losses and without."""
    parts = (paper(length=20e-3 * s, lossy=lossy) for s in (share, 1.0 - share))
    joined, whole = end_to_end(*parts), paper(lossy=lossy)
    assert joined.ports == whole.ports == BIMORPH
    # the shorter part is as many times stiffer against rotation, and that cancels at the joint; of
    # 800 cuts along the bimorph the worst takes 1.4e-13
    shorter = min(share, 1.0 - share)
    assert distance(joined.stiffness, whole.stiffness) < 1.5e-13 / shorter


@pytest.mark.parametrize(
    ("use", "words"),
    [
        (lambda p: p.index("w_tp"), 'port "w_tp" is unknown .did you mean "w_tip"'),
        (lambda p: reduce(p, ["w_tip", "gap"]), "there are w_base, psi_base, w_tip"),
        (lambda p: p.renamed({"w_base": "w_tip"}), 'two ports are named "w_tip"'),
        (lambda p: connect(p, p, {"w_tip": "psi_base"}), "w in m.*ψ in rad.*different kinds"),
        (lambda p: connect(p, p, {"w_tip": "w_base", "w_base": "w_base"}), "joined to two"),
        (lambda p: connect(p, paper(np.ones(1)), JOINTS), "different frequencies"),
        (lambda p: respond(p, {"voltage": 1.0}, {"voltage": 1.0}), "both moved and loaded"),
    ],
)
def test_what_cannot_be_meant_is_refused(use, words):
    """A misspelt port with the nearest name; a displacement on a rotation; two sweeps."""
    with pytest.raises(InputError, match=words):
        use(paper())


def test_a_force_frees_charge_as_a_volt_moves():
    """And driven to where the force had moved it, the tip takes that force."""
    port, force = attach(paper(), PAPER), {"w_tip": 0.1}
    volt, pushed = respond(port, {"voltage": 50.0}), respond(port, {"voltage": 0.0}, force)
    np.testing.assert_allclose(
        pushed.effort["voltage"] / 0.1, volt.motion["w_tip"] / 50.0, rtol=1e-12
    )
    moved = {"voltage": 0.0, "w_tip": pushed.motion["w_tip"]}
    np.testing.assert_allclose(respond(port, moved).effort["w_tip"], 0.1, rtol=1e-12)


def test_a_held_port_is_one_driven_by_nothing():
    """To hold a port before or while driving is one thing; then its effort is known too."""
    port = paper()
    held = respond(hold(port, "w_base", "psi_base"), {"voltage": 50.0})
    driven_to_rest = respond(port, {"voltage": 50.0, "w_base": 0.0, "psi_base": 0.0})
    np.testing.assert_array_equal(driven_to_rest.motion["w_tip"], held.motion["w_tip"])
    assert not driven_to_rest.motion["w_base"].any()
    # clamped at rest, the base carries no moment under the voltage: nothing reacts at the tip
    moment = np.abs(driven_to_rest.effort["psi_base"])
    assert moment[0] < 1e-10 * moment[2]  # at 500 Hz inertia does


def test_springs_to_the_ground_are_the_paper_support():
    """Springs joined to the base by name are what the ends attach."""
    springs = Springs(3e6, 0.24, rotational_damping=4.46e-6)
    lateral = spring(FREQUENCIES, LATERAL, stiffness=3e6, ends=("wall", "w"))
    turning = spring(FREQUENCIES, ROTATION, stiffness=0.24, damping=4.46e-6, ends=("floor", "psi"))
    machine = connect(connect(paper(), lateral, {"w_base": "w"}), turning, {"psi_base": "psi"})
    found = hold(machine, "wall", "floor")
    expected = attach(paper(), Ends(springs))
    assert found.ports == expected.ports
    assert distance(found.stiffness, expected.stiffness) < 1e-15


@given(st.floats(1e-2, 1e8), st.floats(1e-2, 1e8), st.floats(0.0, 1.0))
def test_springs_in_series(first, second, damping):
    """Compliances add, dampers and all; force goes through unchanged."""
    a = spring(FREQUENCIES, AXIAL, stiffness=first, damping=damping)
    b = spring(FREQUENCIES, AXIAL, stiffness=second, ends=("low", "top"))
    chain = reduce(connect(a, b.renamed({"low": "middle"}), {"high": "middle"}), ["low", "top"])
    one = first + 2j * np.pi * FREQUENCIES * damping
    expected = one * second / (one + second)
    np.testing.assert_allclose(chain["top", "low"], -expected, rtol=1e-14)
    # what the stiff end of a soft chain answers is the small difference of its own stiffness
    lost = np.abs(chain["low", "low"] - expected)
    assert (lost < 4.0 * np.finfo(float).eps * np.abs(one)).all()
    assert chain.names == ("low", "top")
