"""Stills and films of states: the device, with colour bar, words and a scale of lengths.

Deformation, colours and views are those of the page.  The same request gives the same
bytes on the same machine.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.cad.solids import colour_of
from tactgen.geometry.device.parts import MM
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import engineering
from tactgen.geometry.meshing.mesh import Surface, surface_of
from tactgen.validation.show.colours import MAGNITUDE, SIGNED, Shade, shades_of
from tactgen.validation.show.field import (
    MODELS,
    FieldResult,
    State,
    at_phase,
    enlargement,
    region_title,
    words_of,
)
from tactgen.validation.show.page import Still
from tactgen.validation.show.pictures import DIM, INK, Stage, as_png, check_ffmpeg, fonts, save_film

if TYPE_CHECKING:
    from PIL.Image import Image

#: Directions from the device to the eye, and what is up: lying or not, opened by a quarter or not.
_VIEWS = {
    (True, False): ((0.5, 1.0, 0.3), (1.0, 0.0, 0.0)),
    (False, False): ((0.75, -1.0, 0.45), (0.0, 0.0, 1.0)),
    (True, True): ((-0.8, -1.0, 0.25), (-1.0, 0.0, 0.0)),
    (False, True): ((-0.75, -1.0, 0.45), (0.0, 0.0, 1.0)),
}
#: Room for words above and below the device, in parts of the picture's height.
_HEAD, _FOOT = 0.14, 0.2
#: Pictures of one period, and milliseconds that each is shown.
_FRAMES, _SHOWN = 24, 80
#: Periods in an .mp4, which players do not repeat by themselves.
_REPEATS = 4


@dataclass(frozen=True)
class Picture:
    """Style of a still: size in pixels and colour field; None colours by part."""

    width: int = 1200
    height: int = 640
    shade: Shade | None = None

    @property
    def lies(self) -> bool:
        """Whether the device lies, its tip to the right."""
        return self.width > self.height


def still(result: FieldResult, state: State, picture: Picture, phase: float | None = None) -> bytes:
    """PNG of a state at a phase (rad), of what is driven by default that of its largest motion.

    Raises InputError where the system has no OpenGL library.
    """
    if phase is None:  # at resonance nothing has moved at phase 0
        phase = -float(np.angle(state.tip)) if state.kind == "harmonic" else 0.0
    stage = _StateStage(result, state, picture)
    return as_png(stage.images([phase], stage.picture_at, lambda _: None)[0])


def captioned(result: FieldResult, state: State, size: tuple[int, int]) -> Still:
    """Still of so many pixels, coloured by the result's first field, with the state's caption."""
    words, picture = words_of(result, state), Picture(*size, shade=shades_of(result)[0])
    caption = f"{words.title}: {words.number}, {words.detail}".removesuffix(", ")
    return Still(still(result, state, picture), caption)


def check_film(path: Path, state: State) -> None:
    """Refuse a film of what does not move, or one that needs a program that is not there."""
    if state.kind == "static":
        raise InputError(
            f'state "{state.name}" does not move, so there is no film of it; write --png, or '
            "choose a mode or a harmonic state with --state"
        )
    check_ffmpeg(path)


def write_film(
    path: Path,
    result: FieldResult,
    state: State,
    picture: Picture,
    announce: Callable[[str], None] = lambda _: None,
) -> None:
    """Write one period of a state; see :func:`check_film` for what is refused."""
    check_film(path, state)
    phases = [2.0 * np.pi * k / _FRAMES for k in range(_FRAMES)]
    stage = _StateStage(result, state, picture)
    save_film(path, stage.images(phases, stage.picture_at, announce), _SHOWN, _REPEATS)


class _StateStage(Stage):
    """The scene of one state; only points and colours change with the phase."""

    def __init__(self, result: FieldResult, state: State, picture: Picture) -> None:
        super().__init__(picture.width, picture.height)
        self.result, self.state, self.style = result, state, picture
        self.enlarge = enlargement(result, state)
        self.top = picture.shade.top(state) if picture.shade else 0.0
        surface, points = surface_of(result.mesh), result.mesh.points * MM
        self._parts: list[Any] = []
        plain = list(range(len(result.mesh.regions)))
        if picture.shade is not None:
            # rigid bodies know their displacement alone
            bare = result.rigid if picture.shade.field != "displacement" else ()
            plain = [result.mesh.regions.index(name) for name in bare]
            part = self.surface(
                points, surface.triangles[~np.isin(surface.region_of_triangle, plain)]
            )
            part["shade"] = np.zeros(len(points))
            low = -self.top if picture.shade.signed else 0.0
            self._add(
                part, scalars="shade", cmap=SIGNED if picture.shade.signed else MAGNITUDE,
                clim=(low, self.top or 1.0), show_scalar_bar=False, ambient=0.45, diffuse=0.6,
            )  # fmt: skip
        for number in plain:
            part = self.surface(points, surface.triangles[surface.region_of_triangle == number])
            self._add(part, color=colour_of(result.mesh.regions[number]))
        self._lines(surface, points)
        self._look(points)

    def _add(self, part: Any, **options: Any) -> None:
        actor = self.plotter.add_mesh(part, **options)
        actor.mapper.resolve = "polygon_offset"  # lines on it are not swallowed
        self._parts.append(part)

    def _lines(self, surface: Surface, points: Any) -> None:
        """Add flux lines, else the mesh's edges."""
        flux = self.result.lines
        ends = points.copy() if flux is None else flux.reshape(-1, 3) * MM
        pairs = surface.edges if flux is None else np.arange(len(ends)).reshape(-1, 2)
        lines = np.column_stack([np.full(len(pairs), 2), pairs]).ravel()
        drawn = self.pv.PolyData(ends, lines=lines)
        if flux is not None:
            self.plotter.add_mesh(drawn, color="black", line_width=1.5)
            return
        self.plotter.add_mesh(drawn, color="#1d2733", opacity=0.3, line_width=1)
        self._parts.append(drawn)

    def _look(self, points: Any) -> None:
        direction, up = _VIEWS[self.style.lies, self.result.lines is not None]
        low, high = points.min(axis=0), points.max(axis=0)
        middle, long = 0.5 * (low + high), float(np.ptp(points[:, 2]))
        away = np.array(direction) / np.linalg.norm(direction)
        # across the screen, the device and what it moves; the words have rooms of their own
        right = np.cross(-away, up)
        right /= np.linalg.norm(right)
        over = np.cross(right, -away)
        corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T - middle
        moved = 0.0 if self.state.kind == "static" else 1.0
        values = self.state.fields.get("displacement")
        reach = 0.0 if values is None else self.enlarge * MM * float(np.abs(values).max())
        wide = 2.0 * np.abs(corners @ right).max() + (0.4 + moved) * abs(right[0]) * reach
        tall = 2.0 * np.abs(corners @ over).max() + 2.0 * abs(over[0]) * reach
        aspect, free = self.style.width / self.style.height, 1.0 - _HEAD - _FOOT
        scale = max(1.08 * tall / free, 1.08 * wide / aspect)
        shift = 0.5 * (_HEAD - _FOOT) * scale * over
        self.look_at(middle + shift, 4.0 * long * away, up, 0.5 * scale)
        self.per_pixel = scale / self.style.height

    def picture_at(self, phase: float) -> Image:
        """Picture at a phase (rad)."""
        at = 0.0 if self.state.kind == "static" else phase
        points = self.result.mesh.points.copy()
        if self.enlarge:
            points += self.enlarge * at_phase(np.asarray(self.state.fields["displacement"]), at)
        for part in self._parts:
            part.points = points * MM
        if self.style.shade is not None:
            self._parts[0]["shade"] = self.style.shade.at(self.state, at)
        image = self.image()
        _words(image, self, phase)
        return image


def _words(image: Image, stage: _StateStage, phase: float) -> None:
    """Write title, colour bar or parts, and a scale of lengths into a picture."""
    from PIL import ImageDraw

    result, state, picture = stage.result, stage.state, stage.style
    draw = ImageDraw.Draw(image)
    size = max(13, round(min(picture.height / 38, picture.width / 34)))
    font, small = fonts(1.0 * size, 0.84 * size)
    words, line = words_of(result, state), 1.45 * size
    said = [f"{MODELS.get(result.model, result.model)}: {words.title}"]
    said += [f"{words.number}  {words.detail}"] if picture.lies else [words.number, words.detail]
    for number, text in enumerate(said):
        draw.text((size, 0.8 * size + number * line), text, fill=INK, font=font)
    if stage.enlarge:
        angle = "" if state.kind == "static" else f", phase {round(np.degrees(phase)) % 360}°"
        times = f"displacements × {stage.enlarge:,.4g}{angle}"
        draw.text((size, 0.8 * size + len(said) * line), times, fill=DIM, font=small)
    bottom = picture.height - 3.1 * line
    if picture.shade is None:
        _parts(draw, result, (size, bottom + line), font)
    else:
        _bar(image, draw, stage, (size, bottom - 0.4 * line), font)
        draw.text((size, bottom + 2.1 * line), words.note, fill=DIM, font=small)
    _ruler(draw, stage, (picture.width - size, picture.height - 2.2 * line), small)


def _parts(draw: Any, result: FieldResult, at: tuple[float, float], font: Any) -> None:
    x, y = at
    for region in result.mesh.regions:
        colour = tuple(round(255 * c) for c in colour_of(region))
        title = region_title(region)
        draw.rectangle((x, y + 2, x + font.size, y + 2 + font.size), fill=colour, outline=DIM)
        draw.text((x + 1.4 * font.size, y), title, fill=INK, font=font)
        x += 2.6 * font.size + draw.textlength(title, font=font)


def _bar(image: Image, draw: Any, stage: _StateStage, at: tuple[float, float], font: Any) -> None:
    import matplotlib as mpl

    shade = stage.style.shade
    assert shade is not None
    x, y = round(at[0]), round(at[1])
    width, thick = round(0.3 * image.width + 6 * font.size), round(0.7 * font.size)
    draw.text((x, y), shade.title, fill=INK, font=font)
    top = y + round(1.4 * font.size)
    colours = mpl.colormaps[SIGNED if shade.signed else MAGNITUDE](np.linspace(0.0, 1.0, width))
    for k, colour in enumerate(colours):
        fill = tuple(round(255 * float(c)) for c in colour[:3])
        draw.line((x + k, top, x + k, top + thick), fill=fill)
    high = engineering(stage.top, shade.unit, 3)
    low = ("−" + high) if shade.signed else "0"
    under = top + thick + 2
    draw.text((x, under), low, fill=INK, font=font)
    draw.text((x + width - draw.textlength(high, font=font), under), high, fill=INK, font=font)
    if shade.signed:
        draw.text((x + 0.5 * width - 3, under), "0", fill=INK, font=font)


def _ruler(draw: Any, stage: _StateStage, at: tuple[float, float], font: Any) -> None:
    """Draw a length that is round and about an eighth of the picture."""
    wanted = stage.per_pixel * stage.style.width / 8.0
    power = 10.0 ** np.floor(np.log10(wanted))
    length = next(n * power for n in (5.0, 2.0, 1.0) if n * power <= wanted)
    right, y = at
    left = right - length / stage.per_pixel
    draw.line((left, y - 5, left, y, right, y, right, y - 5), fill=INK, width=2)
    text = engineering(length * 1e-3, "m", 3)
    place = 0.5 * (left + right - draw.textlength(text, font=font))
    draw.text((place, y + 5), text, fill=INK, font=font)
