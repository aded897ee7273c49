"""The report: complete, self-contained, written in one piece; exports beside it."""

import json
import math
import re
import shutil
import subprocess

import meshio
import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import engineering, percent, prefixed, share, signed, with_error
from tactgen.validation.catalogue.models import models_of
from tactgen.validation.command_line.cli import main
from tactgen.validation.models.bimorph.solid import cells_of, mesh_pair
from tactgen.validation.report.page import _with_pages, print_report, write_report
from tactgen.validation.report.sections.bimorph_figures import MODEL_STYLE, response_values
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.browser import anchor_pages, find_browser
from tactgen.validation.studies import parameter_uncertainty as propagation


def make(tmp_path, name, *overrides):
    scene, origins = load_scene(name, overrides)
    steps = []
    page = write_report(scene, origins, tmp_path / "out", True, steps.append)
    return page.read_text(encoding="utf-8"), steps


def test_a_model_without_a_value_there_tells_none():
    """Where the page is pointed at: null, of which the page makes words, and never nan."""
    curve = {"tip_displacement": {"tmm": np.array([2e-6j, np.nan])}}
    values = json.loads(response_values(np.array([10.0, 20.0]), curve))
    shown = values["cases"][0]["models"]["tmm"]
    assert shown == {"size": ["2 µm", None], "phase": ["90.0", None]}


def test_every_model_of_the_bimorph_has_a_line():
    assert set(MODEL_STYLE) == set(models_of("bimorph"))


@pytest.mark.heavy
def test_report_is_complete_and_self_contained(tmp_path, run_elsewhere):
    """All sections, every light check, pictures inside the page, no address to fetch."""
    html, steps = make(tmp_path, "j1", "mesh.level=1")
    assert re.findall(r'<h2 id="(\w+)">', html) == [
        "models", "modes", "response", "drive_limits", "bridge", "uncertainty", "checks",
        "parameters",
    ]  # fmt: skip
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", html)
    assert "@import" not in html
    # solids, two meshes, four modes, stress
    assert html.count('src="data:image/png;base64,') == 8
    assert "five-port matrix of the model solid is reciprocal and passive" in html
    assert "<td>SOL-1</td>" not in html  # about job J1 as it stands
    assert "is reconstructed" not in html
    assert not any("network" in step or "axisymmetric" in step for step in steps)
    assert "picture of mode 4, short circuit" in steps
    assert (
        html.count('class="tv tv-light"') == html.count("class Pane") == 1
    )  # one viewer, one copy
    text = re.sub(r"<[^>]+>", " ", html[html.index("<main>") :])
    assert not re.search(r"\bnan\b|\bNone\b(?! does)|Undefined", text)


@pytest.fixture(scope="module")
def prototype(tmp_path_factory, make_plain):
    """The plain page of a bimorph by the cheapest models at few frequencies.

    Few samples are drawn: they have tests of their own.
    """
    asked = ("models=lumped,tmm", "frequency=10,100,439,1000", "modes=1")
    with pytest.MonkeyPatch.context() as patch:
        make_plain(patch)
        patch.setattr(propagation, "_EVALUATIONS", 30)
        return make(tmp_path_factory.mktemp("prototype"), "prototype", *asked)


def test_report_without_the_solid_says_so(prototype):
    """A scene that asks for one-dimensional models gets a report about those."""
    html, steps = prototype
    assert re.findall(r'<h2 id="(\w+)">', html) == [
        "models", "modes", "response", "drive_limits", "uncertainty", "checks", "parameters",
    ]  # fmt: skip
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", html)
    assert "No detailed model was solved" in html
    assert not re.search(r"\bnan\b|\bNone\b(?! does)|Undefined", re.sub(r"<[^>]+>", " ", html))
    assert not any(step.startswith("solid.") for step in steps if "check" not in step)


#: A table of several words in each heading, and of lists of names: both have to wrap.
HEADS = "".join(f'<th class="n">a heading of several words {k}</th>' for k in range(7))
CELLS = '<td class="n">+12.34 %</td>' * 7
NAMES = '<td rowspan="2">tip displacement, tip velocity, detection ratio, load force</td>'
WIDE = f"<table><tr><th>share</th>{HEADS}</tr><tr>{NAMES}{CELLS}</tr><tr>{CELLS}</tr></table>"
#: Rules for paper, put in force on the screen.
PAPER = """
  const rules = [...document.styleSheets].flatMap((sheet) => [...sheet.cssRules])
    .filter((rule) => rule instanceof CSSMediaRule);
  const under = (word) => rules.filter((rule) => rule.conditionText.includes(word))
    .flatMap((rule) => [...rule.cssRules]);
  const style = document.createElement('style');
  style.textContent = under('print').map((rule) => rule.cssText).join(' ');
"""


def test_a_report_in_a_browser(prototype, driven):
    """Opened where all is dark: what is pointed at, followed, and printed; light is no other."""
    found = driven(
        prototype[0],
        f"""
        const plot = one('figure:has(.values)'), drawn = plot.querySelectorAll('g[id^="axes_"]');
        const panels = [...drawn].map((g) => g.querySelector('path').getBoundingClientRect());
        found.panels = panels.length;
        const point = (x, y) => plot.dispatchEvent(
          new PointerEvent('pointermove', {{ clientX: x, clientY: y, bubbles: true }}));
        const [first, second] = panels;
        found.before = text('.told');
        point(first.left - 20, first.top + 5); found.beside = text('.told');
        point(first.left + 0.1, first.top + 5); found.low = text('.told');
        point(second.right - 0.1, second.bottom - 5); found.high = text('.told');
        found.frequencies = JSON.parse(text('.values')).frequency;
        found.links = all('nav a').map((a) => [a.hash, one(a.hash) !== null]);
        one('#parameters').scrollIntoView(); dispatchEvent(new Event('scroll'));
        found.current = all('nav a[aria-current]').map((a) => a.hash);
        const sheet = one('main'), inner = parseFloat(getComputedStyle(sheet).paddingRight);
        sheet.insertAdjacentHTML('beforeend', {json.dumps(WIDE)});
        found.over = sheet.lastElementChild.getBoundingClientRect().right
          - sheet.getBoundingClientRect().right + inner;
        sheet.lastElementChild.remove();
        found.dark = matchMedia('(prefers-color-scheme: dark)').matches;
        {PAPER}
        found.darkened = under('dark').map((rule) => rule.selectorText).filter(one);
        document.head.append(style);
        found.paper = getComputedStyle(one('main')).backgroundColor;
        found.rules = under('print').length;
        found.moving = all('.tv, .up, .told').length;
        const beyond = (node) => node.getBoundingClientRect().right > innerWidth + 1;
        const wide = all('main *:not(svg *)').filter(beyond);
        found.wide = wide.map((node) => node.outerHTML.slice(0, 90));
        """,
        "--blink-settings=preferredColorScheme=0",
    )
    assert found["panels"] == 2
    assert found["before"] == found["beside"] == "Point at a panel to read values."
    assert found["low"].startswith("tip displacement, 10.00 Hz: lumped ")
    assert "tmm " in found["low"]
    assert "nm" in found["low"]
    assert found["high"].startswith("admittance, 1000 Hz: ")
    assert found["frequencies"][0] == 10.0
    assert len(found["frequencies"]) == 400
    assert {"#models", "#response", "#parameters"} <= {link for link, _ in found["links"]}
    assert all(there for _, there in found["links"])
    assert found["current"] == ["#parameters"]
    assert abs(found["over"]) < 2.0  # 1 px and a fraction are rounding
    assert found["dark"]
    assert found["darkened"] == []  # no rule for the dark: words and pictures are made for white
    assert found["paper"] == "rgb(255, 255, 255)"
    assert found["rules"] >= 1
    assert found["moving"] == 0
    assert found["wide"] == []


def test_folder_is_checked_before_any_work(tmp_path):
    """A file where the folder should be: refused at once, and the file is untouched."""
    blocker = tmp_path / "report"
    blocker.write_text("mine", encoding="utf-8")
    scene, origins = load_scene("paper")
    with pytest.raises(InputError, match="cannot be written"):
        write_report(scene, origins, blocker, True, lambda _: pytest.fail("work was done"))
    assert blocker.read_text(encoding="utf-8") == "mine"


def test_exported_files_are_complete(tmp_path, capsys):
    """STEP, glTF and mesh of the built-in generator and bimorph."""
    step, glb, mesh = tmp_path / "g.step", tmp_path / "g.glb", tmp_path / "m.vtu"
    assert main(["export", "bimorph_on_rod", "--step", str(step), "--glb", str(glb)]) == 0
    assert main(["export", "j1", "--set", "mesh.level=2", "--mesh", str(mesh)]) == 0
    assert capsys.readouterr().out.splitlines() == [str(step), str(glb), str(mesh)]
    assert step.read_text(encoding="utf-8").startswith("ISO-10303-21")
    assert glb.read_bytes()[:4] == b"glTF"
    written = meshio.read(mesh)
    regions = {f"region {name}" for name in ("piezo_top", "piezo_bottom", "shim")}
    assert regions == {name for name in written.cell_data if name.startswith("region ")}
    finest = mesh_pair(load_scene("j1", ["mesh.level=2"])[0]).meshes[0]
    assert len(written.cells[0].data) == len(cells_of(finest).cells)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["g.glb", "g.step", "m.vtu"]


def test_numbers_that_are_none_and_bars_of_nothing():
    """What is not finite is said in words; a value without an error keeps seven digits."""
    assert [percent(x) for x in (math.nan, 1e-12, -2e-6, 0.5)] == [
        "n/a", "0 %", "-2e-04 %", "+50.000 %",
    ]  # fmt: skip
    assert [share(x) for x in (math.inf, 0.0123)] == ["n/a", "1.2 %"]
    assert prefixed(3e-5, "m") == (pytest.approx(1e6), "µm")
    assert prefixed(3e-5, "1") == prefixed(0.0, "1") == (1.0, "1")
    assert prefixed(math.inf, "m") == (1.0, "m")
    assert with_error(1.23456789e-3, 0.0, "m") == "1.234568 mm"
    assert with_error(1.23456789e-3, math.nan, "m") == "1.2346 mm (no error bar)"


def test_numbers_for_people():
    """Engineering prefixes, digits that the bar allows, rounding bars as powers of ten."""
    assert engineering(4.955e-5, "m") == "49.55 µm"
    assert engineering(0.0, "m") == "0 m"
    assert engineering(0.042667, "in") == "0.042667 in"  # and not 42.667 min
    assert engineering(9.9996e-7, "m", 3) == "1 µm"  # and not 1e+03 nm
    assert engineering(4.96e-4, "N m", 2) == "500 µN m"  # and not 5e+02 µN m
    assert engineering(5e12, "Pa", 2) == "5e+03 GPa"  # no prefix goes further
    assert engineering(9.9996e-7, "m", 5) == "999.96 nm"
    assert with_error(4.7087e-5, 2.6e-8, "m") == "47.087 ± 0.026 µm"
    assert with_error(-6.7582e-7, 1e-20, "m").startswith("-675.82 nm (±1e-14")
    assert with_error(365.1, 10.2, "Hz") == "365 ± 10 Hz"
    assert with_error(5e-9, 8.4134e-5, "N") == "0 ± 84 µN"  # read beside its bar
    assert percent(0.0524) == "+5.240 %"
    assert percent(3e-8) == "+3e-06 %"
    assert percent(3e-14) == "0 %"
    assert share(0.00822) == "0.82 %"
    assert with_error(1.0, float("inf"), "m") == "1 m (no error bar)"


def test_zero_has_no_sign():
    """No "-0.000", no "-0.0 %", no "-0 N", and no "-0.0" within its bar."""
    for number, text in ((-1e-9, "0.000"), (-0.0, "0.000"), (-0.0004, "0.000"), (6e-4, "+0.001")):
        assert signed(number, 3) == text
        assert percent(0.01 * number, 3) == f"{text} %"
    assert engineering(-0.0, "N") == "0 N"
    assert with_error(-1e-3, 0.1, "m").startswith("-1 ")
    assert with_error(-0.001, 1.2, "1") == "0.0 ± 1.2"


def test_printing_without_a_browser_is_refused_before_any_work(tmp_path, monkeypatch, capsys):
    """One sentence, nothing written."""
    from tactgen.validation.command_line.cli import main
    from tactgen.validation.show import browser

    monkeypatch.setattr(browser.shutil, "which", lambda _: None)
    assert main(["report", "j1", "--out", str(tmp_path / "out"), "--pdf"]) == 2
    assert "--pdf needs a Chromium or Chrome browser" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.heavy
def test_a_report_prints(prototype, tmp_path):
    """Pages with numbers and none nearly empty; each section where the contents have it, once."""
    browser = find_browser()
    if browser is None or shutil.which("pdftotext") is None:
        pytest.skip("no Chromium or no Poppler on this machine")
    page = tmp_path / "page.html"
    page.write_text(prototype[0], encoding="utf-8")
    pdf = print_report(browser, page)
    pages = said("pdftotext", "-layout", pdf, "-").decode().split("\f")[:-1]
    assert [text.split("\n\n")[-1].replace(" ", "").strip() for text in pages] == [
        f"{number}/{len(pages)}" for number in range(1, len(pages) + 1)
    ]
    titles = re.findall(r'<h2 id="\w+">(.*?)</h2>', prototype[0])
    contents = "\n".join(pages[:2])
    for title in titles:
        (at,) = (
            k for k, text in enumerate(pages, 1) if re.search(rf"^ *{title}$", text, re.MULTILINE)
        )
        assert re.search(rf"{title} +{at}\b", contents), title
    drawn = said("pdftoppm", "-r", "12", "-gray", pdf).split(b"P5\n")[1:]
    for picture in drawn[:-1]:
        size, _, dots = picture.split(b"\n", 2)
        width, height = map(int, size.split())
        ink = (np.frombuffer(dots, np.uint8).reshape(height, width) < 220).any(axis=1)
        # the foot with the page's number apart
        assert np.flatnonzero(ink[: int(0.93 * height)])[-1] > 0.5 * height


def said(*command):
    """Return what a command writes."""
    return subprocess.run(command, check=True, capture_output=True).stdout


def test_contents_have_page_numbers_where_a_printed_page_tells_them():
    """Of what is no PDF of Chromium's nothing is told, and the page stays as it is."""
    html = '<a href="#what">1 What <span class="page" data-of="what"></span></a>'
    assert ">12</span>" in _with_pages(html, {"what": 12, "elsewhere": 3})
    assert _with_pages(html, anchor_pages(b"%PDF-1.4 of another program")) == html
