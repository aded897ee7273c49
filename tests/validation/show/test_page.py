"""The page: its data are the solver's, it asks for nothing, and a browser moves it."""

import base64
import html
import json
import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BarycentricInterpolator

from tactgen.geometry.formats import with_error
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.browser import find_browser, run_browser
from tactgen.validation.show.colours import SHADES, shades_of
from tactgen.validation.show.field import at_phase, enlargement
from tactgen.validation.show.gather import gather
from tactgen.validation.show.lengths import LengthRange, ModeOverLength, length_range
from tactgen.validation.show.page import Still, page
from tactgen.validation.show.viewer import Block, payload

PHASES = np.arange(8) * np.pi / 4
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg=="
)


@pytest.fixture(scope="module")
def data(seen):
    return payload(seen)


@pytest.fixture(scope="module")
def text(data):
    return page("j1: modes & fields", data, [Still(PIXEL, "one pixel")])


def unpacked(data):
    """Return a function that reads the page's arrays as the page does."""
    raw = zlib.decompress(base64.b64decode(data["blob"]), -15)
    kinds = {"f4": "<f4", "u4": "<u4", "i2": "<i2"}

    def read(ref):
        values = np.frombuffer(raw, kinds[ref["type"]], ref["count"], ref["offset"])
        return values * np.float32(ref["scale"]) if ref["type"] == "i2" else values

    return read


def test_arrays_of_the_page_are_the_solvers(seen, data):
    """Every state's displacement at eight phases and every colour's amplitude, to 1e-4."""
    read = unpacked(data)
    for result, shown in zip(seen, data["results"], strict=True):
        assert read(shown["points"]).reshape(-1, 3) == pytest.approx(
            result.mesh.points, abs=1e-7 * np.abs(result.mesh.points).max()
        )
        for state, packed in zip(result.states, shown["states"], strict=True):
            parts = [read(r).reshape(-1, 3) for r in packed["arrays"]["displacement"]]
            amplitude = parts[0] + (1j * parts[1] if len(parts) == 2 else 0.0)
            own = np.asarray(state.fields["displacement"])
            for phase in PHASES:
                moved, true = at_phase(amplitude, phase), at_phase(own, phase)
                assert np.abs(moved - true).max() < 1e-4 * np.abs(own).max()
            for shade in shades_of(result):
                assert packed["tops"][shade.key] == shade.top(state)
                if shade.field != "displacement":
                    parts = [read(r) for r in packed["arrays"][shade.key]]
                    found = parts[0] + (1j * parts[1] if len(parts) == 2 else 0.0)
                    assert np.abs(found - shade.amplitude(state)).max() <= 1e-4 * shade.top(state)


def test_frequencies_shown_are_the_quantities(seen, data):
    for result, shown in zip(seen, data["results"], strict=True):
        for state, packed in zip(result.states, shown["states"], strict=True):
            if state.kind == "mode":
                assert packed["text"] == with_error(state.frequency, state.error, "Hz")
            # the most detailed model has no other beside it
            assert ("modelling error" in packed["detail"]) is (result.model != "solid")


def test_equal_arrays_are_there_once(data):
    """A mode in which the ports take no part is the same in both circuits."""
    states = [s for s in data["results"][0]["states"] if s["motion"] == "bending_y"]
    assert len(states) == 2
    assert states[0]["arrays"] == states[1]["arrays"]


def test_the_page_is_small_and_whole(text):
    """At most 1.2 MB, no address to load from, the scene's name escaped."""
    assert len(text.encode()) < 1.2e6
    assert "j1: modes &amp; fields" in text
    assert not re.search(r'(?:src|href)="(?!data:)', text)
    assert "default-src 'none'" in text


@pytest.fixture(scope="module")
def over_length(seen):
    """Return the first result at made-up lengths: it grows, and its modes become stiffer."""
    result = seen[0]
    known, solved = np.linspace(0.01, 0.02, 6), np.linspace(0.011, 0.019, 5)
    shapes = [s for s in result.states if s.kind == "mode" and s.motion == "bending_x"]
    stretch = solved / np.ptp(result.mesh.points[:, 2])
    own = [np.real(s.fields["displacement"]) for s in shapes]
    modes = [
        ModeOverLength(
            state.circuit, "bending_x", [s.circuit for s in shapes[:n]].count(state.circuit),
            np.append(state.frequency / known[:-1], np.nan), np.append(0.01 / known[:-1], np.nan),
            np.stack([(1.0 + k) * own[n] for k in range(5)]),
        )
        for n, state in enumerate(shapes)
    ]  # fmt: skip
    points = np.stack([result.mesh.points * [1.0, 1.0, s] for s in stretch])
    return LengthRange(0.014, result.mesh, known, solved, points, tuple(modes), 1e-3, "m")


def test_lengths_of_the_page_are_the_solvers(seen, over_length):
    """Points and shapes at a solved length, what is written at each, where nothing is known."""
    data = payload(seen, [over_length, None])
    read, own = unpacked(data), data["results"][0]["lengths"]
    assert data["results"][1]["lengths"] is None
    assert own["here"] == 0.014
    for k, shape in enumerate(own["shapes"]):
        assert read(shape).reshape(-1, 3) == pytest.approx(over_length.points[k], abs=1e-9)
    assert [m["name"] for m in own["modes"]] == [
        s.name for s in seen[0].states if s.motion == "bending_x" and s.kind == "mode"
    ]
    for mode, packed in zip(over_length.modes, own["modes"], strict=True):
        for k, shape in enumerate(mode.shapes):
            found = (read(packed["middle"]) + read(packed["apart"][k])).reshape(-1, 3)
            assert np.abs(found - shape).max() < 1e-4 * np.abs(mode.shapes).max()
        assert packed["texts"][:-1] == [
            with_error(f, b, "Hz")
            for f, b in zip(mode.frequency[:-1], mode.error[:-1], strict=True)
        ]
        assert packed["texts"][-1] == "not among the lowest"
    assert "off by up to 0.1 %" in own["note"]


def test_pictures_can_be_coloured_by_what_a_model_has(seen):
    solid, tmm = (tuple(s.key for s in shades_of(result)) for result in seen)
    assert solid == tuple(s.key for s in SHADES if s.key != "flux_density")
    assert tmm == ("size", "u_x", "u_y", "u_z", "potential")


@pytest.fixture(scope="module")
def browser():
    found = find_browser()
    if found is None:
        pytest.skip("no Chromium on this machine")
    return found


def selftest(browser, text, path):
    """Return what the self-test wrote into the page, and the browser's messages."""
    script = Path(__file__).with_name("selftest.js").read_text(encoding="utf-8")
    head, body = text.split("</head>")
    path.write_text(f"{head}<script>{script}</script></head>{body}", encoding="utf-8")
    done = run_browser(
        browser, path.as_uri(), "--dump-dom", "--virtual-time-budget=20000",
        "--window-size=1000,700", "--enable-logging=stderr",
    )  # fmt: skip
    found = re.search(r'<pre id="selftest">(.*?)</pre>', done.stdout, flags=re.DOTALL)
    assert found is not None, done.stderr[-2000:]
    return json.loads(html.unescape(found[1])), done.stderr


@pytest.fixture(scope="module")
def tested(browser, text, tmp_path_factory):
    return selftest(browser, text, tmp_path_factory.mktemp("page") / "view.html")


@pytest.mark.heavy
def test_a_browser_has_no_complaint_and_asks_for_nothing(tested):
    report, messages = tested
    assert "CONSOLE" not in messages
    assert report["errors"] == []
    assert report["requests"] == 0


@pytest.mark.heavy
def test_the_shader_puts_the_tip_where_the_solver_does(tested, seen):
    """Read back from the graphics processor, every state at eight phases."""
    report, _ = tested
    result = seen[0]
    points = result.mesh.points
    tip = int(
        np.argmin(np.hypot(points[:, 0], points[:, 1]) + 1e3 * (points[:, 2].max() - points[:, 2]))
    )
    for state, found in zip(result.states, report["states"], strict=True):
        enlarged = enlargement(result, state)
        assert found["enlarge"] == pytest.approx(enlarged)
        own = np.asarray(state.fields["displacement"])
        expected = [points[tip] + enlarged * at_phase(own[tip], p) for p in PHASES]
        drawn = enlarged * np.abs(own).max()
        assert np.array(found["tip"]) == pytest.approx(np.array(expected), abs=1e-4 * drawn)


@pytest.fixture(scope="module")
def lengths(seen):
    """Return the scene, and both models over a range of lengths."""
    scene, _ = load_scene("j1", ["mesh.level=2", "modes=3", "models=solid,tmm"])
    return scene, [length_range(scene, r.model, (0.012, 0.018), known=11) for r in seen]


@pytest.mark.heavy
def test_the_slider_of_the_length(browser, seen, lengths, tmp_path):
    """Pixels, shape and numbers follow it; a number is the quantity at that length to its bars."""
    scene, ranges = lengths
    text = page("j1", payload(seen, ranges), [Still(PIXEL, "one pixel")])
    assert len(text.encode()) < 1.2e6
    report, messages = selftest(browser, text, tmp_path / "lengths.html")
    assert "CONSOLE" not in messages
    assert report["errors"] == []
    assert [name for name, changed in report["changes"].items() if not changed] == []
    assert len({found["sum"] for found in report["lengths"]}) == 3
    name = "short_circuit_frequencies"
    for found in report["lengths"]:
        length = float(ranges[0].lengths[found["k"]])
        assert found["said"] in found["label"]
        assert found["height"] == pytest.approx(length, rel=1e-5)
        bimorph = scene.bimorph.model_copy(update={"length": length})
        at = scene.model_copy(update={"bimorph": bimorph})
        first = solve(at, ("solid",), (name,)).get(name, "solid")
        mode = next(m for m in ranges[0].modes if (m.circuit, m.motion) == ("short", "bending_x"))
        assert found["texts"]["mode 1, short circuit"] == with_error(
            mode.frequency[found["k"]], mode.error[found["k"]], "Hz"
        )
        apart = abs(mode.frequency[found["k"]] - first.value[0])
        assert apart <= mode.error[found["k"]] + first.error[0]
        # the tip is where its polynomial is, enlarged
        shape, points = (
            BarycentricInterpolator(ranges[0].solved, v)(length)
            for v in (mode.shapes, ranges[0].points)
        )
        top = int(np.argmin(np.hypot(points[:, 0], points[:, 1]) - 1e3 * points[:, 2]))
        drawn = found["enlarge"] * np.abs(shape).max()
        assert np.array(found["tip"]) == pytest.approx(
            points[top] + found["enlarge"] * shape[top], abs=2e-3 * drawn
        )


@pytest.mark.heavy
def test_every_control_changes_the_picture(tested):
    """State, phase, amplitude, cuts, colours, views, keys; and it moves by itself."""
    report, _ = tested
    assert report["painted"] > 5000
    assert [name for name, changed in report["changes"].items() if not changed] == []
    sums = {state["name"]: state["sum"] for state in report["states"]}
    assert sums["mode 1, short circuit"] != sums["mode 3, short circuit"]
    assert report["opened"] == "mode 1, open circuit"


@pytest.mark.heavy
def test_the_page_can_be_read_without_eyes(tested):
    """Alternative texts, labels of all controls, a value under the pointer."""
    report, _ = tested
    assert "Mode 1, short circuit" in report["label"]
    assert report["images"] == report["unlabelled"] == 0
    assert report["reading"]["region"] in ("piezo_top", "piezo_bottom", "shim")
    assert re.search(r"\|u\|: [\d.]+ [nµ]m", report["reading"]["text"])
    assert all("1, short circuit" in caption for caption in report["captions"])


@pytest.mark.heavy
def test_without_webgl_stills_are_shown_and_it_is_said(browser, text, tmp_path):
    path = tmp_path / "view.html"
    path.write_text(text, encoding="utf-8")
    done = run_browser(browser, path.as_uri() + "#nowebgl", "--dump-dom")
    assert 'data-ready="stills"' in done.stdout
    assert "has no WebGL 2, so nothing moves here" in done.stdout
    assert 'alt="one pixel"' in done.stdout


@pytest.mark.heavy
def test_a_field_at_rest_is_shown_and_read(browser, tmp_path):
    """The normal actuator: no controls of motion, |B| under the pointer, no complaint."""
    scene, _ = load_scene("reluctance", ["models=axisymmetric", "accuracy=0.01"])
    (field,) = gather(scene, ["axisymmetric"], (), "edges")
    text = page("field", payload([field]), [])
    report, messages = selftest(browser, text, tmp_path / "field.html")
    assert "CONSOLE" not in messages
    assert report["errors"] == []
    assert [name for name, changed in report["changes"].items() if not changed] == []
    assert re.search(r"\|B\|: [\d.]+ m?T", report["reading"]["text"])


def test_equal_bytes_are_kept_once_for_each_meaning():
    """Zeros are the same bytes as numbers, as places and as shares of any size."""
    block = Block()
    numbers, places = block.plain(np.zeros(2)), block.plain(np.zeros(2, dtype=int))
    assert (numbers["type"], places["type"]) == ("f4", "u4")
    small, large = (block.small(np.zeros(4), top) for top in (1.0, 2.0))
    assert large["scale"] == 2.0 * small["scale"]
    assert len({found["offset"] for found in (numbers, places, small, large)}) == 4
    length = len(block.data)
    assert block.plain(np.zeros(2)) == numbers
    assert len(block.data) == length
