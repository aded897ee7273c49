"""The solid model reduced to its ports, and its state space, as files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.piezo.port_model import PortModel
from tactgen.geometry.files import written_whole
from tactgen.tmm.generator.transient.machine import MachineStateSpace, machine_state_space
from tactgen.validation.models.generator.small_signal import rod_of
from tactgen.validation.models.generator.transient import scene_modes


def check_state_space(scene: Scene) -> None:
    """Refuse a state space without a range of frequencies to be true in, or of a loose body.

    Raises InputError if the scene has no frequency above 0 Hz, or a spring of its support is zero.
    """
    if scene.ends.base is not None:
        for name, unit in (("rotational_stiffness", "N m/rad"), ("lateral_stiffness", "N/m")):
            if getattr(scene.ends.base, name) == 0.0:
                raise InputError(
                    f"support.{name} = 0 {unit} does not hold the base, which a state space for "
                    'time simulation needs; give it a stiffness or set support.kind = "clamped"'
                )
    if max(scene.frequency) <= 0.0:
        raise InputError(
            "frequency = 0 Hz alone gives a state space no range; "
            'write for example --set frequency="10:20000:200:log"'
        )


def write_port_files(scene: Scene, files: dict[str, Path]) -> None:
    """Write the scene's solid on its finer mesh: kinds "ports" and "state_space".

    Raises InputError if the solid model cannot take the scene or a file cannot be written.
    """
    from tactgen.fem.piezo.reduction_files import made_from, reduced_solid, write_ports
    from tactgen.fem.piezo.state_space import write_state_space
    from tactgen.validation.models.bimorph.cad import mesh_pair

    mesh = mesh_pair(scene).meshes[0]
    frequencies = np.asarray(scene.frequency, dtype=float)
    # the tolerance of `tactgen solve`, so that one reduction serves both
    reduced = reduced_solid(scene.device, mesh, frequencies, tolerance=1e-3 * scene.accuracy)
    if "ports" in files:
        write_ports(files["ports"], reduced, made_from=made_from(scene.device, mesh))
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


def check_machine(scene: Scene) -> None:
    """Refuse a scene whose bimorph does not stand on its rod's contact.

    Raises InputError with the remedy.
    """
    if scene.support.kind != "contact":
        raise InputError(
            "--machine is the state space of the machine on its rod, of which support.kind = "
            f'"{scene.support.kind}" says nothing; set support.kind=contact'
        )


def scene_state_space(scene: Scene) -> MachineStateSpace:
    """State space of a scene's machine, its bimorph by beam elements.

    Raises InputError if the rod rests nowhere.
    """
    check_machine(scene)
    rod = rod_of(scene, scene.pull)
    return machine_state_space(rod, scene_modes(scene), supply=scene.coil.supply)


def write_machine(path: str | Path, scene: Scene) -> None:
    """Write the state space, whole or not at all; refusals as above and of the place."""
    found = scene_state_space(scene)
    with written_whole(path) as temporary:
        np.savez_compressed(
            temporary,
            title=np.array(_TITLE),
            conventions=np.array(_CONVENTIONS),
            a=found.a,
            b=found.b,
            c=found.c,
            d=found.d,
            inputs=np.array(found.inputs),
            outputs=np.array(found.outputs),
        )
