"""The report of a user's own bimorph: its own story, and nothing that is the paper's only."""

import re
from html import unescape
from types import SimpleNamespace

import pytest

from tactgen.validation.models.difference import expected_differences
from tactgen.validation.report.page import write_report
from tactgen.validation.report.sections import bimorph
from tactgen.validation.scene.scene import load_scene

OWN = [
    "models=lumped,tmm", "bimorph.length=18mm", "bimorph.piezo_thickness=0.2mm",
    "bimorph.shim_thickness=0.1mm", "piezo.material=PZT-5H", "shim.youngs_modulus=105GPa",
    "shim.shear_modulus=39GPa", "shim.poisson_ratio=0.34", "shim.density=8500kg/m^3",
    "drive.voltage=40V", "load.kind=mass", "load.mass=20mg", "support.kind=clamped",
    "bimorph.width_profile=0 mm: 3 mm, 18 mm: 1.5 mm", "bimorph.bare_above=1mm",
    "bimorph.glue_thickness=10um", "bimorph.tab_length=2mm", "frequency=10:900:20",
]  # fmt: skip


#: What section 1 must say of that device.
SAID = (
    "width_profile", "0 mm: 3 mm, 18 mm: 1.5 mm", "1 mm at the upper", "10 µm of glue",
    "the bare shim goes on for 2 mm", "a mass of 20 mg", "40 V",
)  # fmt: skip


def words(html):
    """Return a page's text, without its style and tags."""
    text = re.sub(r"<[^>]+>", " ", re.sub(r"(?s)<style.*?</style>", "", html))
    return re.sub(r"\s+", " ", unescape(text))


@pytest.mark.parametrize(("name", "there"), [("j1", False), ("prototype", True)])
def test_the_papers_sections_are_about_the_papers_device(name, there, monkeypatch):
    """Its printed formulas, and voltages that were felt on its display."""
    monkeypatch.setattr(bimorph.audit, "section", lambda *_: {})
    monkeypatch.setattr(bimorph.voltage_section, "section", lambda *_: {})
    study = SimpleNamespace(scene=load_scene(name)[0], announce=lambda _: None)
    for section in (bimorph._audit, bimorph._voltage):
        assert (section(study) is not None) is there


@pytest.mark.heavy
def test_a_report_of_ones_own(tmp_path, undrawn, run_elsewhere):
    """The whole page: its own sections, and in the headline what no model here has."""
    scene, origins = load_scene("paper", OWN)
    page = write_report(scene, origins, tmp_path, True, lambda _: None)
    text = words(page.read_text("utf-8"))
    assert [said for said in (*SAID, "No solid was solved") if said not in text] == []
    for label, band in zip(
        ("static tip displacement", "free capacitance"),
        list(expected_differences(scene).values())[::2],
        strict=True,
    ):
        both = f"{100 * band.low:+.0f} to {100 * band.high:+.0f}"
        assert re.search(rf"{re.escape(both)}\D*{label}", text)
    for other in ("The printed formulas", "Voltage at the detection threshold", "Fig 9", "Fig 17"):
        assert other not in text, other
