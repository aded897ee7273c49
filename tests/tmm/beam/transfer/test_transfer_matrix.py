"""The transfer-matrix model against the stored 60-digit state-space solution."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Load, Support
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.ports.elements import attach, ends_of
from tactgen.tmm.ports.multiport import respond, round_off

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
