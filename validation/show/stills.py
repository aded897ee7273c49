"""Stills and films of states: PyVista off screen draws the device, colour bar and scale go on top.

Deformation, colours and views are those of the page.  The same request gives the same
bytes on the same machine.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.formats import engineering
from tactgen.geometry.meshing.mesh import Surface, surface_of
from tactgen.validation.show.field import (
    COLOURS,
    MAGNITUDE,
    MODELS,
    REGIONS,
    SIGNED,
    FieldResult,
    Shade,
    State,
    at_phase,
    enlargement,
    words_of,
)
from tactgen.validation.show.figures import off_screen

if TYPE_CHECKING:
    from PIL.Image import Image
import shutil
import subprocess
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole

#: Directions from the device to the eye, and what is up, lying and standing.
_LYING = ((0.5, 1.0, 0.3), (1.0, 0.0, 0.0))
_STANDING = ((0.75, -1.0, 0.45), (0.0, 0.0, 1.0))
#: The same of what is opened by a quarter, to look into it.
_LYING_OPEN = ((-0.8, -1.0, 0.25), (-1.0, 0.0, 0.0))
_STANDING_OPEN = ((-0.75, -1.0, 0.45), (0.0, 0.0, 1.0))
_INK, _DIM = (29, 39, 51), (91, 103, 118)
#: Room for words above and below the device, in parts of the picture's height.
_HEAD, _FOOT = 0.14, 0.2
_MM = 1e3


@dataclass(frozen=True)
class Picture:
    """Style of a still: size in pixels and colour field; None colours by part."""

    width: int = 1200
    height: int = 640
    shade: Shade | None = None
    mesh: bool = True

    @property
    def lies(self) -> bool:
        """Whether the device lies, its tip to the right."""
        return self.width > self.height


def still(result: FieldResult, state: State, picture: Picture, phase: float = 0.0) -> bytes:
    """PNG of a state at a phase (rad).

    Raises InputError if the system has no OpenGL library.
    """
    image = next(iter(frames(result, state, picture, [phase])))
    buffer = io.BytesIO()
    image.save(buffer, format="PNG", optimize=True)
    return buffer.getvalue()


def frames(
    result: FieldResult,
    state: State,
    picture: Picture,
    phases: list[float],
    announce: Callable[[str], None] = lambda _: None,
) -> list[Image]:
    """Image for each phase (rad), all to one scale of colours and lengths."""
    from PIL import Image as Images

    stage = _Stage(result, state, picture)
    made = []
    for number, phase in enumerate(phases, start=1):
        announce(f"picture {number} of {len(phases)}")
        image = Images.fromarray(stage.shot(phase))
        _words(image, stage, phase)
        made.append(image)
    stage.close()
    return made


class _Stage:
    """The off-screen scene of one state; only points and colours change with the phase."""

    def __init__(self, result: FieldResult, state: State, picture: Picture) -> None:
        pv = off_screen()
        self.result, self.state, self.picture = result, state, picture
        self.enlarge = enlargement(result, state)
        self.top = picture.shade.top(state) if picture.shade else 0.0
        surface = surface_of(result.mesh)
        points = result.mesh.points * _MM
        self._plotter = pv.Plotter(
            off_screen=True, window_size=(picture.width, picture.height), lighting="three lights"
        )
        self._plotter.set_background("white")
        self._plotter.enable_anti_aliasing("ssaa")
        self._parts: list[Any] = []
        if picture.shade is None:
            for number in range(len(result.mesh.regions)):
                self._of_region(pv, points, surface, number)
        else:
            bare = result.rigid if picture.shade.field != "displacement" else ()
            rigid = [result.mesh.regions.index(name) for name in bare]
            part = surface_part(
                pv, points, surface.triangles[~np.isin(surface.region_of_triangle, rigid)]
            )
            part["shade"] = np.zeros(len(points))
            low = -self.top if picture.shade.signed else 0.0
            self._solid(
                part, scalars="shade", cmap=SIGNED if picture.shade.signed else MAGNITUDE,
                clim=(low, self.top or 1.0), show_scalar_bar=False, ambient=0.45, diffuse=0.6,
            )  # fmt: skip
            self._parts.append(part)
            for number in rigid:  # which have no such field
                self._of_region(pv, points, surface, number)
        if result.lines is not None:
            ends = result.lines.reshape(-1, 3) * _MM
            pairs = np.arange(len(ends)).reshape(-1, 2)
            lines = pv.PolyData(
                ends, lines=np.column_stack([np.full(len(pairs), 2), pairs]).ravel()
            )
            self._plotter.add_mesh(lines, color="black", line_width=1.5)
        elif picture.mesh:
            lines = np.column_stack([np.full(len(surface.edges), 2), surface.edges])
            edges = pv.PolyData(points.copy(), lines=lines.ravel())
            self._plotter.add_mesh(edges, color="#1d2733", opacity=0.3, line_width=1)
            self._parts.append(edges)
        self._look(points)

    def _of_region(self, pv: Any, points: Any, surface: Surface, number: int) -> None:
        """Add the part of a region in its own colour."""
        part = surface_part(pv, points, surface.triangles[surface.region_of_triangle == number])
        self._solid(part, color=COLOURS.get(self.result.mesh.regions[number], "silver"))
        self._parts.append(part)

    def _solid(self, part: Any, **options: Any) -> None:
        actor = self._plotter.add_mesh(part, **options)
        actor.mapper.resolve = "polygon_offset"  # lines on it are not swallowed

    def _look(self, points: Any) -> None:
        direction, up = _LYING if self.picture.lies else _STANDING
        if self.result.lines is not None:
            direction, up = _LYING_OPEN if self.picture.lies else _STANDING_OPEN
        camera, low, high = self._plotter.camera, points.min(axis=0), points.max(axis=0)
        middle, long = 0.5 * (low + high), float(np.ptp(points[:, 2]))
        away = np.array(direction) / np.linalg.norm(direction)
        camera.focal_point = tuple(middle)
        camera.position = tuple(middle + 4.0 * long * away)
        camera.up = up
        camera.parallel_projection = True
        # across the screen, the device and what it moves; the words have rooms of their own
        right = np.cross(-away, up)
        right /= np.linalg.norm(right)
        over = np.cross(right, -away)
        corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T - middle
        moved = 0.0 if self.state.kind == "static" else 1.0
        reach = self.enlarge * _MM * self._largest()
        wide = 2.0 * np.abs(corners @ right).max() + (0.4 + moved) * abs(right[0]) * reach
        tall = 2.0 * np.abs(corners @ over).max() + 2.0 * abs(over[0]) * reach
        aspect, free = self.picture.width / self.picture.height, 1.0 - _HEAD - _FOOT
        scale = max(1.08 * tall / free, 1.08 * wide / aspect)
        camera.parallel_scale = 0.5 * scale
        shift = 0.5 * (_HEAD - _FOOT) * scale * over
        camera.focal_point = tuple(middle + shift)
        camera.position = tuple(middle + shift + 4.0 * long * away)
        self.per_pixel = scale / self.picture.height
        self._plotter.renderer.ResetCameraClippingRange()

    def _largest(self) -> float:
        values = self.state.fields.get("displacement")
        return 0.0 if values is None else float(np.abs(values).max())

    def shot(self, phase: float) -> Any:
        """Picture (height, width, 3) at a phase (rad)."""
        phase = 0.0 if self.state.kind == "static" else phase
        points = self.result.mesh.points.copy()
        if self.enlarge:
            moved = at_phase(np.asarray(self.state.fields["displacement"]), phase)
            points += self.enlarge * moved
        for part in self._parts:
            part.points = points * _MM
        if self.picture.shade is not None:
            self._parts[0]["shade"] = self.picture.shade.at(self.state, phase)
        self._plotter.render()
        return self._plotter.screenshot(return_img=True)

    def close(self) -> None:
        """Let go of the off-screen window."""
        self._plotter.close()


def surface_part(pv: Any, points: Any, triangles: Any) -> Any:
    """Triangles (m, 3) of points (n, 3) as PyVista's surface."""
    faces = np.column_stack([np.full(len(triangles), 3), triangles])
    return pv.PolyData(points.copy(), faces.ravel())


def _words(image: Image, stage: _Stage, phase: float) -> None:
    """Write title, colour bar or parts, and a scale of lengths into a picture."""
    from PIL import ImageDraw, ImageFont

    result, state, picture = stage.result, stage.state, stage.picture
    draw = ImageDraw.Draw(image)
    size = max(13, round(min(picture.height / 38, picture.width / 34)))
    font, small = (ImageFont.truetype(typeface(), k * size) for k in (1.0, 0.84))
    words, left, line = words_of(result, state), size, 1.45 * size
    draw.text((left, 0.8 * size), f"{MODELS.get(result.model, result.model)}: {words.title}",
              fill=_INK, font=font)  # fmt: skip
    said = [words.number, words.detail] if not picture.lies else [f"{words.number}  {words.detail}"]
    for number, text in enumerate(said, start=1):
        draw.text((left, 0.8 * size + number * line), text, fill=_INK, font=font)
    if stage.enlarge:
        angle = "" if state.kind == "static" else f", phase {round(np.degrees(phase)) % 360}°"
        times = f"displacements × {stage.enlarge:,.4g}{angle}"
        draw.text((left, 0.8 * size + (1 + len(said)) * line), times, fill=_DIM, font=small)
    bottom = picture.height - 3.1 * line
    if picture.shade is None:
        _parts(draw, result, (left, bottom + line), font)
    else:
        _bar(image, draw, stage, (left, bottom - 0.4 * line), font)
        draw.text((left, bottom + 2.1 * line), words.note, fill=_DIM, font=small)
    _ruler(draw, stage, (picture.width - size, picture.height - 2.2 * line), small)


def typeface() -> str:
    """File of a typeface that has ×, − and µ: matplotlib brings it."""
    import matplotlib as mpl

    return str(Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")


def _parts(draw: Any, result: FieldResult, at: tuple[float, float], font: Any) -> None:
    x, y = at
    for region in result.mesh.regions:
        colour = tuple(round(255 * c) for c in COLOURS.get(region, (0.7, 0.7, 0.7)))
        title = REGIONS.get(region, region)
        draw.rectangle((x, y + 2, x + font.size, y + 2 + font.size), fill=colour, outline=_DIM)
        draw.text((x + 1.4 * font.size, y), title, fill=_INK, font=font)
        x += 2.6 * font.size + draw.textlength(title, font=font)


def _bar(image: Image, draw: Any, stage: _Stage, at: tuple[float, float], font: Any) -> None:
    import matplotlib as mpl

    shade = stage.picture.shade
    assert shade is not None
    x, y = round(at[0]), round(at[1])
    width, thick = round(0.3 * image.width + 6 * font.size), round(0.7 * font.size)
    draw.text((x, y), shade.title, fill=_INK, font=font)
    top = y + round(1.4 * font.size)
    colours = mpl.colormaps[SIGNED if shade.signed else MAGNITUDE](np.linspace(0.0, 1.0, width))
    for k, colour in enumerate(colours):
        fill = tuple(round(255 * float(c)) for c in colour[:3])
        draw.line((x + k, top, x + k, top + thick), fill=fill)
    high = engineering(stage.top, shade.unit, 3)
    low = ("−" + high) if shade.signed else "0"
    under = top + thick + 2
    draw.text((x, under), low, fill=_INK, font=font)
    draw.text((x + width - draw.textlength(high, font=font), under), high, fill=_INK, font=font)
    if shade.signed:
        draw.text((x + 0.5 * width - 3, under), "0", fill=_INK, font=font)


def _ruler(draw: Any, stage: _Stage, at: tuple[float, float], font: Any) -> None:
    """Draw a length that is round and about an eighth of the picture."""
    wanted = stage.per_pixel * stage.picture.width / 8.0
    power = 10.0 ** np.floor(np.log10(wanted))
    length = next(n * power for n in (5.0, 2.0, 1.0) if n * power <= wanted)
    right, y = at
    left = right - length / stage.per_pixel
    draw.line((left, y - 5, left, y, right, y, right, y - 5), fill=_INK, width=2)
    text = engineering(length * 1e-3, "m", 3)
    place = 0.5 * (left + right - draw.textlength(text, font=font))
    draw.text((place, y + 5), text, fill=_INK, font=font)


#: Pictures of one period, and milliseconds that each is shown.
_FRAMES, _SHOWN = 24, 80
#: Periods in an .mp4, which players do not repeat by themselves.
_REPEATS = 4


def check_film(path: Path, state: State) -> None:
    """Refuse a film before anything is drawn.

    Raises InputError if the state does not move, or an .mp4 is wanted and there is no ffmpeg.
    """
    if state.kind == "static":
        raise InputError(
            f'state "{state.name}" does not move, so there is no film of it; write --png, or '
            "choose a mode or a harmonic state with --state"
        )
    check_ffmpeg(path)


def check_ffmpeg(path: Path) -> None:
    """Refuse an .mp4 where there is no ffmpeg.

    Raises InputError with the remedy.
    """
    if path.suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise InputError(
            f"--mp4 {path} needs the program ffmpeg, which is not on this machine; install it "
            "(apt-get install ffmpeg), or write --gif"
        )


def write_film(
    path: Path,
    result: FieldResult,
    state: State,
    picture: Picture,
    announce: Callable[[str], None] = lambda _: None,
) -> None:
    """Write one period of a state; refusals as of :func:`check_film`."""
    check_film(path, state)
    phases = [2.0 * np.pi * k / _FRAMES for k in range(_FRAMES)]
    save_film(path, frames(result, state, picture, phases, announce), _SHOWN, _REPEATS)


def save_film(path: Path, images: Sequence[Image], shown: int, repeats: int = 1) -> None:
    """Write pictures of one size as a film, each shown so many milliseconds.

    Parameters
    ----------
    repeats : int
        How often an .mp4 holds them all; a .gif starts again by itself.

    Raises InputError if the film cannot be made or written.
    """
    from PIL.Image import Dither

    check_ffmpeg(path)
    with written_whole(path) as temporary:
        if path.suffix == ".gif":
            # one palette for all pictures, so that nothing flickers
            palette = images[0].quantize(colors=255)
            indexed = [image.quantize(palette=palette, dither=Dither.NONE) for image in images]
            indexed[0].save(
                temporary, save_all=True, append_images=indexed[1:], duration=shown, loop=0
            )
            return
        raw = b"".join(image.tobytes() for image in images) * repeats
        size = "{}x{}".format(*images[0].size)
        command = [
            "ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", size, "-r", f"{1000.0 / shown:g}", "-i", "-", "-pix_fmt", "yuv420p",
            "-movflags", "+faststart", "-fflags", "+bitexact", str(temporary),
        ]  # fmt: skip
        done = subprocess.run(command, input=raw, capture_output=True, check=False)
        if done.returncode != 0:
            reason = done.stderr.decode(errors="replace").strip().splitlines() or ["no reason"]
            raise InputError(f"{path} was not made: ffmpeg says: {reason[-1]}; write --gif")
