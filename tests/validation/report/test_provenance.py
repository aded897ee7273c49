"""What lies beside a report is whole and true, and the report can be computed again."""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import store_folder
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.answers import quantity_from_json, quantity_json
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.model import Quantity
from tactgen.validation.report import page as report_page
from tactgen.validation.report import provenance as again
from tactgen.validation.report import provenance as files
from tactgen.validation.report.provenance import SUMS, seal
from tactgen.validation.scene.load import load_scene

ASKED = (
    "models=lumped", "frequency=10 Hz,20 Hz",
    "quantities=tip_displacement,short_circuit_frequencies,capacitance_free",
)  # fmt: skip
PAGE = "index.html"


def made(*overrides):
    scene, _ = load_scene("prototype", [*ASKED, *overrides])
    return files.recorded(solve(scene))


@pytest.fixture(scope="module")
def record():
    return made()


@pytest.fixture
def sealed(tmp_path, record):
    """A report of one line, with all that lies beside one."""
    (tmp_path / PAGE).write_text("<p>report</p>", encoding="utf-8")
    seal(tmp_path, record, (PAGE,))
    return tmp_path


def given(value, error):
    return Quantity(np.array(value), np.array(error), name="x", model="tmm", unit="m")


def reproduced(folder):
    return again.reproduce(folder, lambda _: None)


def changed(record, quantity, value=None, **entries):
    """Return the record with other entries in one of its quantities."""

    def other(q):
        values = {**q, **entries} if value is None else {**q, **entries, "value": value}
        return values if q["name"] == quantity else q

    return replace(record, quantities=tuple(other(q) for q in record.quantities))


@pytest.mark.parametrize("named", ["", PAGE])
def test_a_report_is_computed_again_to_the_last_digit(sealed, named):
    """By its folder or any file in it; the same code on the same machine gives the same bits."""
    found = reproduced(sealed / named if named else sealed)
    assert found.holds
    assert {(row.name, row.verdict, row.difference, row.over_bars) for row in found.rows} == {
        (name, "identical", 0.0, 0.0)
        for name in ("tip_displacement", "short_circuit_frequencies", "capacitance_free")
    }


@pytest.mark.heavy
def test_a_whole_report_with_the_solid_is_computed_again(tmp_path, capsys):
    """What the command wrote, with two models and all that a quick report asks."""
    assert (
        main(["report", "j1", "--quick", "--set", "models=tmm,solid", "--out", str(tmp_path)]) == 0
    )
    capsys.readouterr()
    assert main(["report", "--reproduce", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines()[-1].endswith(" 0 differs")


def test_nothing_kept_answers_for_it(sealed, monkeypatch):
    """The second run has an empty store of its own, and leaves the user's alone."""
    seen = []
    before = store_folder()
    monkeypatch.setattr(
        again, "solve", lambda scene, announce: seen.append(store_folder()) or solve(scene)
    )
    assert reproduced(sealed).holds
    assert seen[0] != before
    assert not seen[0].exists()
    assert store_folder() == before


def test_what_differs_is_told_from_what_its_bar_covers(sealed, record):
    """Half a bar, another list of modes, a quantity that is gone."""
    capacitance = next(q for q in record.quantities if q["name"] == "capacitance_free")
    near = changed(record, "capacitance_free", capacitance["value"] + 0.5e-12, uncertainty=1e-12)
    modes = changed(record, "short_circuit_frequencies", classes=["torsion"] * 4)
    gone = replace(record, quantities=record.quantities[:-1])
    for other, verdict in ((near, "within bars"), (modes, "differs"), (gone, "differs")):
        seal(sealed, other, (PAGE,))
        found = reproduced(sealed)
        verdicts = sorted(row.verdict for row in found.rows)
        assert verdicts == sorted(["identical", "identical", verdict])
        assert found.holds is (other is near)


def test_no_number_is_not_a_number(record):
    """A recorded nan is null, comes back as nan, and equals no number."""
    q = given([1.0 + 2.0j, 3.0 - 1.0j], [0.1, np.inf])
    back = quantity_from_json(quantity_json(q))
    assert np.array_equal(back.value, q.value)
    assert np.isnan(back.error[1])
    nothing, something = (given([value, 3.0], [0.0, 0.0]) for value in (np.nan, 1.0))
    for one, other in ((nothing, something), (something, nothing)):
        assert again.compared([one], [other])[0].verdict == "differs"
    # beyond a bar that is not known there is nothing
    moved = replace(back, value=back.value + np.array([0.0, 1e-9]))
    assert again.compared([back], [moved])[0].verdict == "differs"
    assert "NaN" not in files.record_text(record)


@pytest.mark.parametrize(
    ("then", "now", "verdict", "difference", "over_bars"),
    [
        (([1.0, 2.0], [0.0, 0.0]), ([1.0, 2.0], [0.0, 0.0]), "identical", 0.0, 0.0),
        (([1.0, 2.0], [0.0, 0.1]), ([1.0, 2.05], [0.0, 0.0]), "within bars", 0.025, 0.5),
        (([1.0, 2.0], [0.0, 0.1]), ([1.005, 2.0], [0.0, 9.0]), "differs", 0.0025, np.inf),
        (([1.0, -2.0], [0.1, 0.1]), ([1.0, -2.2], [0.0, 0.05]), "differs", 0.1, 4.0 / 3.0),
        (([0.0, 0.0], [0.0, 1.0]), ([0.0, 0.5], [0.0, 0.0]), "within bars", 0.5, 0.5),
        (([np.nan, 2.0], [0.0, 0.5]), ([np.nan, 2.5], [0.0, 0.0]), "within bars", 0.25, 1.0),
        (([1.0, 2.0], [0.0, 0.1]), ([1.0, 2.0, 3.0], [0.0, 0.1, 0.0]), "differs", np.nan, np.inf),
    ],
)
def test_a_difference_is_judged_by_both_bars(then, now, verdict, difference, over_bars):
    """A number without a bar may not differ at all; each number is judged by its own."""
    before, after = given(*then), given(*now)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (found,) = again.compared([before], [after])
    assert found.verdict == verdict
    expected = pytest.approx([difference, over_bars], nan_ok=True)
    assert [found.difference, found.over_bars] == expected


@pytest.mark.parametrize("name", [PAGE, files.FILE])
def test_altered_files_are_refused(sealed, name):
    """One byte, or the whole file gone."""
    content = (sealed / name).read_bytes()
    (sealed / name).write_bytes(content[:-2] + b" \n")
    with pytest.raises(InputError, match=f"{name} was altered after the report was written"):
        reproduced(sealed)
    (sealed / name).unlink()
    with pytest.raises(InputError, match=f"{name} is missing"):
        reproduced(sealed)


def test_half_a_report_is_refused(sealed):
    """The list comes last."""
    (sealed / SUMS).unlink()
    with pytest.raises(InputError, match="has no list of checksums"):
        reproduced(sealed)
    (sealed / SUMS).write_text("not a list\n", encoding="utf-8")
    with pytest.raises(InputError, match="is not a list of checksums"):
        reproduced(sealed)
    with pytest.raises(InputError, match="does not exist"):
        reproduced(sealed / "elsewhere")


@pytest.mark.parametrize("what", ["version", "code"])
def test_another_versions_report_is_refused(sealed, record, what):
    """In one sentence that names both."""
    seal(sealed, replace(record, made_by=replace(record.made_by, **{what: "0.0.7"})), (PAGE,))
    with pytest.raises(InputError, match=r"0\.0\.7.*reproduce it with the version that wrote it"):
        reproduced(sealed)
    text = (sealed / files.FILE).read_text("utf-8").replace(files.FORMAT, "tactgen report 0")
    (sealed / files.FILE).write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="written by another version"):
        files.read_record(sealed)


def test_another_machine_is_said(sealed, record):
    """It is no reason to refuse, and one for a difference."""
    libraries = {**record.made_by.libraries, "numpy": "1.0"}
    there = replace(record.made_by, libraries=libraries, machine="VAX")
    seal(sealed, replace(record, made_by=there), (PAGE,))
    found = reproduced(sealed)
    assert found.holds
    assert [words.partition(" then")[0] for words in found.elsewhere] == [
        "numpy: 1.0", "machine: VAX",
    ]  # fmt: skip


def test_files_that_the_scene_reads_count(tmp_path, sealed):
    """A steel's table: gone or changed since, the report is not computed with another."""
    table = tmp_path / "steel.csv"
    table.write_text("H (A/m),B (T)\n0,0\n100,0.8\n1000,1.5\n50000,2.1\n", encoding="utf-8")
    stated = made(f"steel.curve={table}")
    assert list(stated.inputs) == [str(table)]
    seal(sealed, stated, (PAGE,))
    assert reproduced(sealed).holds
    table.write_text(table.read_text("utf-8").replace("0.8", "0.7"), encoding="utf-8")
    with pytest.raises(InputError, match="has changed since"):
        reproduced(sealed)
    table.unlink()
    with pytest.raises(InputError, match="is gone"):
        reproduced(sealed)


@pytest.mark.parametrize(
    "changes",
    [
        ("bimorph.width_profile=0 mm: 2.1 mm, 14 mm: 1 mm",),
        ("bimorph.length=14.0 ± 0.1 mm", "load.kind=finger"),
        ("support.kind=contact", "coil.current=0mA"),
    ],
)
def test_every_scene_comes_back_from_its_record(changes):
    """Profiles, tolerances, contacts: the scene that is solved again is the one that was."""
    scene, _ = load_scene("prototype", [*ASKED[:2], "quantities=capacitance_free", *changes])
    content = json.loads(files.record_text(files.recorded(solve(scene))))
    content.pop("format")
    assert type(scene).model_validate(content["scene"]).model_dump() == scene.model_dump()
    assert list(content["tolerances"]) == list(scene.tolerances)


def test_a_printed_report_appears_whole_or_not_at_all(tmp_path, monkeypatch):
    """Printed twice, with the contents' pages the second time: an older one stays till then."""
    page, target, drafts = tmp_path / "other.html", tmp_path / "report.pdf", []
    page.write_text("<p>report</p>", encoding="utf-8")
    target.write_bytes(b"older")

    def printed(browser, draft, temporary):
        drafts.append(draft.name)
        temporary.write_bytes(b"newer")
        assert target.read_bytes() == b"older"
        if len(drafts) == 2:
            raise InputError("the browser went away")

    monkeypatch.setattr(report_page, "print_pdf", printed)
    monkeypatch.setattr(report_page, "anchor_pages", lambda content: {})
    with pytest.raises(InputError, match="went away"):
        report_page.print_report("browser", page)
    assert (target.read_bytes(), drafts) == (b"older", ["other.html"] * 2)
    assert report_page.print_report("browser", page) == target
    assert target.read_bytes() == b"newer"


def test_the_command_prints_every_quantity(sealed, record, capsys):
    """Exit code 1 if one differs; options that would change the report are refused."""
    assert main(["report", "--reproduce", str(sealed)]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[-1] == "prototype: 3 identical, 0 within bars, 0 differs"
    seal(sealed, changed(record, "capacitance_free", 1.0), (PAGE,))
    assert main(["report", "--reproduce", str(sealed)]) == 1
    assert "differs  off by" in capsys.readouterr().out
    assert main(["report", "j1", "--reproduce", str(sealed)]) == 2
    assert main(["report", "--quick", "--reproduce", str(sealed)]) == 2
    assert "leave the scene and all other options out" in capsys.readouterr().err
