"""Pictures without painting: what is told to PyVista and Pillow, as text.

A picture is judged by eye once, and coarsely by its pixels; what it is made of (surfaces, colours,
camera, words and where they stand) is a list that approved outputs hold, on every machine alike.
"""

from itertools import groupby
from types import SimpleNamespace

import numpy as np
from approved import described

#: Calls of one kind in a row are written out up to this many, then the first, middle and last.
FEW = 8


def told(value):
    """Return what is handed over on one line, rows of numbers by their size and some numbers."""
    if isinstance(value, dict):
        return " ".join(f"{name}={told(one)}" for name, one in value.items())
    if isinstance(value, tuple | list):
        value = np.array(value, dtype=float)
    return " ".join(described(value).split())


class Calls:
    """Takes any call and writes it down."""

    def __init__(self, kept):
        self._kept = kept

    def __getattr__(self, name):
        def call(*given, **options):
            self._kept.append(" ".join([name, *map(told, given), told(options)]).strip())

        return call


class Body:
    """A surface or a grid: its points, what stands between them, what was done to it."""

    def __init__(self, points, faces=(), lines=(), *, kinds=(), done=""):
        self.points, self.faces, self.lines = np.array(points, dtype=float), faces, lines
        self.kinds, self.done, self.values = kinds, done, {}

    def __setitem__(self, name, values):
        self.values[name] = values

    @property
    def n_cells(self):
        return len(self.points)

    def also(self, done, keep=None):
        points = self.points if keep is None else self.points[keep]
        return Body(points, self.faces, self.lines, kinds=self.kinds, done=f"{self.done} {done}")

    def clip(self, normal, origin):
        """Take away all on the side that the normal points to, as VTK does."""
        kept = (self.points - np.array(origin)) @ np.array(normal) <= 0.0
        return self.also(f"clip {told(normal)} {told(origin)}", kept)

    def extract_cells(self, numbers):
        return self.also(f"cells {told(np.asarray(numbers))}")

    def extract_surface(self, **options):
        return self.also(f"surface {told(options)}")

    def said(self):
        parts = [("points", self.points), ("faces", self.faces), ("lines", self.lines)]
        parts += [("kinds", self.kinds), *self.values.items()]
        shown = [f"{name} {told(np.asarray(one))}" for name, one in parts if len(one)]
        shown.append(f"about {told(self.points.mean(axis=0))}")
        return "; ".join([*shown, self.done.strip()]).rstrip("; ")


class Stage(Calls):
    """PyVista's plotter; a picture of it is white with a dark box, each with another dot in it."""

    def __init__(self, kept, **options):
        super().__init__(kept)
        kept.append(f"stage {told(options)}")
        self._size, self._bodies, self._shots = options["window_size"], [], 0
        self.camera, self.renderer = SimpleNamespace(), Calls(kept)

    def add_mesh(self, body, **options):
        self._bodies.append(body)
        actor = SimpleNamespace(mapper=SimpleNamespace(resolve=""))
        self._kept.append(SimpleNamespace(options=options, mapper=actor.mapper))
        return actor

    def reset_camera(self):
        direction, middle, up = self.camera_position
        points = np.concatenate([body.points for body in self._bodies])
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        self.camera.focal_point = tuple(centre)
        self.camera.position = tuple(centre + np.array(direction) - np.array(middle))
        self.camera.up = up

    def screenshot(self, **options):
        self._kept += [f"camera {told(vars(self.camera))}", *(b.said() for b in self._bodies)]
        self._kept.append(f"screenshot {told(options)}")
        width, height = self._size
        picture = np.full((height, width, 3), 255, dtype=np.uint8)
        picture[height // 4 : height // 2, width // 4 : width // 2] = 0
        picture[height // 4, width // 4 + self._shots] = 100
        self._shots += 1
        return picture


class Pen(Calls):
    """Pillow's pen, whose letters are half as wide as they are high."""

    def textlength(self, text, font):
        return 0.5 * font.size * len(text)

    def text(self, at, text, **options):
        options["font"] = options["font"].size
        self._kept.append(f"text {text!r} {told(at)} {told(options)}")


def unpainted(patch):
    """Let pictures be told and not drawn, given a monkeypatch; return the list it grows in."""
    from PIL import ImageDraw

    from tactgen.validation.view import assembly_frames, pictures, stills
    from tactgen.validation.view.run import frames

    kept = []
    library = SimpleNamespace(
        Plotter=lambda **options: Stage(kept, **options), PolyData=Body,
        UnstructuredGrid=lambda cells, kinds, points: Body(points, cells, kinds=kinds),
    )  # fmt: skip
    for room in (assembly_frames, frames, pictures, stills):
        patch.setattr(room, "off_screen", lambda: library)
    patch.setattr(ImageDraw, "Draw", lambda _: Pen(kept))
    return kept


def as_text(kept):
    """Return what was told since the last time, a call a line, and forget it."""
    lines = []
    plain = [one if isinstance(one, str) else _mesh(one) for one in kept]
    kept.clear()
    for _, calls in groupby(plain, key=lambda line: line.partition(" ")[0]):
        run = list(calls)
        lines += run if len(run) <= FEW else [f"{len(run)} times:", *run[:: len(run) // 2]]
    return "\n".join(lines)


def _mesh(one):
    resolve = f" lines {one.mapper.resolve}" if one.mapper.resolve else ""
    return f"mesh {told(one.options)}{resolve}"


def placed(figure):
    """Return how words and marks of a figure stand to the points that they are about.

    Beside what `figure_text` says: alignment, distance in points, arrows, colours, legends' places.
    """
    lines = []
    for axis in figure.axes:
        for text in axis.texts:
            stands = f"{text.get_text()!r} {text.get_ha()} {text.get_va()}"
            if hasattr(text, "xyann"):
                stands += f" {text.anncoords} {told(np.array(text.xyann, dtype=float))}"
                stands += f" clip {text.get_annotation_clip()} {_arrow(text)}"
            lines.append(stands)
        for line in (line for line in axis.lines if line.get_marker() not in ("None", "")):
            shift = line.get_transform().transform((0, 0)) - axis.transData.transform((0, 0))
            if np.abs(shift).max() > 1e-9:
                lines.append(f"mark {line.get_marker()} {told(shift * 72.0 / figure.dpi)}")
        lines += _colours("lines", [(line.get_color(), line.get_mfc()) for line in axis.lines])
        lines += _colours("patches", [(patch.get_facecolor(),) for patch in axis.patches])
        if axis.get_legend() is not None:
            lines.append(f"legend at {axis.get_legend()._get_loc()}")
    return "\n".join(lines)


def _colours(name, given):
    """Return the colours of what is drawn one after the other, each as often as it is repeated."""
    shown = [" ".join(dict.fromkeys(map(_hex, colours))) for colours in given]
    rows = [(colour, len(list(same))) for colour, same in groupby(shown)]
    said = [colour if count == 1 else f"{count} {colour}" for colour, count in rows]
    return [f"{name}: {', '.join(said)}"] if said else []


def _hex(colour):
    from matplotlib.colors import to_hex

    return to_hex(colour)


def _arrow(text):
    if text.arrow_patch is None:
        return ""
    shrunk = text.arrow_patch.shrinkA, text.arrow_patch.shrinkB
    return f"arrow {type(text.arrow_patch.get_arrowstyle()).__name__} {told(shrunk)}"
