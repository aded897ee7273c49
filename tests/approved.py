"""Approved outputs: what a cheap run says as a whole, kept as text once somebody has read it.

A test hands the fixture `approved` a text; it is compared with the file of the test's name in
``tests/data/approved/``, as `alike` says.  ``make approve`` writes the files anew, and marks what
another processor says otherwise; their diff is what is reviewed.  An approved output pins what is
said.  It is no reason for a number: references and tolerances are stated elsewhere.
"""

import dataclasses
import html
import numbers
import re
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from alike import TINY_PART, by_letter, differences, loosened, with_marks

FOLDER = Path(__file__).parent / "data" / "approved"
#: Differences shown when a test fails.
SHOWN = 6
#: A row of more numbers than this is written as its size, some of its numbers and their mean.
LONG = 8


def pytest_addoption(parser):
    """Add the options that write approved outputs anew."""
    parser.addoption("--approve", action="store_true", help="write approved outputs anew")
    parser.addoption(
        "--loosen", action="store_true", help="mark numbers of approved outputs that differ"
    )


@pytest.fixture
def approved(request):
    """Return a function that compares a text with the approved one of this test, if it is light."""
    name = re.sub(r"[^\w.=-]+", "-", request.node.name).strip("-")

    def compare(text, part="", *, exactly=False):
        if _is_heavy(request):
            return
        file = FOLDER / request.path.stem / f"{name}{part and '.' + part}.txt"
        before = file.read_text("utf-8") if file.exists() else ""
        kept = _kept(request, before, lean(text), by_letter if exactly else differences)
        _write(file, before, kept)
        if found := (by_letter if exactly else differences)(kept, lean(text)):
            _fail(request, file.name, found)

    return compare


@pytest.fixture
def approved_line(request):
    """Return a function that compares one line, named after the case of a test with many cases."""
    test = request.node.name.partition("[")[0]
    file = FOLDER / request.path.stem / f"{test}.txt"

    def compare(text):
        if _is_heavy(request):
            return
        name = request.node.callspec.id
        before = file.read_text("utf-8") if file.exists() else ""
        known = dict(line.split(": ", 1) for line in before.splitlines())
        known[name] = _kept(request, known.get(name, ""), text, differences).rstrip("\n")
        _write(file, before, "".join(f"{key}: {known[key]}\n" for key in sorted(known)))
        if found := differences(known[name], text):
            _fail(request, f"{file.name}, {name}", found)

    return compare


def _is_heavy(request):
    return request.node.get_closest_marker("heavy") is not None


def _kept(request, before, after, judge):
    """Return what is approved from now on, given what was and what a test says."""
    if judge(before, after):
        if request.config.getoption("--approve"):
            return after if judge is by_letter else with_marks(before, after)
        if request.config.getoption("--loosen") and judge is differences:
            return loosened(before, after) or before
    return before


def _write(file, before, kept):
    """Write an approved text, where it is another."""
    if kept != before:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(kept, encoding="utf-8")


def _fail(request, name, found):
    """Fail with some of the lines that differ, and how they are approved."""
    test = request.path.relative_to(request.config.rootpath)
    told = [f"{name}: not what was approved", *found[:SHOWN]]
    told.append(f"{len(found)} lines; if all are meant: make approve TESTS={test}")
    pytest.fail("\n".join(told), pytrace=False)


def lean(text):
    """Return a text without empty lines and blanks at the ends of lines."""
    return "\n".join(line.rstrip() for line in text.splitlines() if line.strip()) + "\n"


def described(value, name="", indent=0):
    """Return a value of results, sections or rows as text, a line for each thing in it."""
    pad = "  " * indent
    head = f"{pad}{name}: " if name else pad
    if isinstance(value, np.ndarray | np.generic) and value.ndim == 0:
        value = value.item()
    if isinstance(value, str):
        return head + (page_text(value) if value.lstrip().startswith("<") else _plain(value))
    if isinstance(value, numbers.Number) or value is None:
        return head + _number(value)
    if isinstance(value, np.ndarray) or _is_row(value):
        return head + _row(np.asarray(value))
    if isinstance(value, bytes | bytearray):
        return f"{head}(bytes)"
    if isinstance(value, Path):
        return head + value.name
    if hasattr(value, "axes") and hasattr(value, "canvas"):
        return f"{head}figure\n{figure_text(value)}"
    if isinstance(value, dict):
        parts = [(str(key), part) for key, part in value.items()]
    elif isinstance(value, list | tuple | set | frozenset) and not hasattr(value, "_fields"):
        ordered = sorted(value, key=str) if isinstance(value, set | frozenset) else value
        parts = [("-", part) for part in ordered]
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        shown = [field.name for field in dataclasses.fields(value) if field.repr]
        head, parts = head + type(value).__name__, [(n, getattr(value, n)) for n in shown]
    elif hasattr(value, "_asdict"):
        head, parts = head + type(value).__name__, list(value._asdict().items())
    elif isinstance(value, SimpleNamespace):
        parts = list(vars(value).items())
    else:
        return head + getattr(value, "__name__", type(value).__name__)
    return "\n".join([head, *(described(part, key, indent + 1) for key, part in parts)])


def answered(quantities):
    """Return what quantities say: each on a line, with bars that are more than rounding."""
    return "\n".join(map(_answered, quantities))


def _answered(q):
    value, bar = np.asarray(q.value), np.asarray(q.uncertainty, dtype=float)
    # three digits of a bar: it is a difference, of which no more are the same elsewhere
    rounded = np.vectorize(lambda one: float(f"{one:.3g}"))(bar)
    of = "" if (bar <= TINY_PART * np.abs(value)).all() else f" ± {_row(rounded)}"
    over = "" if q.frequency is None else f" at {_row(np.array(q.frequency))}"
    kinds = "" if q.classes is None else f", {' '.join(q.classes)}"
    return f"{q.name} by {q.model}: {_row(value)}{of} {q.unit}{over}{kinds}"


def by_ports(multiport):
    """Return a symmetric port matrix by its pairs of ports, each over frequency."""
    names = [port.name for port in multiport.ports]
    return {
        f"{a} {b}": multiport.stiffness[:, i, j]
        for i, a in enumerate(names)
        for j, b in enumerate(names[: i + 1])
    }


def measured_text(outcome):
    """Return what a check measured: of errors beside nothing two digits, and below 1e-6 none.

    What is left of cancellation below that is of the libraries.
    """
    measured, reference = outcome.measured, outcome.check.reference
    if outcome.check.unit == "1" and (isinstance(reference, tuple) or not reference):
        return f"{measured:.1e}" if abs(measured) >= 1e-6 else "rounding"
    return f"{measured:.5g} of {described(np.array(reference))} {outcome.check.unit}"


def _plain(text):
    """Return a text on one line, without the data of pictures."""
    return re.sub(r"(data:[\w/+-]+)[^\s\"]*", r"\1", " ".join(text.split()))


def _number(value):
    if isinstance(value, complex):
        return f"{value.real:.7g} {value.imag:+.7g}j"
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def _is_row(value):
    plain = isinstance(value, list | tuple) and len(value) > LONG
    return plain and all(isinstance(v, numbers.Number) for v in value)


def _row(array):
    """Return an array as text: all of it, or its shape, five of its numbers and their mean."""
    if array.dtype.kind in "fc" and np.isfinite(array).any():
        largest = np.abs(array[np.isfinite(array)]).max()
        array = np.where(np.abs(array) < TINY_PART * largest, 0.0, array)
    flat = array.ravel().tolist()
    if array.dtype.kind not in "biufc":
        return f"{array.shape} " + " ".join(_plain(str(v)) for v in flat[:LONG])
    if len(flat) <= LONG:
        return "[" + ", ".join(map(_number, flat)) + "]"
    some = [flat[i] for i in np.linspace(0, len(flat) - 1, 5).astype(int)]
    sizes = np.abs(flat)
    mean = float(sizes[np.isfinite(sizes)].mean()) if np.isfinite(sizes).any() else np.nan
    return f"{array.shape} [" + ", ".join(map(_number, some)) + f"] mean {_number(mean)}"


def figure_text(figure):
    """Return what a figure shows: of all axes the words, limits, scales and data."""
    lines = [f"figure {described([t.get_text() for t in figure.texts])}" if figure.texts else ""]
    for axis in figure.axes:
        titles = filter(None, map(axis.get_title, ("left", "center", "right")))
        lines.append(f"axes {_plain(' | '.join(titles))!r}")
        for side, limits in ((axis.xaxis, axis.get_xlim()), (axis.yaxis, axis.get_ylim())):
            label, ticks = side.label.get_text(), [t.get_text() for t in side.get_ticklabels()]
            lines.append(
                f"  {side.axis_name} {_plain(label)!r} {side.get_scale()} {_row(np.array(limits))}"
            )
            if side.get_major_locator().__class__.__name__ == "FixedLocator":
                lines.append(f"    at {_row(side.get_ticklocs())} {_plain(' | '.join(ticks))}")
        lines += map(_line, axis.lines)
        for made in axis.collections:
            where = made.get_offsets() if len(made.get_offsets()) > 1 else _corners(made)
            data = made.get_array()
            lines.append(f"  {type(made).__name__} {_row(np.asarray(where))}")
            lines += [f"    values {_row(np.ma.filled(data, np.nan))}"] if data is not None else []
        for patch in axis.patches:
            box = patch.get_extents().transformed(axis.transData.inverted()).extents
            label = "" if patch.get_label().startswith("_") else patch.get_label()
            lines.append(f"  {type(patch).__name__} {label} {_row(box)}")
        for image in axis.images:
            shown, extent = np.asarray(image.get_array()), np.array(image.get_extent())
            lines.append(f"  image {_row(shown)} {_row(extent)}")
        for text in axis.texts:
            at = text.xy if hasattr(text, "xy") else text.get_position()
            lines.append(
                f"  text {_plain(text.get_text())!r} {_row(np.asarray(at, object).astype(float))}"
            )
        legend = axis.get_legend()
        lines += [f"  legend {[t.get_text() for t in legend.get_texts()]}"] if legend else []
    for legend in figure.legends:
        lines.append(f"legend {[t.get_text() for t in legend.get_texts()]}")
    return "\n".join(line for line in lines if line)


def _line(line):
    label = "" if line.get_label().startswith("_") else line.get_label()
    x, y = line.get_xydata().T
    return (
        f"  line {_plain(label)!r} {line.get_linestyle()} {line.get_marker()} {_row(x)} {_row(y)}"
    )


def _corners(made):
    """Return the corners of what a collection draws."""
    if hasattr(made, "get_coordinates"):
        return made.get_coordinates()
    found = [path.vertices for path in made.get_paths()]
    return np.concatenate(found) if found else np.zeros((0, 2))


#: Elements that stand on lines of their own, and those that say nothing.
_BLOCKS = {
    "p", "tr", "li", "h1", "h2", "h3", "h4", "div", "figure", "figcaption", "svg", "section",
    "table", "dt", "dd", "ul", "pre", "summary", "option", "button", "label", "nav",
}  # fmt: skip
_SILENT = {"style", "script", "metadata"}
#: What is another on another day or machine: dates, times, versions.
_PASSING = re.compile(
    r"\b\d{4}-\d{2}-\d{2}\b|(?<![\w.])\d[\d.]*(?:e-\d\d)? s\b|(?<=\| )\d+\.\d{3}(?= \|)"
    r"|on \w+ \w+, Python [\d.]+, by .*|code [0-9a-f]{12}\b.*"
    r"|commit (?:[0-9a-f]{7,40}(?:-dirty)?|installed without its repository)"
    r"|libraries numpy .*"
)


class _Page(HTMLParser):
    """Gathers what a page says."""

    def __init__(self):
        super().__init__()
        self.said, self.silent = [], 0

    def handle_starttag(self, tag, attrs):
        self.silent += tag in _SILENT
        if tag in _BLOCKS:
            self.said.append("\n")
        elif tag in ("td", "th"):
            self.said.append(" | ")
        elif tag in ("sub", "sup"):
            self.said.append({"sub": "_", "sup": "^"}[tag])
        for name, value in attrs:
            if name in ("alt", "title", "aria-label", "placeholder") and value:
                self.said.append(f" [{name}: {value}] ")
            elif name == "href" and value and not value.startswith("data:"):
                self.said.append(f" ({value}) ")

    def handle_endtag(self, tag):
        self.silent -= tag in _SILENT
        if tag in _BLOCKS:
            self.said.append("\n")

    def handle_data(self, data):
        if not self.silent:
            self.said.append(data)


def page_text(page):
    """Return what a page of HTML says, a line for each paragraph, row or title."""
    parser = _Page()
    parser.feed(page)
    lines = (" ".join(line.split()) for line in "".join(parser.said).splitlines())
    return lasting("\n".join(line for line in lines if line))


def lasting(text):
    """Return a text without dates, times and versions."""
    return _PASSING.sub("…", text)


def in_text(patch):
    """Let figures be written as text in place of drawings, given a monkeypatch: much quicker."""
    from tactgen.validation.view import figures

    def written(canvas, file, **__):
        said = html.escape(figure_text(canvas.figure))
        file.write(f"<svg><text>{said}</text></svg>")

    patch.setattr(figures, "lay_out", lambda _: None)
    patch.setattr(_svg_canvas(), "print_svg", written)


def kept_figures(patch):
    """Return a list to which each figure that is drawn is added as text, given a monkeypatch."""
    found, draw = [], _svg_canvas().print_svg

    def drawn(canvas, *given, **options):
        found.append(figure_text(canvas.figure))
        draw(canvas, *given, **options)

    patch.setattr(_svg_canvas(), "print_svg", drawn)
    return found


def _svg_canvas():
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    return FigureCanvasSVG
