"""The solid on bricks of high order, the fast reference, on two levels of a family.

The bimorph alone is one body.  On its rod it is three: foot and tip, reduced once and kept, and
what is between them, so that another length asks for a small system only.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING

from tactgen.fem.piezo.symmetry import Motion
from tactgen.geometry.bimorph.bimorph_bricks import LEVELS, BrickParts, bimorph_bricks
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.bimorph.rod_bricks import ROD_LEVELS, rod_parts
from tactgen.geometry.device.checks import (
    check_bonded,
    check_constant_section,
    check_plain_layers,
)
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.error_bars import (
    ROD_FACTOR,
    ROD_GAIN,
    SAFETY,
    SURPLUS_FACTOR,
    SURPLUS_FACTOR_AT_EDGES,
)
from tactgen.validation.models.bimorph.two_meshes import TwoMeshModel
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.piezo.system import SolidSystem, Surplus

#: Relative error bar of static deflection, capacitances and first frequencies that each level
#: stays below on the paper's bimorph and on job J1 (tests/validation/engine/test_refinement.py).
_BRICK_BARS = (1e-1, 8e-4, 2.5e-4, 2e-4, 6e-5)

#: The same of the bimorph on its rod, on the built-in scene; its true errors are less than half
#: of these (tests/validation/models/test_solid_on_rod.py).
_ROD_BARS = (1e-1, 7e-3, 1e-3, 9e-4, 2.5e-4)


class SolidModel(TwoMeshModel):
    """The bimorph alone, or glued into its rod, on bricks."""

    name = "solid"

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse what bricks do not know: profiles, layers that slide; on the rod also others."""
        device = scene.device
        check_constant_section(device)
        check_bonded(device)
        if scene.support.kind == "rod":
            check_plain_layers(device)
            _check_accuracy(scene)

    @classmethod
    def finest(cls, scene: Scene) -> float:
        """Return the relative error bar that the finest bricks keep to."""
        return _ROD_BARS[-1] if scene.support.kind == "rod" else super().finest(scene)

    def warnings(self, quantities: Sequence[str]) -> tuple[str, ...]:
        """Say that the coarsest level is no answer of its own."""
        if self.scene.mesh.level != 1:
            return ()
        sentence = (
            "mesh.level = 1 is 2 for the model solid, whose error bar needs a coarser level than "
            "its own; write mesh.level = 2 to say what it is"
        )
        return (sentence,)

    def make_pair(self) -> BrickPair:
        """Return the level that the accuracy asks for, and the next coarser one."""
        return brick_pair(self.scene)


@dataclass(frozen=True)
class BrickPair:
    """Bricks of two neighbouring levels, the coarser to judge the finer by."""

    device: Device
    meshes: tuple[Bricks | BrickParts, Bricks | BrickParts]

    @cached_property
    def systems(self) -> tuple[SolidSystem, SolidSystem]:
        """The lossless systems on the finer and the coarser mesh."""
        from tactgen.fem.piezo.solid import assemble

        fine, coarse = (assemble(self.device, mesh, lossy=False) for mesh in self.meshes)
        return fine, coarse

    @cached_property
    def lacking(self) -> Callable[[Motion], Surplus] | None:
        """Gives the polynomials of one degree more that the finer bricks lack; not on the rod."""
        if isinstance(self.meshes[0], BrickParts):
            return None
        from tactgen.fem.piezo.brick_error import BrickSurplus

        return cache(BrickSurplus(self.device, self.meshes[0]).of)

    @property
    def lacking_lossy(self) -> Callable[[], Surplus] | None:
        """Gives the same with losses, of bending in x: what judges the response."""
        bricks = self.meshes[0]
        if isinstance(bricks, BrickParts):
            return None
        from tactgen.fem.piezo.brick_error import BrickSurplus

        return lambda: BrickSurplus(self.device, bricks, lossy=True).of("bending_x")

    @property
    def static_factor(self) -> float:
        """Error bar of all that is answered per difference from what judges it."""
        if isinstance(self.meshes[0], BrickParts):
            return ROD_FACTOR
        b = self.device.bimorph
        inside = max(b.tab_length, b.glue_thickness, b.bare_below, b.bare_above) > 0.0
        inside |= self.meshes[0].held == "shim"
        return SURPLUS_FACTOR_AT_EDGES if inside else SURPLUS_FACTOR

    @property
    def response_factor(self) -> float:
        """The same of the response."""
        return self.static_factor

    @property
    def static_share(self) -> float:
        """Relative error that static quantities and the response count with besides: none."""
        return 0.0

    @property
    def mode_factors(self) -> tuple[float, float]:
        """The same of frequencies: of bending in x, and of the other classes of motion."""
        return self.static_factor, self.static_factor

    @property
    def method(self) -> str:
        """How the error bars come about, for the reader."""
        fine, coarse = (
            mesh.values if isinstance(mesh, BrickParts) else system.size
            for mesh, system in zip(self.meshes, self.systems, strict=True)
        )
        if self._on_rod:
            return (
                f"two levels of bricks ({fine} and {coarse} unknowns), the error assumed to fall "
                f"by {ROD_GAIN:g}, safety factor {SAFETY}"
            )
        return (
            f"what polynomials of one degree more make of the residual of {fine} unknowns, times "
            f"{self.static_factor:g}"
        )

    @property
    def _on_rod(self) -> bool:
        return isinstance(self.meshes[0], BrickParts)


def brick_pair(scene: Scene) -> BrickPair:
    """Return the bricks that the scene asks for, and those to judge them by."""
    finer = level_for(scene)

    def bricks(number: int) -> Bricks | BrickParts:
        if scene.support.kind == "rod":
            return rod_parts(scene.device, ROD_LEVELS[number])
        return bimorph_bricks(scene.device, LEVELS[number])

    return BrickPair(scene.device, (bricks(finer), bricks(finer - 1)))


def _check_accuracy(scene: Scene) -> None:
    """Refuse an accuracy on the rod that no level is known to reach."""
    finest = _ROD_BARS[-1]
    if not scene.mesh.level and scene.accuracy < finest:
        raise InputError(
            f"accuracy = {scene.accuracy:g} is less than the {finest:g} that the model solid is "
            f"known to reach on the rod; ask for {finest:g} or more, or set mesh.level = "
            f"{len(_ROD_BARS)} and judge the error bar that it states"
        )


def level_for(scene: Scene) -> int:
    """Return the index (0 to 4) of the finer bricks' level; never the coarsest."""
    if scene.mesh.level:
        return max(scene.mesh.level - 1, 1)
    bars = _ROD_BARS if scene.support.kind == "rod" else _BRICK_BARS
    for index, error in enumerate(bars):
        if index and error <= scene.accuracy:
            return index
    return len(bars) - 1
