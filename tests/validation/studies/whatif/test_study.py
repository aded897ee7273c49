"""Studies: only what changed is solved, failures are kept, files open elsewhere."""

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
from tactgen.validation.studies.whatif.point_answers import Question
from tactgen.validation.studies.whatif.study import Study, run_study


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
    study = run_study(statement(
        "bimorph.length=20mm", "load.kind=none,finger", models=("lumped", "tmm"), sets=("modes=1",),
        quantities=("tip_displacement", "short_circuit_frequencies", "capacitance_free"),
    ))  # fmt: skip
    assert len(study.points) == 2
    for point, model, answer in study.rows:
        sets = ["bimorph.length=20mm", f"load.kind={point['load.kind']}"]
        scene, _ = load_scene("prototype", ["frequency=100,500", "modes=1", *sets])
        alone = solve(scene, (model,), study.statement.quantities)
        assert answer.status == "ok"
        plain = {"value": 0, "error": 0, "seconds": 0, "modelling": None}
        for a, b in zip(answer.quantities, alone.quantities, strict=True):
            assert replace(a, **plain) == replace(b, **plain)
            np.testing.assert_array_equal(a.value, b.value)
            np.testing.assert_array_equal(a.error, b.error)
            np.testing.assert_array_equal(a.modelling_error, b.modelling_error)


def test_only_new_points_are_solved(solved):
    """A grown axis, a finer one, another axis: what was answered is not asked again."""
    run_study(statement("bimorph.length=14mm:18mm:3"))
    assert len(solved) == 3
    for more, computed, recalled in (
        ((), 2, 3), (("load.kind=none,finger",), 5, 5),
        (("coil.current=1mA:9mA:9",), 0, 5),  # what the model does not read is no new question
    ):  # fmt: skip
        counts = run_study(statement("bimorph.length=14mm:18mm:5", *more)).counts
        assert (counts["computed"], counts["recalled"]) == (computed, recalled)
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
    assert run_study(asked).counts["failed"] == 1
    assert len(solved) == 3
    counts = run_study(asked, retry=True).counts
    assert (counts["failed"], counts["computed"], counts["recalled"]) == (0, 1, 2)
    assert run_study(asked).counts["failed"] == 0


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
def test_a_study_is_gone_on_with(tmp_path, capsys):
    """Not overwritten unasked; resumed with nothing said, with a finer axis, or with more asked."""
    out = tmp_path / "study"
    vary, again = ("--vary", "bimorph.length=14mm:18mm:3"), ("--resume", "--out", out)
    asked = ("prototype", "--quantity", "capacitance_free", "--out", out)
    assert run(capsys, *asked, *vary)[0] == 0
    before = (out / "study.csv").read_bytes()
    code, _, err = run(capsys, *asked, *vary)
    assert (code, err.count("\n")) == (2, 1)
    assert "holds a study already; add --resume" in err
    assert "0 answers computed, 3 kept" in run(capsys, *again)[2]
    assert (out / "study.csv").read_bytes() == before
    _, said, err = run(capsys, *again, "--vary", "bimorph.length=14mm:18mm:5", "--json")
    assert "2 answers computed, 3 kept" in err
    lengths = [p["at"]["bimorph.length"] for p in json.loads(said)["points"]]
    assert lengths == [0.014, 0.015, 0.016, 0.017, 0.018]
    more = ("--model", "lumped", "--quantity", "capacitance_blocked")
    assert run(capsys, *again, *more)[0] == 0
    held = read_statement(out)
    assert held.models == ("tmm", "lumped")
    assert held.quantities == ("capacitance_free", "capacitance_blocked")
    text = (out / "study.csv").read_text(encoding="utf-8")
    assert all(model in text for model in held.models)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "nothing is varied"),
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
    ):  # fmt: skip
        (out / "study.json").write_text(text)
        code, _, err = run(capsys, "--resume", "--out", out)
        assert (code, err.count("\n")) == (2, 1)
        assert words in err
        assert [p.name for p in out.iterdir()] == ["study.json"]


def told(*warnings):
    """Return the warnings of a study whose two points were answered with these, model by model."""
    one, two, three, four = (Answer("ok", "", warnings=(text,)) for text in warnings)
    answers = {"tmm": one, "lumped": two}, {"tmm": three, "lumped": four}
    return Study(Statement(), ({"gap": 1e-4}, {"gap": 2e-4}), answers, {}).warnings


def test_a_group_of_warnings_is_its_worst_with_its_point():
    """Numbers are compared as numbers; points are counted, not answers; alike once is enough."""
    stress = "the stress reaches {} MPa at {} Hz, more than 28 MPa"
    (found,) = told(*(stress.format(*of) for of in ((30, 7), (9e2, 5), (1e3, 6), (1e3, 5))))
    place = "at 2 of 2 points by tmm, lumped, worst by tmm at gap = 0.2 mm: "
    assert found == f"{place}{stress.format(1e3, 6)}"
    (found,) = told(*["the same"] * 4)
    assert found == "at 2 of 2 points by tmm, lumped: the same"


def test_an_axis_that_changes_nothing_is_named_with_its_reason():
    """A width beside its profile, a coil of a bimorph; a length is none."""
    profile = {"bimorph": {"width_profile": "0 mm: 4 mm, 20 mm: 1 mm"}}
    axes = ("bimorph.width=2mm,3mm", "coil.turns=100,200", "piezo.d31=-200 pC/N,-300 pC/N")
    asked = Statement("prototype", profile, axes, ("tmm",), ("static_tip_displacement",))
    found = [text.partition(" changed no answer: ")[0] for text in run_study(asked).without_effect]
    assert found == ["bimorph.width", "coil.turns"]
