"""Scenes at random, from foil to block, on whatever holds, presses and drives them: every number
by one model within the bars of another that shares no numerics with it, or one sentence."""

import secrets

import numpy as np
import pytest

from tactgen.validation.evidence import stress_driven as at_random
from tactgen.validation.evidence.judgement import Family, Judged, run_parts
from tactgen.validation.scene.load import load_scene


def judge(pair, overrides):
    """Return the answers of one scene that are beyond their bars, and what was judged."""
    family = Family("family")
    pair.add(family, "here", load_scene(pair.scene, overrides)[0])
    names = {one.which.partition(" ")[0] for one in family.answers}
    return [one for one in family.answers if not one.within], names


def test_a_second_model_bears_out_any_answer():
    """Bimorphs and machines; `tactgen stress --only random` draws two thousand, anew each time."""
    (part,) = run_parts("stress", ["random"], 2026, lambda _: None, devices=4)
    assert [row.worst for row in part.rows if not row.holds] == []
    assert [row.quantity for row in part.rows] == ["generator", "prototype", "all"]
    assert min(row.count for row in part.rows) > 10


@pytest.mark.heavy
def test_a_second_model_bears_out_two_thousand_answers():
    """The same of many more."""
    (part,) = run_parts("stress", ["random"], secrets.randbelow(10**9), lambda _: None)
    assert [(part.seed, row.worst) for row in part.rows if not row.holds] == []


#: Pieces so short that hardly a digit of the ports' stiffness is left when it is condensed; a thin
#: tab with one element in both meshes; a rod that stands on nothing but 5 µN of preload.
FOUND = {
    "bare above": (
        at_random.MACHINE,
        ["bimorph.bare_above=0.011281 mm", "bimorph.bare_below=1.4455 mm", "frequency=92.522 Hz"],
    ),
    "thin tab": (
        at_random._BEAM,
        ["bimorph.length=44.307 mm", "bimorph.piezo_thickness=0.60937 mm",
         "bimorph.shim_thickness=0.10029 mm", "bimorph.tab_length=2.7346 mm",
         "shim.material=brass", "piezo.material=PZT-5H", "frequency=18600 Hz"],
    ),
    "hardly any preload": (
        at_random.MACHINE,
        ["bimorph.length=7.0019 mm", "bimorph.piezo_thickness=0.68955 mm",
         "bimorph.shim_thickness=0.21824 mm", "spring.preload=0.0048464 mN",
         "frequency=71.694 Hz"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("which", FOUND)
def test_what_was_found_at_random(which):
    """Errors of 1.1 to 9 bars, and a coupling factor of 0 that was sure of it."""
    beyond, names = judge(*FOUND[which])
    assert beyond == []
    assert names == set(FOUND[which][0].quantities)


def test_what_breaks_off_or_never_ends_fails(monkeypatch):
    """An exception that is no refusal, and a scene that takes too long, each name their scene."""

    def broken(*_):
        raise TypeError("no such thing")

    monkeypatch.setattr(at_random, "load_scene", broken)
    monkeypatch.setattr(at_random, "any_scene", lambda _: ("prototype", ["modes=1"]))
    monkeypatch.setattr(at_random, "_ENDLESS", -1.0)
    found = at_random.judge_random(np.random.default_rng(0))
    assert [one.where for one in found] == [
        "prototype modes=1: TypeError: no such thing", "prototype modes=1: endless",
    ]  # fmt: skip
    assert all(np.isinf(one.error) for one in found)


def test_a_stopped_run_goes_on(monkeypatch, own_store):
    """Scenes of a seed are judged once, and told in their order; another seed draws others."""
    judged, told = [], []

    def made_up(rng):
        name, overrides = at_random.any_scene(rng)
        judged.append(f"{name} {'; '.join(overrides)}")
        return [Judged(judged[-1], name, 1e-9, 1e-8)]

    def stopped(words):
        if words.startswith("random: device 7 "):
            raise KeyboardInterrupt

    def whole(seed):
        (part,) = run_parts("stress", ["random"], seed, told.append, quick=True)
        return [one.where for one in part.answers]

    monkeypatch.setattr(at_random, "judge_random", made_up)
    with pytest.raises(KeyboardInterrupt):
        run_parts("stress", ["random"], 5, stopped, quick=True)
    assert len(judged) == 6
    found = whole(5)
    assert found == judged
    assert len(found) == len(set(found)) == 16
    assert told == [f"random: device {number} of 16" for number in range(1, 17)]
    assert whole(5) == found
    assert not set(whole(6)) & set(found)
