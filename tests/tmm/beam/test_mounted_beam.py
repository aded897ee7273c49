"""The closed form of the mounted beam: as good as 80 digits allow, at any shape and chunk."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device, Load, Support
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.mounted_beam import mounted_response
from tactgen.tmm.beam.sections import section
from tactgen.tmm.beam.transfer_matrix import chain
from tactgen.tmm.ports.elements import attach, base_stiffness, ends_of, tip_stiffness
from tactgen.tmm.ports.multiport import respond

LENGTH = 20e-3
EPS = np.finfo(float).eps
CLAMPED, SPRING = Support(kind="clamped"), Support()
FREE, FINGER = Load(kind="none"), Load()


def bimorph(*, lossy=True):
    return section(Piece("bimorph", LENGTH), Device(), Beam(), lossy=lossy)


def respond_at(beam, length, f, ends, **options):
    base = ends.base and base_stiffness(ends.base, f)
    tip, omega = tip_stiffness(ends.tip, f), 2 * np.pi * f
    return mounted_response(beam, length, omega, base=base, tip=tip, **options)


@pytest.mark.parametrize("support", [CLAMPED, SPRING], ids=["clamped", "spring"])
@pytest.mark.parametrize("load", [FREE, FINGER, Load(kind="mass", mass=1e-3)], ids=lambda l: l.kind)
def test_same_as_the_dynamic_stiffness(support, load):
    """Displacement, rotation and charge are those of the beam's D with the ends attached."""
    f = np.geomspace(0.1, 1e5, 400)
    ends = ends_of(support, load)
    ours = respond_at(bimorph(), LENGTH, f, ends)
    matrix = respond(attach(chain([(bimorph(), LENGTH)], f), ends), {"voltage": 1.0})
    # D's resonances, damped with Q = 60, cost the elimination four digits
    np.testing.assert_allclose(ours.w_tip, matrix.motion["w_tip"], rtol=1e-11)
    np.testing.assert_allclose(ours.psi_tip, matrix.motion["psi_tip"], rtol=1e-11)
    np.testing.assert_allclose(ours.charge, matrix.effort["voltage"], rtol=1e-11)


@pytest.mark.parametrize("number", range(18))
def test_against_the_stored_state_space_solution(state_space, number):
    """Tip velocity and current of the paper's bimorph, free and loaded, to 30 roundings."""
    case = state_space["cases"][number]
    f = np.array([case["frequency"]])
    ends = ends_of(SPRING, Load(kind=case["load"]))
    ours = respond_at(bimorph(), case["length"], f, ends)
    # section constants, Ω and the attachments are rounded, too, and the condition is below 100;
    # beside a minimum or a peak a rounding of Ω alone is worth four
    for got, name in ((ours.w_tip, "v_tip"), (ours.charge, "current")):
        velocity = 2j * np.pi * f[0] * got[0] * case["voltage"]
        assert velocity == pytest.approx(complex(*case[name]), rel=30 * EPS), name


def test_the_bound_says_how_near_the_own_resonance_is():
    """Ten times nearer to a lossless resonance it is ten times larger."""
    beam = bimorph(lossy=False)
    first = bending_frequencies([(beam, LENGTH)], Ends(), 1, open_circuit=False)[0]
    f = first * (1 + np.array([1e-3, 1e-4, 1e-5]))
    bound = respond_at(beam, LENGTH, f, Ends()).error
    np.testing.assert_allclose(bound[1:] / bound[:-1], 10.0, rtol=0.05)


@pytest.mark.parametrize("chunk", [1, 100000])
def test_chunks_do_not_show(chunk):
    """The result does not depend on how many points are worked on at a time."""
    f = np.geomspace(1e-2, 1e6, 110)
    ends = ends_of(SPRING, FINGER)
    one, other = (respond_at(bimorph(), LENGTH, f, ends, chunk=n) for n in (50, chunk))
    # vector instructions may round the last elements of an array differently
    np.testing.assert_allclose(one.w_tip, other.w_tip, rtol=1e3 * EPS)


def test_everything_broadcasts():
    """Sections, lengths, supports, loads and frequencies in one call, each on its own axis."""
    one, f = bimorph(), np.array([0.0, 100.0, 2e3])
    beam = replace(one, EI=one.EI * np.array([1.0, 1.1])[:, None, None, None])
    lengths, tips = np.array([5e-3, 20e-3])[:, None, None], np.array([0.0, 700.0])[:, None]
    base = (1e5, np.array([0.2, 0.3, 0.4]))
    got = mounted_response(beam, lengths, 2 * np.pi * f, base=base, tip=tips)
    assert got.w_tip.shape == got.charge.shape == got.error.shape == (2, 2, 2, 3)
    for i, j, k, n in np.ndindex(got.w_tip.shape):
        alone = mounted_response(
            replace(one, EI=beam.EI[i, 0, 0, 0]), lengths[j, 0, 0], 2 * np.pi * f[n],
            base=(1e5, base[1][n]), tip=tips[k, 0],
        )  # fmt: skip
        np.testing.assert_allclose(got.w_tip[i, j, k, n], alone.w_tip, rtol=20 * EPS)


def test_static_clamped_bimorph():
    """At 0 Hz the tip is at −K l²/(2 EI) per volt, turned by K l/EI, the charge (C + K²/EI) l."""
    beam = bimorph(lossy=False)
    got = mounted_response(beam, LENGTH, 0.0, base=None, tip=0.0)
    assert got.w_tip == pytest.approx(-beam.K * LENGTH**2 / (2 * beam.EI), rel=1e-14)
    assert got.psi_tip == pytest.approx(beam.K * LENGTH / beam.EI, rel=1e-14)
    assert got.charge == pytest.approx((beam.C + beam.K**2 / beam.EI) * LENGTH, rel=1e-14)


def test_unheld_beam_has_no_static_response():
    """Without support or load nothing balances the motion at 0 Hz."""
    with pytest.raises(np.linalg.LinAlgError, match="nothing holds"):
        mounted_response(bimorph(), LENGTH, 0.0, base=(0.0, 0.0), tip=0.0)


def test_memory_stays_flat():
    """Beside inputs and results a sweep needs memory for one block, however long it is."""
    beam, extra = bimorph(), []
    base, tip = (3e6, 0.2), 700.0
    for n in (10_000, 40_000):
        f = np.linspace(10.0, 2e3, n)
        tracemalloc.start()
        got = mounted_response(beam, LENGTH, 2 * np.pi * f, base=base, tip=tip)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        extra.append(peak - f.nbytes - 3 * got.w_tip.nbytes - got.error.nbytes)
    assert extra[1] < 1.1 * extra[0]
    assert extra[1] < 40e6
