"""Which meshes the solid model is solved on, chosen from the scene and its accuracy."""

from __future__ import annotations

from geometry.mesh import Mesh
from geometry.structured import LEVELS, hexahedral
from validation.scene import Scene

#: Relative error in static deflection and first frequencies that each level of the
#: structured family stays below on the reference job J1 (tests/test_solid_reference.py).
_LEVEL_ERROR = (2e-3, 7e-4, 3e-4, 1.5e-4, 8e-5)

#: Root edge length and far edge length of the tetrahedral family, in piezo layer
#: thicknesses; each level about 1.3 times finer than the last.
_TET_EDGES = ((1.0, 2.2), (0.75, 1.7), (0.58, 1.3), (0.45, 1.0), (0.35, 0.8))


def level_for(scene: Scene) -> int:
    """Return the index (0 to 4) of the finer mesh's level; never the coarsest."""
    if scene.mesh.level:
        return max(scene.mesh.level - 1, 1)
    for index, error in enumerate(_LEVEL_ERROR):
        if index and error <= scene.accuracy:
            return index
    return len(LEVELS) - 1


def uses_tetrahedra(scene: Scene) -> bool:
    """Return whether the scene is meshed with tetwild."""
    return scene.mesh.kind == "tetwild" or scene.support.kind == "rod"


def mesh_pair(scene: Scene) -> tuple[Mesh, Mesh]:
    """Return the finer and the coarser mesh of the solid model."""
    level = level_for(scene)
    if uses_tetrahedra(scene):
        return tetrahedral(scene, level), tetrahedral(scene, level - 1)
    return hexahedral(scene.device, LEVELS[level]), hexahedral(scene.device, LEVELS[level - 1])


def tetrahedral(scene: Scene, level: int) -> Mesh:
    """Return the tetwild mesh of the mechanical solids at a level of the family."""
    from geometry.tetmesh import TetMeshing, tetrahedralise

    on_rod = scene.support.kind == "rod"
    root, far = (edge * scene.bimorph.piezo_thickness for edge in _TET_EDGES[level])
    regions = ("piezo_top", "piezo_bottom", "shim") + (("glue", "rod") if on_rod else ())
    options = TetMeshing(edge_length=far, root_edge_length=root, time_limit=scene.mesh.time_limit)
    return tetrahedralise(scene.device, "rod" if on_rod else "alone", regions, options)
