"""Studies: only what changed is solved, failures are kept, files open elsewhere."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene, scene_values
from tactgen.validation.studies.whatif import executor
from tactgen.validation.studies.whatif import point_answers as questions
from tactgen.validation.studies.whatif.definition import Statement, read_statement
from tactgen.validation.studies.whatif.output_files import dataset
from tactgen.validation.studies.whatif.point_answers import Question
from tactgen.validation.studies.whatif.study import Counts, Study, run_study


def statement(
    *vary, scene="prototype", models=("tmm",), quantities=("capacitance_free",), sets=(), **more
):
    values, _ = scene_values(scene, ["frequency=100,500", *sets])
    return Statement(scene, values, vary, models, quantities, **more)


@pytest.fixture
def solved(own_store, monkeypatch):
    """Return the list of the scenes that are solved; the store is empty."""
    found = []

    def counted(scene, *arguments, **options):
        found.append(scene)
        return solve(scene, *arguments, **options)

    monkeypatch.setattr(questions, "solve", counted)
    questions._earlier.clear()
    return found


def test_a_point_says_what_solve_says(solved):
    """Bit for bit, by every quick model, complex and real."""
    study = run_study(
        statement(
            "bimorph.length=20mm", "load.kind=none,finger", models=("lumped", "tmm"),
            quantities=("tip_displacement", "short_circuit_frequencies", "capacitance_free"),
            sets=("modes=1",),
        )
    )  # fmt: skip
    assert len(study.points) == 2
    for point, model, answer in study.rows:
        sets = [f"{k}={v!r} m" if k == "bimorph.length" else f"{k}={v}" for k, v in point.items()]
        scene, _ = load_scene("prototype", ["frequency=100,500", "modes=1", *sets])
        alone = solve(scene, (model,), study.statement.quantities)
        assert answer.status == "ok"
        for a, b in zip(answer.quantities, alone.quantities, strict=True):
            assert replace(a, value=0, error=0, seconds=0, modelling=None) == replace(
                b, value=0, error=0, seconds=0, modelling=None
            )
            np.testing.assert_array_equal(a.value, b.value)
            np.testing.assert_array_equal(a.error, b.error)
            np.testing.assert_array_equal(a.modelling_error, b.modelling_error)


def test_only_new_points_are_solved(solved):
    """A grown axis, a finer one, another axis: what was answered is not asked again."""
    run_study(statement("bimorph.length=14mm:18mm:3"))
    assert len(solved) == 3
    counts = run_study(statement("bimorph.length=14mm:18mm:5")).counts
    assert (counts.computed, counts.recalled, len(solved)) == (2, 3, 5)
    counts = run_study(statement("bimorph.length=14mm:18mm:5", "load.kind=none,finger")).counts
    assert (counts.computed, counts.recalled) == (5, 5)
    # what the model does not read makes no new question
    counts = run_study(statement("bimorph.length=14mm:18mm:5", "coil.current=1mA:9mA:9")).counts
    assert (counts.computed, counts.recalled) == (0, 5)
    assert len(solved) == 10


def test_a_failure_is_kept_until_it_is_tried_again(solved, monkeypatch):
    """One sentence, not asked again without being told to, and the other points are there."""
    whole = questions.solve

    def failing(scene, *arguments, **options):
        if scene.bimorph.length == 0.016:
            solved.append(scene)
            raise np.linalg.LinAlgError("singular\nmatrix")
        return whole(scene, *arguments, **options)

    asked = statement("bimorph.length=14mm:18mm:3")
    monkeypatch.setattr(questions, "solve", failing)
    study = run_study(asked)
    assert [a.status for _, _, a in study.rows] == ["ok", "failed", "ok"]
    assert study.answers[1]["tmm"].reason == "LinAlgError: singular matrix"
    assert len(solved) == 3
    monkeypatch.setattr(questions, "solve", whole)
    assert run_study(asked).counts.failed == 1
    assert len(solved) == 3
    counts = run_study(asked, retry=True).counts
    assert (counts.failed, counts.computed, counts.recalled) == (0, 1, 2)
    assert run_study(asked).counts.failed == 0


def test_what_is_shared_is_scheduled_once():
    """Questions of one field solution go to one worker, those that share a stage wait for it."""

    def scheduled(*shared):
        questions = (Question("solid", ("capacitance_free",), (), keys, {}) for keys in shared)
        return executor.schedule(dict(enumerate(questions)))

    plain = scheduled(("a",), ("b",), ("a",), ("a", "c"), ("d",))
    assert [list(batch.questions) for batch in plain] == [[0, 2], [1], [3], [4]]
    assert [set(batch.after) for batch in plain] == [set(), set(), {0}, set()]
    many = scheduled(*[("a",)] * 70)
    assert [len(batch.questions) for batch in many] == [32, 32, 6]
    assert [set(batch.after) for batch in many] == [set(), {0}, {0}]


@pytest.mark.usefixtures("coarse_bricks")
def test_one_field_solution_for_all_loads_and_voltages(own_store, monkeypatch):
    """Ten points that differ in load and voltage cost the solid one mesh and one reduction."""
    ran = []
    asked = statement(
        "load.kind=none,finger", "drive.voltage=1V:5V:5", scene="j1", models=("solid",),
        quantities=("tip_displacement",), sets=("mesh.level=2", "modes=2", "frequency=100"),
    )  # fmt: skip
    study = run_study(asked, 1, lambda text: ran.append(text.rpartition(": ")[2]))
    assert {answer.status for _, _, answer in study.rows} == {"ok"}
    assert ran.count("solid.ports") == ran.count("solid.mesh") == 1


def run(capsys, *arguments):
    code = main(["whatif", *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.mark.usefixtures("undrawn")
def test_the_files_open_elsewhere(tmp_path, capsys):
    """netCDF by xarray with names, units, bars and provenance; CSV with the same numbers."""
    xarray = pytest.importorskip("xarray")
    out = tmp_path / "study"
    code, _, err = run(
        capsys, "prototype", "--vary", "bimorph.length=14mm:18mm:3", "--vary",
        "bimorph.bare_above=1mm,16mm", "--vary", "gap=normal(200um,10um)", "--sample", 2,
        "--model", "tmm", "--model", "network", "--quantity", "tip_displacement",
        "--quantity", "short_circuit_frequencies", "--quantity", "magnetic_force",
        "--frequency", "10,500", "--set", "modes=2", "--out", out,
    )  # fmt: skip
    assert (code, sorted(p.name for p in out.iterdir())) == (
        0, ["statistics.csv", "study.csv", "study.html", "study.json", "study.nc"],
    )  # fmt: skip
    assert "refused" in err
    with xarray.open_dataset(out / "study.nc") as data:
        assert data.sizes == {
            "model": 2, "bimorph.length": 3, "bimorph.bare_above": 2, "sample": 2,
            "frequency": 2, "mode": 2,
        }  # fmt: skip
        assert data["gap"].dims == ("sample",)
        assert data["bimorph.length"].attrs["units"] == "m"
        assert data.tip_displacement_re.attrs["units"] == "m"
        assert data.attrs["scene"] == "prototype"
        classes = data["short_circuit_frequencies_class"]
        assert classes.dims == data.short_circuit_frequencies.dims
        assert len(data.attrs["scene_sha256"]) == 64
        assert data.model.values.tolist() == ["tmm", "network"]
        place = {"model": "tmm", "bimorph.length": 0.016, "bimorph.bare_above": 1e-3}
        at = data.sel(place).isel(sample=1)
        assert int(at.status) == 0
        assert at.reason.item() == ""
        refused = data.sel(model="tmm").isel({"bimorph.bare_above": 1, "bimorph.length": 0})
        assert data.status.attrs["flag_meanings"].split()[int(refused.status[0])] == "refused"
        assert np.isnan(refused.short_circuit_frequencies).all()
        scene, _ = load_scene(
            "prototype", ["bimorph.length=16mm", "bimorph.bare_above=1mm", "frequency=10,500"]
        )
        alone = solve(scene, ("tmm",), ("tip_displacement",)).quantities[0]
        assert at.short_circuit_frequencies_class.values.tolist() == ["bending_x"] * 2
        np.testing.assert_array_equal(at.tip_displacement_re, alone.value.real)
        np.testing.assert_array_equal(at.tip_displacement_im, alone.value.imag)
        np.testing.assert_array_equal(at.tip_displacement_uncertainty, alone.error)
        force = data.magnetic_force.sel(model="network").values.ravel()
    with (out / "study.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0])[:3] == ["bimorph.length (m)", "bimorph.bare_above (m)", "gap (m)"]
    kinds = {
        r["class"] for r in rows if r["quantity"] == "short_circuit_frequencies" and r["value"]
    }
    assert kinds == {"bending_x"}
    mine = [r for r in rows if r["quantity"] == "magnetic_force"]
    assert [float(r["value"]) for r in mine if r["value"]] == force[np.isfinite(force)].tolist()
    response = [
        r for r in rows if r["quantity"] == "tip_displacement" and r["status"] == "ok"
        and float(r["bimorph.length (m)"]) == 0.016
    ]  # fmt: skip
    assert [float(r["frequency"]) for r in response[:2]] == [10.0, 500.0]
    assert complex(float(response[0]["value"]), float(response[0]["value_im"])) == alone.value[0]
    missing = next(r for r in rows if r["status"] == "refused")
    assert (missing["value"], missing["uncertainty"]) == ("", "")
    assert "bimorph.bare_above" in missing["reason"]


@pytest.mark.usefixtures("undrawn")
def test_a_study_is_gone_on_with(tmp_path, capsys):
    """Not overwritten unasked; resumed with nothing said, with a finer axis, or with more asked."""
    out = tmp_path / "study"
    vary = ("--vary", "bimorph.length=14mm:18mm:3")
    asked = ("prototype", "--quantity", "capacitance_free", "--out", out)
    assert run(capsys, *asked, *vary)[0] == 0
    before = (out / "study.csv").read_bytes()
    code, _, err = run(capsys, *asked, *vary)
    assert (code, err.count("\n")) == (2, 1)
    assert "holds a study already; add --resume" in err
    code, _, err = run(capsys, "--resume", "--out", out)
    assert code == 0
    assert "0 answers computed, 3 kept" in err
    assert (out / "study.csv").read_bytes() == before
    code, out_text, err = run(
        capsys, "--resume", "--out", out, "--vary", "bimorph.length=14mm:18mm:5", "--json"
    )
    assert code == 0
    assert "2 answers computed, 3 kept" in err
    found = json.loads(out_text)
    assert found["scene"] == "prototype"
    lengths = [p["at"]["bimorph.length"] for p in found["points"]]
    assert lengths == [0.014, 0.015, 0.016, 0.017, 0.018]
    assert found["points"][0]["quantities"][0]["name"] == "capacitance_free"
    more = ("--model", "lumped", "--quantity", "capacitance_blocked")
    assert run(capsys, "--resume", "--out", out, *more)[0] == 0
    held = read_statement(out)
    assert held.models == ("tmm", "lumped")
    assert held.quantities == ("capacitance_free", "capacitance_blocked")
    text = (out / "study.csv").read_text(encoding="utf-8")
    assert "lumped" in text
    assert "tmm" in text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "nothing is varied"),
        (("--vary", "bimorph.length=14mm:15mm", "--sample", "2", "--seed", "x"), "--seed"),
        (("--vary", "bimorph.length=14mm,15mm", "--jobs", "0"), "--jobs"),
        (("--vary", "bimorph.length=14mm,15mm", "--resume"), "--resume needs the study"),
    ],
)
def test_bad_requests_are_one_sentence(capsys, arguments, words):
    code, out, err = run(capsys, *arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert words in err


def test_damaged_and_foreign_studies_are_refused(tmp_path, capsys):
    """No study, not JSON, another version: one sentence, and nothing is written."""
    out = tmp_path / "study"
    assert "holds no study" in run(capsys, "--resume", "--out", out)[2]
    assert not out.exists()
    out.mkdir()
    for text, words in (
        ("{", "is damaged"), ('{"format": 99}', "format = 99, and this version reads 1"),
        ('{"format": 1}', "is damaged"),
    ):  # fmt: skip
        (out / "study.json").write_text(text)
        code, _, err = run(capsys, "--resume", "--out", out)
        assert (code, err.count("\n")) == (2, 1)
        assert words in err
        assert [p.name for p in out.iterdir()] == ["study.json"]


def test_a_study_over_frequency_is_a_sweep():
    """Frequency is an axis of the arrays then, once; what nothing answers is no array."""
    values, _ = scene_values("prototype", ["frequency=100,500"])
    asked = Statement("prototype", values, ("frequency=100,500", "load.kind=none,table"), ("tmm",),
                      ("tip_displacement",))  # fmt: skip
    study = run_study(asked, 1)
    found = dataset(study).variables["tip_displacement"]
    assert found.dims == ("model", "frequency", "load.kind")
    scene, _ = load_scene("prototype", ["frequency=100,500", "load.kind=none"])
    sweep = solve(scene, ("tmm",), ("tip_displacement",)).quantities[0].value
    np.testing.assert_array_equal(found.values[0, :, 0], sweep)
    assert np.isnan(found.values[0, :, 1]).all()
    unanswered = replace(
        study, answers=tuple({"tmm": Answer("refused", "why")} for _ in study.answers)
    )
    assert set(dataset(unanswered).data_vars) == {"status", "reason", "seconds"}


def told(*warnings, points=2):
    """Return the warnings of a study whose points were answered with these, model by model."""
    every = iter(warnings)
    answers = tuple(
        {model: Answer("ok", "", warnings=(next(every),)) for model in ("tmm", "lumped")}
        for _ in range(points)
    )
    at = tuple({"gap": 1e-4 * (number + 1)} for number in range(points))
    return Study(Statement(), at, answers, Counts(0, 0, 0, 0)).warnings


def test_a_group_of_warnings_is_its_worst_with_its_point():
    """Numbers are compared as numbers; points are counted, not answers; alike once is enough."""
    stress = "the stress reaches {} MPa at {} Hz, more than 28 MPa"
    (found,) = told(*(stress.format(*of) for of in ((30, 7), (9e2, 5), (1e3, 6), (1e3, 5))))
    assert found == (
        "at 2 of 2 points by tmm, lumped, worst by tmm at gap = 0.2 mm: "
        f"{stress.format(1e3, 6)}"
    )  # fmt: skip
    (found,) = told(*["the same"] * 4)
    assert found == "at 2 of 2 points by tmm, lumped: the same"


def test_an_axis_that_changes_nothing_is_named_with_its_reason():
    """A width beside its profile, a coil of a bimorph; a length is none."""
    profile = {"bimorph": {"width_profile": "0 mm: 4 mm, 20 mm: 1 mm"}}
    axes = ("bimorph.width=2mm,3mm", "coil.turns=100,200", "piezo.d31=-200 pC/N,-300 pC/N")
    asked = Statement("prototype", {**profile}, axes, ("tmm",), ("static_tip_displacement",))
    found = run_study(asked).without_effect
    assert [sentence.partition(" changed no answer: ")[0] for sentence in found] == [
        "bimorph.width", "coil.turns",
    ]  # fmt: skip
