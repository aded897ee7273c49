"""The picture of a study's aims: which one the axes and goals ask for, and that it is right."""

from tactgen.validation.scene.scene import scene_values
from tactgen.validation.studies.whatif.aim_evaluation import parse_aims, verdict
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.page import write_page
from tactgen.validation.studies.whatif.study import run_study

LENGTH, WIDTH = "bimorph.length=14mm:22mm:5", "bimorph.width=1.5mm:2.1mm:3"
QUANTITIES = ("static_tip_displacement", "short_circuit_frequencies")
FAST = "first(short_circuit_frequencies) >= 500 Hz"


def asked(vary, *aims, **more):
    """Return a study by transfer matrices and what the aims say of it."""
    values, _ = scene_values("prototype", ["modes=1"])
    study = run_study(Statement("prototype", values, vary, ("tmm",), QUANTITIES, **more))
    return study, verdict(study, parse_aims(aims))


def test_the_page_begins_with_what_the_aims_say(tmp_path):
    """Words and picture stand before the sliders; without aims there is neither."""
    study, found = asked((LENGTH,), FAST)
    page = write_page(tmp_path, study, found).read_text(encoding="utf-8")
    said = f"{len(found.met)} of 5 points meet {FAST}".replace(">", "&gt;")
    assert page.index("<h2>Aims</h2>") < page.index(said) < page.index("<h2>Slide</h2>")
    assert "<h2>Aims</h2>" not in write_page(tmp_path, study).read_text(encoding="utf-8")
