"""The book's figures, whole: a drawing of everything that one may hold, convergence, scatter."""

from tactgen.validation.book.sketch import _drawn
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


def test_a_drawing_of_one_bare_area():
    """No legend of lines where there are none."""
    figure = _drawn(Drawing(areas=DRAWING.areas[:1]))
    assert [t.get_text() for t in figure.axes[0].get_legend().get_texts()] == ["iron"]
