"""CAD and mesh files of a scene."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from geometry.errors import InputError
from validation.scene import Scene


def export(scene: Scene, targets: dict[str, Path], announce: Callable[[str], None]) -> list[Path]:
    """Write the wanted files, all or none of a kind, and return their paths.

    Parameters
    ----------
    targets : dict of {"step", "glb", "mesh"} to Path
        What to write where.

    Raises
    ------
    InputError
        If a folder cannot be written or a mesh file has an unknown suffix.
    """
    for path in targets.values():
        if not path.parent.is_dir():
            raise InputError(
                f"{path} cannot be written (its folder does not exist); choose another place"
            )
    if "mesh" in targets and targets["mesh"].suffix not in (".vtu", ".msh"):
        raise InputError(f"{targets['mesh']} must end in .vtu or .msh; name the mesh file so")
    if "step" in targets or "glb" in targets:
        _export_solids(scene, targets, announce)
    if "mesh" in targets:
        from geometry.mesh_files import write_mesh
        from validation.solid_meshes import mesh_pair

        announce("mesh")
        write_mesh(mesh_pair(scene)[0], targets["mesh"])
    return list(targets.values())


def scene_solids(scene: Scene) -> dict[str, Any]:
    """Return the CAD solids of a scene: the whole generator, or the bimorph alone (mm)."""
    from geometry.layout import BIMORPH
    from geometry.solids import build_solids

    if scene.support.kind == "rod":
        return build_solids(scene.device, None, "rod")
    return build_solids(scene.device, BIMORPH, "alone")


def _export_solids(scene: Scene, targets: dict[str, Path], announce: Callable[[str], None]) -> None:
    from geometry.solids import export_glb, export_step

    announce("CAD solids")
    solids = scene_solids(scene)
    if "step" in targets:
        export_step(solids, targets["step"])
    if "glb" in targets:
        export_glb(solids, targets["glb"])
