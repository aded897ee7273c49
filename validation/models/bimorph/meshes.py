"""Two meshes of one solid: what judges the finer one, and which pair a scene is solved on."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from tactgen.geometry.bimorph.brick_parts import BrickParts
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.mirror import whole_mesh
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.bimorph.motions import Motion
    from tactgen.fem.bimorph.system import SolidSystem, Surplus

#: Why the solid on its rod is in no picture.
NOT_SHOWN = (
    'with support.kind = "rod" the model solid reduces rod and tab to what the bimorph feels of '
    "them and has no fields there; ask for pictures with --model cad"
)


class MeshPair(Protocol):
    """A finer mesh, a coarser one to judge it by, and what their difference says."""

    @property
    def meshes(self) -> tuple[Mesh | Bricks | BrickParts, Mesh | Bricks | BrickParts]:
        """The finer and the coarser mesh."""

    @property
    def systems(self) -> tuple[SolidSystem, SolidSystem]:
        """The lossless systems on them."""

    @property
    def lacking(self) -> Callable[[Motion], Surplus] | None:
        """What gives functions that the finer mesh lacks, which then judge it."""

    @property
    def lacking_lossy(self) -> Callable[[], Surplus] | None:
        """What gives the same with losses, of bending in x, which then judge the response."""

    @property
    def static_factor(self) -> float:
        """Error bar of static quantities per difference from what judges them."""

    @property
    def response_factor(self) -> float:
        """Error bar of the response per difference from what judges it."""

    @property
    def static_share(self) -> float:
        """Relative error that static quantities count with at least, and the response besides."""

    @property
    def mode_factors(self) -> tuple[float, float]:
        """The same of frequencies: of bending in x, and of the other classes of motion."""

    @property
    def method(self) -> str:
        """How the error bars come about, for the reader."""


def mesh_pair(scene: Scene) -> MeshPair:
    """Return the meshes for pictures and files: bricks if the scene asks for them and can.

    Raises
    ------
    InputError
        If neither bricks nor tetrahedra know the scene's bimorph.
    """
    if scene.support.kind == "rod" or ("cad" in scene.models and "solid" not in scene.models):
        from tactgen.validation.models.bimorph.adaptive_meshes import adapted_pair, level_limits
        from tactgen.validation.models.bimorph.cad import CadModel

        CadModel.check(scene)
        return adapted_pair(scene, *level_limits(scene))
    from tactgen.validation.models.bimorph.solid import SolidModel, brick_pair

    SolidModel.check(scene)
    return brick_pair(scene)


def cells_of(mesh: Mesh | Bricks | BrickParts) -> Mesh:
    """Return the cells to show or to write, of the whole: bricks become eight-cornered ones.

    Raises
    ------
    InputError
        For bricks in parts, which the round outline of a rod cuts.
    """
    if isinstance(mesh, BrickParts):
        raise InputError(NOT_SHOWN)
    return mesh.corner_mesh() if isinstance(mesh, Bricks) else whole_mesh(mesh)
