"""The report: complete, self-contained, written in one piece; exports beside it."""

import re
from html import unescape

import pytest

from tactgen.geometry.cad import system_libraries
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh_files import read_mesh
from tactgen.validation.command_line.cli import main
from tactgen.validation.report.page import write_report
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.uncertainty import propagation
from tactgen.validation.view.formats import engineering, percent, share, with_bar


def make(tmp_path, name, *overrides):
    scene, origins = load_scene(name, overrides)
    steps = []
    page = write_report(scene, origins, tmp_path / "out", True, steps.append)
    return page.read_text(encoding="utf-8"), steps


@pytest.mark.heavy
def test_report_is_complete_and_self_contained(tmp_path, run_elsewhere):
    """All sections, every light check, pictures inside the page, no address to fetch."""
    html, steps = make(tmp_path, "j1", "mesh.level=1")
    assert re.findall(r'<h2 id="(\w+)">', html) == [
        "what", "models", "modes", "bridge", "response", "drive_limits", "length",
        "uncertainty", "checks", "credibility", "parameters", "plan",
    ]  # fmt: skip
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", html)
    assert "@import" not in html
    assert html.count('<img src="data:image/png;base64,') == 8  # solids, meshes, four modes
    assert "<td>SV-1</td>" in html
    assert "<td>INV-4</td>" in html
    assert "<td>SOL-1</td>" not in html  # about job J1 as it stands
    assert "normal actuator is reconstructed" not in html
    assert not any("network" in step or "axisymmetric" in step for step in steps)
    assert "picture of mode 4, short circuit" in steps
    assert (
        html.count('class="tv tv-light"') == html.count("class Pane") == 1
    )  # one viewer, one copy
    assert html[html.index('<h2 id="length">') :].split("<h2", 2)[1].count("<svg") == 1
    text = re.sub(r"<[^>]+>", " ", html[html.index("<main>") :])
    assert not re.search(r"\bnan\b|\bNone\b|Undefined", text)


@pytest.mark.usefixtures("run_elsewhere", "undrawn")
def test_report_without_the_solid_says_so(tmp_path, monkeypatch):
    """A scene that asks for one-dimensional models gets a report about those.

    Where its drive and load are not those that a length is designed for, that is said.
    """
    # the samples of the parameters' ranges have tests of their own
    monkeypatch.setattr(propagation, "affordable", lambda _: 100)
    html, steps = make(tmp_path, "prototype", "models=lumped,tmm", "frequency=10,100,439,1000")
    assert re.findall(r'<h2 id="(\w+)">', html) == [
        "what", "models", "modes", "bridge", "response", "drive_limits", "length", "voltage",
        "uncertainty", "checks", "credibility", "audit", "parameters", "plan",
    ]  # fmt: skip
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", html)
    assert "The solid model was not asked for" in html
    text = unescape(re.sub(r"<[^>]+>", "", html))
    assert "at 50 V under the finger instead of this scene's 1 V, with a free tip" in text
    assert not re.search(r"\bnan\b|\bNone\b|Undefined", re.sub(r"<[^>]+>", " ", html))
    assert not any(step.startswith("solid.") for step in steps if "check" not in step)


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
    assert capsys.readouterr().out.split() == [str(step), str(glb), str(mesh)]
    assert step.read_text(encoding="utf-8").startswith("ISO-10303-21")
    assert glb.read_bytes()[:4] == b"glTF"
    written = read_mesh(mesh)
    assert set(written.regions) == {"piezo_top", "piezo_bottom", "shim"}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["g.glb", "g.step", "m.vtu"]


def test_missing_library_is_one_sentence(monkeypatch):
    """What would crash the renderer is found before it is loaded."""
    monkeypatch.setitem(system_libraries._PACKAGE, "libnothing.so", "libosmesa6")
    with pytest.raises(InputError, match="apt-get install --no-install-recommends libosmesa6"):
        system_libraries.require_library("libnothing.so", "pictures")


def test_numbers_for_people():
    """Engineering prefixes, digits that the bar allows, rounding bars as powers of ten."""
    assert engineering(4.955e-5, "m") == "49.55 µm"
    assert engineering(0.0, "m") == "0 m"
    assert engineering(9.9996e-7, "m", 3) == "1 µm"  # and not 1e+03 nm
    assert engineering(4.96e-4, "N m", 2) == "500 µN m"  # and not 5e+02 µN m
    assert engineering(5e12, "Pa", 2) == "5e+03 GPa"  # no prefix goes further
    assert engineering(9.9996e-7, "m", 5) == "999.96 nm"
    assert with_bar(4.7087e-5, 2.6e-8, "m") == "47.087 ± 0.026 µm"
    assert with_bar(-6.7582e-7, 1e-20, "m").startswith("-675.82 nm (±1e-14")
    assert with_bar(365.1, 10.2, "Hz") == "365 ± 10 Hz"
    assert percent(0.0524) == "+5.240 %"
    assert percent(3e-8) == "+3e-06 %"
    assert percent(3e-14) == "0 %"
    assert share(0.00822) == "0.82 %"
    assert with_bar(1.0, float("inf"), "m") == "1 m (no error bar)"


def test_printing_without_a_browser_is_refused_before_any_work(tmp_path, monkeypatch, capsys):
    """One sentence, nothing written."""
    from tactgen.validation.command_line.cli import main
    from tactgen.validation.view import browser

    monkeypatch.setattr(browser.shutil, "which", lambda _: None)
    assert main(["report", "j1", "--out", str(tmp_path / "out"), "--pdf"]) == 2
    assert "--pdf needs a Chromium or Chrome browser" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_page_prints_with_numbered_pages(tmp_path):
    """Chromium makes a PDF of two pages; where anchors stand in it is found again."""
    from tactgen.validation.view.browser import find_browser, print_pdf
    from tactgen.validation.view.pdf_pages import anchor_pages

    found = find_browser()
    if found is None:
        pytest.skip("no Chromium on this machine")
    page = tmp_path / "index.html"
    page.write_text(
        "<a href='#one'>1</a><a href='#two'>2</a><p id=one>one</p>"
        "<p id=two style='break-before:page'>two</p>",
        encoding="utf-8",
    )
    print_pdf(found, page, tmp_path / "page.pdf")
    pdf = (tmp_path / "page.pdf").read_bytes()
    assert pdf.startswith(b"%PDF")
    assert pdf.count(b"/Type /Page\n") == 2
    assert anchor_pages(pdf) == {"one": 1, "two": 2}


def test_contents_have_page_numbers_where_a_printed_page_tells_them():
    """Of what is no PDF of Chromium's nothing is told, and the page stays as it is."""
    from tactgen.validation.report.page import _with_pages
    from tactgen.validation.view.pdf_pages import anchor_pages

    html = '<a href="#what">1 What <span class="page" data-of="what"></span></a>'
    assert ">12</span>" in _with_pages(html, {"what": 12, "elsewhere": 3})
    assert _with_pages(html, anchor_pages(b"%PDF-1.4 of another program")) == html
