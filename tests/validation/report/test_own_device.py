"""The report of a user's own bimorph: its own story, and nothing that is the paper's only."""

import re
from html import unescape

import pytest

from tactgen.validation.report.page import write_report
from tactgen.validation.scene.load import load_scene

OWN = [
    "description=my device", "models=lumped,tmm", "bimorph.length=18mm",
    "bimorph.piezo_thickness=0.2mm",
    "bimorph.shim_thickness=0.1mm", "piezo.material=PZT-5H", "shim.youngs_modulus=105GPa",
    "shim.shear_modulus=39GPa", "shim.poisson_ratio=0.34", "shim.density=8500kg/m^3",
    "drive.voltage=40V", "load.kind=mass", "load.mass=20mg", "support.kind=clamped",
    "bimorph.width_profile=0 mm: 3 mm, 18 mm: 1.5 mm", "bimorph.bare_above=1mm",
    "bimorph.glue_thickness=10um", "bimorph.tab_length=2mm", "frequency=10:900:20",
]  # fmt: skip


#: Words of the first page about that device.
SAID = (
    "width_profile", "0 mm: 3 mm, 18 mm: 1.5 mm", "1 mm at the upper end",
    "Glue between shim and ceramic: 10 µm", "Bare shim below the ceramic: 2 mm",
    "Conditions: clamped, 20 mg on the tip", "40 V peak",
)  # fmt: skip


def words(html):
    """Return a page's text, without its style and tags."""
    text = re.sub(r"<[^>]+>", " ", re.sub(r"(?s)<(style|script).*?</\1>", "", html))
    return re.sub(r"\s+", " ", unescape(text))


@pytest.mark.heavy
def test_a_report_of_ones_own(tmp_path, undrawn, run_elsewhere):
    """The whole page: its own sections, and nothing of the paper's."""
    scene, origins = load_scene("paper", OWN)
    page = write_report(scene, origins, tmp_path, True, lambda _: None)
    text = words(page.read_text("utf-8"))
    assert [said for said in SAID if said not in text] == []
    assert not re.search(r"finger|fingertip|Fig \d", text)
