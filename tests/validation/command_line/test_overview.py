"""What solve prints unless asked for more, help, version and completion."""

import json
import re
import subprocess

import pytest

from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.command_line.cli import main
from tactgen.validation.command_line.overview import print_overview
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.files import built_in_scenes
from tactgen.validation.scene.load import load_scene

PREFIXES = {"p": 1e-12, "n": 1e-9, "µ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3}


def run(capsys, *arguments):
    code = main(list(arguments))
    return code, *capsys.readouterr()


def test_one_screen_shows_what_json_holds(capsys):
    """Models side by side, each number in a unit with its prefix, to the five digits shown."""
    models = ("--model", "lumped", "--model", "tmm", "--set", "modes=1", "--frequency", "10:900:8")
    code, out, _ = run(capsys, "solve", *models)
    lines = out.splitlines()
    assert code == 0
    assert len(lines) <= 28
    assert lines[0].startswith("Conditions: base on springs")
    assert lines[1].split() == ["lumped", "tmm"]
    assert "--quantity all" in out
    values = re.sub(r"\(.*?\)|±", "", out)
    assert not re.search(r"\d(e-|e\+)\d", values)  # units have prefixes instead
    names = ("static_tip_displacement", "capacitance_free", "coupling_factor")
    asked = [word for name in names for word in ("--quantity", name)]
    _, text, _ = run(capsys, "solve", *models, *asked, "--json")
    found = {(q["name"], q["model"]): q["value"] for q in json.loads(text)["quantities"]}
    for name in names:
        (line,) = (line for line in lines if line.startswith(QUANTITIES[name].label))
        shown = re.findall(r"  ([0-9.]+)(?: (\S+))? \(", line)
        own = QUANTITIES[name].unit
        for model, (number, unit) in zip(("lumped", "tmm"), shown, strict=True):
            scale = PREFIXES[unit.removesuffix(own)] if own not in ("", "1") else 1.0
            assert float(number) * scale == pytest.approx(found[name, model], rel=5e-5)


def test_the_machine_is_one_screen_in_parts(capsys):
    """Though its scene names quantities: bimorph, normal actuator, machine, each its models."""
    scene, _ = load_scene("generator", ["models=tmm,network", "coil.supply=voltage", "modes=1"])
    print_overview(solve(scene))
    parts = [part.splitlines() for part in capsys.readouterr().out.split("\n\n")]
    assert [re.split(r"  +", part[0]) for part in parts[:3]] == [
        ["bimorph", "tmm"], ["normal actuator", "network"], ["machine, small motions", "tmm"],
    ]  # fmt: skip
    assert sum(map(len, parts)) <= 32
    assert not re.search(r"\d(e-|e\+)\d", re.sub(r"\(.*?\)", "", str(parts)))
    # what nothing moves is named once and fills no rows
    (idle,) = (line for line in parts[2] if line.startswith("0 "))
    assert idle.endswith(": axial tip per voltage, axial tip per current, lateral tip per current")


def test_all_values_are_one_option_away(capsys):
    """The table has complex values as magnitude and phase, one notation for all."""
    _, out, _ = run(
        capsys, "solve", "--model", "tmm", "--quantity", "tip_velocity", "--frequency", "100,200"
    )
    rows = out.splitlines()[3:]
    assert len(rows) == 2
    assert all(re.search(r"[0-9.]+ mm/s ∠ -?[0-9.]+°", row) for row in rows)


def test_version_and_examples(capsys):
    """On stdout, exit code 0."""
    code, out, err = run(capsys, "--version")
    assert (code, err) == (0, "")
    assert re.fullmatch(r"tactgen \d+\.\d+\S*\n", out)
    assert "examples:" in run(capsys, "--help")[1]


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [(["slove"], "solve"), (["solve", "--quantiy", "x"], "--quantity"),
     (["design", "--aim", "shortes"], "shortest")],
)  # fmt: skip
def test_misspelt_commands_options_and_choices(capsys, arguments, meant):
    """The nearest one is named."""
    code, out, err = run(capsys, *arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f'did you mean "{meant}"' in err


def test_a_shell_completes(capsys):
    """bash itself completes commands, scenes, models and keys with the script."""
    code, script, _ = run(capsys, "completion")
    assert code == 0
    for words, expected in (
        (["tactgen", "sol"], {"solve"}), (["tactgen", "solve", "pa"], {"paper"}),
        (["tactgen", "solve", "--model", "net"], {"network"}),
        (["tactgen", "solve", "--set", "bimorph.wi"],
         {"bimorph.width=", "bimorph.width_profile=", "bimorph.wiring="}),
        (["tactgen", "report", ""], set(built_in_scenes())),
    ):  # fmt: skip
        typed = " ".join(f"'{word}'" for word in words)
        ask = f"{script}\nCOMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; _tactgen\n"
        ask += 'printf "%s\\n" "${COMPREPLY[@]}"'
        done = subprocess.run(["bash", "-c", ask], capture_output=True, text=True, check=True)
        assert set(done.stdout.split()) >= expected, done.stderr
