"""Statistics of drawn points: of each model and of each value of what is not drawn."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from tactgen.validation.engine.answers import Answer
from tactgen.validation.scene.load import scene_values
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.output_files import (
    STATISTICS,
    sample_statistics,
    statistics_lines,
    write_statistics,
)
from tactgen.validation.studies.whatif.study import run_study

STATIC = "static_tip_displacement"


@pytest.fixture(scope="module")
def study():
    """Six draws of the width at two lengths by two models; one draw has no answer by tmm."""
    values, _ = scene_values("prototype")
    axes = ("bimorph.length=14mm,16mm", "bimorph.piezo_thickness=normal(0.26mm,2%)")
    models = ("tmm", "lumped")
    found = run_study(Statement("prototype", values, axes, models, (STATIC,), samples=6))
    first = {**found.answers[0], "tmm": Answer("failed", "why")}
    return replace(found, answers=(first, *found.answers[1:]))


def test_mean_deviation_and_percentiles_are_those_of_the_answers(study):
    """At each length over its own draws; a draw without an answer is left out."""
    found = {(one.at["bimorph.length"], one.model): one for one in sample_statistics(study)}
    assert set(found) == {(length, m) for length in (0.014, 0.016) for m in ("tmm", "lumped")}
    assert [found[0.014, m].count for m in ("tmm", "lumped")] == [5, 6]
    for (length, model), one in found.items():
        values = [
            q.value for point, m, answer in study.rows for q in answer.quantities
            if (point["bimorph.length"], m) == (length, model)
        ]  # fmt: skip
        assert one.mean == pytest.approx(np.mean(values), rel=1e-12)
        assert one.deviation == pytest.approx(np.std(values, ddof=1), rel=1e-9)
        assert one.percentiles == pytest.approx(np.percentile(values, [5, 50, 95]), rel=1e-12)


def test_they_are_printed_and_written(study, tmp_path):
    found = sample_statistics(study)
    _, _, *lines = statistics_lines(study, found)
    assert len(lines) == len(found)
    with write_statistics(tmp_path, study, found).open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert (tmp_path / STATISTICS).exists()
    assert [float(row["percentile_95"]) for row in rows] == [one.percentiles[2] for one in found]
    assert [float(row["bimorph.length (m)"]) for row in rows] == [0.014, 0.016] * 2
    assert {row["unit"] for row in rows} == {"m"}


def test_one_draw_has_no_deviation_and_steps_have_no_statistics():
    values, _ = scene_values("prototype")
    axes = ("gap=normal(0.2mm,2%)",)
    drawn = Statement("prototype", values, axes, ("tmm",), (STATIC,), samples=1)
    one = run_study(drawn)
    (found,) = sample_statistics(one)
    assert np.isnan(found.deviation)
    assert "-" in statistics_lines(one, [found])[-1].split()
    stepped = run_study(replace(drawn, vary=("gap=0.1mm,0.2mm",), samples=0))
    assert sample_statistics(stepped) == []
    assert statistics_lines(stepped, []) == []
