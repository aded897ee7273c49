"""A scene's bimorph on its head, as harmonic balance takes it."""

from __future__ import annotations

from typing import Literal

from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.generator.positions import History, axial_forces, resting_place
from tactgen.tmm.generator.rocking import RockingHead, rocking_head
from tactgen.tmm.ports.elements import ends_of
from tactgen.validation.models.five_port import five_port
from tactgen.validation.scene.scene import Scene

State = Literal["not activated", "held"]
#: Current (A) and history of the two states in which the paper measured.
COILS: dict[State, tuple[float, History]] = {
    "not activated": (0.0, "rising"),
    "held": (50e-3, "falling"),
}
#: What a scene says of them.
STATES: dict[State, tuple[str, ...]] = {
    state: (f"coil.current={1e3 * current:g}mA", f"coil.history={history}")
    for state, (current, history) in COILS.items()
}


def in_state(scene: Scene, state: State) -> Scene:
    """Return a scene in one of these states."""
    current, history = COILS[state]
    coil = scene.coil.model_copy(update={"current": current, "history": history})
    return scene.model_copy(update={"coil": coil})


def held_head(scene: Scene, model: str = "tmm") -> RockingHead:
    """Return the bimorph on the head that a stop carries.

    Raises
    ------
    InputError
        If the support is no contact, or the rod touches no stop.
    """
    if scene.support.kind != "contact":
        raise InputError(
            f"support.kind = {scene.support.kind} in scene {scene.name} is linear, so that nothing "
            "depends on amplitude; --set support.kind=contact holds the bimorph by the rod's head "
            "on its stop"
        )
    device, current = scene.device, abs(scene.coil.current)
    pull = scene.pull if current else None
    forces = axial_forces(device, pull, scene.load.normal_force)
    place = resting_place(forces, current, scene.coil.history)
    if place.kind == "floating":
        raise InputError(
            f"coil.current = {1e3 * scene.coil.current:g} mA leaves the rod between its stops, "
            "where no contact holds the head; use 0 mA, or one that pulls it down"
        )
    free = scene.support.model_copy(update={"kind": "spring"})
    tip = ends_of(free, scene.load).tip
    return rocking_head(five_port(scene, model), tip, forces, place, current, _bimorph_mass(scene))


def _bimorph_mass(scene: Scene) -> float:
    row = transfer_matrix.sections(scene.device, scene.support, scene.beam, lossy=False)
    return float(sum(getattr(section, "m", 0.0) * length for section, length in row))
