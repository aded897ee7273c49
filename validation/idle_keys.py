"""Keys that a scene sets although nothing in it reads them: said once, with the remedy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from geometry import parameters as p
from geometry import units as u
from validation.quantities import LATERAL_MODELS, MAGNETIC_MODELS
from validation.scene import ON_COMMAND_LINE, Scene

#: Groups that only the models of the lateral actuator read.
_LATERAL = (
    "bimorph", "piezo", "shim", "glue", "support", "load", "drive", "beam", "mesh", "frequency",
    "modes",
)  # fmt: skip
#: Groups and keys that only the models of the normal actuator read.
_MAGNETIC = (
    "steel", "spring", "coil.turns", "coil.current", "coil.fill_factor", "coil.resistivity",
    "coil.temperature",
)  # fmt: skip
#: Keys of the rod that the magnetic field does not read.
_MECHANICAL = ("rod.slot_depth", "rod.youngs_modulus", "rod.poisson_ratio", "rod.density")


def scene_warnings(scene: Scene, origins: Mapping[str, str]) -> tuple[str, ...]:
    """Return one sentence for each key that was set but has no effect with the chosen kinds."""
    found = []
    for key, origin in origins.items():
        # a file may describe both actuators, whichever is asked about today
        because = (_not_asked(scene, key) if origin == ON_COMMAND_LINE else "") or _idle(scene, key)
        if because:
            found.append(f"{key} = {_text(scene, key)} has no effect {because}")
    return (*found, *_weightless(scene.load))


def _not_asked(scene: Scene, key: str) -> str:
    """Return why a key has no effect on the models asked for."""
    group, models = key.split(".", 1)[0], f"with models = {', '.join(scene.models)}"
    if group == "mesh" and "magnetic3d" in scene.models:
        return ""
    if group in _LATERAL and not set(scene.models) & set(LATERAL_MODELS):
        return f"{models}; ask for one of the lateral actuator, such as --model tmm, to use it"
    magnetic = set(scene.models) & set(MAGNETIC_MODELS)
    if (group in _MAGNETIC or key in _MAGNETIC) and not magnetic:
        return f"{models}; ask for one of the normal actuator, such as --model network, to use it"
    return ""


def _idle(scene: Scene, key: str) -> str:
    """Return why a key has no effect with the chosen kinds, or nothing if it has one."""
    group = key.split(".", 1)[0]
    needed = {
        **dict.fromkeys(("load.stiffness", "load.damping"), "spring_damper"),
        "load.mass": "mass",
    }.get(key)
    if needed and scene.load.kind != needed:
        return f'with load.kind = "{scene.load.kind}"; set load.kind = "{needed}" to use it'
    profile = f"{key}_profile"
    if profile.removeprefix("bimorph.") in scene.bimorph.profiles and not _has_tab(scene, key):
        return f"with {profile}, which gives it along the ceramic; leave one of the two out"
    support = scene.support.kind
    if group == "support" and key != "support.kind" and support != "spring":
        return f'with support.kind = "{support}"; set support.kind = "spring" to use it'
    if _only_on_rod(scene, key):
        return f'with support.kind = "{support}"; set support.kind = "rod" to use it'
    tetrahedra = scene.mesh.kind == "tetwild" or support == "rod"
    if key == "mesh.time_limit" and not tetrahedra:
        return f'with mesh.kind = "{scene.mesh.kind}"; set mesh.kind = "tetwild" to use it'
    graded = {"axisymmetric", "magnetic3d"} & set(scene.models)
    if key == "accuracy" and scene.mesh.level and not graded:
        return f"with mesh.level = {scene.mesh.level}; leave mesh.level out to use it"
    return ""


def _only_on_rod(scene: Scene, key: str) -> bool:
    """Return whether a key describes the rod's surroundings, which nothing here looks at."""
    group = key.split(".", 1)[0]
    if group not in ("glue", "rod", "coil", "sleeve", "gap") or scene.support.kind == "rod":
        return False
    if set(scene.models) & set(MAGNETIC_MODELS) and group != "glue" and key not in _MECHANICAL:
        return False
    limit = key == "rod.head_radius" and scene.support.kind == "spring"  # of the bimorph's width
    layers = group == "glue" and scene.bimorph.glue_thickness and key != "glue.thickness"
    return not limit and not layers


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


def _text(scene: Scene, key: str) -> str:
    value: Any = scene
    info: Any = None
    for name in key.split("."):
        info, value = type(value).model_fields[name], getattr(value, name)
    if isinstance(value, tuple):
        return f"{len(value)} value{'s' if len(value) > 1 else ''}"
    unit = next((m for m in info.metadata if isinstance(m, u.Unit)), None)
    return unit.show(value) if unit else str(value)
