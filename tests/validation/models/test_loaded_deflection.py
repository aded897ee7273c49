"""Deflection under load where the head may rock: linear at small voltages, refusals."""

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import respond
from tactgen.validation.models.backbone import (
    STATES,
    LoadedDeflection,
    five_port,
    held_head,
    loaded_deflection,
    voltage_for,
)
from tactgen.validation.scene.load import load_scene


def loaded(state):
    return load_scene("paper", ("support.kind=contact", "models=tmm", *STATES[state]))[0]


@pytest.mark.heavy
def test_at_50_v_the_head_takes_what_the_linear_support_does_not():
    """At 30 Hz, not activated: less than the linear 39 um, since the head rocks."""
    scene = loaded("not activated")
    head = held_head(scene)
    port = attach(five_port(scene, "tmm")(np.array([30.0])), scene.ends)
    linear = float(np.abs(respond(port, {"voltage": 50.0}).motion["w_tip"][0]))
    found = loaded_deflection(head, 50.0, (30.0, 30.1))
    assert 0.5 * linear < np.abs(found.displacement[0]) < 0.95 * linear


def test_the_fitted_line_is_even_in_frequency():
    """However unevenly the branch was met."""
    at = np.geomspace(10.0, 1000.0, 40)
    line = LoadedDeflection(at, (5e-5 - 3e-8 * at).astype(complex), "")
    assert line.fitted_slope == pytest.approx(-3e-8, rel=1e-9)


def test_what_is_not_reached_is_said():
    """One sentence with the largest voltage allowed."""
    with pytest.raises(InputError, match=r"1e\+06 um at 60 Hz is not reached with 0.001 V"):
        voltage_for(held_head(loaded("held")), 60.0, 1.0, 1e-3)
