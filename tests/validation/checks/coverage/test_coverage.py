"""The coverage study: what it counts, what it calls too narrow, and that seeds repeat."""

import csv
import itertools
import json
import secrets

import numpy as np
import pytest

from tactgen.fem.bimorph.bricks.assembly import assemble_bricks
from tactgen.fem.bimorph.ports import direct_multiport
from tactgen.geometry.bimorph.bimorph_bricks import bimorph_bricks
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.network_pull import network_pull
from tactgen.tmm.reluctance.circuit import CELLS
from tactgen.tmm.reluctance.direct_pull import DirectPull
from tactgen.validation.checks.coverage import (
    PARTS,
    axisymmetric,
    beam,
    in_time,
    machine,
    magnetic3d,
    run,
    scenes,
    solid,
    taper,
    tmm,
)
from tactgen.validation.checks.coverage.output import table
from tactgen.validation.checks.coverage.result import (
    MULTIPLES,
    Judged,
    calibration,
    rows,
)
from tactgen.validation.command_line.cli import main


def answers(inside, outside, quantity="f 1"):
    return [Judged("here", quantity, 1.0, 2.0)] * inside + [Judged("there", quantity, 3.0, 2.0)] * (
        outside
    )


@pytest.mark.parametrize(
    ("inside", "outside", "holds"),
    [(20, 0, True), (18, 2, True), (15, 5, False), (190, 10, True), (180, 20, False), (1, 0, True)],
)
def test_verdict_allows_for_chance(inside, outside, holds):
    """Less than 95 % of a few may be chance; of many it is not (binomial, 1 % false alarm)."""
    (row,) = rows(answers(inside, outside))
    assert (row.inside, row.count, row.holds) == (inside, inside + outside, holds)
    assert row.width == 2.0
    assert row.verdict == ("holds" if holds else "fails")
    assert row.worst.where == ("there" if outside else "here")


def test_width_is_the_median_of_bar_over_error():
    """Answers that are hit exactly take what a double can tell for their error."""
    eps = np.finfo(float).eps
    found = [
        Judged("", "f", 0.0, 3.0 * eps),
        Judged("", "f", 1e-3, 4e-3),
        Judged("", "f", 1.0, 9.0),
    ]
    assert rows(found)[0].width == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("bars", "verdict"),
    [
        ([1.0, 5.0, 9.0], "holds"),
        ([1.0, 5.1, 9.0], "wide"),
        (3 * [0.1] + 4 * [90.0], "fails"),
    ],
)
def test_bars_that_cover_by_being_wide_are_called_so(bars, verdict):
    """Median of bar over error beyond five; what does not cover fails, however wide it is."""
    (row,) = rows([Judged(f"device {n % 2}", "f", 1.0, bar) for n, bar in enumerate(bars)])
    assert (row.verdict, row.devices) == (verdict, 2)
    assert row.holds == (verdict != "fails")


def test_numbers_of_modes_count_together():
    """One row for all numbers of a quantity, and one for all."""
    found = rows([*answers(3, 0, "f 1"), *answers(2, 1, "f 2"), *answers(1, 0, "u")])
    assert [(row.quantity, row.inside, row.count) for row in found] == [
        ("f", 5, 6), ("u", 1, 1), ("all", 6, 7),
    ]  # fmt: skip


def test_calibration_counts_what_lies_within_so_many_bars():
    """Errors of 0.5 and 1.5 bars: half from 0.5 on, all from 1.5 on."""
    curve = calibration(answers(1, 1))
    assert curve[MULTIPLES < 0.5].max() == 0.0
    assert set(curve[(MULTIPLES >= 0.5) & (MULTIPLES < 1.5)]) == {0.5}
    assert set(curve[MULTIPLES >= 1.5]) == {1.0}


def test_bars_of_beams_hold_on_fresh_devices(approved):
    """One device of each kind; `tactgen coverage` takes many."""
    told = []
    for judge in (
        tmm.judge, beam.judge, taper.judge, machine.judge_map, machine.judge_motions, in_time.judge,
    ):  # fmt: skip
        found = judge(np.random.default_rng([2026, 0]))
        assert found, judge
        assert all(one.within for one in found), [one for one in found if not one.within]
        assert any(one.error > 0.0 for one in found)  # no reference is what it judges
        told += [judge.__module__, *dict.fromkeys(one.where for one in found)]
        bars = (f"{one.bar:.2e}" if one.bar > 1e-8 else "rounding" for one in found)
        told += map("{0.quantity} ±{1}".format, found, bars)
    approved("\n".join(told))


def test_the_networks_own_pull_is_the_maps():
    """Arrays of any shape, slopes with the map's signs, as far as the steel's corners let them."""
    surface = network_pull(Device())
    exact = DirectPull(Device(), CELLS, surface.gap_limits)
    current, gap = np.array([[0.05], [0.12]]), np.array([0.1e-3, 0.2e-3, 0.24e-3])
    for name in ("force", "incremental_inductance", "force_gradient", "motional_coefficient"):
        by_map, found = (getattr(pull, name)(current, gap) for pull in (surface, exact))
        assert found.shape == (2, 3)
        assert found == pytest.approx(by_map, rel=0.02), name


def test_what_judges_the_solid_finds_the_ports_of_its_bricks(few_bricks):
    """A route of its own, without refinement of what it solves: to seven digits."""
    device = Device()
    system = assemble_bricks(device, bimorph_bricks(device, few_bricks[0]), lossy=False)
    exact = direct_multiport(system, np.zeros(1)).stiffness[0]
    found = solid._at_rest(system).stiffness[0]
    size = np.sqrt(np.abs(np.diag(exact)))
    assert (np.abs(found - exact) / np.outer(size, size)).max() < 1e-7


@pytest.fixture
def told(monkeypatch, tmp_path):
    """Which devices were judged, by the first number of their streams; with a store of its own."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "store"))
    numbers = []

    def judge(rng):
        numbers.append(float(rng.random()))
        return [Judged("device", "f", numbers[-1], np.float64(0.0))]

    monkeypatch.setattr(beam, "judge", judge)
    return numbers


def test_the_table_says_what_does_not_hold_and_where(approved):
    """A line a quantity; of bars that are too narrow the worst, and the device it is of."""
    fine = [Judged("anywhere", "f1", 1e-6, 2e-6)] * 30
    narrow = [Judged("a long one", "d", 3e-4, 1e-4)] * 30
    part = run.Part("beam", "beam against tmm", 7, 30, (*fine, *narrow))
    lines = table([part]).splitlines()
    assert lines[0] == "beam: beam against tmm; 30 devices, seed 7"
    rows = {line.split()[0]: line.split()[1:] for line in lines[2:]}
    assert rows["f1"] == ["1", "30/30", "2", "holds"]
    assert rows["d"] == ["1", "0/30", "0.33", "fails"]
    at = next(number for number, line in enumerate(lines) if line.split()[0] == "d")
    assert lines[at + 1 : at + 3] == [
        "    worst: 3.0e-04 beside a bar of 1.0e-04", "    at a long one",
    ]  # fmt: skip
    assert not any(line.startswith("wide:") for line in lines)
    approved("\n".join(lines))


def test_wide_bars_are_said_in_table_json_and_csv(monkeypatch, capsys, tmp_path):
    """And the exit code stays 0."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "store"))
    monkeypatch.setattr(beam, "judge", lambda rng: [Judged("device", "f", 1e-6, 6e-6)])
    asked = ["coverage", "--only", "beam", "--devices", "2", "--seed", "1"]
    assert main([*asked, "--out", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2].split() == ["f", "1", "2/2", "6", "wide"]
    assert lines[3] == "wide: bars that cover, but of a median bar/error beyond 5"
    with (tmp_path / "verdicts.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert (row["quantity"], row["answers"], row["verdict"]) == ("f", "2", "wide")
    assert main([*asked, "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["rows"]["beam"]
    assert row["verdict"] == "wide"


def test_references_of_the_solid_are_per_volt_of_the_drive(monkeypatch, few_bricks):
    """At 3 V: three times the deflection, and the same capacitances and frequencies."""
    monkeypatch.setattr(solid.Case, "reference", few_bricks[0])
    one, three = (
        solid.reference(solid.Case((f"drive.voltage={volts} V", "modes=1")), ()) for volts in (1, 3)
    )
    deflection = ("static_tip_displacement", "")
    assert three.pop(deflection) == pytest.approx([3.0 * one.pop(deflection)[0]], rel=1e-9)
    assert one.keys() == three.keys()
    for name, values in one.items():
        assert three[name] == pytest.approx(values, rel=1e-9), name
    free, blocked = (abs(one[f"capacitance_{how}", ""][0]) for how in ("free", "blocked"))
    assert blocked < free < 1e-6


def test_a_seed_draws_the_same_devices(told, capsys, tmp_path, monkeypatch):
    """The second of two devices is that of a run of five; exit code 1 where bars are too narrow."""
    few = run.run_parts(["beam"], 2, 7, lambda _: None)[0].answers
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "another"))
    many = run.run_parts(["beam"], 5, 7, lambda _: None)[0].answers
    assert many[:2] == few
    assert len(told) == 7
    tmp_path = tmp_path / "out"
    code = main(["coverage", "--only", "beam", "--devices", "9", "--json", "--out", str(tmp_path)])
    out, err = capsys.readouterr()
    out = json.loads(out)
    assert f"--seed {out['seed']}" in err
    files = ("verdicts.csv", "coverage.csv", "calibration.svg")
    assert err.endswith("".join(f"{tmp_path / name}\n" for name in files))
    assert code == 1
    assert len(out["answers"][0]["answers"]) == 9
    assert {path.name for path in tmp_path.iterdir()} == set(files)
    with (tmp_path / "coverage.csv").open() as file:
        assert [float(row["relative bar"]) for row in csv.DictReader(file)] == 9 * [0.0]


def test_the_largest_seed_that_is_drawn_can_be_given(told, capsys, monkeypatch):
    monkeypatch.setattr(secrets, "randbelow", lambda below: below - 1)
    asked = ["coverage", "--only", "beam", "--devices", "1", "--json"]
    main(asked)
    seed = json.loads(capsys.readouterr().out)["seed"]
    main([*asked, "--seed", str(seed)])
    assert json.loads(capsys.readouterr().out)["seed"] == seed


def test_a_stopped_run_goes_on(told):
    """What was judged with a seed is not judged again."""

    def stopped(text):
        if "3 of 5" in text:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run.run_parts(["beam"], 5, 7, stopped)
    assert len(told) == 2
    (found,) = run.run_parts(["beam"], 5, 7, lambda _: None)
    assert len(told) == len(set(told)) == len(found.answers) == 5


def test_what_was_judged_of_other_scenes_is_judged_again(told, monkeypatch):
    """The built-in scenes are no code, and steer every answer."""
    run.run_parts(["beam"], 2, 7, lambda _: None)
    monkeypatch.setattr(run, "built_in_texts", lambda: {"paper": "name = 'another'"})
    run.run_parts(["beam"], 2, 7, lambda _: None)
    assert told[:2] == told[2:]


@pytest.mark.parametrize(
    ("judge", "model"),
    [
        (axisymmetric.judge, (axisymmetric, "solve_point")),
        (magnetic3d.judge, (magnetic3d, "solve_solid")),
        (machine.judge_map, (machine, "network_pull")),
        (machine.judge_motions, (machine, "load_scene")),
        (in_time.judge, (in_time, "scene_machine")),
    ],
)
def test_a_model_that_refuses_all_ends_the_draws(judge, model, monkeypatch):
    """One sentence, with what was said of the last of them."""
    calls = itertools.count(1)

    def refuse(*_, **__):
        raise InputError(f"no {next(calls)}")

    monkeypatch.setattr(*model, refuse)
    monkeypatch.setattr(scenes, "MOST_DRAWS", 3)
    with pytest.raises(InputError, match=r"all 3 random devices were refused; .* no 3$"):
        judge(np.random.default_rng(0))


def test_bad_input_is_refused(capsys):
    """One sentence each."""
    for arguments in (["--devices", "0"], ["--seed", "-1"], ["--only", "beams"]):
        assert main(["coverage", *arguments]) == 2
        assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.heavy
@pytest.mark.parametrize("part", [part for part in PARTS if part not in ("solid", "cad")])
def test_bars_hold(part):
    """As many devices as the command takes; solid and cad have tests of their own."""
    (found,) = run.run_parts([part], None, 1, lambda _: None)
    assert found.holds, found.rows
    assert found.devices == PARTS[part][2]
