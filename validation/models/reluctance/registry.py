"""The models of the normal actuator by name, and their quantities."""

from __future__ import annotations

from validation.engine.stages import Stages
from validation.models.reluctance.field import AxisymmetricModel, Magnetic3dModel
from validation.models.reluctance.model import MagneticModel, NetworkModel
from validation.models.reluctance.point import Measured
from validation.scene.scene import Scene

_CLASSES: dict[str, type[MagneticModel]] = {
    c.name: c for c in (NetworkModel, AxisymmetricModel, Magnetic3dModel)
}


#: Quantities that ask when the rod moves, with their names among the switching currents.
SWITCHING = {
    "pull_in_current": "pull_in",
    "holding_current": "holding",
    "drop_out_current": "drop_out",
}


def read_magnetic(name: str, model: MagneticModel) -> tuple[Measured, str]:
    """Return a quantity of the catalogue, and how its error bar comes about."""
    if name in SWITCHING:
        found = model.switching()
        current: Measured = getattr(found, SWITCHING[name])
        return current, found.method
    point = model.point()
    if name == "inductance":
        return point.inductance, point.method
    value: Measured = getattr(point, "force" if name == "magnetic_force" else name)
    return value, point.method


def make_magnetic_model(name: str, scene: Scene, stages: Stages) -> MagneticModel:
    """Return the named model of a scene's normal actuator."""
    return _CLASSES[name](scene, stages)
