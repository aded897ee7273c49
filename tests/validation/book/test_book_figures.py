"""The book's figures, whole: a drawing of everything that one may hold, convergence, scatter."""

import numpy as np
import pytest
from approved import figure_text, kept_figures
from unpainted import placed

from tactgen.validation.book import figures
from tactgen.validation.book.sketch import _drawn
from tactgen.validation.book.statistics import Scatter
from tactgen.validation.checks.drawings.drawing import Drawing, Line, Mark, rectangle

DRAWING = Drawing(
    areas=(
        rectangle((0.0, 0.0), (2.0, 1.0), "iron"), rectangle((2.0, 0.0), (3.0, 1.0), "copper"),
        rectangle((0.0, 1.0), (1.0, 2.0), "iron"),
    ),
    lines=tuple(
        Line(((0.1 * k, -1.0), (0.1 * k + 1.0, -1.5)), kind)
        for k, kind in enumerate(
            ("division", "held", "potential", "axis", "spring", "damper", "flux")
        )
    ),
    marks=(
        Mark("force", (1.0, 1.0), 30.0, "F"), Mark("force", (2.0, 1.0), 270.0, "G"),
        Mark("hinge", (0.0, 0.0), text="hinge"), Mark("mass", (3.0, 0.5), text="m"),
        Mark("mass", (3.0, 1.5), 90.0, "above"), Mark("turning spring", (3.0, 0.0), text="c"),
        Mark("text", (4.0, 4.0), text="beside"), Mark("text", (4.0, 3.0), 90.0, "over"),
    ),
    labels=("z (mm)", "height, stretched"),
)  # fmt: skip


@pytest.mark.parametrize("equal", [True, False])
def test_all_that_a_drawing_may_hold(equal, approved):
    """Areas by material, every kind of line and mark, arrows that end where they act."""
    figure = _drawn(Drawing(**{**vars(DRAWING), "equal": equal}))
    said = [figure_text(figure), placed(figure)]
    for line in figure.axes[0].lines:
        effects = [type(effect).__name__ for effect in line.get_path_effects()]
        said += effects
    axis = figure.axes[0]
    said.append(f"{axis.get_aspect()} {[spine.get_visible() for spine in axis.spines.values()]}")
    approved("\n".join(said))


def test_a_drawing_of_one_bare_area():
    """No legend of lines where there are none."""
    figure = _drawn(Drawing(areas=DRAWING.areas[:1]))
    assert [t.get_text() for t in figure.axes[0].get_legend().get_texts()] == ["iron"]


def test_convergence_and_scatter(monkeypatch, approved):
    """Errors that are rounding, a tolerance where there is one, levels and unknowns."""
    kept = kept_figures(monkeypatch)
    error = figures.Curve("error", [1000, 100, 10], [0.0, -1e-4, 1e-2])
    figures.convergence([error, figures.Curve("change", [100, 10], [1e-4, 2e-2])], "unknowns", 1e-3)
    figures.convergence([figures.Curve("error", [0, -1, -2], [1e-4, 1e-3, 1e-2])], "level", 0.0)
    groups = {
        name: Scatter(size * np.array([1.0, 2.0, 5.0]), size * np.array([1.1, 1.9, 5.0]), 1.0, 0.1)
        for name, size in (("beams", 1e-3), ("coils", 1e2))
    }
    figures.scattered(groups)
    approved("\n".join(kept))
