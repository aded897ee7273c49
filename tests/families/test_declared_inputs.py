"""Stages read what they declare and no more: what is kept under a key is right for that key."""

from typing import Literal, get_args, get_origin

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Parameters
from tactgen.geometry.device.profile import Profile
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models import backbone as states
from tactgen.validation.models.backbone import held_head, in_state
from tactgen.validation.scene.inputs import values_read
from tactgen.validation.scene.keys import scene_keys
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.whatif.point_answers import question

#: What of a scene no stage reads: whose it is, and what is asked.
ASKED = ("name", "description", "models", "quantities")


def other(group, name):
    """Return another value of a parameter, close enough to be as good a device."""
    value, info = getattr(group, name), type(group).model_fields[name]
    if isinstance(value, Profile):
        return None
    if get_origin(info.annotation) is Literal:
        # a table wants a file of its own
        others = (c for c in get_args(info.annotation) if c not in (value, "table"))
        return next(others, None)
    if name == "curve":
        return "linear"
    if name == "material":
        return "PZT-5H"
    if name == "frequency":
        return tuple(1.01 * f for f in value)
    if isinstance(value, int):
        return value + 1
    if isinstance(value, float):
        return 1.001 * value or 1e-6
    return 1e10 if name == "transverse_modulus" else None


def changed(scene, keys):
    """Return the scene with another value of each of the keys."""
    for key in keys:
        group, _, name = key.rpartition(".")
        owner = getattr(scene, group) if group else scene
        owner = owner.model_copy(update={name: other(owner, name)})
        scene = scene.model_copy(update={group: owner}) if group else owner
    return scene


def varied(scene, model=""):
    """Return the keys of which there is another value that the model takes."""
    found = []
    for key in scene_keys():
        group, _, name = key.rpartition(".")
        owner = getattr(scene, group) if group else scene
        machine = scene.support.kind == "contact"  # its quantities want that kind
        if key in ASKED or (machine and key == "support.kind"):
            continue
        if key == "measurement.below_tip" and model == "lumped":  # which refuses it
            continue
        if key == "spring.eccentricity_angle" and scene.name == "display":  # which refuses it
            continue
        if other(owner, name) is not None:
            found.append(key)
    return found


STATIC, MODES, DRIVEN = "static_tip_displacement", "open_circuit_frequencies", "tip_displacement"
LISTED = "bimorph.layers=PZT-5A 0.2 mm +x; glue 20 um; shim 0.2 mm"
SOLID = ("mesh.level=2", "modes=2")
HELD = ("support.kind=contact", "coil.current=0mA")
PAIR = ("display.rows=2", "display.columns=1", "bimorph.tab_length=2mm")
CASES = [
    # what these cost is little; what all models of the bimorph share is tried with them
    *(("paper", (), m, q) for m in ("lumped", "tmm", "beam") for q in (STATIC, MODES, DRIVEN)),
    ("j1", (LISTED, "modes=2"), "tmm", STATIC),
    ("j1", (LISTED, *SOLID), "solid", STATIC),
    ("bimorph_on_rod", ("modes=2",), "tmm", DRIVEN),
    ("paper", HELD, "tmm", "short_circuit_frequencies"),
    ("paper", HELD, "tmm", "axial_tip_per_current"),
    ("display", PAIR, "tmm", "crosstalk_largest"),
    ("display", PAIR, "lumped", "tuned_spread"),
    ("j1", SOLID, "solid", STATIC),
    pytest.param("j1", SOLID, "solid", "coupling_factor", marks=pytest.mark.heavy),
    ("j1", SOLID, "solid", DRIVEN),
    ("reluctance", (), "network", "magnetic_force"),
    ("reluctance", (), "network", "pull_in_current"),
    ("reluctance", ("coil.current=50mA",), "network", "rod_position"),
    ("display", ("bimorph.tab_length=2mm",), "network", "pull_one_driven"),
    ("reluctance", ("accuracy=10%",), "axisymmetric", "magnetic_force"),
    pytest.param("reluctance", ("accuracy=10%",), "magnetic3d", "magnetic_force",
                 marks=pytest.mark.heavy),
]  # fmt: skip


@pytest.mark.usefixtures("coarse_bricks")
@pytest.mark.parametrize(("name", "overrides", "model", "quantity"), CASES)
def test_a_key_stands_for_all_that_is_read(
    name, overrides, model, quantity, tmp_path_factory, monkeypatch
):
    """Everything that does not change a stage's key is changed at once: the stage's result is
    taken over, and what follows is bit for bit what a cold run of the changed scene gives."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("kept")))
    scene, _ = load_scene(name, ["frequency=100", *overrides])
    asked = (model,), (quantity,)
    keys = make_plan(scene, *asked).keys
    alone = {k: make_plan(changed(scene, [k]), *asked).keys for k in varied(scene, model)}
    first = solve(scene, *asked)
    tried = set()
    for stage, key in keys.items():
        unread = tuple(k for k in alone if alone[k].get(stage) == key)
        assert 15 < len(unread) < len(alone)
        if unread in tried:
            continue
        tried.add(unread)
        also = changed(scene, unread)
        assert make_plan(also, *asked).keys[stage] == key
        ran = []
        again = solve(also, *asked, reuse=first, announce=ran.append)
        assert stage not in ran
        monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("cold")))
        cold = solve(also, *asked)
        (kept,), (fresh,) = again.quantities, cold.quantities
        np.testing.assert_array_equal(kept.value, fresh.value, err_msg=stage)
        np.testing.assert_array_equal(kept.error, fresh.error, err_msg=stage)


def test_another_value_is_another_scene():
    """The test above varies nearly every key, each to a value of its own."""
    scene = Scene()
    keys = varied(scene)
    assert len(keys) > 0.85 * len(scene_keys())
    for key in keys:
        assert changed(scene, [key]) != scene
    assert {key.split(".")[0] for key in keys} >= {
        name for name, value in scene if isinstance(value, Parameters)
    } - {"threshold"}  # the paper's, or a table


@pytest.mark.parametrize(
    ("name", "model", "quantities"),
    [
        ("paper", "beam", ("admittance", "coupling_factor", "dynamic_stiffness")),
        ("reluctance", "network", ("magnetic_force", "pull_in_current")),
    ],
)
def test_an_answer_stands_for_all_that_is_read(name, model, quantities):
    """Everything that does not change what a point of a study goes by is changed at once: numbers,
    bars and warnings are the same to the last bit."""
    scene, _ = load_scene(name, ["frequency=100,500"])
    inputs = question(scene, model, quantities, {}).inputs
    unread = [
        key for key in varied(scene, model)
        if question(changed(scene, [key]), model, quantities, {}).inputs == inputs
    ]  # fmt: skip
    assert len(unread) > 20
    first, also = (solve(s, (model,), quantities) for s in (scene, changed(scene, unread)))
    assert first.warnings == also.warnings
    for a, b in zip(first.quantities, also.quantities, strict=True):
        np.testing.assert_array_equal(a.value, b.value)
        np.testing.assert_array_equal(a.error, b.error)


def test_what_is_kept_of_growing_amplitudes_goes_by_all_that_it_reads():
    """All keys at once that leave its inputs as they are leave the head and its stop, too."""
    scene, _ = load_scene("paper", ["support.kind=contact", "load.kind=finger"])
    held = in_state(scene, "held")
    first = values_read(held, states._READS)
    idle = [k for k in varied(held) if values_read(changed(held, [k]), states._READS) == first]
    assert "bimorph.length" not in idle
    assert "frequency" in idle
    one, other = (held_head(each) for each in (held, changed(held, idle)))
    assert (one.place, one.support) == (other.place, other.support)
    f = np.array([0.0, 300.0])
    assert np.array_equal(one.attached(f), other.attached(f))
    assert np.array_equal(one.oscillator.linear(f), other.oscillator.linear(f))
    assert np.array_equal(one.oscillator.static, other.oscillator.static)
