"""The machine of a scene in small motions, as matrices in a file (npz)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.tmm.generator.transient.machine import MachineStateSpace, machine_state_space
from tactgen.validation.models.generator.judged_rod import rod_of
from tactgen.validation.models.generator.transient import scene_modes
from tactgen.validation.scene.scene import Scene

_TITLE = "the tactile generator in small motions about where its rod rests"
_CONVENTIONS = (
    "SI; x' = a x + b u, y = c x + d u; deviations from rest; the tip is free, what touches it is "
    "connected at the input tip force; each mode has viscous damping in place of constant Q"
)


def check_machine(scene: Scene) -> None:
    """Refuse a scene whose bimorph does not stand on its rod's contact.

    Raises
    ------
    InputError
        With the remedy.
    """
    if scene.support.kind != "contact":
        raise InputError(
            "--machine is the state space of the machine on its rod, of which support.kind = "
            f'"{scene.support.kind}" says nothing; set support.kind=contact'
        )


def scene_state_space(scene: Scene) -> MachineStateSpace:
    """Return the state space of a scene's machine, its bimorph by beam elements.

    Raises
    ------
    InputError
        If the rod rests nowhere.
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
