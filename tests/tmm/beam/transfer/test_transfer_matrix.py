"""The transfer-matrix model against the stored 60-digit state-space solution."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Load, Support
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.beam.modes import bending_frequencies
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


def case_name(case):
    return f"{case['length'] * 1e3:g} mm {case['load']} {case['frequency']:g} Hz"


def test_all_cases_are_there(state_space):
    """Two lengths, free and loaded, 10 Hz to 2 kHz: eighteen cases."""
    assert len({case_name(case) for case in state_space["cases"]}) == 18


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


def test_resonance_peak(state_space):
    """The 14 mm actuator peaks at 781.609 Hz with 22.795 mm/s per volt."""
    peak = state_space["peak"]

    def speed(f):
        f = np.array([f])
        r = driven(model(peak["length"], f), ends_of(SUPPORT, Load(kind="none")))
        return float(2 * np.pi * f[0] * np.abs(r.motion["w_tip"][0]))

    top = minimize_scalar(
        lambda f: -speed(f), bounds=(700.0, 850.0), method="bounded", options={"xatol": 1e-7}
    )
    # a maximum's place shows to the square root of machine precision only, 1.5e-8 · 780 Hz
    assert top.x == pytest.approx(peak["frequency"], abs=5e-5)
    assert -top.fun == pytest.approx(peak["tip_speed"], rel=1e-13)
    assert (round(top.x, 3), round(-top.fun * 1e3, 3)) == (781.609, 22.795)


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


def test_printed_speeds_of_the_free_prototype():
    """|v| of the free 14 mm actuator at 1 V, four digits, 10 Hz to 2 kHz."""
    f = np.array([10.0, 100.0, 500.0, 1000.0, 2000.0])
    r = driven(model(14e-3, f), ends_of(SUPPORT, Load(kind="none")))
    speeds = 2 * np.pi * f * np.abs(r.motion["w_tip"])
    np.testing.assert_allclose(
        speeds, [3.052e-5, 3.091e-4, 2.333e-3, 3.008e-3, 6.567e-4], rtol=2e-4
    )


def test_deflections_under_the_finger():
    """Loaded 20 mm actuator at 50 V: 45.37 µm at 10 Hz, falling to 10.30 µm at 500 Hz."""
    f = np.array([10.0, 100.0, 250.0, 500.0])
    r = driven(model(20e-3, f), ends_of(SUPPORT, Load()), 50.0)
    np.testing.assert_allclose(
        np.abs(r.motion["w_tip"]) * 1e6, [45.37, 31.15, 21.42, 10.30], rtol=3e-4
    )


def test_resonance_and_antiresonance_from_the_ports():
    """Undamped, the driving-point charge has its poles and zeros at the stored resonances."""
    # Q/U of the free, clamped beam is infinite at short-circuit, zero at open-circuit resonance
    f = np.array([2126.3489321047098, 2234.0894387245760])
    for sign in (-1e-9, 1e-9):
        port = model(14e-3, f * (1 + sign), lossy=False)
        free = driven(port, Ends()).effort["voltage"].real
        if sign < 0:
            before = free
    assert (np.sign(before) != np.sign(free)).all()
    assert np.abs(before[0]) > 1e5 * np.abs(before[1])


def test_sweep_equals_single_points():
    """A frequency may be asked for alone or within a sweep; a scalar will do."""
    f = np.geomspace(10.0, 2e4, 7)
    sweep = model(20e-3, f).stiffness
    for i, one in enumerate(f):
        np.testing.assert_allclose(model(20e-3, one).stiffness[0], sweep[i], rtol=1e-14)


def test_what_holds_the_actuator():
    """Nothing reacts on a free actuator at rest: tab and rod leave its bending as it is.

    Its first mode is lower the more compliant its hold.
    """
    clamped, rod = Support(kind="clamped"), Support(kind="rod")
    bending, first = [], []
    for tab, support in ((0.0, clamped), (1.6e-3, clamped), (2e-3, rod)):
        device = Device(bimorph=Bimorph(tab_length=tab))
        port = tmm.multiport(device, support, Beam(), np.zeros(1), lossy=False)
        bending.append(driven(port, Ends()).motion["w_tip"][0].real)
        pieces = tmm.sections(device, support, Beam(), lossy=False)
        first.append(bending_frequencies(pieces, Ends(), 1, open_circuit=False)[0])
    # rounding times the condition number of the ports of a row held by nothing, 1e4
    np.testing.assert_allclose(bending, bending[0], rtol=1e-10)
    # the slot takes 0.4 mm of the 2 mm tab, and its glue gives way
    assert first[0] > first[1] > first[2]
