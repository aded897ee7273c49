"""The section between a narrow strip and a wide plate: what the free side edges decide.

Far from its ends the section of a narrow bimorph knows no stress across, that of a wide one
is laminate theory's.  In between the solid's own section shows how far the width has come.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tactgen.tmm.beam.sections import laminate_section
from tactgen.validation.models.bimorph.bridge.solid_values import (
    SolidCase,
    far_section,
    solve_static,
)
from tactgen.validation.scene.scene import Scene

#: Widths in terms of the scene's.
WIDTHS = (0.1, 0.5, 1.0, 2.0, 5.0)
#: Least length in widths, so that the ends are far.
_LENGTHS = 10.0


@dataclass(frozen=True)
class WidthPoint:
    """A width (m) and the share of the way from strip (0) to plate (1), per section constant."""

    width: float
    bending: float
    moment: float
    capacitance: float


def width_study(
    scene: Scene, widths: Sequence[float] = WIDTHS, *, level: int = 1
) -> list[WidthPoint]:
    """Return where the solid's section stands between strip and plate for several widths."""
    return [_point(scene, share * scene.bimorph.width, level) for share in widths]


def _point(scene: Scene, width: float, level: int) -> WidthPoint:
    length = max(scene.bimorph.length, _LENGTHS * width)
    bimorph = scene.bimorph.model_copy(update={"width": width, "length": length})
    case = SolidCase(scene.model_copy(update={"bimorph": bimorph}), level=level)
    own = far_section(case, solve_static(case))
    device, beam = case.scene.device, scene.beam
    strip = laminate_section(device, beam, poisson=False, d32=False)
    plate = laminate_section(device, beam)
    shares = []
    for key in ("EI", "K", "C"):
        low, high = getattr(strip, key), getattr(plate, key)
        shares.append(float((getattr(own, key) - low) / (high - low)))
    return WidthPoint(width, *shares)
