"""A report as a browser shows it: values where it is pointed at, sections, dark mode, paper."""

import pytest

from tactgen.validation.report.page import write_report
from tactgen.validation.report.sections import bimorph
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.uncertainty import propagation

#: Few frequencies and the cheapest models: the page is the same.
FEW = ("models=lumped,tmm", "frequency=10,100,439,1000")
#: Sections of the lateral actuator that move, answer, or hold tables.
KEPT = ("models", "modes", "bridge", "response")
#: Rules for paper, put in force on the screen.
PAPER = """
  const rules = [...document.styleSheets].flatMap((sheet) => [...sheet.cssRules])
    .filter((rule) => rule instanceof CSSMediaRule && rule.conditionText === 'print');
  const style = document.createElement('style');
  const within = rules.flatMap((rule) => [...rule.cssRules]);
  style.textContent = within.map((rule) => rule.cssText).join(' ');
"""


@pytest.fixture
def report(tmp_path, monkeypatch, run_elsewhere):
    """Return the page of the cheapest bimorph."""
    # the samples of the parameters' ranges have tests of their own
    monkeypatch.setattr(propagation, "affordable", lambda _: 300)
    few = tuple(section for section in bimorph.LATERAL if section.id in KEPT)
    monkeypatch.setattr(bimorph, "LATERAL", few)
    scene, origins = load_scene("prototype", FEW)
    return write_report(scene, origins, tmp_path / "out", True, str).read_text(encoding="utf-8")


def test_a_report_in_a_browser(report, driven):
    """One page, opened light and dark: what is pointed at, followed, and printed."""
    found = driven(
        report,
        """
        const plot = one('figure:has(.values)'), drawn = plot.querySelectorAll('g[id^="axes_"]');
        const panels = [...drawn].map((g) => g.querySelector('path').getBoundingClientRect());
        found.panels = panels.length;
        const point = (x, y) => plot.dispatchEvent(
          new PointerEvent('pointermove', { clientX: x, clientY: y, bubbles: true }));
        const [first, second] = panels;
        found.before = text('.told');
        point(first.left - 20, first.top + 5); found.beside = text('.told');
        point(first.left + 0.1, first.top + 5); found.low = text('.told');
        point(second.right - 0.1, second.bottom - 5); found.high = text('.told');
        found.frequencies = JSON.parse(text('.values')).frequency;
        found.links = all('nav a').map((a) => [a.hash, one(a.hash) !== null]);
        one('#parameters').scrollIntoView(); dispatchEvent(new Event('scroll'));
        found.current = all('nav a[aria-current]').map((a) => a.hash);
        found.parts = all('nav b').map((b) => b.textContent);
        found.dark = matchMedia('(prefers-color-scheme: dark)').matches;
        """,
    )
    assert found["panels"] == 6
    assert found["before"] == found["beside"] == "Point at a panel: the values there."
    assert found["low"].startswith("free tip, 10.00 Hz: lumped ")
    assert "tmm " in found["low"]
    assert "µm" in found["low"]
    assert found["high"].startswith("under the finger, 1000 Hz: ")
    assert found["frequencies"][0] == 10.0
    assert len(found["frequencies"]) == 400
    assert {"#what", "#response", "#plan"} <= {link for link, _ in found["links"]}
    assert all(there for _, there in found["links"])
    assert found["current"] == ["#parameters"]
    assert found["parts"] == ["For the engineer", "Appendix"]
    assert not found["dark"]

    dark = driven(
        report,
        f"""
        found.dark = matchMedia('(prefers-color-scheme: dark)').matches;
        found.paper = getComputedStyle(one('main')).backgroundColor;
        {PAPER}
        document.head.append(style);
        found.rules = rules.length;
        found.moving = all('.tv, .up, .told').length;
        const beyond = (node) => node.getBoundingClientRect().right > innerWidth + 1;
        const wide = all('main *:not(svg *)').filter(beyond);
        found.wide = wide.map((node) => node.outerHTML.slice(0, 90));
        """,
        "--blink-settings=preferredColorScheme=0",
    )
    assert dark["dark"]
    assert dark["paper"] == "rgb(255, 255, 255)"  # words and pictures are made for white
    assert dark["rules"] >= 1
    assert dark["moving"] == 0
    assert dark["wide"] == []
