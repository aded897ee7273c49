"""The report's section on what the tip touches."""

from tactgen.validation.report.page import templates
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections.tip_load import load_section
from tactgen.validation.scene.scene import load_scene


def study(*overrides):
    scene, origins = load_scene("paper", ["models=tmm", "quantities=load_force", *overrides])
    return Study(scene, origins, lambda _: None, quick=True)


def page(of, shown):
    return templates().get_template("load.html").render(scene=of.scene, **shown)


def test_a_free_tip_has_none():
    assert load_section(study("load.kind=none")) is None
