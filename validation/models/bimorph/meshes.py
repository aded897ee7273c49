"""Which meshes the solid model is solved on, chosen from the scene and its accuracy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from geometry.bimorph.brick_family import LEVELS, bimorph_bricks
from geometry.bimorph.bricks import Bricks
from geometry.device.checks import check_bonded, check_constant_section, check_plain_layers
from geometry.device.parameters import Device
from geometry.meshing.mesh import Mesh
from validation.engine.refinement import ASSUMED_GAIN, BRICK_FACTOR, SAFETY
from validation.scene.scene import Scene

if TYPE_CHECKING:
    from fem.bimorph.system import SolidSystem
    from validation.models.bimorph.adaptive_meshes import AdaptedPair

#: Relative error bar of static deflection, capacitances and first frequencies that each level
#: stays below on the paper's bimorph and on job J1 (tests/test_refinement.py).
_BRICK_BARS = (1e-1, 3e-3, 8e-4, 2.5e-4, 6e-5)
#: Accuracy that each level stands for with tetrahedra.
_TET_BARS = (1e-2, 3e-3, 1e-3, 6e-4, 2.5e-4)


def level_for(scene: Scene) -> int:
    """Return the index (0 to 4) of the finer bricks' level; never the coarsest."""
    if scene.mesh.level:
        return max(scene.mesh.level - 1, 1)
    for index, error in enumerate(_BRICK_BARS):
        if index and error <= scene.accuracy:
            return index
    return len(_BRICK_BARS) - 1


def uses_tetrahedra(scene: Scene) -> bool:
    """Return whether the scene is meshed with tetwild."""
    return scene.mesh.kind == "tetwild" or scene.support.kind == "rod"


def check_meshable(scene: Scene) -> None:
    """Refuse a bimorph that the scene's kind of mesh does not know.

    Raises
    ------
    InputError
        In one sentence that names the models that can.
    """
    if uses_tetrahedra(scene):
        check_plain_layers(scene.device)
    else:
        check_constant_section(scene.device)
        check_bonded(scene.device)


@dataclass(frozen=True)
class BrickPair:
    """Bricks of two neighbouring levels, the coarser to judge the finer by."""

    device: Device
    meshes: tuple[Bricks, Bricks]

    @cached_property
    def systems(self) -> tuple[SolidSystem, SolidSystem]:
        """The lossless systems on the finer and the coarser mesh."""
        from fem.bimorph.bricks.assembly import assemble_bricks

        fine, coarse = (assemble_bricks(self.device, m, lossy=False) for m in self.meshes)
        return fine, coarse

    @property
    def static_factor(self) -> float:
        """Error bar of static quantities per difference between the two meshes."""
        return BRICK_FACTOR

    @property
    def mode_factor(self) -> float:
        """Error bar of natural frequencies per difference between the two meshes."""
        return self.static_factor

    @property
    def method(self) -> str:
        """How the error bars come about, for the reader."""
        fine, coarse = (system.size for system in self.systems)
        return (
            f"two levels of bricks ({fine} and {coarse} unknowns), the error assumed to fall by "
            f"{ASSUMED_GAIN:g}, safety factor {SAFETY}"
        )


def mesh_pair(scene: Scene) -> BrickPair | AdaptedPair:
    """Return the finer mesh of the solid model, and a coarser one to judge it by.

    Bricks are compared with the next coarser level, tetrahedra with the mesh that they were
    refined from.
    """
    level = scene.mesh.level
    if uses_tetrahedra(scene):
        from validation.models.bimorph.adaptive_meshes import adapted_pair

        return adapted_pair(scene, _TET_BARS[level - 1] if level else scene.accuracy)
    fine = level_for(scene)
    bricks = [bimorph_bricks(scene.device, LEVELS[number]) for number in (fine, fine - 1)]
    return BrickPair(scene.device, (bricks[0], bricks[1]))


def cells_of(mesh: Mesh | Bricks) -> Mesh:
    """Return the cells to show or to write: bricks become eight-cornered cells of the whole."""
    return mesh.corner_mesh() if isinstance(mesh, Bricks) else mesh


def points_of(mesh: Mesh | Bricks) -> Mesh:
    """Return a mesh whose points are nodes of the solution."""
    return mesh.node_mesh() if isinstance(mesh, Bricks) else mesh
