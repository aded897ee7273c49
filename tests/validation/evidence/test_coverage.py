"""The coverage study: what it counts, what it calls too narrow, and that seeds repeat."""

import csv
import itertools
import json

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.circuit import CELLS
from tactgen.tmm.reluctance.map_range import network_map
from tactgen.tmm.reluctance.network import DirectForce
from tactgen.validation.command_line.cli import main
from tactgen.validation.evidence import coverage as run
from tactgen.validation.evidence import coverage_actuator as axisymmetric
from tactgen.validation.evidence import coverage_bimorph as beam
from tactgen.validation.evidence import coverage_bimorph as solid
from tactgen.validation.evidence import random_devices as scenes
from tactgen.validation.evidence.coverage import MULTIPLES, PARTS, Judged, calibration, rows


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
    [([1.0, 5.0, 9.0], "holds"), ([1.0, 5.1, 9.0], "wide"), (3 * [0.1] + 4 * [90.0], "fails")],
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


def test_the_networks_own_pull_is_the_maps():
    """Arrays of any shape, slopes with the map's signs, as far as the steel's corners let them."""
    surface = network_map(Device())
    exact = DirectForce(Device(), CELLS, surface.gap_limits)
    current, gap = np.array([[0.05], [0.12]]), np.array([0.1e-3, 0.2e-3, 0.24e-3])
    for name in ("force", "incremental_inductance", "force_gradient", "motional_coefficient"):
        by_map, found = (getattr(pull, name)(current, gap) for pull in (surface, exact))
        assert found.shape == (2, 3)
        assert found == pytest.approx(by_map, rel=0.02), name


def test_wide_bars_are_said_in_table_json_and_csv(monkeypatch, capsys, tmp_path):
    """And the exit code stays 0."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "store"))

    def judge(_):
        return [Judged("device", "f", 1e-6, 6e-6)]

    judge.__module__ = beam.__name__  # by which the store keys it
    monkeypatch.setattr(beam, "judge_beam", judge)
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


def test_a_model_that_refuses_all_ends_the_draws(monkeypatch):
    """One sentence, with what was said of the last of them."""
    calls = itertools.count(1)

    def refuse(*_, **__):
        raise InputError(f"no {next(calls)}")

    monkeypatch.setattr(axisymmetric, "solve_point", refuse)
    monkeypatch.setattr(scenes, "MOST_DRAWS", 3)
    with pytest.raises(InputError, match=r"all 3 random devices were refused; .* no 3$"):
        axisymmetric.judge_axisymmetric(np.random.default_rng(0))


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
    assert found.devices == PARTS[part].devices
