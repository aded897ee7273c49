"""A sum rule for the derivatives of the actuator's field by all of its dimensions.

If all lengths grow by a factor s, and the current with them, H and B stay: the co-energy grows as
s³, pull and flux linkage as s².  So by Euler's theorem on homogeneous functions

    Σ_k p_k ∂q/∂p_k + i ∂q/∂i = n q,    n = 3 for the co-energy, 2 for the others,

over all lengths p_k, also the gap at which axial positions are stated, which is no parameter: it
moves all of these positions.  Every derivative is taken by itself, on a grid that moves with its
key alone.
"""

from __future__ import annotations

from tactgen.geometry.device.parameters import NOMINAL_GAP
from tactgen.validation.checks.cases.fineness import cached
from tactgen.validation.engine.derivatives import derivatives
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
#: What a power of the size is known of.
_QUANTITIES = ("coenergy", "flux_linkage", "magnetic_force")


def power_of_size(name: str) -> float:
    """Return the power with which a quantity grows with the device, from its derivatives."""
    return _powers()[name]


@cached
def _powers() -> dict[str, float]:
    scene, _ = load_scene("reluctance", ["models=axisymmetric", *_DEVICE])
    found = derivatives(
        scene, lambda key, value: with_values(scene, {key: value}), "axisymmetric",
        _QUANTITIES, _KEYS,
    )  # fmt: skip
    sums = {}
    for each in found:
        total = 0.0
        for key in _KEYS:
            size = float(value_of(scene, key)) + NOMINAL_GAP * (key in _POSITIONS)
            total += size * float(each.slopes[key])
        sums[each.quantity.name] = total / float(each.quantity.value)
    return sums
