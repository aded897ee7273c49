"""A scaling law of the actuator's field: all of its dimensions grown together, and the current.

If all lengths grow by a factor s, and the current with them, H and B stay: the co-energy grows as
s³, pull and flux linkage as s².  Axial positions are stated from the nominal gap, which grows too.
"""

from __future__ import annotations

import math

from tactgen.geometry.device.parameters import NOMINAL_GAP
from tactgen.validation.checks.cases.fineness import cached
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.nearby import value_of, with_values
from tactgen.validation.scene.scene import load_scene

#: Stated from the nominal gap.
_POSITIONS = ("rod.length", "rod.flange_position", "coil.position")
#: All lengths, and the current.
_KEYS = (
    "rod.radius", "rod.head_radius", "rod.head_thickness", "rod.flange_radius",
    "rod.flange_thickness", *_POSITIONS, "coil.inner_radius", "coil.outer_radius", "coil.length",
    "sleeve.inner_radius", "sleeve.outer_radius", "sleeve.length", "sleeve.collar_radius",
    "sleeve.collar_thickness", "gap", "coil.current",
)  # fmt: skip
#: No two edges level, so that every size may become larger and smaller.
_DEVICE = (
    "rod.radius=0.62mm", "rod.head_radius=1.12mm", "rod.length=4.8mm",
    "sleeve.collar_radius=0.93mm", "coil.outer_radius=0.89mm", "accuracy=1%",
)  # fmt: skip
#: Factor of all lengths.
_GROWTH = 1.25
#: What a power of the size is known of.
_QUANTITIES = ("coenergy", "flux_linkage", "magnetic_force")


def power_of_size(name: str) -> float:
    """Return the power with which a quantity grows with the device, as it is grown."""
    return _powers()[name]


@cached
def _powers() -> dict[str, float]:
    scene, _ = load_scene("reluctance", ["models=axisymmetric", *_DEVICE])
    grown = {}
    for key in _KEYS:
        shift = NOMINAL_GAP * (key in _POSITIONS)
        grown[key] = _GROWTH * (float(value_of(scene, key)) + shift) - shift
    before, after = (
        solve(each, ("axisymmetric",), _QUANTITIES) for each in (scene, with_values(scene, grown))
    )
    return {
        name: math.log(
            float(after.get(name, "axisymmetric").value / before.get(name, "axisymmetric").value),
            _GROWTH,
        )
        for name in _QUANTITIES
    }
