"""Shared by the tests of reports: checks and stress runs have tests of their own."""

import numpy as np
import pytest

from tactgen.validation.checks.stress import beam
from tactgen.validation.checks.stress.result import Approach, ErrorMap, Point, Stress, judged


@pytest.fixture
def made_up_stress(monkeypatch):
    """Return a function that puts a made-up stress run with these points in the real one's place.

    Without points it has one that holds.
    """
    table = ErrorMap(
        "made up", np.array([0.0, 1.0]), np.array([1e-3]), np.full((1, 2), 1e-14),
        np.array([[np.nan, np.inf]]), np.ones((1, 2)),
    )  # fmt: skip
    approach = Approach("made up", np.array([1e3, 1e6]), np.array([1e-15, 1e-13]), np.ones(2))

    def put(points=()):
        points = points or [Point("somewhere", 1e-13, 1.0, 1e-12, np.nan)]
        rows = (judged("family", "what", points),)
        made = Stress("tmm", "words", rows, (table,), (approach,), 0)
        monkeypatch.setattr(beam, "run", lambda *_: made)

    return put


@pytest.fixture
def undrawn(monkeypatch):
    """Leave a report's figures blank, for tests of its words: drawing takes most of its time."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    from tactgen.validation.view import figures, pictures

    def blank(_, file, **__):
        file.write("<svg></svg>")

    monkeypatch.setattr(figures, "lay_out", lambda _: None)
    monkeypatch.setattr(FigureCanvasSVG, "print_svg", blank)
    monkeypatch.setattr(pictures, "solids_picture", lambda _: b"")


@pytest.fixture
def run_elsewhere(monkeypatch, made_up_stress):
    """Let a report show its checks as passed and a made-up stress run, without running either."""
    from tactgen.validation.report import study  # slow to import

    monkeypatch.setattr(study, "run_check", lambda check: study.Outcome(check, 1.0, 0.0, "pass"))
    made_up_stress()
