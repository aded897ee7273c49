"""Every model by name: its quantities, and the inputs of its stages.

One row a model; plan, solver, report and command line derive from it.  The classes are listed in
:mod:`validation.models.classes`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from tactgen.validation.catalogue.quantities import QUANTITIES, Actuator, Need, QuantityRow

#: Keys that count under a condition only, whichever analysis reads them.
_UNDER: Mapping[str, tuple[str, ...]] = {
    "load.kind=spring_damper": ("load.stiffness", "load.damping"),
    "spring.eccentricity": ("spring.eccentricity_angle",),
    "load.kind=mass": ("load.mass", "load.offset", "load.rotational_inertia"),
    "load.kind=table": ("load.file", "load.extrapolation"),
    "load.kind=pad": (
        "load.pad_modulus", "load.pad_loss_factor", "load.pad_thickness", "load.pad_radius",
        "load.pad_weight", "load.pad_backing",
    ),
    "circuit.kind=source": ("drive.voltage",),
    "circuit.kind!=open": (
        "circuit.resistance", "circuit.inductance", "circuit.capacitance", "circuit.connection",
    ),
    "no bimorph.layers": (
        "bimorph.piezo_thickness", "bimorph.shim_thickness", "bimorph.piezo_thickness_profile",
        "bimorph.shim_thickness_profile", "bimorph.glue_thickness", "bimorph.poling",
    ),
    "layer of piezo": ("piezo",),
    "layer of shim": ("shim",),
    "threshold.kind=table": ("threshold.file",),
    "support.kind=table": ("support.file",),
    "guide.clearance": ("guide.guided_length",),
    "steel.curve=linear": ("steel.relative_permeability",),
    "support.kind=spring": (
        "support.rotational_stiffness", "support.lateral_stiffness", "support.rotational_damping",
        "support.rotational_inertia",
    ),
    "load.kind!=none": ("skin",),
}  # fmt: skip
#: Condition of each of these keys.
CONDITIONS = {key: condition for condition, keys in _UNDER.items() for key in keys}
#: Dimensions of the ceramic that a profile gives instead, where no tab below it has them, too.
PROFILED = ("bimorph.width", "bimorph.piezo_thickness", "bimorph.shim_thickness")

_ON_ROD = ("rod if support.kind=rod", "glue if support.kind=rod")
_LAYERS = tuple(
    f"glue.{name} if layer of glue"
    for name in ("youngs_modulus", "poisson_ratio", "density", "loss_factor")
)
_BIMORPH = ("bimorph", "piezo", "shim", "support.kind", *_LAYERS, *_ON_ROD)
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
    "spring", "contact", "guide", "load.normal_force", "load if spring.eccentricity",
)  # fmt: skip
#: One unit beside the others: its board and its skin; and units that differ.
CROSSTALK = (*MACHINE, "measurement", "support.kind", "load", "frequency", "display", "skin")
SPREAD = (*MACHINE, "support", "load", "display", "scatter", "modes")

#: Springs of a contact: equilibrium of the rod and weight of what moves.  With a current also the
#: circuit; a field's map brings all of its own inputs.
HELD = (
    "support.kind", "contact", "guide.lateral_stiffness", "guide.rotational_stiffness",
    "guide.clearance", "guide.guided_length", "spring.preload", "spring.stiffness",
    "spring.eccentricity", "spring.eccentricity_angle", "coil.current", "load.normal_force", *_ROD,
    "rod.density",
    "coil.fill_factor", "coil.inner_radius", "coil.outer_radius", "coil.length", "coil.position",
    "coil.copper_density",
)  # fmt: skip
HELD_WITH_CURRENT = (*HELD, *CIRCUIT, "spring.stop_gap", "coil.history", "models")

#: Keys that quantities are read with off the answers, or warned by, by actuator.
READING: Mapping[str, tuple[str, ...]] = {
    "bimorph": (
        "drive", "circuit", "support", "load", "threshold", "frequency", "modes", "accuracy",
        "bimorph.length",
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


#: Equations that a model solves: two of one theory differ by no more than their error bars.
Theory = Literal["beam", "calibrated", "solid", "circuit", "field"]


@dataclass(frozen=True)
class ModelRow:
    """One model of one actuator."""

    #: Name in the interface, one line of explanation
    name: str
    description: str
    actuator: Actuator  #: What it is a model of
    theory: Theory  #: The equations it solves
    rank: int  #: How much it knows compared with others of its actuator: the highest judges them
    #: Its stages in the order in which they run, each with the scene keys that it reads
    stages: Mapping[str, tuple[str, ...]]
    #: What it can be asked for, each with the stages that the answer needs, in order
    gives: Mapping[Need, tuple[str, ...]]
    shortcut: str = ""  #: What it leaves out of its theory, except at 0 Hz; empty if nothing
    #: Whether its answers rest on no other model's
    independent: bool = True
    quick: bool = False  #: Whether it answers anything in a fraction of a second
    remedy: str = ""  #: What to do when its error bar is wider than asked for, if it can be
    #: Stages whose results are kept in the store, since they cost more than reading them
    kept: tuple[str, ...] = ()
    #: Modules and packages that compute them without being imported by name
    loads: tuple[str, ...] = ()
    #: Relative error that its finest mesh is known to come down to; 0 if that is not known
    finest: float = 0.0

    @property
    def detailed(self) -> bool:
        """Whether no theory here knows more, so that its modelling error is zero."""
        return self.theory in ("solid", "field")

    def stages_for(self, quantity: QuantityRow) -> tuple[str, ...]:
        """Names of the stages that a quantity needs, in order."""
        own = (f"{self.name}.{stage}" for need in quantity.needs for stage in self.gives[need])
        return tuple(dict.fromkeys(own))


_ROW_GIVES: Mapping[Need, tuple[str, ...]] = {
    "static": ("static",), "modes_short": ("modes",), "modes_open": ("modes",),
    "harmonic": ("ports",), "small_signal": ("ports", "machine"), "machine_poles": ("machine",),
    "crosstalk": ("ports", "crosstalk"), "spread": ("spread",),
    "load": (),
}  # fmt: skip
_MAGNETIC_GIVES: Mapping[Need, tuple[str, ...]] = {
    "magnetic_point": ("point",), "magnetic_map": ("map", "switching"),
    "rest": ("map", "rest"),
}  # fmt: skip
_IN_ARRAY_GIVES: Mapping[Need, tuple[str, ...]] = {
    **_MAGNETIC_GIVES, "neighbours": ("neighbours",),
}  # fmt: skip
_MAGNETIC_KEPT = ("point", "map", "switching", "rest")
#: The mesher runs in a process that is started by its file.
_MESHER = ("tactgen.geometry.meshing.tetwild",)


_SOLID_KEPT = ("static", "modal", "ports")
_SOLID_STAGES: Mapping[str, tuple[str, ...]] = {
    "mesh": (*SOLID, "measurement"),
    "assembly": (*SOLID, "measurement"),
    "static": (*SOLID, "measurement"),
    "modal": (*SOLID, "modes"),
    "modes_short": (*SOLID, *ENDS, "modes"),
    "modes_open": (*SOLID, *ENDS, "modes"),
    "ports": (*SOLID, "measurement", "frequency"),
    "machine": MACHINE,
    "crosstalk": (*SOLID, *CROSSTALK),
}
_SOLID_GIVES: Mapping[Need, tuple[str, ...]] = {
    "static": ("mesh", "assembly", "static"),
    "modes_short": ("mesh", "assembly", "modal", "modes_short"),
    "modes_open": ("mesh", "assembly", "modal", "modes_open"),
    "harmonic": ("mesh", "assembly", "ports"),
    "small_signal": ("mesh", "assembly", "ports", "machine"),
    "machine_poles": ("machine",),
    "crosstalk": ("mesh", "assembly", "ports", "crosstalk"),
    "load": (),
}


def _row_stages(*modes: str) -> dict[str, tuple[str, ...]]:
    return {
        "ports": (*BEAM, "measurement", "frequency"),
        "static": (*BEAM, "measurement"),
        "modes": (*BEAM, *ENDS, *modes),
        "machine": MACHINE,
        "crosstalk": CROSSTALK,
        "spread": SPREAD,
    }


def _magnetic_stages(
    own: tuple[str, ...], *mesh: str, wanted: tuple[str, ...] = ("accuracy",)
) -> dict[str, tuple[str, ...]]:
    return {
        "point": (*own, *wanted, *mesh, *(SLOT if mesh else ())),
        "map": (*own, *STROKE, *mesh),
        "switching": (*own, *STROKE, *wanted, *mesh),
        "rest": (*own, *REST, *wanted, *mesh),
    }


def _in_array(own: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    return {"neighbours": (*(key for key in own if key != "coil.current"), *ARRAY)}


_ROWS = (
    ModelRow(
        "lumped", "static closed forms, consistent mass, one-mode circuit", "bimorph",
        theory="beam", rank=1,
        stages=_row_stages(), gives=_ROW_GIVES, quick=True,
        shortcut="the inertia is that of the static shapes",
    ),
    ModelRow(
        "tmm", "exact Timoshenko transfer-matrix model (paper appendix A, corrected)", "bimorph",
        theory="beam", rank=2,
        stages=_row_stages("modes"), gives=_ROW_GIVES, quick=True,
    ),
    ModelRow(
        "beam", "Timoshenko beam finite elements", "bimorph",
        theory="beam", rank=3,
        stages=_row_stages("modes"), gives=_ROW_GIVES, quick=True,
        kept=("ports", "static", "modes"),
    ),
    ModelRow(
        "calibrated", "transfer-matrix model with sections calibrated on 3D solids", "bimorph",
        theory="calibrated", rank=4,
        stages=_row_stages("modes"), gives=_ROW_GIVES, quick=True, independent=False,
    ),
    ModelRow(
        "solid", "3D piezoelectric solid on bricks of high order", "bimorph",
        theory="solid", rank=6,
        stages=_SOLID_STAGES, gives=_SOLID_GIVES,
        remedy="raise mesh.level (at most 5) or accept the error", kept=_SOLID_KEPT,
        finest=6e-5,
    ),
    ModelRow(
        "cad", "3D piezoelectric solid on the CAD solids: fTetWild's tetrahedra in scikit-fem",
        "bimorph", theory="solid", rank=5,
        stages=_SOLID_STAGES, gives=_SOLID_GIVES,
        remedy="raise mesh.level (at most 5) or accept the error",
        kept=_SOLID_KEPT, loads=_MESHER,
    ),
    ModelRow(
        "network", "lumped reluctance network with fringing, leakage and saturation", "reluctance",
        theory="circuit", rank=1,
        stages=_magnetic_stages(CIRCUIT, wanted=()) | _in_array(CIRCUIT),
        gives=_IN_ARRAY_GIVES, quick=True, kept=_MAGNETIC_KEPT,
    ),
    ModelRow(
        "axisymmetric", "nonlinear magnetic field in the half section, finite elements",
        "reluctance", theory="field", rank=3,
        stages=_magnetic_stages(MAGNETIC),
        gives=_MAGNETIC_GIVES, remedy="this is the finest grid",
        kept=_MAGNETIC_KEPT,
    ),
    ModelRow(
        "magnetic3d", "nonlinear magnetic field in 3D by vector and scalar potential",
        "reluctance", theory="field", rank=2,
        stages=_magnetic_stages(MAGNETIC, "mesh.kind") | _in_array(MAGNETIC),
        gives=_IN_ARRAY_GIVES, remedy="this is the finest mesh",
        kept=(*_MAGNETIC_KEPT, "neighbours"), loads=_MESHER,
    ),
)  # fmt: skip

#: Cheapest first within each actuator.
MODELS: dict[str, ModelRow] = {row.name: row for row in _ROWS}


#: Models whose answers rest on no other's: what ``all`` stands for, and what is asked by default.
WITNESSES: tuple[str, ...] = tuple(row.name for row in _ROWS if row.independent)


def map_model(models: Iterable[str]) -> str:
    """Model of the normal actuator whose co-energy map the machine takes.

    Of those asked for the one that knows most; the cheapest if none is.
    """
    own = models_of("reluctance")
    return (*own[:1], *(name for name in ranked(models) if name in own))[-1]


def models_of(actuator: Actuator) -> tuple[str, ...]:
    """Names of an actuator's models, cheapest first."""
    return tuple(name for name, row in MODELS.items() if row.actuator == actuator)


def ranked(models: Iterable[str]) -> list[str]:
    """Models by rank; the last is the reference of the others."""
    return sorted(models, key=lambda name: MODELS[name].rank)


def gives(model: str, quantity: str) -> bool:
    """Whether a model can compute a quantity."""
    return set(QUANTITIES[quantity].needs) <= set(MODELS[model].gives)


def all_given(models: Iterable[str]) -> tuple[str, ...]:
    """All quantities that the models give.

    Of machine and display only what is named counts, since they want a bimorph on the rod's
    contact; of sensors and harvesters, too.
    """
    able = tuple(models)
    return tuple(
        name
        for name, row in QUANTITIES.items()
        if row.actuator not in ("generator", "display")
        and not row.by_name
        and any(gives(m, name) for m in able)
    )


def stage_reads() -> dict[str, tuple[str, ...]]:
    """Entries of keys that each stage reads; a changed voltage re-meshes nothing."""
    return {
        f"{row.name}.{stage}": reads
        for row in MODELS.values()
        for stage, reads in row.stages.items()
    }


def reading(model: str) -> tuple[str, ...]:
    """Entries of keys that a model's answers are read with, beside its stages'."""
    return READING[MODELS[model].actuator]
