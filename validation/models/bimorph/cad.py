"""The CAD solids on tetrahedra: cadquery's shapes, fTetWild's mesh, scikit-fem's elements.

Shares with the bricks of the model solid the equations and nothing of mesh or assembly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.checks import check_plain_layers
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.structured_tets import whole_mesh
from tactgen.validation.engine.stages import Stages
from tactgen.validation.models.bimorph.lowest_modes import MeshModes
from tactgen.validation.models.bimorph.solid import SolidModel, brick_pair
from tactgen.validation.models.bimorph.two_meshes import MeshPair, TwoMeshModel
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.piezo.system import SolidSystem
    from tactgen.validation.models.bimorph.adaptive_meshes import AdaptedPair


class CadModel(TwoMeshModel):
    """The bimorph alone, or glued into its rod, on tetrahedra refined for its accuracy."""

    name = "cad"

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse what the CAD solids do not know: profiles, bare ends, glue between layers."""
        check_plain_layers(scene.device)

    def __init__(self, scene: Scene, stages: Stages) -> None:
        super().__init__(scene, stages)
        self._ahead: list[tuple[SolidSystem, MeshModes]] = []

    def make_pair(self) -> AdaptedPair:
        """Last mesh of the refinement, and an earlier one to judge it by."""
        # an answer from the store needs none of what makes meshes
        from tactgen.validation.models.bimorph.adaptive_meshes import adapted_pair, level_limits

        pair = adapted_pair(self.scene, *level_limits(self.scene), self._look_ahead)
        # the systems of all other meshes are let go
        self._ahead = [found for found in self._ahead if found[0] is pair.coarse.system]
        return pair

    def coarse_modes(self, system: SolidSystem) -> MeshModes:
        """What modes follow from on a mesh that judges another; found before, perhaps."""
        ahead = (modes for of, modes in self._ahead if of is system)
        return next(ahead, None) or super().coarse_modes(system)

    def _look_ahead(self, system: SolidSystem) -> None:
        if self.will_run("modal"):
            self._ahead.append((system, super().coarse_modes(system)))


def mesh_pair(scene: Scene) -> MeshPair:
    """Meshes for pictures and files: bricks if the scene asks for them and can.

    Raises InputError if neither bricks nor tetrahedra know the scene's bimorph.
    """
    if scene.support.kind == "rod" or ("cad" in scene.models and "solid" not in scene.models):
        from tactgen.validation.models.bimorph.adaptive_meshes import adapted_pair, level_limits

        CadModel.check(scene)
        return adapted_pair(scene, *level_limits(scene))
    SolidModel.check(scene)
    return brick_pair(scene)


def cells_of(mesh: Mesh | Bricks) -> Mesh:
    """Cells to show or to write, of the whole: bricks become eight-cornered ones."""
    return mesh.corner_mesh() if isinstance(mesh, Bricks) else whole_mesh(mesh)
