"""Scene keys that each analysis reads: the one declaration of them.

An entry is a key or a whole group; "KEY if OTHER=VALUE" counts only with that value of another
key ("!=" any other value; "if OTHER" alone: where it is not 0 or empty).  Plan, cache key,
"has no effect" and "runs again" follow from it, by :mod:`validation.engine.inputs`.
"""

from __future__ import annotations

from collections.abc import Mapping

#: Conditions of keys, whichever analysis reads them.
CONDITIONS: Mapping[str, str] = {
    "load.stiffness": "load.kind=spring_damper",
    "load.damping": "load.kind=spring_damper",
    "load.mass": "load.kind=mass",
    "load.file": "load.kind=table",
    "load.extrapolation": "load.kind=table",
    "load.pad_modulus": "load.kind=pad",
    "load.pad_loss_factor": "load.kind=pad",
    "load.pad_thickness": "load.kind=pad",
    "load.pad_radius": "load.kind=pad",
    "load.pad_weight": "load.kind=pad",
    "load.pad_backing": "load.kind=pad",
    "threshold.file": "threshold.kind=table",
    "guide.guided_length": "guide.clearance",
    "steel.relative_permeability": "steel.curve=linear",
    "support.rotational_stiffness": "support.kind=spring",
    "support.lateral_stiffness": "support.kind=spring",
    "support.rotational_damping": "support.kind=spring",
    "support.rotational_inertia": "support.kind=spring",
    "skin": "load.kind!=none",
}
#: Dimensions of the ceramic that a profile gives instead, where no tab below it has them, too.
PROFILED = ("bimorph.width", "bimorph.piezo_thickness", "bimorph.shim_thickness")

_ON_ROD = ("rod if support.kind=rod", "glue if support.kind=rod")
_LAYERS = tuple(
    f"glue.{name} if bimorph.glue_thickness"
    for name in ("youngs_modulus", "poisson_ratio", "density", "loss_factor")
)
_BIMORPH = ("bimorph", "piezo", "shim", "support.kind", *_ON_ROD, *_LAYERS)
#: The segmented beam.
BEAM = (*_BIMORPH, "beam")
#: Base and tip.
ENDS = ("support", "load")
#: The solid; tetrahedra are refined by what is solved on them.
SOLID = (*_BIMORPH, "mesh.level", "accuracy if mesh.level=0")

_ROD = (
    "rod.radius", "rod.head_radius", "rod.head_thickness", "rod.flange_radius",
    "rod.flange_thickness", "rod.flange_position", "rod.length",
)  # fmt: skip
#: The magnetic circuit at one current and gap; no formula of the network has the winding's radii.
CIRCUIT = (
    *_ROD, "coil.length", "coil.position", "coil.turns", "coil.current", "sleeve", "steel", "gap",
)  # fmt: skip
MAGNETIC = (*CIRCUIT, "coil.inner_radius", "coil.outer_radius")
#: Range of a map over the stroke: it covers what the spring may ask of it.
STROKE = ("spring.preload", "spring.stiffness", "spring.stop_gap")
#: Equilibrium of the rod, on the map.
REST = (
    *STROKE, "contact.shape", "contact.decay_length", "contact.lower_decay_ratio", "coil.history",
    "load.normal_force",
)  # fmt: skip
#: One unit among others that are driven, too, but for its own current.
ARRAY = ("display.rows", "display.columns", "display.pitch", "display.coil_current")
#: Slot of the rod's head, in 3D.
SLOT = (
    "support.kind", "rod.slot_depth", "bimorph.width", "bimorph.shim_thickness", "glue.thickness",
)  # fmt: skip

#: The machine in small motions about its equilibrium; `models` stands for the map's inputs.
MACHINE = (
    "models", "bimorph", "piezo", "shim", "glue", "beam", "rod", "coil", "sleeve", "steel", "gap",
    "spring", "contact", "guide", "load.normal_force",
)  # fmt: skip
#: One unit beside the others: its board and its skin; and units that differ.
CROSSTALK = (*MACHINE, "support.kind", "load", "frequency", "display", "skin")
SPREAD = (*MACHINE, "support", "load", "display", "scatter", "modes")

#: Springs of a contact: equilibrium of the rod and weight of what moves.  With a current also the
#: circuit; a field's map brings all of its own inputs.
HELD = (
    "support.kind", "contact", "guide.lateral_stiffness", "guide.rotational_stiffness",
    "guide.clearance", "guide.guided_length", "spring.preload", "spring.stiffness", "coil.current",
    "load.normal_force", *_ROD, "rod.density", "coil.fill_factor", "coil.inner_radius",
    "coil.outer_radius", "coil.length", "coil.position", "coil.copper_density",
)  # fmt: skip
HELD_WITH_CURRENT = (*HELD, *CIRCUIT, "spring.stop_gap", "coil.history", "models")

#: Keys that quantities are read with off the answers, or warned by, by actuator.
READING: Mapping[str, tuple[str, ...]] = {
    "bimorph": (
        "drive", "support", "load", "threshold", "frequency", "modes", "accuracy", "bimorph.length",
        "bimorph.wiring", "limits.ceramic_strength", "limits.depoling_field",
        "limits.amplifier_current", "limits.amplifier_channels",
    ),
    "reluctance": ("accuracy",),
}  # fmt: skip
#: Keys that say how long something may take, or on what mesh: not among a stage's inputs.
SETTINGS: Mapping[str, tuple[str, ...]] = {
    "cad": ("mesh.time_limit",),
    "magnetic3d": ("mesh.kind", "mesh.time_limit if mesh.kind=tetwild"),
}


def plain_keys(entries: tuple[str, ...]) -> tuple[str, ...]:
    """Keys and groups without their conditions."""
    return tuple(dict.fromkeys(entry.partition(" if ")[0] for entry in entries))
