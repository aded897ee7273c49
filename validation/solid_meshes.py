"""Which meshes the solid model is solved on, chosen from the scene and its accuracy."""

from __future__ import annotations

from geometry.mesh import Mesh
from geometry.structured import LEVELS, hexahedral
from validation.scene import Scene

#: Relative error bar of static deflection, capacitances and first frequencies that each
#: level stays below on the paper's bimorph and on job J1 (tests/test_refinement.py).
_LEVEL_BAR = (1e-2, 3e-3, 1e-3, 6e-4, 2.5e-4)

#: Edge length at the root and far from it of the tetrahedral family, in thicknesses of
#: the shim (its tab carries the root's bending); each level about 1.3 times finer.
_TET_EDGES = ((0.9, 2.2), (0.7, 1.7), (0.54, 1.3), (0.42, 1.0), (0.32, 0.8))


def level_for(scene: Scene) -> int:
    """Return the index (0 to 4) of the finer mesh's level; never the coarsest."""
    if scene.mesh.level:
        return max(scene.mesh.level - 1, 1)
    for index, error in enumerate(_LEVEL_BAR):
        if index and error <= scene.accuracy:
            return index
    return len(LEVELS) - 1


def uses_tetrahedra(scene: Scene) -> bool:
    """Return whether the scene is meshed with tetwild."""
    return scene.mesh.kind == "tetwild" or scene.support.kind == "rod"


def mesh_pair(scene: Scene) -> tuple[Mesh, Mesh]:
    """Return the finer mesh of the solid model, and a coarser one to judge it by.

    Structured meshes are compared with the next coarser level.  Tetrahedral meshes are not
    nested and scatter a little, so two levels are put between them.
    """
    fine = level_for(scene)
    if uses_tetrahedra(scene):
        return tetrahedral(scene, fine), tetrahedral(scene, max(fine - 2, 0))
    return hexahedral(scene.device, LEVELS[fine]), hexahedral(scene.device, LEVELS[fine - 1])


def tetrahedral(scene: Scene, level: int) -> Mesh:
    """Return the tetwild mesh of the mechanical solids at a level of the family."""
    from geometry.tetmesh import TetMeshing, tetrahedralise

    on_rod = scene.support.kind == "rod"
    root, far = (edge * scene.bimorph.shim_thickness for edge in _TET_EDGES[level])
    regions = ("piezo_top", "piezo_bottom", "shim") + (("glue", "rod") if on_rod else ())
    options = TetMeshing(edge_length=far, root_edge_length=root, time_limit=scene.mesh.time_limit)
    return tetrahedralise(scene.device, "rod" if on_rod else "alone", regions, options)
