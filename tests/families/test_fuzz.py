"""Invocations at random, right and wrong: each ends with an answer or with one sentence.

Judged by the exit code, by what is on both streams, and where there is an answer by a second
model: lumped and tmm share a section's constants and nothing else about statics.
"""

import json
import math
import random
import signal

import pytest

from tactgen.geometry.units import Unit
from tactgen.validation.command_line.cli import main
from tactgen.validation.scene.keys import scene_keys
from tactgen.validation.scene.scene import Scene

#: Seconds after which an invocation is taken for endless.
ENDLESS = 120
#: Groups that a static answer about the lateral actuator may read, and some that it does not.
GROUPS = ("bimorph", "piezo", "shim", "glue", "support", "load", "drive", "beam", "coil", "gap")
JUNK = (
    "", " ", "0", "-1", "nan", "inf", "1e999", "-0.0", "abc", "1,5 mm", "1_0 mm", "20", "20 kg",
    "mm", "20 mm 3", "0x10 mm", "[1]", "{}", "true", "none", "µ", "1 µm", "20 mm; rm", "=", "5==5",
    "1e-300 m", "9" * 400, "%s", "\\", "'", '"', "uniform", "0 mm: 1 mm", "clamped", "rod", "mass",
    "٣ mm", "1 mm\n", "PZT-5H", "series", "+x", "all", "20 ± 1", "1/0 m", "m", "2**9 mm",
)  # fmt: skip
#: Faults of a command line that no command forgives, whatever else is on it.
FAULTS = (
    ["--nonsense"], ["--set"], ["--set", "a"], ["--set", "=1"], ["--set", "bimorph=1"],
    ["--set", "bimorph.lenght=1mm"], ["--model", "fem"], ["--model", ""], ["--quantity", "speed"],
    ["--quantity", ""], ["--frequency", "10:20"], ["--frequency", "-5"], ["--frequency", "nan"],
    ["--frequency", "1:2:3:4:5"], ["--frequency", "10:20:0"], ["--frequency", ""],
    ["two", "scenes"],
    ["--frequency", "10:20:1e9"], ["--frequency", "1 THz"], ["--model", "tmm,"], ["no-such.toml"],
)  # fmt: skip


def unit_of(key):
    """Return the unit of a scene key, None if it has none."""
    group, _, name = key.rpartition(".")
    fields = (type(getattr(Scene(), group)) if group else Scene).model_fields
    return next((m for m in fields[name].metadata if isinstance(m, Unit)), None)


def some_value(key, chance):
    """Return a value for a key: often one that can be meant, else too large, too small, junk."""
    unit = unit_of(key)
    if unit is None or chance.random() < 0.3:
        return chance.choice(JUNK)
    number, _, name = unit.example.partition(" ")
    factor = 10.0 ** (chance.uniform(-0.3, 0.3) if chance.random() < 0.6 else chance.gauss(0, 8))
    return f"{float(number) * factor:.6g} {name}".strip()


def some_settings(chance):
    keys = [key for key in scene_keys() if key.partition(".")[0] in GROUPS]
    for _ in range(chance.randint(0, 3)):
        key = chance.choice(keys)
        yield from ("--set", f"{key}={some_value(key, chance)}")


def asked(chance):
    """Return an invocation of solve, and whether it has a fault besides its settings."""
    scene = chance.choice(["paper", "prototype", "j1"])
    words = [scene, "--model", "lumped", "--model", "tmm", "--json", *some_settings(chance)]
    words += ["--quantity", "static_tip_displacement", "--quantity", "capacitance_free"]
    faulty = chance.random() < 0.15
    if faulty:
        words += chance.choice(FAULTS)
    return ["solve", *words], faulty


def judge(capsys, words, *, faulty):
    """Run one invocation and refuse what is neither an answer nor a sentence."""
    code = main(words)
    out, err = capsys.readouterr()
    lines = err.splitlines()
    assert all(line.startswith("tactgen: ") and len(line) < 1000 for line in lines), (words, err)
    if code == 2:
        assert out == "", words
        assert sum(not line.startswith("tactgen: warning: ") for line in lines) == 1, (words, err)
        return code
    assert (code, faulty) == (0, False), words
    check_answer(json.loads(out)["quantities"], words)
    return code


def check_answer(quantities, words):
    """Two models of the same statics agree: to rounding, on tapers to what their bars say."""
    values = {(q["name"], q["model"]): (q["value"], q["uncertainty"]) for q in quantities}
    for name in ("static_tip_displacement", "capacitance_free"):
        (a, bar_a), (b, bar_b) = values[name, "lumped"], values[name, "tmm"]
        assert math.isfinite(a), words
        # lumped takes the row element by element: 1e-6 for what rounding does to extremes
        assert abs(a - b) <= 1e-6 * abs(b) + bar_a + bar_b, (words, name, a, b)


@pytest.mark.parametrize("count", [60, pytest.param(1500, marks=pytest.mark.heavy)])
def test_any_invocation_ends_well(capsys, tmp_path, monkeypatch, count):
    """Answers and refusals, both in numbers; faults are never forgiven."""
    monkeypatch.chdir(tmp_path)
    chance = random.Random(count)

    def endless(*_):
        raise AssertionError("endless")

    before = signal.signal(signal.SIGALRM, endless)
    codes = []
    try:
        for _ in range(count):
            words, faulty = asked(chance)
            signal.alarm(ENDLESS)
            codes.append(judge(capsys, words, faulty=faulty))
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    assert min(codes.count(0), codes.count(2)) > 0.2 * count
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fault", FAULTS, ids=" ".join)
@pytest.mark.parametrize(
    "command",
    ["solve", *(pytest.param(c, marks=pytest.mark.heavy)
                for c in ("report", "plan", "design", "sensitivity", "export", "whatif", "view"))],
)  # fmt: skip
def test_no_fault_is_forgiven(capsys, tmp_path, monkeypatch, command, fault):
    """One sentence and exit code 2 from every command, nothing written."""
    monkeypatch.chdir(tmp_path)
    more = {"export": ["--step", "a.step"], "whatif": ["--vary", "drive.voltage=10V:20V:2"]}.get(
        command, []
    )
    code = main([command, "paper", *more, *fault])
    out, err = capsys.readouterr()
    assert (code, out) == (2, ""), fault
    assert err.count("\n") - err.count("tactgen: warning: ") == 1
    assert not list(tmp_path.iterdir())
