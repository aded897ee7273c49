"""CAD, mesh, co-energy map and reduced solid files of a scene."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.device.parameters import Device, Measurement
from tactgen.geometry.display.clearances import check_display
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.validation.catalogue.models import models_of
from tactgen.validation.engine.solve import asks_display
from tactgen.validation.models.classes import map_of
from tactgen.validation.models.model import Stages
from tactgen.validation.scene.inputs import stage_key
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.piezo.port_model import PortModel
    from tactgen.tmm.generator.transient.machine import MachineStateSpace


def write_port_files(scene: Scene, files: dict[str, Path]) -> None:
    """Write the scene's solid on its finer mesh: kinds "ports" and "state_space".

    Raises InputError if the solid model cannot take the scene or a file cannot be written.
    """
    from tactgen.fem.piezo.reduction_files import made_from, reduced_solid, write_ports
    from tactgen.fem.piezo.state_space import write_state_space
    from tactgen.validation.models.bimorph.solid import mesh_pair

    # ports are ends: where motion is measured is none
    device = scene.device.model_copy(update={"measurement": Measurement()})
    mesh = mesh_pair(scene).meshes[0]
    frequencies = np.asarray(scene.frequency, dtype=float)
    # the tolerance of `tactgen solve`, so that one reduction serves both
    reduced = reduced_solid(device, mesh, frequencies, tolerance=1e-3 * scene.accuracy)
    if "ports" in files:
        write_ports(files["ports"], reduced, made_from=made_from(device, mesh))
    if "state_space" in files:
        top = float(frequencies.max())
        bounds = max(float(frequencies.min()), 1e-3 * top), top
        model = _wired(scene, reduced.fine)
        write_state_space(files["state_space"], model, scene.ends.base, bounds)


def _wired(scene: Scene, model: PortModel) -> PortModel:
    """Port seen in the scene's wiring: in series each layer takes half of U."""
    if scene.bimorph.wiring == "parallel":
        return model
    stiffness = model.stiffness.copy()
    stiffness[-1] *= 0.5
    stiffness[:, -1] *= 0.5
    return replace(model, stiffness=stiffness)


_TITLE = "the tactile generator in small motions about where its rod rests"
_CONVENTIONS = (
    "SI; x' = a x + b u, y = c x + d u; deviations from rest; the tip is free, what touches it is "
    "connected at the input tip force; each mode has viscous damping in place of constant Q"
)


def check_machine(scene: Scene, option: str) -> None:
    """Refuse a scene whose bimorph does not stand on its rod's contact.

    Raises InputError with the remedy.
    """
    if scene.support.kind != "contact":
        raise InputError(
            f"--{option} is of the generator on its rod, and support.kind = "
            f'"{scene.support.kind}" holds the bimorph alone; set support.kind=contact, or take '
            "--state-space, which has the scene's own support"
        )


def scene_state_space(scene: Scene) -> MachineStateSpace:
    """State space of a scene's machine, its bimorph by beam elements.

    Raises InputError if the rod rests nowhere.
    """
    from tactgen.tmm.generator.transient.machine import machine_state_space
    from tactgen.validation.models.small_signal import rod_of
    from tactgen.validation.models.transient import check_in_time, scene_modes

    check_machine(scene, "machine")
    check_in_time(scene, "state space")
    rod = rod_of(scene, map_of(scene))
    return machine_state_space(rod, scene_modes(scene), supply=scene.coil.supply)


def write_machine(path: str | Path, scene: Scene) -> None:
    """Write the state space, whole or not at all; refusals as above and of the place."""
    found = scene_state_space(scene)
    with written_whole(path) as temporary:
        np.savez_compressed(temporary, title=_TITLE, conventions=_CONVENTIONS, **vars(found))


def check_place(option: str, path: Path, suffixes: tuple[str, ...]) -> None:
    """Refuse a file with another ending, or in a place that cannot be written.

    Raises InputError with the option and the remedy.
    """
    if path.suffix not in suffixes:
        raise InputError(f"{option} {path} must end in {' or '.join(suffixes)}; name the file so")
    try:
        if path.is_dir():
            reason = "it is a folder"
        elif not path.parent.is_dir():
            reason = "its folder does not exist"
        else:
            free = os.access(path.parent, os.W_OK | os.X_OK)
            reason = "" if free else "its folder is read-only"
    except OSError as error:  # such as a name that is too long
        reason = (error.strerror or str(error)).lower()
    if reason:
        raise InputError(f"{option} {path} cannot be written ({reason}); choose another place")


#: Endings that each kind of file may have.
_SUFFIXES = {
    "step": (".step", ".stp"), "glb": (".glb",), "mesh": (".vtu", ".msh"), "map": (".nc",),
    "ports": (".npz",), "state_space": (".npz",), "fields": (".vtu", ".vtkhdf", ".pvd"),
    "animated_glb": (".glb",), "fmu": (".fmu",), "machine": (".npz",),
}  # fmt: skip


def export(
    scene: Scene,
    targets: dict[str, Path],
    announce: Callable[[str], None],
    frequencies: tuple[float, ...] | None = None,
) -> list[Path]:
    """Write the wanted files, all or none, and return their paths.

    Parameters
    ----------
    targets : dict of {"step", "glb", "mesh", "map", "ports", "state_space", "fields",
    "animated_glb", "fmu", "machine"} to Path
        What to write where.
    frequencies : tuple of float, optional
        Of driven states (Hz); None takes half the first frequency of bending and that itself.

    Raises InputError if a place cannot be written, has the wrong ending or is named twice, or a map
    is wanted of a scene without a model of the normal actuator, or the solid model cannot take the
    scene.
    """
    _check_targets(targets)
    if asks_display(scene.quantities):
        check_display(scene.device, scene.display)
    if "map" in targets:
        _check_map(scene)
    if {"ports", "state_space"} & set(targets):
        _refuse_without_lateral(scene, "to reduce to its ports")
    if "mesh" in targets and scene.support.kind != "rod":
        _refuse_without_lateral(scene, "to divide into a mesh")
    if "state_space" in targets:
        from tactgen.validation.models.held_bimorph import check_base_held

        check_base_held(scene, "a state space for time simulation")
        if max(scene.frequency) <= 0.0:
            raise InputError(
                "frequency = 0 Hz alone gives a state space no range; "
                'write for example --set frequency="10:20000:200:log"'
            )
    for option in ("machine", "fmu"):
        if option in targets:
            check_machine(scene, option)
    if {"fields", "animated_glb"} & set(targets):
        _refuse_without_motion(scene, targets)
    with ExitStack() as stack:
        # the files take their names together, when all of them have been written
        drafts = {kind: stack.enter_context(written_whole(p)) for kind, p in targets.items()}
        try:
            _write(scene, drafts, announce)
            _write_motion(scene, drafts, targets, announce, frequencies)
        except InputError as error:
            text = str(error)
            for kind, draft in drafts.items():
                text = text.replace(str(draft), str(targets[kind]))
            raise InputError(text) from error
    return list(targets.values())


def _refuse_without_lateral(scene: Scene, purpose: str) -> None:
    """Refuse files of the bimorph from a scene that is about the normal actuator alone.

    The bimorph of such a scene is the default one, of which nobody spoke.
    """
    if set(scene.models) <= set(models_of("reluctance")):
        raise InputError(
            f"models = {','.join(scene.models)} have no bimorph {purpose}; "
            'name another scene, such as "paper", or set models=solid'
        )


def _refuse_without_motion(scene: Scene, targets: dict[str, Path]) -> None:
    """Refuse fields of a scene that has none, and movement of one in which nothing moves."""
    from tactgen.validation.show.gather import MAGNETIC, default_models

    if default_models(scene) != (MAGNETIC,):
        return
    still = [k for k, path in targets.items() if k == "animated_glb" or path.suffix == ".pvd"]
    if still:
        option = "--" + still[0].replace("_", "-")
        raise InputError(
            f"{option} {targets[still[0]]} is for what moves, and the model {MAGNETIC} has a field "
            "at rest; write --fields FILE.vtu"
        )


def _check_targets(targets: dict[str, Path]) -> None:
    """Refuse exports that would fail only after minutes of work."""
    taken: dict[Path, str] = {}
    for kind, path in targets.items():
        option = "--" + kind.replace("_", "-")
        check_place(option, path, _SUFFIXES[kind])
        place = path.resolve()
        if place in taken:
            raise InputError(
                f"{option} {path} is also the file of {taken[place]}; give each its own name"
            )
        taken[place] = option


def _write(scene: Scene, files: dict[str, Path], announce: Callable[[str], None]) -> None:
    if "step" in files or "glb" in files:
        _export_solids(scene, files, announce)
    if "mesh" in files:
        from tactgen.geometry.meshing.mesh_files import write_mesh
        from tactgen.validation.models.bimorph.solid import cells_of, mesh_pair

        announce("mesh")
        write_mesh(cells_of(mesh_pair(scene).meshes[0]), files["mesh"])
    reductions = {kind: file for kind, file in files.items() if kind in ("ports", "state_space")}
    if reductions:
        announce("ports of the solid")
        write_port_files(scene, reductions)
    if "fmu" in files:
        from tactgen.validation.models.transient import scene_machine
        from tactgen.validation.show.fmu import write_fmu

        announce("co-simulation unit")
        machine = scene_machine(scene, coil=scene.coil.supply, volts=scene.drive.voltage)
        write_fmu(files["fmu"], machine, scene.name)
    if "machine" in files:
        announce("machine")
        write_machine(files["machine"], scene)
    if "map" in files:
        from tactgen.tmm.reluctance.coenergy_fit import write_map

        stage = f"{scene.map_model}.map"
        found = map_of(scene, Stages({stage: stage_key(stage, scene)}, announce))
        write_map(files["map"], found)


def _write_motion(
    scene: Scene,
    drafts: dict[str, Path],
    targets: dict[str, Path],
    announce: Callable[[str], None],
    frequencies: tuple[float, ...] | None,
) -> None:
    """Write fields and their animation."""
    if not {"fields", "animated_glb"} & set(drafts):
        return
    from tactgen.validation.show.gather import default_models, gather

    (result,) = gather(scene, default_models(scene), frequencies, announce=announce)
    if "fields" in drafts:
        from tactgen.validation.show.field_files import write_fields

        write_fields(drafts["fields"], result, targets["fields"].stem)
    if "animated_glb" in drafts:
        from tactgen.geometry.cad.solids import COLOURS
        from tactgen.validation.show.field_files import write_animated_glb

        write_animated_glb(drafts["animated_glb"], result, COLOURS)


def _check_map(scene: Scene) -> None:
    """Refuse a map of a scene without a model of the normal actuator, or without one in 3D."""
    able = models_of("reluctance")
    if not set(able) & set(scene.models):
        raise InputError(
            f"--map needs one of the models {', '.join(able)}, and the scene asks for "
            f"{', '.join(scene.models)}; add --set models={able[0]}"
        )
    if scene.map_model == "magnetic3d":
        from tactgen.validation.models.reluctance.field import check_solid_map

        check_solid_map(scene)


def scene_solids(scene: Scene) -> dict[str, Any]:
    """CAD solids of a scene (mm): the whole generator, or the actuator asked about."""
    from tactgen.geometry.cad.solids import build_solids
    from tactgen.geometry.device.parts import bimorph_parts

    if scene.support.kind == "rod":
        return build_solids(scene.device, None, "rod")
    if set(scene.models) <= set(models_of("reluctance")):
        return normal_actuator_solids(scene.device)
    return build_solids(scene.device, bimorph_parts(scene.device), "alone")


def normal_actuator_solids(device: Device) -> dict[str, Any]:
    """CAD solids of rod, coil and sleeve (mm), the rod with its slot.

    The bimorph matters by its cross-section only; the tab that goes into the slot fits.
    """
    from tactgen.geometry.cad.solids import build_solids
    from tactgen.geometry.reluctance.tets import with_fitting_tab

    return build_solids(with_fitting_tab(device, device.gap), ("rod", "coil", "sleeve"), "rod")


def _export_solids(scene: Scene, targets: dict[str, Path], announce: Callable[[str], None]) -> None:
    from tactgen.geometry.cad.solids import solids_assembly, write_glb, write_step

    if asks_display(scene.quantities):
        from tactgen.geometry.cad.display import display_assembly

        announce("CAD solids of the display")
        assembly = display_assembly(scene.device, scene.display)
    else:
        announce("CAD solids")
        assembly = solids_assembly(scene_solids(scene))
    if "step" in targets:
        write_step(assembly, targets["step"])
    if "glb" in targets:
        write_glb(assembly, targets["glb"])
