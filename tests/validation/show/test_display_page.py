"""The display's page in a browser, and the wave of its film."""

import base64

import numpy as np
import pytest

from tactgen.validation.show.display import Swing, display_page, enlargement
from tactgen.validation.show.page import Still
from tactgen.validation.show.pictures import Part

PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg=="
)
#: Corners of a unit cube, and its faces as triangles.
CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
FACES = np.array(
    [[a, b, c] for q in ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4),
                         (1, 3, 7, 5)) for a, b, c in (q[:3], (q[0], *q[2:]))]
)  # fmt: skip
UNITS = ("r1c1", "r1c2")
PLACES = np.array([[0.0, 0.0, 0.0], [2.4, 0.0, 0.0]])


@pytest.fixture(scope="module")
def page():
    """Two posts that swing above one board; at 200 Hz the second goes a quarter period behind."""
    post = Part("shim", (0.9, 0.6, 0.1), CUBE * [0.3, 1.0, 10.0], FACES, PLACES, moves=True)
    board = Part(
        "upper_board", (0.1, 0.4, 0.2), CUBE * [6.0, 4.0, 1.0] - [1.5, 1.5, 1.0], FACES,
        np.zeros((1, 3)), moves=False,
    )  # fmt: skip
    tips = np.array([[1e-5, 1e-6], [2e-5, -5e-6j], [4e-6, 1e-7]])
    swing = Swing(UNITS, 0, 50.0, np.array([100.0, 200.0, 400.0]), tips, 0.0, 10.0, 2.4)
    return display_page("<two>", (post, board), swing, Still(PIXEL, "two posts on a board"))


def test_every_control_changes_the_picture(page, driven):
    """Sliders, ticks and keys; what is hidden comes back; words are the solved numbers."""
    found = driven(
        page,
        """const canvas = one('canvas'), picture = () => { draw(); return canvas.toDataURL(); };
        found.label = canvas.getAttribute('aria-label');
        found.moved = picture() !== picture();
        press('canvas', ' ');
        found.button = text('.td-play');
        const still = picture();
        found.stopped = still === picture();
        found.changes = {}; found.back = {};
        const differs = (name, there, back) => {
          there(); found.changes[name] = still !== picture();
          back(); found.back[name] = still === picture();
        };
        const slide = (what, value) => () => set(what, value);
        const [frequency, enlarge, cut] = ['.td-frequency', '.td-enlarge', '.td-cut'];
        differs('enlarged', slide(enlarge, 1), slide(enlarge, 0.5));
        differs('cut', slide(cut, 1), slide(cut, one(cut).max));
        const key = (way) => () => press('canvas', 'Arrow' + way);
        differs('turned', key('Left'), key('Right'));
        differs('tipped', key('Up'), key('Down'));
        for (const [n, box] of all('input[type=checkbox]').entries()) {
          differs(`hidden ${n}`, () => box.click(), () => box.click());
        }
        found.words = [0, 1, 2].map((n) => { set(frequency, n); return text('.td-words'); });
        found.said = one(frequency).getAttribute('aria-valuetext');
        found.parts = all('.td-parts label').map((label) => label.textContent);""",
    )
    assert found["moved"]
    assert found["stopped"]
    assert found["button"] == "move"
    assert [name for name, changed in found["changes"].items() if not changed] == []
    assert [name for name, same in found["back"].items() if not same] == []
    assert found["parts"] == ["shim (2)", "upper board (1)"]
    assert found["words"][0].startswith("100.0 Hz: r1c1 driven with 50 V, its tip 10.0 µm;")
    assert "largest other tip r1c2: 5.00 µm, 25.0 %" in found["words"][1]
    assert "its tip 4.00 µm; largest other tip r1c2: 100 nm, 2.50 %" in found["words"][2]
    assert found["said"] == "400.0 Hz"
    assert found["label"].startswith("The display, 2 generators. 200.0 Hz: r1c1 driven")


def test_without_webgl_the_still_is_shown(page, driven):
    """And nothing of the panel that would not work."""
    found = driven(
        page.replace("<head>", "<head><script>delete window.WebGL2RenderingContext;"
                     "HTMLCanvasElement.prototype.getContext = () => null</script>", 1),
        "found.shown = all('img').map((img) => img.alt); found.panel = all('.td-panel').length;",
        "--disable-gpu",
    )  # fmt: skip
    assert found == {"shown": ["two posts on a board"], "panel": 0}


def test_motions_are_enlarged_to_a_share_of_the_pitch():
    """Whatever their size; none where nothing moves."""
    for tips, pitch in ((np.array([1e-6, -3e-6j]), 2.4), (np.array([5e-3]), 10.0)):
        drawn = 1e3 * np.abs(tips).max() * enlargement(tips, pitch)
        assert 0.1 * pitch < drawn < 0.5 * pitch  # seen, and clear of the neighbour
        assert drawn == pytest.approx(pitch * enlargement(np.array([1e-3]), 1.0))
    assert enlargement(np.zeros(2), 2.4) == 0.0
