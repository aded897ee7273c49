"""Bimorphs at random, from foil to block, on whatever holds and loads them: every number by one
model within the bars of another that shares no numerics with it, or one sentence of refusal."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import load_scene

STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
DYNAMIC = ("short_circuit_frequencies", "coupling_factor", "tip_displacement", "admittance")


def sizes(low, high, unit):
    """Values even on a logarithmic scale, as a user writes them."""
    exponents = st.floats(np.log10(low), np.log10(high))
    return exponents.map(lambda e: f"{10.0**e:.5g} {unit}")


#: What a scene may say of a bimorph that beam theory takes; each key is set or left out.
KEYS = {
    "bimorph.width": sizes(0.2, 10.0, "mm"),
    "bimorph.tab_length": sizes(0.05, 5.0, "mm"),
    "bimorph.bare_below": sizes(0.01, 2.0, "mm"),
    "bimorph.bare_above": sizes(0.01, 2.0, "mm"),
    "bimorph.glue_thickness": sizes(1e-3, 0.1, "mm"),
    "bimorph.wiring": st.sampled_from(["parallel", "series"]),
    "piezo.material": st.sampled_from(["M1876", "PZT-5H", "PZT-5A"]),
    "piezo.quality_factor": st.sampled_from(["5", "50", "1000"]),
    "shim.material": st.sampled_from(["brass", "titanium"]),
    "support.kind": st.sampled_from(["clamped", "spring"]),
    "support.rotational_stiffness": sizes(1e-3, 1e3, "N*m/rad"),
    "support.rotational_damping": sizes(1e-9, 1e-3, "N*m*s/rad"),
    "load.kind": st.sampled_from(["none", "mass", "spring_damper", "finger"]),
    "load.mass": sizes(1e-2, 1e4, "mg"),
    "load.stiffness": sizes(1e-1, 1e6, "N/m"),
    "load.damping": sizes(1e-5, 1e1, "N*s/m"),
    "drive.voltage": sizes(1e-3, 50.0, "V"),
    "modes": st.sampled_from(["1", "3", "6"]),
}


@st.composite
def scenes(draw):
    """Overrides of the scene prototype."""
    layers = {
        "bimorph.length": draw(sizes(2.0, 80.0, "mm")),
        "bimorph.piezo_thickness": draw(sizes(0.01, 1.0, "mm")),
        "bimorph.shim_thickness": draw(sizes(0.01, 1.0, "mm")),
        "frequency": ", ".join(draw(st.lists(sizes(1.0, 2e4, "Hz"), min_size=1, max_size=3))),
    }
    more = draw(st.lists(st.sampled_from(sorted(KEYS)), max_size=6, unique=True))
    found = layers | {key: draw(KEYS[key]) for key in more}
    return [f"{key}={value}" for key, value in found.items()]


def check(overrides):
    """Return whether there was an answer; refuse one that no second model bears out."""
    try:
        scene, _ = load_scene("prototype", overrides)
        found = solve(scene, ("lumped", "tmm", "beam"), (*STATIC, *DYNAMIC))
    except InputError as error:
        sentence = str(error)
        assert 0 < len(sentence) < 1000, overrides
        assert "\n" not in sentence, overrides
        return False
    for name in (*STATIC, *DYNAMIC):
        first = found.get(name, "tmm")
        second = found.get(name, "beam")
        others = (second, found.get(name, "lumped")) if name in STATIC else (second,)
        assert np.isfinite(first.value).all(), (name, overrides)
        for other in others:
            apart = np.abs(first.value - other.value)
            bars = first.uncertainty + other.uncertainty
            # lumped takes the row element by element: 1e-6 for what rounding does to extremes
            slack = 1e-6 if other.model == "lumped" else 1e-12
            inside = apart <= bars + slack * np.abs(first.value)
            assert inside.all(), (name, other.model, apart, bars, first.value, overrides)
    return True


@given(scenes())
@settings(max_examples=16)
def test_a_second_model_bears_out_any_answer(overrides):
    """Finite, and within both bars; or one sentence."""
    check(overrides)


@pytest.mark.heavy
@given(scenes())
@settings(max_examples=2000)
def test_a_second_model_bears_out_two_thousand_answers(overrides):
    """The same of many more."""
    check(overrides)
