"""The report's section on what the tip touches."""

import re

import numpy as np
import pytest
from approved import page_text

from tactgen.tmm.ports.loads.finger import finger_impedance
from tactgen.validation.report.page import templates
from tactgen.validation.report.sections.load import load_section
from tactgen.validation.report.study import Study
from tactgen.validation.scene.scene import load_scene


def study(*overrides):
    scene, origins = load_scene("paper", ["models=tmm", "quantities=load_force", *overrides])
    return Study(scene, origins, lambda _: None, quick=True)


def page(of, shown):
    return templates().get_template("load.html").render(scene=of.scene, **shown)


def in_words(of, shown):
    html = page(of, shown)
    text = re.sub(r"\s+", " ", re.sub(r"<svg.*?</svg>|<[^>]+>", " ", html, flags=re.DOTALL))
    assert not re.search(r"\bnan\b|\bNone\b|Undefined", text)
    return text


def test_a_free_tip_has_none():
    assert load_section(study("load.kind=none")) is None


@pytest.mark.usefixtures("undrawn")
def test_the_finger_is_that_of_figures_4_and_6(approved):
    """Impedance and phase by eqs 1 and 2, stiffness and damping by eqs 4 and 5; not passive."""
    of = study("frequency=10:1000:10:log")
    shown = load_section(of)
    for row in shown["rows"]:
        z = finger_impedance(np.array([row["frequency"]]))[0]
        assert row["impedance"] * np.exp(1j * np.radians(row["phase"])) == pytest.approx(z)
        assert row["damping"] == pytest.approx(z.real)
        assert row["stiffness"] == pytest.approx(-2 * np.pi * row["frequency"] * z.imag)
        assert row["power"] > 0.0
    assert "No springs, dampers and masses have both" in in_words(of, shown)
    approved(page_text(page(of, shown)))


@pytest.mark.usefixtures("undrawn")
def test_a_table_is_shown_with_its_fits(tmp_path, approved):
    """The printed constants come back from a table of the paper's finger."""
    f = np.geomspace(10.0, 1000.0, 30)
    rows = [f"{a}, {z.real}, {z.imag}" for a, z in zip(f, finger_impedance(f), strict=True)]
    path = tmp_path / "load.csv"
    head = "frequency (Hz), impedance_re (N s/m), impedance_im (N s/m)"
    path.write_text("\n".join([head, *rows]))
    of = study("load.kind=table", f"load.file={path}", "frequency=20,500")
    shown = load_section(of)
    approved(page_text(page(of, shown)).replace(str(tmp_path), "…"))
    text = in_words(of, shown)
    for wanted in (
        "has 30 points",
        "= 0.0002263",
        "= 57.79",
        "= -38.67°",
        "is interpolated",
    ):
        assert wanted in text, wanted
