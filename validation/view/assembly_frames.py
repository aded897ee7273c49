"""Pictures of the display in motion: parts that stand at several places, their tips swinging."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.validation.view.pictures import Assembled, off_screen
from tactgen.validation.view.stills import typeface

if TYPE_CHECKING:
    from PIL.Image import Image

#: Size in pixels, and where the eye is: far enough up that all tips are seen.
_SIZE = 640, 720
_VIEW = (2.2, -3.0, 2.0)
#: Half the picture's height over the size of what moves.
_ROOM = 0.62
#: Share of the pitch that the largest deflection is drawn as.
_REACH = 0.3


class Swinging(Assembled, Protocol):
    """A part that may swing with its unit's tip."""

    @property
    def moves(self) -> bool:
        """Whether it does."""


def enlargement(tips: Complex, pitch: float) -> float:
    """Return by how much tips' motions (units,) in m are drawn enlarged at a pitch (mm)."""
    largest = 1e3 * float(np.abs(tips).max(initial=0.0))
    return _REACH * pitch / largest if largest > 0.0 else 0.0


def assembly_frames(
    parts: Sequence[Swinging],
    tips: Complex,
    ceramic: tuple[float, float],
    enlarge: float,
    words: str,
    phases: Sequence[float],
    announce: Callable[[str], None] = lambda _: None,
) -> list[Image]:
    """Return an image for each phase (rad).

    Parameters
    ----------
    parts : sequence of Swinging
        Lengths in mm.  Places of what moves are in the order of the tips.
    tips : (units,) complex array
        Lateral motion, along x (m, peak).
    ceramic : (float, float)
        Height of its lower edge in a unit's frame, and its length (mm); between base and tip
        a bimorph is drawn as a parabola.
    enlarge : float
        By how much motion is drawn enlarged.
    words : str
        Written into the pictures.
    """
    from PIL import Image, ImageDraw, ImageFont

    pv = off_screen()
    plotter = pv.Plotter(off_screen=True, window_size=_SIZE, lighting="three lights")
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    moving = [_placed(pv, plotter, part, ceramic) for part in parts]
    plotter.camera_position = [_VIEW, (0.0, 0.0, 0.0), (0, 0, 1)]
    plotter.camera.parallel_projection = True
    plotter.reset_camera()
    swinging = [rest.reshape(-1, 3) for _, rest, shares in moving if shares is not None]
    _look_at(plotter, np.concatenate(swinging))
    font = ImageFont.truetype(typeface(), 15)
    images = []
    for number, phase in enumerate(phases, start=1):
        announce(f"picture {number} of {len(phases)}")
        swing = 1e3 * enlarge * np.real(tips * np.exp(1j * phase))
        for surface, rest, shares in moving:
            if shares is not None:
                points = rest.copy()
                points[..., 0] += swing[:, None] * shares
                surface.points = points.reshape(-1, 3)
        plotter.render()
        image = Image.fromarray(plotter.screenshot(return_img=True))
        ImageDraw.Draw(image).text((14, 12), words, fill=(29, 39, 51), font=font)
        images.append(image)
    plotter.close()
    return images


def _look_at(plotter: Any, points: Floats) -> None:
    """Fill the picture with what moves (mm); what stands round it may be cut off."""
    camera = plotter.camera
    shift = 0.5 * (points.min(axis=0) + points.max(axis=0)) - np.array(camera.focal_point)
    for name in ("focal_point", "position"):
        setattr(camera, name, tuple(np.array(getattr(camera, name)) + shift))
    camera.parallel_scale = _ROOM * float(np.linalg.norm(np.ptp(points, axis=0)))
    plotter.renderer.ResetCameraClippingRange()


def _placed(
    pv: Any, plotter: Any, part: Swinging, ceramic: tuple[float, float]
) -> tuple[Any, Floats, Floats | None]:
    """Add a part to a picture; return its surface, points (copies, n, 3), shares of the tip's."""
    count, copies = len(part.points), len(part.places)
    points = np.asarray(part.places[:, None, :] + part.points[None], dtype=float)
    numbers = (part.triangles[None] + count * np.arange(copies)[:, None, None]).reshape(-1, 3)
    faces = np.column_stack([np.full(len(numbers), 3), numbers])
    surface = pv.PolyData(points.reshape(-1, 3), faces.ravel())
    plotter.add_mesh(surface, color=part.colour, smooth_shading=False)
    if not part.moves:
        return surface, points, None
    base, reach = ceramic
    height = np.clip((part.points[:, 2] - base) / reach, 0.0, 1.0)
    return surface, points, height[None] ** 2
