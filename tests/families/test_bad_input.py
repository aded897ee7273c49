"""Bad input on the command line: one sentence that says what to do, exit code 2, no traceback.

What a scene refuses, key by key, is in tests/validation/scene; what a table of steel or of a
measurement refuses, beside its reader.
"""

import pytest

from tactgen.validation.command_line import cli
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

COMMANDS = cli.commands()
#: Arguments of a command before the scene and after it, where it must have some.
BEFORE = {"identify": ["SWEEP"]}
AFTER = {"export": ["--step", "x.step"], "whatif": ["--vary", "drive.voltage=10V:20V:2"]}


def has(command, name):
    return any(name in (a.dest, *a.option_strings) for a in COMMANDS[command]._actions)


WITH_SCENE = [name for name in COMMANDS if has(name, "scene")]
AS_JSON = [name for name in WITH_SCENE if has(name, "--json")]


@pytest.fixture(scope="module")
def sweep():
    """Return a measured curve that has no fault: the prototype's own."""
    scene, _ = load_scene("prototype", ["frequency=10:2000:40"])
    velocity = solve(scene, ("tmm",), ("tip_velocity",)).quantities[0].value
    rows = (f"{f},{abs(v)}" for f, v in zip(scene.frequency, velocity, strict=True))
    return "frequency (Hz),velocity (m/s)\n" + "\n".join(rows) + "\n"


@pytest.fixture
def refused(capsys, tmp_path, monkeypatch, sweep):
    """Return a function that calls the command line, checks the refusal and returns its words."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sweep.csv").write_text(sweep, encoding="utf-8")
    (tmp_path / "twice.csv").write_text("frequency (Hz),frequency (Hz)\n1,2\n", encoding="utf-8")
    before = sorted(tmp_path.iterdir())

    def call(*arguments):
        code = cli.main(["sweep.csv" if a == "SWEEP" else a for a in arguments])
        out, err = capsys.readouterr()
        assert (code, out) == (2, ""), err
        assert err.startswith("tactgen: ")
        assert err.count("\n") == 1
        assert sorted(tmp_path.iterdir()) == before
        return err

    return call


@pytest.mark.parametrize("command", COMMANDS)
def test_unknown_option(refused, command):
    """Refused with the way to the help, by every command."""
    error = refused(command, *BEFORE.get(command, []), *AFTER.get(command, []), "--nonsense")
    assert "--help" in error


def test_no_other_commands_option_is_meant(refused):
    """What may have been meant is an option of this command, not the same word of another."""
    assert "did you mean" not in refused("scenes", "--accuracy", "2e-5")
    assert "did you mean" not in refused("sensitivity", "--samples", "9")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere.toml"], ["neither a readable file nor a built-in scene"]),
        (["paper", "--set", "bimorph.lenght=25mm"], ['did you mean "bimorph.length"']),
        (["paper", "--set", "piezo.d31=-3850 pC/N"], ["piezo.d31", "negative energy"]),
    ],
)
@pytest.mark.parametrize("command", WITH_SCENE)
def test_scene_that_cannot_be_used(refused, command, arguments, words):
    """The same sentence from every command that takes a scene, before any work is done."""
    error = refused(command, *BEFORE.get(command, []), *arguments, *AFTER.get(command, []))
    assert ";" in error or "did you mean" in error  # the remedy
    assert all(word in error for word in words), error


@pytest.mark.parametrize("command", AS_JSON)
def test_no_half_a_document(refused, command):
    """With --json too nothing is on stdout, and the sentence on stderr is plain text."""
    error = refused(
        command, *BEFORE.get(command, []), "--json", "--set", "gap=-1 mm", *AFTER.get(command, [])
    )
    assert "gap" in error
    assert "{" not in error


GOAL = ["--aim", "maximise static_tip_displacement"]
LENGTH = ["--vary", "bimorph.length=14mm:22mm"]
LENGTHS = ["whatif", "prototype", "--vary", "bimorph.length=14mm:16mm:2"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["solve", "--frequency", "5000", "--quantity", "tip_velocity"],
         ["5000 Hz", "10 to 1000 Hz"]),
        (["solve", "papr"], ['did you mean "paper"']),
        (["solve", "--set", "bimorph.length"], ["KEY=VALUE"]),
        (["solve", "--set", "bimorph.length=25 kg"], ["bimorph.length", "not a length"]),
        (["solve", "--set", "bimorph.length=25"], ["has no unit"]),
        (["solve", "--set", "piezo.density=-7800 kg/m^3"], ["piezo.density", "greater than 0"]),
        (["solve", "--set", "models=tmn"], ['did you mean "tmm"']),
        (["solve", "--model", "fem"], ['model "fem" is unknown']),
        (["solve", "--quantity", "speed"], ['quantity "speed" is unknown']),
        (["fly"], ["invalid choice"]),
        (["export"], ["--step"]),
        (["export", "--glb", "x.gltf"], ["--glb x.gltf", ".glb"]),
        (["solve", "--frequency", ""], ["--frequency is empty", "--frequency 10:2000:200"]),
        (["solve", "--frequency", "10 20"], ['"10 20"', "not a frequency"]),
        (["solve", "x\ny" * 2000], ["neither a readable file"]),
        (["solve", "--jsn"], ['did you mean "--json"', "tactgen solve --help"]),
        (["solve", "--accuracy", "2e-5"], ['did you mean "--set accuracy=…"']),
        (["solve", "--piezo.d31=-180"], ['did you mean "--set piezo.d31=…"']),
        (["report", "--out", "/proc/nowhere"], ["/proc/nowhere", "cannot be written"]),
        (["solve", "--set", "support.rotational_stiffness=0 N*m/rad"],
         ["support.rotational_stiffness = 0", "no value at 0 Hz"]),
        (["design", "reluctance"],
         ["models = network", "design is about the lateral", "models=tmm"]),
        (["sensitivity", "reluctance", "--sobol"], ["--sobol is of the lateral", "remove it"]),
        (["sensitivity", "--model", "network", "--quantity", "capacitance_free"],
         ["capacitance_free", "is computed by"]),
        (["init", ""], ["FILE.toml is empty"]),
        (["init", "-"], ['FILE.toml = "-"', "name one"]),
        (["report", "--set", "quantities=magnetic_force"],
         ["--set models=lumped,tmm,beam,solid,cad,network"]),
        (["solve", "reluctance", "--set", "coil.turns=1e7"],
         ["coil.turns", "must be from 1 to 1000000"]),
        (["init", "/nowhere/x.toml"], ["/nowhere/x.toml", "cannot be written"]),
        (["simulate", "generator", "--voltage", "1 V sine 9 Hz", "--until", "-1ms"],
         ["--until = -0.001 s is not between"]),
        (["simulate", "generator", "--coil", "9 mA step at 50 ms", "--until", "30 ms"],
         ["--coil starts at 50 ms and the run ends at 30 ms", "give a later --until"]),
        (["init", "own.yaml"], ["own.yaml must end in .toml", "name the file so"]),
        (["solve", "--frequency", "10:2000:1"],
         ["asks for 1 point between two ends", 'such as "10", or at least 2 points']),
        (["whatif", "--vary", "bimorph.length=20mm,21mm", "--seed", "1000000000"],
         ['--seed "1000000000" is not a whole number from 0 to 999999999']),
        ([*LENGTHS, "--plot", "study.png"], ["study.png", "--plot study.svg"]),
        (
            [*LENGTHS, "--model", "lumped", "--quantity", "coupling_factor", "--aim",
             "minimise magnetic_force"],
            ["magnetic_force", "lumped do not give", "--model"],
        ),
        (["whatif", "paper", "--vary", "load.mass=0mg:5mg:log", "--sample", "4"],
         ["load.mass", "must begin above 0"]),
        (["export", "paper", "--machine", "m.npz"], ["--machine", "set support.kind=contact"]),
        (
            ["export", "paper", "--state-space", "s.npz", "--set",
             "support.lateral_stiffness=0 N/m"],
            ["support.lateral_stiffness = 0 N/m", "clamped"],
        ),
        (["view", "--lengths", "14mm:20mm", "--png", "a.png"], ["--lengths", "--out FILE.html"]),
        (["view", "--lengths", "14mm:20mm", "--model", "axisymmetric", "--out", "a.html"],
         ["--lengths", "axisymmetric does not know"]),
        (["view", "--lengths", "14mm:20mm", "--model", "cad", "--out", "a.html"],
         ["--lengths", "a fast way to many lengths", "--model tmm"]),
        (["design", "paper", *GOAL, "--vary", "bimorph.length=normal(20mm,1mm)"],
         ["bimorph.length=normal(20mm,1mm)"]),
        (
            ["solve", "reluctance", "--set", "sleeve.collar_thickness=2mm",
             "--set", "sleeve.collar_radius=0.8mm"],
            ["sleeve.collar_thickness = 2 mm", "make the collar thinner"],
        ),
        (
            ["solve", "--model", "solid", "--set", "bimorph.glue_thickness=20um", "--set",
             "glue.youngs_modulus=0.02MPa"],
            ["glue.youngs_modulus = 2e+04 Pa", "at least"],
        ),
        (["solve", "--set", "load.kind=table", "--set", "load.file=twice.csv"], ["there twice"]),
        (["identify", "nowhere.csv"], ["nowhere.csv cannot be read", "no such file"]),
        (["identify"], ["MEASURED.csv", "--help"]),
        (["identify", "SWEEP", "--fit", "c_q"],
         ['scene key "c_q" is unknown', 'did you mean "c_s"']),
        (["identify", "SWEEP", "--set", "support.kind=clamped"], ["has no effect", "support.kind"]),
        (["identify", "SWEEP", "--noise", "pink"], ["invalid choice"]),
        (["identify", "SWEEP", "--plot", "x.gif"], ["--plot x.gif", ".svg or .png"]),
        (["identify", "SWEEP", "--write", "x.txt"], ['--write "x.txt"', ".toml"]),
        (["identify", "SWEEP", "--write", "/nowhere/x.toml"],
         ["/nowhere/x.toml", "cannot be written"]),
    ],
)  # fmt: skip
def test_arguments(refused, arguments, words):
    """What options and keys refuse, by themselves and together."""
    error = refused(*arguments)
    assert all(word in error for word in words), error


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--vary", "bimorph.length=14mm,22mm", *GOAL], "is not a range to search"),
        (["--vary", "bimorph.length=22mm:14mm", *GOAL], "runs backwards"),
        ([*LENGTH, *GOAL, "--band", "10:100"], "--band is of the length"),
        ([*LENGTH, *GOAL, "--aim", "minimise capacitance_free"], "two goals cannot both be best"),
        ([*LENGTH, *GOAL, "--model", "tmm", "--model", "beam"], "name one --model"),
        ([*LENGTH, *GOAL, "--model", "network"], "model network gives none of"),
        ([*LENGTH, "--aim", "capacitance_free"], "has no comparison"),
        ([*LENGTH, "--aim", "capacitance_free >= 1 mm"], "compares or adds"),
        (["--margin=x"], '--margin "x" is not a number'),
        (["--margin=-1"], "margin = -1 is not a factor above 0"),
        (["--band=10"], '--band "10" is not LOW:HIGH'),
        (["--band=5:1000"], "reaches beyond the detection threshold"),
        (["--band=500:20"], "does not rise"),
        (["--band=10:nan"], '--band = "10:nan" has "nan"'),
        (["--lengths=20:40mm"], 'lengths: "20" has no unit'),
        (["--lengths=40mm:20mm"], "must rise and start above 0 mm"),
        (["--lengths=-1mm:20mm"], "must be greater than 0 mm"),
        (["--aim=longest"], '--aim "longest" is neither shortest nor margin'),
        (["--model=solid"], "--model goes with --vary"),
        (["--vary=bimorph.length=14mm:22mm"], "--vary needs an aim"),
        (["--plot=length.png"], "is not an SVG file"),
        (["--lengths=1um:40mm"], "no beam; start at 0.77 mm or more"),
        (["--lengths=1mm:1m"], "half waves at 1000 Hz"),
        (["--set", "bimorph.bare_above=25mm", "--set", "bimorph.length=30mm"],
         "leave no electrode beside"),
        (["--set", "bimorph.width_profile=0 mm: 2.1 mm, 20 mm: 1 mm"],
         "bimorph.width_profile is stated for 20 mm"),
        (["--set=drive.voltage=0V"], "drive.voltage or piezo.d31 is 0"),
    ],
)  # fmt: skip
def test_design(refused, arguments, message):
    """What searches refuse, over lengths and over ranges of any keys."""
    error = refused("design", *arguments)
    assert message in error
    assert ";" in error or "did you mean" in error  # the remedy


def test_measured_data(refused, tmp_path):
    """The measurement's own faults, with the name of its file."""
    text = "frequency (Hz),velocity (mm/s)\n10,nan\n20,1\n"
    (tmp_path / "sweep.csv").write_text(text, encoding="utf-8")
    error = refused("identify", "SWEEP")
    assert all(word in error for word in ["sweep.csv", "line 2", '"nan"']), error
