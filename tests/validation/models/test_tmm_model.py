"""The transfer-matrix model's responses: the closed form it answers with, and its witness."""

import numpy as np
import pytest

from tactgen.tmm.beam.span import dynamic_stiffness
from tactgen.tmm.beam.transfer_matrix import multiport, sections
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import in_series, respond, round_off
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.cases import exact_beam as reference
from tactgen.validation.scene.load import load_scene

OF_TIP = ("tip_displacement", "tip_rotation", "input_current")


@pytest.mark.parametrize(("kind", "wiring"), [("clamped", "series"), ("spring", "parallel")])
def test_closed_form_against_elimination(kind, wiring):
    """What is answered and the elimination from D(Ω) agree within their two bars."""
    scene, _ = load_scene("paper", [f"support.kind={kind}", f"bimorph.wiring={wiring}"])
    solution = solve(scene, ("tmm",), OF_TIP, modelling=False)
    f, voltage = np.array(scene.frequency), scene.drive.voltage
    port = multiport(scene.device, scene.support, scene.beam, f)
    port = in_series(port) if wiring == "series" else port
    mounted = attach(port, scene.ends)
    witness = respond(mounted, {"voltage": voltage})
    current = 2j * np.pi * f * witness.effort["voltage"]
    values = (witness.motion["w_tip"], witness.motion["psi_tip"], current)
    for name, value in zip(OF_TIP, values, strict=True):
        found = solution.get(name, "tmm")
        bars = found.error + round_off(mounted) * np.abs(value)
        assert (np.abs(found.value - value) <= bars).all(), name


def test_no_digit_lost_where_the_held_beam_resonates():
    """At a pole of D(Ω), almost without losses, the answer is as good as beside it."""
    changes = ["support.kind=clamped", "load.kind=none", "piezo.quality_factor=1e9"]
    scene, _ = load_scene("paper", changes)
    ((beam, length),) = sections(scene.device, scene.support, scene.beam, lossy=True)
    low, high = 6500.0, 6600.0
    while (middle := 0.5 * (low + high)) not in (low, high):
        sign = dynamic_stiffness(beam, length, 2 * np.pi * middle)[0, 2].real
        low, high = (middle, high) if sign < 0.0 else (low, middle)
    at = {"frequency": (low, 1.001 * low)}
    found = solve(scene.model_copy(update=at), ("tmm",), OF_TIP[:1])
    answer = found.get("tip_displacement", "tmm")
    exact = reference.dynamic_stiffness(reference.constants(beam), length, 2 * np.pi * low)
    w_tip, _, _ = reference.tip_motion(exact, None, 0.0)
    error = reference.relative_error(answer.value[0], scene.drive.voltage * w_tip)
    assert error * abs(answer.value[0]) <= answer.error[0]
    at_pole, beside = answer.error / np.abs(answer.value)
    assert at_pole == pytest.approx(beside, rel=0.1)
