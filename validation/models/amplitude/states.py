"""The bimorph at growing amplitude in the paper's two states: up on its stop, and held down."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import kept
from tactgen.geometry.store.values import storable
from tactgen.validation.engine.inputs import values_read
from tactgen.validation.models.amplitude.backbone import Curve, backbone
from tactgen.validation.models.amplitude.deflection import LoadedDeflection, loaded_deflection
from tactgen.validation.models.amplitude.held_head import COILS, State, held_head, in_state
from tactgen.validation.scene.scene import Scene

#: Scene keys and groups that the answers depend on.
_READS = (
    "bimorph", "piezo", "shim", "glue", "beam", "rod", "coil", "sleeve", "steel.curve", "gap",
    "spring", "contact", "guide", "support.kind", "load", "drive", "models",
)  # fmt: skip


@storable
@dataclass(frozen=True)
class RockingState:
    """One state at growing amplitude.

    Attributes
    ----------
    state : str
        ``not activated`` or ``held``.
    contact_force : float
        What presses the head on its stop (N), nan if there is no such state.
    curves : tuple of Curve
        Free tip, by growing voltage.
    deflection : LoadedDeflection or None
        Under the scene's load at the drive voltage; None where the tip is free anyway.
    refused : str
        Why something of it is missing; empty if nothing is.
    """

    state: str
    contact_force: float
    curves: tuple[Curve, ...]
    deflection: LoadedDeflection | None
    refused: str = ""


def rocking_states(
    scene: Scene, voltages: Sequence[float], announce: Callable[[str], None] = lambda _: None
) -> tuple[RockingState, ...]:
    """Return both states of a scene on the rod's contact, by the transfer-matrix model.

    Kept in the store: each takes about half a minute.

    Parameters
    ----------
    voltages : sequence of float
        Of the free tip's curves (V).
    """
    found = []
    for state in COILS:
        made = in_state(scene, state)
        inputs = (values_read(made, _READS), _band(made), tuple(voltages))

        def work(made: Scene = made, state: State = state) -> RockingState:
            return _state(made, state, voltages, announce)

        found.append(kept("amplitude", inputs, (__name__,), work, announce=announce))
    return tuple(found)


def _state(
    scene: Scene, state: State, voltages: Sequence[float], announce: Callable[[str], None]
) -> RockingState:
    free = scene.model_copy(update={"load": scene.load.model_copy(update={"kind": "none"})})
    curves: tuple[Curve, ...] = ()
    deflection = None
    force = float("nan")
    try:
        head = held_head(free)
        force = head.place.contact_force
        announce(f"amplitude, {state}")
        curves = backbone(head, voltages, _band(scene), announce).curves
        if scene.load.kind != "none":
            volts = abs(scene.drive.voltage)
            deflection = loaded_deflection(held_head(scene), volts, _band(scene), announce)
    except InputError as error:
        return RockingState(state, force, curves, deflection, str(error))
    return RockingState(state, force, curves, deflection)


def _band(scene: Scene) -> tuple[float, float]:
    positive = [f for f in scene.frequency if f > 0.0]
    return min(positive), max(positive)
