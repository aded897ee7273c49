"""Two scenes or studies side by side: what differs, and what the error bars cover."""

import json
import re
from dataclasses import replace

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.answers import COLUMNS
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show import export, pictures
from tactgen.validation.studies.whatif import compare
from tactgen.validation.studies.whatif.compare import Comparison, Key, Number, Side, read_sides
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.output_files import TABLE

KEY = Key((), "capacitance_free", "solid", "", "")
SCENE = load_scene("prototype")[0]
HEAD = ",".join(["gap (m)", *COLUMNS])


def side(name, **numbers):
    held = {KEY._replace(number=n): v for n, v in numbers.items()}
    return Side(name, {}, held, 0, SCENE)


@pytest.mark.parametrize(
    ("modelling", "shown"), [(0.0, ""), (0.02, " (± 2 %)"), (float("nan"), " (?)")]
)
def test_the_modelling_error_stands_beside_the_bar(modelling, shown):
    """It is no part of the verdict: one model's error is mostly the same on both sides."""
    a, b = (Number(v, 0.01, "F", modelling) for v in (1.0, 1.1))
    (found,) = Comparison(side("a", x=a), side("b", x=b)).answers
    assert found.cells[3].endswith("F" + shown) or found.cells[3].endswith("%" + shown)
    assert found.beyond == 1


def test_the_largest_change_beyond_the_bars_is_shown():
    """Not the largest of all, if its bars cover it; what only one has is counted."""
    wide = Number(1.0, 1.0, "F"), Number(1.9, 1.0, "F")
    sharp = Number(1.0, 0.0, "F"), Number(1.01, 0.0, "F")
    a = side("a", wide=wide[0], sharp=sharp[0], lone=sharp[0])
    (found,) = Comparison(a, side("b", wide=wide[1], sharp=sharp[1])).answers
    assert (found.key.number, found.beyond, found.count, found.only) == ("sharp", 1, 2, (1, 0))
    nothing = Number(complex("nan"), float("nan"), "F")
    (found,) = Comparison(side("a", x=nothing), side("b", x=sharp[0])).answers
    assert (found.beyond, found.relative) == (1, 0.0)
    (found,) = Comparison(side("a", x=nothing), side("b", x=nothing)).answers
    assert found.beyond == 0


@pytest.mark.parametrize(
    ("frequencies", "along", "abscissae", "gaps"),
    [(("",), "gap (m)", [1.0, 2.0], [""]),
     (("10", "50"), "frequency (Hz)", [10.0, 50.0], ["gap 1000 mm, ", "gap 2000 mm, "])],
)  # fmt: skip
def test_curves_run_along_the_first_axis_of_numbers(
    monkeypatch, frequencies, along, abscissae, gaps
):
    """Words before it and numbers after it tell the curves apart; over frequency all values do.

    Numbers stand in the unit of their key, without digits of rounding.
    """
    drawn = []
    monkeypatch.setattr(compare, "svg", drawn.append)
    held = {
        Key((("load.kind", load), ("gap", gap), ("bimorph.width", "0.0015000000000000001")),
            "force", "tmm", frequency, ""): Number(1.0, 0.0, "N")
        for load in ("none", "mass") for gap in ("1", "2") for frequency in frequencies
    }  # fmt: skip
    compare._curves((Side("a", {}, held, 0, SCENE), Side("b", {}, held, 0, SCENE)))
    (axis,) = drawn[0].axes
    assert axis.get_xlabel() == along
    assert [line.get_label() for line in axis.lines[::2]] == [
        f"A tmm, load.kind {load}, {gap}bimorph.width 1.5 mm"
        for load in ("none", "mass") for gap in gaps
    ]  # fmt: skip
    assert axis.lines[0].get_xdata().tolist() == abscissae


def compared(capsys, *arguments):
    code = main(["compare", *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_two_scenes(capsys, tmp_path):
    """Input and numbers are those of the scenes; the page needs nothing from elsewhere."""
    asked = ("--quantity", "static_tip_displacement", "--quantity", "tip_displacement",
             "--frequency", "10:1000:9")  # fmt: skip
    both = ("paper", "prototype", "--set", "bimorph.length=20mm", *asked)
    found = json.loads(compared(capsys, *both, "--json", "--out", tmp_path)[1])
    assert {i["key"]: (i["a"], i["b"]) for i in found["inputs"]} == {
        "load.kind": ("finger", "none"), "drive.voltage": ("50 V", "1 V"),
    }  # fmt: skip
    static = next(a for a in found["answers"] if a["quantity"] == "static_tip_displacement")
    expected = [
        solve(load_scene(n, ["bimorph.length=20mm"])[0], ("tmm",), ("static_tip_displacement",))
        for n in ("paper", "prototype")
    ]
    assert [static["a"], static["b"]] == [float(s.quantities[0].value) for s in expected]
    peak = next(a for a in found["answers"] if a["quantity"] == "tip_displacement, largest")
    responses = [a for a in found["answers"] if a["quantity"] == "tip_displacement"]
    assert peak["b"] >= max(abs(complex(*a["b"])) for a in responses)
    assert static["verdict"] == "beyond the bars"
    assert static["change"] == pytest.approx(1 / 50 - 1)
    written = (tmp_path / "compare.html").read_text(encoding="utf-8")
    assert not re.findall(r"""(?:src|href)=["'](?!#|data:)|<link|<script|url\((?!#)""", written)
    assert 'aria-label="tip displacement (µm) over frequency (Hz)"' in written
    assert "the input is the same" in compared(capsys, "paper", "paper", *asked)[1]


def test_two_scenes_without_a_common_answer(capsys, tmp_path):
    """It is said, with the remedy; names are listed as a scene writes them."""
    magnet = tmp_path / "magnet.toml"
    magnet.write_text('models = ["network"]\nquantities = ["magnetic_force", "coenergy"]\n')
    same = ("--set", "bimorph.length=14mm", "--frequency", "100")  # so no devices are drawn
    _, out, _ = compared(capsys, "prototype", magnet, *same, "--out", tmp_path)
    said = "no answer is on both sides; ask both for one quantity by one model"
    assert said in out
    assert said in (tmp_path / "compare.html").read_text("utf-8")
    rows = {line.split()[0]: line.split()[1:] for line in out.splitlines() if line.strip()}
    assert rows["models"] == ["tmm", "network"]
    assert rows["quantities"][-2:] == ["magnetic_force,", "coenergy"]


def test_a_browser_has_no_complaint(capsys, tmp_path, driven):
    """Two studies with an own axis: tables and curves are there, each with words for it."""
    asked = ("--vary", "bimorph.length=14mm:16mm:3", "--quantity", "static_tip_displacement")
    for name, voltage in (("a", "1V"), ("b", "2V")):
        given = ("--set", f"drive.voltage={voltage}", "--out", str(tmp_path / name))
        assert main(["whatif", "prototype", *asked, *given]) == 0
    assert compared(capsys, tmp_path / "a", tmp_path / "b", "--out", tmp_path)[0] == 0
    found = driven(
        (tmp_path / "compare.html").read_text(encoding="utf-8"),
        """found.cells = all('td').map((cell) => cell.textContent);
        found.pictures = all('figure > svg').map((svg) => svg.getAttribute('aria-label'));
        found.wide = document.documentElement.scrollWidth - window.innerWidth;""",
        "--disable-gpu",
    )
    assert found["cells"][:3] == ["drive.voltage", "1 V", "2 V"]
    assert found["pictures"] == ["static tip displacement (µm) over bimorph.length (m)"]
    assert found["wide"] <= 0


def test_what_cannot_be_compared_is_refused(tmp_path, capsys):
    code, out, err = compared(capsys, "paper", "nowhere")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "neither a readable file" in err
    study = tmp_path / "study"
    study.mkdir()
    (study / "study.json").write_text("{}")
    with pytest.raises(InputError, match="a scene and a study"):
        read_sides(("paper", str(study)), (), None, None, lambda _: None)
    with pytest.raises(InputError, match="compared as they were written"):
        read_sides((str(study), str(study)), (), ["tmm"], None, lambda _: None)


@pytest.mark.parametrize(
    ("table", "words"),
    [(None, "[Errno 2]"), ("length,quantity\n", "other columns)"),
     (f"{HEAD}\n1,gap,tmm,,,,1 mm,,,,m,ok,\n", "could not convert")],
)  # fmt: skip
def test_a_study_whose_table_is_lost_or_damaged_is_refused(tmp_path, monkeypatch, table, words):
    """With the command that writes it again."""
    stated = Statement("paper", {}, ("gap=1mm,2mm",), ("tmm",), ())
    monkeypatch.setattr(compare, "read_statement", lambda _: stated)
    if table is not None:
        (tmp_path / TABLE).write_text(table)
    with pytest.raises(InputError) as caught:
        compare._study(tmp_path)
    assert f"{tmp_path / TABLE} is not the table of a study ({words}" in str(caught.value)
    assert str(caught.value).endswith(f"tactgen whatif --resume --out {tmp_path}")


def test_pictures_of_devices_have_one_scale(monkeypatch):
    """The larger is as high as a picture may be; where none can be made, it is said why."""
    made = [bytes(20) + height.to_bytes(4, "big") for height in (100, 70)]
    monkeypatch.setattr(pictures, "solids_pictures", lambda _: made)
    monkeypatch.setattr(export, "scene_solids", lambda _: {})
    sides = [replace(side(name), inputs={"bimorph.length": name}) for name in ("long", "short")]
    said = "".join(compare._devices(Comparison(*sides)))
    heights = [float(height) for height in re.findall(r"height:([\d.]+)rem", said)]
    assert heights == pytest.approx([compare._TALLEST, 0.7 * compare._TALLEST], abs=5e-3)
    assert re.findall(r"<figcaption>(.*?)</figcaption>", said) == ["A: long", "B: short"]
    driven = [replace(of, inputs={"drive.voltage": of.name}) for of in sides]
    assert compare._devices(Comparison(*driven)) == []

    def none(_):
        raise InputError("no solids of <these>")

    monkeypatch.setattr(export, "scene_solids", none)
    (said,) = compare._devices(Comparison(*sides))
    assert said == "<p>No picture of the devices: no solids of &lt;these&gt;</p>"
