"""Which of the two field models can take a scene, and the meshes that it is solved on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.mirror import whole_mesh
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.validation.models.bimorph.two_meshes import MeshPair


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


def cells_of(mesh: Mesh | Bricks) -> Mesh:
    """Return the cells to show or to write, of the whole: bricks become eight-cornered ones."""
    return mesh.corner_mesh() if isinstance(mesh, Bricks) else whole_mesh(mesh)
