"""Where the rod is while the coil's current rises and falls: the hysteresis loop of a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.positions import PositionLoop, axial_forces, position_loop
from tactgen.validation.models.reluctance.model import MagneticModel
from tactgen.validation.models.reluctance.rest import position_bar
from tactgen.validation.models.reluctance.switching import SwitchingCurrents

#: Currents of a loop that nobody chose, and how far it goes beyond what moves the rod.
_POINTS, _BEYOND = 121, 1.25


@dataclass(frozen=True)
class RodLoop:
    """The loop by one model of the normal actuator.

    Attributes
    ----------
    model : str
    loop : PositionLoop
    rising_bar, falling_bar : (c,) array
        Error of the map's pull over the axial stiffness (m).
    switching : SwitchingCurrents or None
        Where the rod leaves and comes back; None where a finger presses the tip, of which
        these say nothing.
    """

    model: str
    loop: PositionLoop
    rising_bar: Floats
    falling_bar: Floats
    switching: SwitchingCurrents | None


def rod_loop(model: MagneticModel, currents: Floats | None = None) -> RodLoop:
    """Return the loop of a model over currents (c,) in A, by default as far as what moves the rod.

    Raises
    ------
    InputError
        If the rod rests nowhere, or the model's map does not reach so high a current.
    """
    scene, pull = model.scene, model.map()
    pressed = scene.load.normal_force
    switching = None if pressed else model.switching()
    if currents is None:
        currents = _currents(switching, pull.current_limit)
    elif currents.max() > pull.current_limit:
        raise InputError(
            f"the map of the model {model.name} ends at {1e3 * pull.current_limit:.4g} mA, below "
            f"{1e3 * currents.max():.4g} mA; ask for less, or set coil.current so high"
        )
    forces = axial_forces(scene.device, pull, pressed)
    loop = position_loop(forces, currents)
    rising, falling = (
        np.array([position_bar(forces, pull, i, p) for i, p in zip(currents, way, strict=True)])
        for way in (loop.rising, loop.falling)
    )
    return RodLoop(model.name, loop, rising, falling, switching)


def _currents(switching: SwitchingCurrents | None, limit: float) -> Floats:
    largest = limit
    if switching is not None and np.isfinite(switching.pull_in.value):
        largest = min(limit, _BEYOND * switching.pull_in.value)
    return np.linspace(0.0, largest, _POINTS)
