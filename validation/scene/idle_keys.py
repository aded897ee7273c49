"""Keys that a scene sets although nothing in it reads them: said once, with the remedy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactgen.geometry import units as u
from tactgen.geometry.device import parameters as p
from tactgen.validation.catalogue.models import MODELS, models_of
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.scene.scene import ON_COMMAND_LINE, Scene

#: Groups that only the models of the lateral actuator read.
_LATERAL = (
    "bimorph", "piezo", "shim", "glue", "support", "load", "threshold", "drive", "beam",
    "frequency", "modes",
)  # fmt: skip
#: Groups and keys that only the models of the normal actuator read.
_MAGNETIC = (
    "steel", "spring", "coil.turns", "coil.current", "coil.fill_factor", "coil.resistivity",
    "coil.temperature",
)  # fmt: skip
#: Groups that only the display reads.
_DISPLAY = ("display", "skin", "scatter")
#: Of those, what only the report shows: the coil's resistance and heat.
_HEAT = ("coil.fill_factor", "coil.resistivity", "coil.temperature")
#: What is read where the lateral actuator stands on its contact, besides contact and guide: what
#: presses it, what the moving rod weighs, and with a current the magnetic circuit.
_PRESSES = ("spring.preload", "spring.stiffness", "coil.current", "load.normal_force")
_WEIGHS = (
    "rod.radius", "rod.head_radius", "rod.head_thickness", "rod.flange_radius",
    "rod.flange_thickness", "rod.flange_position", "rod.length", "rod.density", "coil.fill_factor",
    "coil.inner_radius", "coil.outer_radius", "coil.length", "coil.position",
    "coil.copper_density",
)  # fmt: skip
_CIRCUIT = ("spring.stop_gap", "steel", "sleeve", "gap", "coil.turns", "coil.history")
#: Of the contact, what where the rod rests depends on as well.
_RESTS = (
    "contact.shape", "contact.decay_length", "contact.lower_decay_ratio", "coil.history",
    "load.normal_force",
)  # fmt: skip
#: What only the machine in small motions reads.
_IN_MOTION = (
    "coil.supply", "coil.source_resistance", "guide.axial_damping", "spring.eccentricity",
)  # fmt: skip
#: Dimensions that no formula of the reluctance network contains.
_FIELD_ONLY = ("coil.inner_radius", "coil.outer_radius")
#: Keys of the rod that the magnetic field does not read.
_MECHANICAL = ("rod.slot_depth", "rod.youngs_modulus", "rod.poisson_ratio", "rod.density")


def scene_warnings(
    scene: Scene, origins: Mapping[str, str], *, report: bool = False
) -> tuple[str, ...]:
    """Return one sentence for each key that was set but has no effect with the chosen kinds.

    Parameters
    ----------
    origins : mapping of str to str
        Where each key was set; "" for a key that is only asked about.
    report : bool
        Whether all is shown that the models know, not the scene's quantities only.
    """
    found = []
    for key, origin in origins.items():
        because = ""
        if origin in (ON_COMMAND_LINE, ""):
            # a file may describe both actuators, whichever is asked about today
            because = _not_asked(scene, key) or ("" if report else _not_shown(scene, key))
        because = because or _idle(scene, key)
        if because:
            found.append(f"{key} = {_text(scene, key)} has no effect {because}")
    return (*found, *_weightless(scene.load), *_signs(scene))


def idle(scene: Scene, key: str) -> str:
    """Return why a key has no effect with the scene's kinds, or nothing if it may have one."""
    found = scene_warnings(scene, {key: ""})
    return next((sentence for sentence in found if sentence.startswith(f"{key} = ")), "")


def _not_asked(scene: Scene, key: str) -> str:
    """Return why a key has no effect on the models asked for."""
    if key.split(".", 1)[0] in _DISPLAY:
        return _not_of_display(scene, key)
    group, models = key.split(".", 1)[0], f"with models = {', '.join(scene.models)}"
    if key == "mesh.level" and not any(MODELS[name].reads(key) for name in scene.models):
        return f"{models}; use it with --set models=solid"
    if group in _LATERAL and not set(scene.models) & set(models_of("bimorph")):
        return f"{models}; use it with one of the lateral actuator, such as --set models=tmm"
    if _holds_the_bimorph(scene, key) or _of_machine(scene, key):
        return ""
    magnetic = set(scene.models) & set(models_of("reluctance"))
    around = group in ("coil", "sleeve", "gap") and scene.support.kind != "rod"
    if (group in _MAGNETIC or key in _MAGNETIC or around) and not magnetic:
        return (
            f"{models}; ask for one of the normal actuator, such as --set models=network, to use it"
        )
    return ""


def _not_of_display(scene: Scene, key: str) -> str:
    """Return why a key of the display has no effect on the quantities asked for."""
    of_display = {name: row for name, row in QUANTITIES.items() if row.actuator == "display"}
    if not set(scene.quantities) & of_display.keys():
        return (
            f"with quantities = {', '.join(scene.quantities)}; ask for one of the display, such "
            f"as {next(iter(of_display))}, to use it"
        )
    if key.startswith("skin.") and scene.load.kind == "none":
        return 'with load.kind = "none", on whose tips nothing lies; set load.kind = "finger"'
    return ""


def _not_shown(scene: Scene, key: str) -> str:
    """Return why a key of the normal actuator has no effect on the quantities asked for."""
    magnetic = set(scene.models) & set(models_of("reluctance"))
    if not magnetic:
        return ""
    asked = f"with quantities = {', '.join(scene.quantities)}"
    rests = any("rest" in QUANTITIES[name].needs for name in scene.quantities)
    moves = any("magnetic_map" in QUANTITIES[name].needs for name in scene.quantities)
    if _holds_the_bimorph(scene, key) or _of_machine(scene, key):
        return ""
    if key in _RESTS and not rests:
        return f"{asked}; ask for {_listed('rest')} to use it"
    if key.startswith("spring.") and not (moves or rests):
        return f"{asked}; ask for {_listed('magnetic_map', 'rest')} to use it"
    if key in _HEAT:
        return "on any quantity; tactgen report shows the coil's resistance and heat"
    if key in _FIELD_ONLY and all(MODELS[name].theory == "circuit" for name in magnetic):
        field = next(name for name, row in MODELS.items() if row.theory == "field")
        return f"with models = {', '.join(sorted(magnetic))}; use it with --set models={field}"
    return ""


def _listed(*needs: str) -> str:
    names = [name for name, row in QUANTITIES.items() if set(row.needs) & set(needs)]
    return f"{', '.join(names[:-1])} or {names[-1]}"


def _holds_the_bimorph(scene: Scene, key: str) -> bool:
    """Return whether a key enters the contact on which the lateral actuator stands."""
    if scene.support.kind != "contact" or not set(scene.models) & set(models_of("bimorph")):
        return False
    group = key.split(".", 1)[0]
    if group in ("contact", "guide") or key in _PRESSES or key in _WEIGHS:
        return key not in _IN_MOTION
    return scene.coil.current != 0.0 and (group in _CIRCUIT or key in _CIRCUIT)


def _of_machine(scene: Scene, key: str) -> bool:
    """Return whether the machine, or the display of many, reads a key for what is asked of it."""
    asked = (q for q in scene.quantities if QUANTITIES[q].actuator in ("generator", "display"))
    needs = {need for name in asked for need in QUANTITIES[name].needs}
    stages = (
        (row, stage)
        for row in (MODELS[name] for name in scene.models)
        for need in needs & row.gives.keys()
        for stage in row.gives[need]
    )
    group = key.split(".", 1)[0]
    return any({key, group} & set(row.stages[stage]) for row, stage in stages)


def _of_contact(scene: Scene, key: str) -> str:
    """Return why a key of the rod's contact and guide has no effect, or nothing if it has one."""
    if key in _IN_MOTION:
        rows = {name: QUANTITIES[name].actuator for name in QUANTITIES}
        if any(rows[name] == "generator" for name in scene.quantities):
            return ""
        first = next(name for name, actuator in rows.items() if actuator == "generator")
        return (
            f"with quantities = {', '.join(scene.quantities)}; ask for one of the machine, such as "
            f"{first}, to use it"
        )
    group = key.split(".", 1)[0]
    if group not in ("contact", "guide") and key not in (*_RESTS, "coil.copper_density"):
        return ""
    magnetic = set(scene.models) & set(models_of("reluctance"))
    if _holds_the_bimorph(scene, key) or (magnetic and key in _RESTS):
        return ""
    support = scene.support.kind
    return f'with support.kind = "{support}"; set support.kind = "contact" to use it'


def _idle(scene: Scene, key: str) -> str:
    """Return why a key has no effect with the chosen kinds, or nothing if it has one."""
    group = key.split(".", 1)[0]
    needed = {
        **dict.fromkeys(("load.stiffness", "load.damping"), "spring_damper"),
        "load.mass": "mass",
        **dict.fromkeys(("load.file", "load.extrapolation"), "table"),
        **dict.fromkeys((f"load.{k}" for k in p.Load.model_fields if k.startswith("pad_")), "pad"),
    }.get(key)
    if needed and scene.load.kind != needed:
        return f'with load.kind = "{scene.load.kind}"; set load.kind = "{needed}" to use it'
    if key == "threshold.file" and scene.threshold.kind != "table":
        kind = scene.threshold.kind
        return f'with threshold.kind = "{kind}"; set threshold.kind = "table" to use it'
    if key == "guide.guided_length" and not scene.guide.clearance:
        return "with guide.clearance = 0 mm, which leaves no play; set guide.clearance to use it"
    profile = f"{key}_profile"
    if profile.removeprefix("bimorph.") in scene.bimorph.profiles and not _has_tab(scene, key):
        return f"with {profile}, which gives it along the ceramic; leave one of the two out"
    support = scene.support.kind
    if key == "steel.relative_permeability" and scene.steel.curve != "linear":
        curve = scene.steel.curve
        return f'with steel.curve = "{curve}"; set steel.curve = "linear" to use it'
    because = _of_contact(scene, key)
    if because:
        return because
    if group == "support" and key != "support.kind" and support != "spring":
        return f'with support.kind = "{support}"; set support.kind = "spring" to use it'
    if _only_on_rod(scene, key):
        return f'with support.kind = "{support}"; set support.kind = "rod" to use it'
    normal = "magnetic3d" in scene.models
    if key == "mesh.kind" and not normal:
        return f"with models = {', '.join(scene.models)}; use it with --set models=magnetic3d"
    tetrahedra = "cad" in scene.models or (normal and scene.mesh.kind == "tetwild")
    if key == "mesh.time_limit" and not tetrahedra:
        return f"with models = {', '.join(scene.models)}; use it with --set models=cad"
    if key == "accuracy" and scene.mesh.level and not _read_by_magnetic(scene, key):
        return f"with mesh.level = {scene.mesh.level}; leave mesh.level out to use it"
    return ""


def _read_by_magnetic(scene: Scene, key: str) -> bool:
    """Return whether a model of the normal actuator that is asked for reads a key."""
    asked = (MODELS[name] for name in scene.models)
    return any(row.actuator == "reluctance" and row.reads(key) for row in asked)


def _only_on_rod(scene: Scene, key: str) -> bool:
    """Return whether a key describes the rod's surroundings, which nothing here looks at."""
    group = key.split(".", 1)[0]
    if (
        group not in ("glue", "rod")
        or scene.support.kind == "rod"
        or _holds_the_bimorph(scene, key)
    ):
        return False
    if (
        set(scene.models) & set(models_of("reluctance"))
        and group == "rod"
        and key not in _MECHANICAL
    ):
        return False
    layers = group == "glue" and scene.bimorph.glue_thickness and key != "glue.thickness"
    return not layers


def _has_tab(scene: Scene, key: str) -> bool:
    """Return whether a dimension of the ceramic is also that of the tab below it."""
    return key != "bimorph.piezo_thickness" and scene.bimorph.tab_length > 0.0


def _weightless(load: p.Load) -> list[str]:
    if load.kind == "mass" and load.mass == 0.0:
        return ['load.kind = "mass" with load.mass = 0 mg is a free tip; set load.mass']
    if load.kind == "spring_damper" and load.stiffness == load.damping == 0.0:
        both = "load.stiffness = 0 N/m and load.damping = 0 N*s/m"
        return [f'load.kind = "spring_damper" with {both} is a free tip; set one of them']
    return []


def _signs(scene: Scene) -> list[str]:
    """Return what looks like a size that was taken for a value."""
    found = []
    if scene.piezo.d31 > 0.0:
        found.append(
            f"piezo.d31 = {_text(scene, 'piezo.d31')} is positive, and that of poled ceramics is "
            "negative; if a data sheet prints its size, write it with a minus"
        )
    for key in ("shim.poisson_ratio", "rod.poisson_ratio", "glue.poisson_ratio"):
        group, name = key.split(".")
        if getattr(getattr(scene, group), name) < 0.0:
            found.append(f"{key} = {_text(scene, key)} is negative, as hardly any material's is")
    return found


def _text(scene: Scene, key: str) -> str:
    value: Any = scene
    info: Any = None
    for name in key.split("."):
        info, value = type(value).model_fields[name], getattr(value, name)
    if isinstance(value, tuple):
        return f"{len(value)} value{'s' if len(value) > 1 else ''}"
    unit = next((m for m in info.metadata if isinstance(m, u.Unit)), None)
    return unit.show(value) if unit else str(value)
