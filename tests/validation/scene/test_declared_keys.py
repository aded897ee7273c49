"""Every key of a scene is what tests/data/scene_keys.json says a second time.

Scenes that people wrote rest on defaults, ranges and limits: none of them moves unseen.  Who
changes one changes both, with the reason in the commit.
"""

import json
from dataclasses import fields
from pathlib import Path

import pytest

from tactgen.geometry.device.parameters import Parameters
from tactgen.geometry.units import Unit
from tactgen.geometry.whole_number import WholeNumber
from tactgen.validation.scene.scene import Scene

DATA = Path(__file__).parents[2] / "data" / "scene_keys.json"


def declared(group, prefix=""):
    """Yield every key with its default, its range, and what it may be, as plain values."""
    for name, info in type(group).model_fields.items():
        value, key = getattr(group, name), f"{prefix}{name}"
        if isinstance(value, Parameters):
            yield from declared(value, f"{key}.")
            continue
        if name in ("frequency", "quantities"):  # long lists, each with tests of its own
            continue
        extra = info.json_schema_extra or {}
        row = {"default": list(value) if isinstance(value, tuple) else value}
        if extra.get("spread"):
            low, high, _reason, *absolute = extra["spread"]
            row |= {"range": [low, high], "absolute": bool(absolute and absolute[-1])}
        if extra.get("own"):
            row["own"] = extra["own"][1:]
        rules = (getattr(each, "func", each) for each in info.metadata)
        for rule in (rule for rule in rules if isinstance(rule, Unit | WholeNumber)):
            limits = {f.name: getattr(rule, f.name) for f in fields(rule)}
            row |= {n: list(v) if isinstance(v, tuple) else v for n, v in limits.items()
                    if v is not None and n not in ("kind", "example")}  # fmt: skip
        yield key, row


KNOWN = json.loads(DATA.read_text(encoding="utf-8"))


def test_no_key_is_added_or_lost():
    """A new key is written here, too."""
    assert [key for key, _ in declared(Scene())] == list(KNOWN)


def shown(value):
    """Return a value with twelve digits of its numbers: rounding is nobody's promise."""
    if isinstance(value, dict):
        return {name: shown(entry) for name, entry in value.items()}
    if isinstance(value, list):
        return [shown(entry) for entry in value]
    return f"{value:.12g}" if isinstance(value, float) else value


@pytest.mark.parametrize("group", sorted({key.rpartition(".")[0] for key in KNOWN}))
def test_keys_are_the_known_ones(group):
    """Default in SI, range, what it may be at all, and the unit in which people see it."""
    for key, row in declared(Scene()):
        if key.rpartition(".")[0] == group:
            assert shown(row) == shown(KNOWN[key]), key
