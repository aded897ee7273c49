"""Shared by the tests of reports: checks and stress runs have tests of their own."""

import base64
import html
import json
import re
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from pages import blank_figures

from tactgen.validation.show.browser import find_browser, run_browser

#: What watches a page in a browser, and where in it a test's own steps go.
DRIVER = Path(__file__).with_name("driver.js").read_text(encoding="utf-8")
STEPS = "/* what the test says */"
#: Least contrast of small words (WCAG 2.2, 1.4.3).
LEAST_CONTRAST = 4.5


#: A picture of one dot.
DOT = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR42mNgAAAAAgAB5Sfe/AAAAABJRU5ErkJggg=="
)


@pytest.fixture(scope="session")
def leave_unlaid():
    """Return what leaves figures as they come, given a monkeypatch: layout is half of drawing."""

    def leave(patch):
        from tactgen.validation.show import figures

        lay_out = figures.lay_out

        def as_they_come(figure):
            figure.set_layout_engine("none")  # else it acts once they are drawn
            lay_out(figure)

        patch.setattr(figures, "lay_out", as_they_come)

    return leave


@pytest.fixture(scope="session")
def make_plain(leave_unlaid):
    """Return what makes reports plain, given a monkeypatch: for one that many tests read.

    Figures as they come, dots for the CAD solids, checks that count as passed: all of these
    have tests of their own.
    """

    def make(patch):
        from tactgen.validation.report import report_data as study
        from tactgen.validation.show import export as files  # slow to import, as the next
        from tactgen.validation.show import pictures

        leave_unlaid(patch)
        patch.setattr(files, "scene_solids", lambda _: {})
        patch.setattr(files, "normal_actuator_solids", lambda _: {})
        patch.setattr(pictures, "solids_picture", lambda _: DOT)
        patch.setattr(study, "run_check", lambda check: study.Outcome(check, 1.0, 0.0, "pass"))

    return make


@pytest.fixture(autouse=True)
def unlaid(request, monkeypatch, leave_unlaid):
    """Leave figures as they come; the tests of what is seen, and heavy ones, lay them out."""
    seen = "view" in request.path.parent.parts
    if not seen and request.node.get_closest_marker("heavy") is None:
        leave_unlaid(monkeypatch)


@pytest.fixture(autouse=True)
def no_curve_without_words(monkeypatch):
    """Let no figure be drawn whose curves run out of sight, or along an axis without a name."""
    from tactgen.validation.show import figures

    in_words = figures._in_words

    def beside(axis, figure, along):
        """Return axes in the same row or column of a grid."""
        place = axis.get_subplotspec()
        if place is None:
            return [axis]
        spans = [(each, each.get_subplotspec()) for each in figure.axes]
        return [e for e, s in spans if s is not None and getattr(s, along) == getattr(place, along)]

    def first(words):
        return next(filter(None, words), "")

    def checked(figure):
        seen = []
        for axis in figure.axes:
            if not axis.axison or not axis.lines:
                continue
            column, row = (beside(axis, figure, way) for way in ("colspan", "rowspan"))
            over = first(each.get_ylabel() for each in (axis, *row))
            title = first(each.get_title() for each in (axis, *column))
            assert over or axis.get_title(), "a curve over what?"
            assert first(each.get_xlabel() for each in (axis, *column)), "along what?"
            seen.append((title, over, axis.get_xlabel()))
            low, high = sorted(axis.get_xlim())
            at = np.concatenate([np.asarray(line.get_xdata(), float) for line in axis.lines])
            at = at[np.isfinite(at)]
            assert at.size == 0 or ((at >= low) & (at <= high)).mean() >= 0.5, "out of sight"
        assert len(seen) == len(set(seen)), "which of them?"
        legends = [*figure.legends, *filter(None, (axis.get_legend() for axis in figure.axes))]
        shown = {text.get_text() for legend in legends for text in legend.get_texts()}
        meant = {line.get_label() for axis in figure.axes for line in axis.lines}
        assert {label for label in meant if label[:1] != "_"} <= shown, "a label that nobody sees"
        return in_words(figure)

    monkeypatch.setattr(figures, "_in_words", checked)


@pytest.fixture(scope="session")
def rough_fields():
    """Return what solves the normal actuator's fields far more coarsely than an answer needs.

    Within it, in a store of its own whose keys do not know: for tests of what runs and is shown.
    """
    from tactgen.fem.magnetics import axisymmetric as actuator
    from tactgen.fem.magnetics import axisymmetric as walk
    from tactgen.tmm.reluctance import map_range
    from tactgen.validation.models.reluctance import field

    @contextmanager
    def within(store):
        kept = map_range._network_pull  # of the grid that holds at the time
        with ExitStack() as stack, pytest.MonkeyPatch.context() as patch:
            kept.cache_clear()
            stack.callback(kept.cache_clear)
            patch.setenv("TACTGEN_CACHE", str(store))
            point = partial(actuator.solve_point, order=2, any_grid=True)
            rows = partial(actuator.solve_map, refinement=0.5, any_grid=True)
            patch.setattr(actuator, "solve_point", point)
            patch.setattr(actuator, "solve_map", rows)
            patch.setattr(field, "REFINEMENTS", ((0.0, 0.5),))
            patch.setattr(field, "MAP_ORDER", 2)
            patch.setattr(walk, "FieldPath", partial(walk.FieldPath, order=3))
            yield patch

    return within


@pytest.fixture
def undrawn(monkeypatch):
    """Write a report's figures blank, for tests of its words: drawing takes most of its time."""
    from tactgen.validation.show import pictures

    blank_figures(monkeypatch)
    monkeypatch.setattr(pictures, "solids_picture", lambda _: b"")


@pytest.fixture
def run_elsewhere(monkeypatch):
    """Let a report show its checks as passed without running them."""
    from tactgen.validation.report import report_data  # slow to import

    passed = lambda check: report_data.Outcome(check, 1.0, 0.0, "pass")  # noqa: E731
    monkeypatch.setattr(report_data, "run_check", passed)


@pytest.fixture
def driven(tmp_path):
    """Return a function that takes steps (JavaScript) in a page (HTML) and returns what they found.

    No page may complain, ask for anything, show words that are hard to read, or pictures and
    controls without a name.
    """
    browser = find_browser()
    if browser is None:
        pytest.skip("no Chromium on this machine")

    def drive(page, steps, *options):
        path = tmp_path / "driven.html"
        script = f"<head><script>{DRIVER.replace(STEPS, steps)}</script>"
        path.write_text(page.replace("<head>", script, 1), encoding="utf-8")
        done = run_browser(
            browser, path.as_uri(), "--dump-dom", "--virtual-time-budget=20000",
            "--window-size=900,700", "--enable-logging=stderr", *options,
        )  # fmt: skip
        written = re.search(r'<pre id="report">(.*?)</pre>', done.stdout, flags=re.DOTALL)
        assert written is not None, done.stderr[-2000:]
        report = json.loads(html.unescape(written[1]))
        assert report["errors"] == []
        assert "CONSOLE" not in done.stderr, done.stderr[-2000:]
        assert report["requests"] == []
        assert report["unnamed"] == []
        assert report["contrast"]["contrast"] >= LEAST_CONTRAST, report["contrast"]
        return report["found"]

    return drive
