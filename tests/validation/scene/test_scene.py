"""Scenes: what is accepted, what is refused and in which words."""

import os
import re

import pytest

from tactgen.geometry.device.magnetisation import TEAM20
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.errors import InputError
from tactgen.validation.scene.files import NEUTRAL, built_in_scenes, parse_frequencies
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.scene.template import template
from tactgen.validation.scene.warnings import idle, scene_warnings


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("bimorph.length=25", ['bimorph.length = "25"', "has no unit", '"20 mm"']),
        ("bimorf.length=25mm", ['did you mean "bimorph.length"']),
        ("bimorph=25mm", ["is a group"]),
        ("piezo.material=PZT-9", ['"PZT-9" is not in the library', "PZT-5H"]),
        ("support.kind=glued", ["support.kind", "'clamped'", "'rod' or 'contact'"]),
        ("quantities=tip_speed", ['quantity "tip_speed" is unknown', "did you mean"]),
        ("piezo.d31=210 pC/N", ["d31 = 2.1e-10 m/V", "; write d31 with a minus"]),
        ("mesh.level=6", ["mesh.level", "whole number from 0 to 5"]),
        ("coil.outer_radius=1mm", ["coil.outer_radius", "sleeve.inner_radius"]),
        ("gap=0 mm", ["gap", "greater than 0 mm", '"0.2 mm"']),
        ("bimorph.length=1e300 m", ["bimorph.length", "from 0.001 mm to 100000 mm"]),
        ("piezo.eps33=1000", ["piezo.eps33 = 1000", "negative energy", "raise piezo.eps33"]),
        ("support.kind=sprng", ['did you mean "spring"']),
        ("modes=٣", ['modes = "٣"', "whole number from 1 to 20", "write for example 4"]),
        ("name=a\nb", ["name = ", "one line"]),
        (f"bimorph.length={'9' * 9000}", ["bimorph.length", "…", '"20 mm"']),
    ],
)
def test_bad_values_are_refused_in_one_sentence(override, words):
    """The sentence names the key, the value and the remedy."""
    with pytest.raises(InputError) as caught:
        load_scene("paper", [override])
    sentence = str(caught.value)
    assert all(word in sentence for word in words), sentence
    assert "\n" not in sentence


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["bimorph.width=2.3mm"], ["bimorph.width = 2.3 mm", "wider than the rod allows", "slot"]),
        (["rod.slot_depth=0.6mm"], ["rod.slot_depth", "rod.head_thickness"]),
        (["bimorph.tab_length=0.2mm"], ["too short for the rod's slot", "0.4 mm"]),
        (["glue.thickness=0.2mm"], ["wider than the rod allows", "bond line"]),
        (["rod.length=3mm"], ["rod.length", "flange"]),
    ],
)
def test_parts_that_do_not_fit_are_refused(overrides, words):
    """A generator that cannot be built is refused before any work."""
    with pytest.raises(InputError) as caught:
        load_scene("bimorph_on_rod", overrides)
    assert all(word in str(caught.value) for word in words), caught.value


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"[bimorph\nlength=", ["is not valid TOML"]),
        (b"\xff\xfe\x00", ["cannot be read", "UTF-8"]),
        (b"[bimorph]\nlength = 20\n", ["bimorph.length = 20 has no unit"]),
        (b"bimorph = 3\n", ["is a group"]),
        (b"[bimorph.length]\nvalue = 3\n", ["bimorph.length.value", "unknown"]),
        (b"[bimorf]\n", ['"bimorf" is unknown', 'did you mean "bimorph"']),
        (b"'bimorph.length' = '3 mm'\n", ['did you mean "bimorph.length"']),
        (b"[piezo]\nmaterial = ['a']\n", ["piezo.material = ['a']", "not in the library"]),
        (b"models = []\n", ["models = []", "names nothing", "lumped"]),
        (b"models = ['tmm', 3]\n", ["models", "not a list of names"]),
        (b"frequency = []\n", ["frequency = []", "no frequency"]),
        (b"frequency = true\n", ["frequency", "not a frequency"]),
        (b"name = 3\n", ["name = 3", "not text", "quotes"]),
        (b"modes = true\n", ["modes", "whole number"]),
        (b"gap = 0x" + b"f" * 9000 + b"\n", ["gap", '"0.2 mm"']),
        (b"gap = " + b"1" * 5000, ["not valid TOML"]),
    ],
)
def test_bad_files_are_refused_in_one_sentence(tmp_path, content, words):
    """Unreadable files and files with wrong content."""
    path = tmp_path / "my.toml"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_scene(str(path))
    assert all(word in str(caught.value) for word in words), caught.value
    assert "\n" not in str(caught.value)


def test_byte_order_mark_and_empty_groups_are_accepted(tmp_path):
    """Files of Windows editors, and groups that say nothing."""
    path = tmp_path / "my.toml"
    path.write_bytes(b"\xef\xbb\xbfgap = '0.3 mm'\n[bimorph]\n")
    scene, origins = load_scene(str(path))
    assert (scene.gap, list(origins)) == (0.3e-3, ["gap"])


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("x" * 5000, "neither a readable file nor a built-in scene"),
        ("a\0b", "neither a readable file nor a built-in scene"),
        ("mine", 'scene "mine" is a folder; name a scene file in it'),
        ("pipe", "a pipe or a device"),
        ("/dev/zero", "a pipe or a device"),
    ],
)
def test_names_that_are_no_file_are_refused(tmp_path, monkeypatch, name, words):
    """Too long for the file system, unprintable, a folder; what never ends is not waited for."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine").mkdir()
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match=words) as caught:
        load_scene(name)
    assert len(str(caught.value)) < 300
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("name", "overrides", "words"),
    [
        ("paper", ["load.kind=spring_damper"], ["load.stiffness = 0 N/m", "free tip"]),
        (
            "paper", ["load.kind=spring_damper", "load.stiffness=1 N/m", "load.mass=1 mg"],
            ["load.mass = 1 mg", 'set load.kind = "mass"'],
        ),
        ("paper", ["load.kind=mass"], ["load.mass = 0 mg", "free tip"]),
        (
            "paper", ["support.kind=clamped", "support.lateral_stiffness=2e6 N/m"],
            ["support.lateral_stiffness = 2000000 N/m", 'support.kind = "clamped"'],
        ),
        (
            "paper", ["mesh.time_limit=60 s", "models=solid"],
            ["mesh.time_limit = 60 s", "--set models=cad"],
        ),
        (
            "paper", ["mesh.kind=tetwild", "models=network"],
            ["mesh.kind = tetwild", "--set models=magnetic3d"],
        ),
        ("paper", ["mesh.level=2", "accuracy=0.01"], ["accuracy = 0.01", "mesh.level = 2"]),
        ("reluctance", ["frequency=10,20"], ["frequency = 2 values", "--set models=tmm"]),
        ("reluctance", ["rod.density=7800 kg/m^3"], ["rod.density", 'support.kind = "rod"']),
        (
            "reluctance", ["steel.relative_permeability=500"],
            ['curve = "team20"', '"linear" to use'],
        ),
        ("reluctance", ["coil.resistivity=2e-8 ohm*m"], ["on any quantity", "tactgen report"]),
    ],
)  # fmt: skip
def test_settings_without_effect_are_named(name, overrides, words):
    """Each key that no model asked for reads, or that conflicts with a kind, gets a sentence."""
    (warning,) = scene_warnings(*load_scene(name, overrides))
    assert all(word in warning for word in words), warning


@pytest.mark.parametrize("name", built_in_scenes())
def test_settings_with_effect_are_not_warned_of(name):
    """The built-in scenes, and keys that go with their kind."""
    assert scene_warnings(*load_scene(name)) == ()
    lateral = ["load.kind=mass", "load.mass=1 mg", "mesh.level=2"]
    normal = ["coil.current=50 mA", "spring.preload=0.1 N", "accuracy=1e-2"]
    fits = normal if name == "reluctance" else lateral
    assert scene_warnings(*load_scene(name, fits)) == ()


@pytest.mark.parametrize(
    ("key", "asked", "words"),
    [
        ("spring.preload=90 mN", "quantities=magnetic_force", "ask for pull_in_current to use it"),
        ("spring.preload=90 mN", "quantities=pull_in_current", ""),
        ("coil.outer_radius=0.87 mm", "models=network", "use it with --set models=axisymmetric"),
        ("coil.outer_radius=0.87 mm", "models=network,axisymmetric", ""),
    ],
)
def test_keys_that_the_quantities_do_not_read_are_warned_of(key, asked, words):
    """What was asked for decides; a report shows everything and is not warned of."""
    scene, origins = load_scene("reluctance", [key, asked])
    found = [text for text in scene_warnings(scene, origins) if text.startswith(key[:6])]
    assert bool(found) is bool(words)
    assert all(words in text for text in found)
    assert not [t for t in scene_warnings(scene, origins, report=True) if t.startswith(key[:6])]


def test_a_file_may_describe_what_is_not_asked_about():
    """The scene of the normal actuator with a model of the lateral one: nobody set the turns."""
    scene, origins = load_scene("reluctance", ["models=tmm", "quantities=magnetic_force"])
    assert scene_warnings(scene, origins) == ()


def test_template_is_the_papers_device_under_neutral_conditions(tmp_path):
    """The commented template is valid as it is, and with every line switched on."""
    text = template()
    commented, full = tmp_path / "a.toml", tmp_path / "b.toml"
    commented.write_text(text, encoding="utf-8")
    full.write_text(re.sub(r"(?m)^# (\w+ = )", r"\1", text), encoding="utf-8")
    neutral = [f"{key}={value}" for key, value in NEUTRAL.items()]
    paper, _ = load_scene("paper", ["start_from=neutral", *neutral])
    paper = paper.model_dump(exclude={"name", "description"})
    for path in (commented, full):
        scene, _ = load_scene(str(path))
        assert not set(scene.not_stated) & set(NEUTRAL)
        scene = scene.model_dump(exclude={"name", "description"})
        scene["shim"]["transverse_modulus"] = None  # shown with its derived value
        scene["beam"]["shear_correction"] = pytest.approx(paper["beam"]["shear_correction"])
        assert scene == paper


def test_every_parameter_has_a_source():
    """A report must be able to say where each number comes from."""
    scene, origins = load_scene("paper", ["bimorph.length=25mm"])
    rows = {row.key: row for row in parameter_rows(scene, origins)}
    physical = [r for k, r in rows.items() if "." in k and not k.startswith("mesh.")]
    assert all(row.source for row in physical)
    assert rows["bimorph.length"].source == "set on the command line"
    assert rows["bimorph.width"].source == "paper table 2"
    assert rows["piezo.eps33"].assumed
    assert not rows["piezo.d31"].assumed


def test_digits_that_nobody_wrote_are_not_shown():
    """What was derived, such as the constants of j1's ceramic and 5/6, has six digits."""
    rows = {row.key: row.text for row in parameter_rows(*load_scene("j1", ["gap=0.2123456 mm"]))}
    assert rows["piezo.d31"] == "-274.546 pC/N"
    assert rows["beam.shear_correction"] == "0.833333"
    assert rows["gap"] == "0.2123456 mm"
    assert rows["bimorph.piezo_thickness"] == "0.26 mm"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("10:30:3", [10.0, 20.0, 30.0]),
        ("10:1000:3:log", [10.0, 100.0, 1000.0]),
        ("0", [0.0]),
        ("10:10:1", [10.0]),
        (" 1e3 Hz , 5 MHz, 2khz", [1000.0, 5e6, 2000.0]),
        (100, [100.0]),
        (["100 Hz", "0.5 kHz", 7], [100.0, 500.0, 7.0]),
    ],
)
def test_frequency_lists(text, expected):
    """Lists and ranges, numbers and text, ends exact."""
    assert parse_frequencies(text) == pytest.approx(expected, rel=1e-12)
    assert parse_frequencies(text)[-1] == expected[-1]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("5 mHz", ["MHz"]),
        ("١٠", ["not a frequency"]),
        ("10:20:٣", ["whole number"]),
        ("10:20:0", ["whole number"]),
        ("10:20:1000001", ["1000000"]),
        ("10:20:1", ["1 point"]),
        ("10:20", ["START:STOP:N"]),
        ("10:20:2:x", ["START:STOP:N"]),
        ("-1", ["not negative"]),
        ("", ["no frequency"]),
        ("0:5:1:log", ["above 0 Hz"]),
        ("1e9999", ["finite"]),
        ("1 kHz:1e9 Hz:3", ["at most 10 MHz"]),
        (["10:20:3"], ["not a frequency"]),
        (10**400, ["finite"]),
        (None, ["not a frequency"]),
    ],
)
def test_frequencies_are_read_strictly(given, words):
    """Whatever is not a number with Hz, kHz or MHz is refused, never guessed."""
    with pytest.raises(InputError) as caught:
        parse_frequencies(given)
    assert all(word in str(caught.value) for word in ["frequency = ", *words]), caught.value


@pytest.mark.parametrize(
    ("name", "overrides", "models"),
    [
        ("paper", [], ("lumped", "tmm", "beam", "solid", "cad")),
        ("bimorph_on_rod", [], ("lumped", "tmm", "beam", "cad")),
        ("paper", ["bimorph.bare_below=1mm"], ("lumped", "tmm", "beam", "solid")),
        ("paper", ["bimorph.width_profile=0mm:2mm,20mm:1mm"], ("lumped", "tmm", "beam")),
    ],
)
def test_models_are_those_that_can_unless_they_are_named(name, overrides, models):
    """Bricks have no rod, CAD has plain layers only."""
    assert load_scene(name, overrides)[0].models == models


def test_paths_in_a_scene_start_at_the_scene(tmp_path, monkeypatch):
    """Wherever the command runs; one on the command line starts where that is."""
    folder = tmp_path / "of the scene"
    folder.mkdir()
    (folder / "mine.csv").write_text("B (T),H (A/m)\n0,0\n1,500\n2,200000\n")
    (folder / "my.toml").write_text('[steel]\ncurve = "mine.csv"\n')
    for here, name in ((tmp_path, "of the scene/my.toml"), (folder, "my.toml")):
        monkeypatch.chdir(here)
        scene, _ = load_scene(name)
        assert magnetisation_curve(scene.steel).flux_density[-1] == 2.0
    monkeypatch.chdir(tmp_path)
    scene, _ = load_scene("of the scene/my.toml", ["steel.curve=mine.csv"])
    with pytest.raises(InputError, match=r'"mine\.csv" cannot be read'):
        magnetisation_curve(scene.steel)
    scene, _ = load_scene("of the scene/my.toml", ["steel.curve=team20"])
    assert magnetisation_curve(scene.steel) is TEAM20


@pytest.mark.parametrize(
    "text",
    ["a = " + "[" * 5000, "bimorph." + ".".join(["a"] * 5000) + " = 1"], ids=["list", "group"],
)  # fmt: skip
def test_deep_nesting_is_refused(tmp_path, text):
    """By the thousand, in one sentence of bounded length."""
    path = tmp_path / "deep.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_scene(str(path))
    assert len(str(caught.value)) < 300


def live(scene):
    return {row.key for row in parameter_rows(scene, {}) if not idle(scene, row.key)}


def test_a_current_brings_the_circuit_to_the_contact():
    """What pulls the head on its stop counts as soon as there is a current, and not before."""
    sets = ["models=tmm", "support.kind=contact"]
    without, with_current = (
        live(load_scene("paper", [*sets, f"coil.current={current}"])[0])
        for current in ("0 A", "50 mA")
    )
    assert with_current - without == {
        "coil.turns", "coil.history", "sleeve.inner_radius", "sleeve.outer_radius",
        "sleeve.length", "sleeve.collar_radius", "sleeve.collar_thickness", "spring.stop_gap",
        "steel.curve", "gap",
    }  # fmt: skip
    assert without < with_current


def test_models_named_alone_leave_out_what_none_of_them_gives():
    """Of the scene's own quantities; what is named beside them stays and is refused later."""
    scene, _ = load_scene("generator", ["models=tmm"])
    assert "coil_impedance" in scene.quantities
    assert "rod_position" not in scene.quantities
    named, _ = load_scene("generator", ["models=tmm", "quantities=rod_position"])
    assert named.quantities == ("rod_position",)
