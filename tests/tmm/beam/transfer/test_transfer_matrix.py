"""The transfer-matrix model against the stored 60-digit state-space solution; its mounted beam."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Load, Support
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.beam.mounted_beam import mounted_response
from tactgen.tmm.beam.sections import section
from tactgen.tmm.ports.multiport import respond, round_off
from tactgen.tmm.ports.supports_and_loads import attach, ends_of

SUPPORT = Support()


def driven(port, ends, voltage=1.0):
    return respond(attach(port, ends), {"voltage": voltage})


def blocked_force(port, ends, voltage):
    return respond(attach(port, ends), {"voltage": voltage, "w_tip": 0.0}).effort["w_tip"]


def model(length, frequencies, *, lossy=True, support=SUPPORT):
    device = Device(bimorph=Bimorph(length=length))
    return tmm.multiport(device, support, Beam(), frequencies, lossy=lossy)


@pytest.mark.parametrize("number", range(18))
def test_against_the_state_space_solution(state_space, number):
    """Tip motion, current, blocked force and base motion of every stored case."""
    case = state_space["cases"][number]
    f = np.array([case["frequency"]])
    port = model(case["length"], f)
    ends = ends_of(SUPPORT, Load(kind=case["load"]))
    r, jw = driven(port, ends, case["voltage"]), 2j * np.pi * f
    got = {
        "v_tip": jw * r.motion["w_tip"],
        "psidot_tip": jw * r.motion["psi_tip"],
        "current": jw * r.effort["voltage"],
        "blocked_force": blocked_force(port, ends, case["voltage"]),
        "v_base": jw * r.motion["w_base"],
        "psidot_base": jw * r.motion["psi_base"],
    }
    # the stated bound, ε times the condition of the boundary system: 3e3 next to the resonance
    rounding = round_off(attach(port, ends))[0]
    assert rounding < 1e-12
    for name in ("v_tip", "psidot_tip", "current", "blocked_force"):
        assert got[name][0] == pytest.approx(complex(*case[name]), rel=rounding), name
    # Only inertia reacts on the base of a free actuator: at 10 Hz that is 1e-4 of the piezo
    # moment, the difference of two nearly equal ones.  So the base's motion is right to the
    # rounding of what the whole piezo moment would cause, and to 1e-10 of its own size.
    ((beam, length),) = tmm.sections(
        Device(bimorph=Bimorph(length=case["length"])), SUPPORT, Beam(), lossy=True
    )
    rate = 2 * np.pi * case["frequency"] * abs(beam.K) * case["voltage"]
    for name, whole in (
        ("v_base", rate / length / SUPPORT.lateral_stiffness),
        ("psidot_base", rate / SUPPORT.rotational_stiffness),
    ):
        exact = complex(*case[name])
        assert abs(got[name][0] - exact) < rounding * max(whole, abs(exact)), name
        assert abs(got[name][0] - exact) < 1e-10 * abs(exact), name


def test_lossless_clamped_statics(state_space):
    """Static tip displacement, blocked force and both capacitances of the clamped beam."""
    clamped = Support(kind="clamped")
    for stored in state_space["lossless_clamped_statics"]:
        port = model(stored["length"], np.zeros(1), lossy=False, support=clamped)
        r = driven(port, Ends())
        # a dozen roundings
        assert r.motion["w_tip"][0] == pytest.approx(stored["tip_displacement"], rel=1e-14)
        assert blocked_force(port, Ends(), 1.0)[0] == pytest.approx(
            stored["blocked_force"], rel=1e-14
        )
        assert r.effort["voltage"][0] == pytest.approx(stored["capacitance"], rel=1e-14)
        assert port["voltage", "voltage"][0] == pytest.approx(
            stored["straight_capacitance"], rel=1e-14
        )


LENGTH = 20e-3
EPS = np.finfo(float).eps


def beam_of(*, lossy=True):
    return section(Piece("bimorph", LENGTH), Device(), Beam(), lossy=lossy)


def test_everything_broadcasts():
    """Sections, lengths, supports, loads and frequencies in one call, each on its own axis, and
    some of all points at a time."""
    one, f = beam_of(), np.array([0.0, 100.0, 2e3])
    beam = replace(one, EI=one.EI * np.array([1.0, 1.1])[:, None, None, None])
    lengths, tips = np.array([5e-3, 20e-3])[:, None, None], np.array([0.0, 700.0])[:, None]
    base = (1e5, np.array([0.2, 0.3, 0.4]))
    got = mounted_response(beam, lengths, 2 * np.pi * f, base=base, tip=tips, chunk=5)
    assert got.w_tip.shape == got.charge.shape == got.error.shape == (2, 2, 2, 3)
    for i, j, k, n in np.ndindex(got.w_tip.shape):
        alone = mounted_response(
            replace(one, EI=beam.EI[i, 0, 0, 0]), lengths[j, 0, 0], 2 * np.pi * f[n],
            base=(1e5, base[1][n]), tip=tips[k, 0],
        )  # fmt: skip
        np.testing.assert_allclose(got.w_tip[i, j, k, n], alone.w_tip, rtol=20 * EPS)


def test_unheld_beam_has_no_static_response():
    """Without support or load nothing balances the motion at 0 Hz."""
    with pytest.raises(np.linalg.LinAlgError, match="nothing holds"):
        mounted_response(beam_of(), LENGTH, 0.0, base=(0.0, 0.0), tip=0.0)


def test_memory_stays_flat():
    """Beside inputs and results a sweep needs memory for one block, however long it is."""
    beam, extra = beam_of(), []
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
