"""What a scene states without effect, twice, or far from what its kind is like."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache

from tactgen.geometry.device.ceramic_constants import tabulated
from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import (
    CONDITIONS,
    MODELS,
    PROFILED,
    SETTINGS,
    gives,
    models_of,
    reading,
)
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.scene.inputs import (
    ASKED,
    LAYER,
    NOT,
    bare_shim,
    condition_holds,
    keys_of,
    keys_read,
    profile_of,
)
from tactgen.validation.scene.keys import declaration, is_scene_key, read_as
from tactgen.validation.scene.load import ON_COMMAND_LINE, reads_tensors, unusual_values
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.tolerances import unit_of
from tactgen.validation.scene.variation import value_of

#: Relative distance of two values that may be one, rounded.
_AS_PRINTED = 0.02


def _width_of_bare_shim(scene: Scene, origins: Mapping[str, str]) -> Iterator[str]:
    """Yield what the bare shim is like beside a profile if the scene does not say so."""
    bare = bare_shim(scene)
    for key in ("bimorph.width", "bimorph.shim_thickness"):
        profile = f"{key}_profile"
        if (
            bare
            and key not in origins
            and profile.removeprefix("bimorph.") in scene.bimorph.profiles
        ):
            yield (
                f"{key} = {_text(scene, key)} is that of the bare shim ({bare}), and not stated "
                f"beside {profile}; set {key}"
            )


def _stated_twice(scene: Scene, origins: Mapping[str, str]) -> Iterator[str]:
    """Yield which of the ceramic's stated constants do not hold beside its single keys."""
    constants = scene.piezo.constants
    single = [key for key in ("s11", "s55", "d31", "eps33") if f"piezo.{key}" in origins]
    if not (constants and single):
        return
    names = " and ".join(f"piezo.{key}" for key in single)
    found = tabulated(scene.piezo.ceramic(), [constant.name for constant in constants])
    for stated, own in zip(constants, found, strict=True):
        if abs(own.value - stated.value) > _AS_PRINTED * abs(stated.value):
            yield f"piezo.constants has {stated}, and with {names} it is {own}; leave one out"


def scene_warnings(
    scene: Scene, origins: Mapping[str, str], *, report: bool = False
) -> tuple[str, ...]:
    """One sentence for each key that was set but has no effect.

    Parameters
    ----------
    origins : mapping of str to str
        Where each key was set.
    report : bool
        Whether all is shown that the models know, not the scene's quantities only.
    """
    found = []
    for key, origin in origins.items():
        if report and key.startswith("coil.") and set(scene.models) & set(models_of("reluctance")):
            continue  # a report shows the coil's resistance and heat
        if key == "drive.voltage" and not scene.drive.voltage:
            continue  # that says itself that nothing is applied
        quantities = _sensible(scene, key) if report else scene.quantities
        # a file may describe both actuators, whichever is asked about today
        found.append(_idle(scene, key, quantities, asked=origin == ON_COMMAND_LINE))
    stated = [key for key in origins if is_scene_key(key)]
    found += [*unusual_values(scene, stated), no_solid(scene)]
    found += [*_width_of_bare_shim(scene, origins), *_stated_twice(scene, origins)]
    load = scene.load
    if load.kind == "mass" and load.mass == 0.0:
        found.append('load.kind = "mass" with load.mass = 0 mg is a free tip; set load.mass')
    if load.kind == "spring_damper" and load.stiffness == load.damping == 0.0:
        both = "load.stiffness = 0 N/m and load.damping = 0 N*s/m"
        found.append(f'load.kind = "spring_damper" with {both} is a free tip; set one of them')
    return tuple(filter(None, found))


def idle(scene: Scene, key: str) -> str:
    """Reason why a key has no effect on a scene's request, or ""."""
    return _idle(scene, key, scene.quantities, asked=True)


def _idle(scene: Scene, key: str, quantities: tuple[str, ...], *, asked: bool) -> str:
    """The same of some quantities; unless `asked` only if the scene itself makes it idle."""
    stated, key = key, read_as(key)
    if key in ASKED or key in keys_read(scene, _entries(scene.models, quantities)):
        return ""
    sensible = _sensible(scene, key)
    profile = profile_of(scene, key) if key in PROFILED else ""
    because = _unmet(scene, key, scene.models, sensible)
    if profile:
        because = f"with {profile}, which gives it along the ceramic; remove one of the two"
    if asked and not because:
        because = _use(scene, key, sensible) or _unmet(scene, key, tuple(MODELS), sensible)
        because = because or "on any quantity; tactgen report shows the coil's resistance and heat"
    return because and f"{stated} = {_text(scene, stated)} has no effect {because}"


def _use(scene: Scene, key: str, quantities: tuple[str, ...]) -> str:
    """Quantity, or else model, to ask for so that a key is read; "" if there is none."""
    for name in quantities:
        if key in keys_read(scene, _entries(scene.models, (name,))):
            return f"with quantities = {', '.join(scene.quantities)}; ask for {name} to use it"
    able = [m for m in MODELS if key in keys_read(scene, _entries((m,), quantities))]
    model = next((m for m in able if not MODELS[m].shortcut), "")
    return model and f"with models = {', '.join(scene.models)}; use it with --set models={model}"


def _sensible(scene: Scene, key: str) -> tuple[str, ...]:
    """Quantities that a scene can be asked for: of machines where one stands."""
    machine = scene.support.kind == "contact" or key.partition(".")[0] in ("display", "skin")
    own = ("bimorph", "reluctance")
    return tuple(name for name, row in QUANTITIES.items() if machine or row.actuator in own)


@lru_cache(maxsize=1024)
def _entries(models: tuple[str, ...], quantities: tuple[str, ...]) -> tuple[str, ...]:
    """Entries of all that models read for quantities, in order."""
    found = dict[str, None]()
    for model in models:
        row, given = MODELS[model], [name for name in quantities if gives(model, name)]
        found |= dict.fromkeys(SETTINGS.get(model, ()))
        if given:
            found |= dict.fromkeys(entry for entry in reading(model) if entry != "accuracy")
        for name in given:
            for stage in row.stages_for(QUANTITIES[name]):
                found |= dict.fromkeys(row.stages[stage.partition(".")[2]])
    return tuple(found)


def _unmet(scene: Scene, key: str, models: tuple[str, ...], quantities: tuple[str, ...]) -> str:
    """Condition without which a key counts for none of the models, in words."""
    conditions = [CONDITIONS.get(key), CONDITIONS.get(key.partition(".")[0])]
    if key.partition(".")[0] in ("contact", "guide") or key.startswith("spring.eccentricity"):
        conditions.append("support.kind=contact")
    conditions += [
        condition
        for path, _, condition in (e.partition(" if ") for e in _entries(models, quantities))
        if condition and key in keys_of(path)
    ]
    unmet = (c for c in conditions if c and not condition_holds(scene, c))
    return next((_remedy(scene, condition) for condition in unmet), "")


def _remedy(scene: Scene, condition: str) -> str:
    """Words for a condition that does not hold."""
    if condition.startswith(NOT):
        key = condition.removeprefix(NOT)
        return f"with {key}; leave {key} out to use it"
    if condition.startswith(LAYER):
        group = condition.removeprefix(LAYER)
        if group == "glue" and not scene.bimorph.layers:
            return "without glue between the layers; set bimorph.glue_thickness to use it"
        return f"without a {condition}; name {group} in bimorph.layers to use it"
    key, unequal, value = condition.partition("!=")
    if unequal:
        return f'with {key} = "{value}"; set another {key} to use it'
    key, _, value = condition.partition("=")
    text = _text(scene, key)
    if not value:
        return f"with {key} = {text}; set {key} to use it"
    if value.isdecimal():
        return f"with {key} = {text}; leave {key} out to use it"
    return f'with {key} = "{text}"; set {key} = "{value}" to use it'


def _text(scene: Scene, key: str) -> str:
    value, unit = value_of(scene, key), unit_of(declaration(key))
    if isinstance(value, tuple):
        return f"{len(value)} value{'s' if len(value) > 1 else ''}"
    return unit.show(value) if unit and value is not None else str(value)


def no_solid(scene: Scene) -> str:
    """Warning of constants that only a solid model would refuse, or ""."""
    if reads_tensors(scene):
        return ""
    try:
        scene.device.piezo.ceramic().check_admissible()
    except InputError as error:
        return f"a solid model would refuse this ceramic, and the models asked do not: {error}"
    return ""
