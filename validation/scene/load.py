"""From a file and overrides to a checked scene.

A small TOML file states only what differs from the paper's device.  Units are written
there and nowhere else; unknown keys are refused with the nearest valid name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import sqrt
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tactgen.geometry.bimorph.segments import material_of
from tactgen.geometry.device import parameters as p
from tactgen.geometry.device.bimorph import GROWTHS
from tactgen.geometry.device.checks import beyond_plain_layers, check_actuator, check_bimorph
from tactgen.geometry.device.load_table import load_table
from tactgen.geometry.device.plausibility import clamped_for_free, slip
from tactgen.geometry.device.steel_library import steel_name
from tactgen.geometry.device.support_table import support_table
from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.models import WITNESSES, all_given, gives, models_of
from tactgen.validation.catalogue.quantities import OF_A_SOURCE, OF_CIRCUIT
from tactgen.validation.scene.files import (
    assign,
    leaves,
    read_scene,
    scene_name,
    sentence,
    split_override,
    with_start,
)
from tactgen.validation.scene.keys import check_key, groups
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.tolerances import split_tolerances, unit_of

#: Keys that name a file, each with what tells values that do not.
FILE_KEYS: dict[str, Callable[[str], bool]] = {
    "steel.curve": lambda text: steel_name(text) is not None,
    "load.file": lambda text: not text,
    "support.file": lambda text: not text,
    "threshold.file": lambda text: not text,
}
#: Origin of what ``--set`` and its shorthands say.
ON_COMMAND_LINE = "set on the command line"
#: Models of the bimorph that read s11, d31 and eps33 and no other constant of the ceramic's.
_LENGTHWISE = frozenset(("lumped", "tmm", "beam"))


def load_scene(name: str = "paper", overrides: Sequence[str] = ()) -> tuple[Scene, dict[str, str]]:
    """Read a scene by file or built-in name and apply ``KEY=VALUE`` overrides.

    Where overrides name models only, the scene's own quantities that none of them gives are left
    out.

    Returns
    -------
    scene : Scene
        Checked and in SI units.
    origins : dict of str to str
        For each key that the scene or an override sets, where it was set.

    Raises InputError in one sentence, for anything that cannot be used.
    """
    values, origins = scene_values(name, overrides)
    scene = checked_scene(values)
    if origins.get("models") == ON_COMMAND_LINE != origins.get("quantities"):
        given = tuple(q for q in scene.quantities if any(gives(m, q) for m in scene.models))
        scene = scene.model_copy(update={"quantities": given or scene.quantities})
    return scene, origins


def scene_values(name: str, overrides: Sequence[str] = ()) -> tuple[dict[str, Any], dict[str, str]]:
    """Scene's values as they are written, overrides in place, and where each was set.

    Raises InputError if there is no such scene, or a key is unknown.
    """
    values, where = read_scene(name)
    origins = {key: where for key, value in leaves(values) if value != {}}
    _point_from_scene(values, name)
    for key, value in leaves(values):
        if value != {} or key not in groups():  # an empty group says nothing
            check_key(key)
    for override in overrides:
        key, text = split_override(override)
        check_key(key)
        assign(values, key, text)
        origins[key] = ON_COMMAND_LINE
    values.setdefault("name", scene_name(Path(name).stem))
    return values, origins


def checked_scene(values: dict[str, Any]) -> Scene:
    """Scene that values describe, as :func:`scene_values` gives them.

    Raises InputError in one sentence, if a value cannot be used or the device does not fit
    together.
    """
    complete, not_stated = with_start(values)
    plain, tolerances = split_tolerances(Scene, complete)
    try:
        scene = Scene.model_validate(plain, context={"units_required": True})
    except ValidationError as error:
        raise InputError(sentence(error)) from None
    scene._tolerances, scene._not_stated = tolerances, not_stated
    _check_together(scene)
    if "models" not in values or scene.models == WITNESSES:  # none, or all of them
        scene = scene.model_copy(update={"models": _able_models(scene)})
    return scene.model_copy(update={"quantities": _with_circuit(scene)})


def _with_circuit(scene: Scene) -> tuple[str, ...]:
    """Quantities of a scene; if all are asked for, also what its circuit is there for.

    And without a source none of what its voltage must be.
    """
    asked, every = scene.quantities, all_given(set(scene.models) & set(models_of("bimorph")))
    if not every or not {*every} <= {*asked}:
        return asked
    further = OF_CIRCUIT.get(scene.circuit.kind, ())
    kept = [name for name in asked if scene.circuit.kind == "source" or name not in OF_A_SOURCE]
    return tuple(dict.fromkeys((*kept, *further)))


def _check_together(scene: Scene) -> None:
    """Refuse values that do not fit together; InputError."""
    if scene.piezo.grows:
        _check_field(scene)
    try:
        if "piezo" in scene.bimorph.own_materials:
            ceramic = scene.device.piezo.ceramic()
            if reads_tensors(scene):
                ceramic.check_admissible()
            else:
                ceramic.check_lengthwise()
            ceramic.check_passive()
    except InputError as error:  # where one constant has a wrong unit, that is the cause
        slips = unusual_values(scene, [f"piezo.{name}" for name in p.Piezo.model_fields])
        if slips:
            raise InputError(slips[0]) from None
        if scene.piezo.grows:
            raise InputError(f"at the field of drive.voltage, {error}") from None
        raise
    device = scene.device
    _check_along(device)
    if set(scene.models) & set(models_of("bimorph")) or scene.support.kind == "rod":
        check_bimorph(device, scene.support)
    check_actuator(device)
    if scene.load.kind == "table":
        load_table(scene.load)
    if scene.support.kind == "table":
        support_table(scene.support)
    if scene.threshold.kind == "table":
        threshold_of(scene.threshold)


def _check_along(device: p.Device) -> None:
    """Refuse a ceramic poled along that no passive material is."""
    for number, layer in enumerate(device.bimorph.layers):
        of = material_of(device, layer)
        if not (layer.pitch and isinstance(of, p.Piezo)):
            continue
        turned = of.ceramic()
        try:
            turned.check_lengthwise()
            turned.check_passive()
        except InputError:
            k33 = abs(turned.d[2, 0]) / sqrt(turned.s[0, 0] * turned.eps_t[2, 2])
            raise InputError(
                f"bimorph.layers has layer {number + 1} ({layer}) with k33 = {k33:.3g} along its "
                "poling, and no passive material has that together with its losses; change d33, "
                "s33 or eps33 in piezo.constants, or piezo.coupling_loss"
            ) from None


def _check_field(scene: Scene) -> None:
    """Refuse a ceramic that grows with the field where the field is not known beforehand."""
    circuit, bimorph = scene.circuit, scene.bimorph
    growth = next(f"piezo.{name}" for name in GROWTHS if getattr(scene.piezo, name))
    known = circuit.kind == "source" and not scene.drive.base_acceleration
    if not known or circuit.resistance or circuit.inductance or circuit.capacitance:
        raise InputError(
            f"{growth} needs the voltage across the electrodes, which follows from circuit and "
            "base motion here; drive them by circuit.kind = source without an impedance, or set "
            f"{growth} = 0 mm/kV"
        )
    layers = bimorph.layers
    own = [n for n, layer in enumerate(layers) if layer.material == "piezo"]
    fields = {layers[n].electrode_distance if layers.hot(n) else 0.0 for n in own}
    varies = "piezo_thickness_profile" if bimorph.piezo_thickness_profile else ""
    if layers and (len(fields) > 1 or fields == {0.0} or not own):
        varies = "layers"
    if varies:
        raise InputError(
            f"{growth} needs one field in all ceramic of the material piezo, and bimorph.{varies} "
            f"does not give it; change that, or set {growth} = 0 mm/kV"
        )


def reads_tensors(scene: Scene) -> bool:
    """Whether any model of the bimorph that is asked reads more than s11, d31 and eps33."""
    asked = set(scene.models) & set(models_of("bimorph"))
    return scene.support.kind == "rod" or not asked or bool(asked - _LENGTHWISE)


def unusual_values(scene: Scene, keys: Iterable[str]) -> list[str]:
    """Questions about values of some keys that lie far outside the range of their kind."""
    found = []
    for key in keys:
        group, _, name = key.partition(".")
        owner = getattr(scene, group) if name else scene
        name = name or key
        value, unit = owner.value(name), unit_of(owner.declaration(name))
        if isinstance(value, float) and (text := slip(key, value, unit)):
            found.append(text)
    if "piezo.eps33" in keys:
        found.append(clamped_for_free(scene.piezo.base, scene.piezo.eps33))
    return list(filter(None, found))


def _point_from_scene(values: dict[str, Any], name: str) -> None:
    """Let a path that a scene file states start where the file is, not where the command runs."""
    for key, named in FILE_KEYS.items():
        group, _, field = key.partition(".")
        inside = values.get(group)
        file = inside.get(field) if isinstance(inside, dict) else None
        if isinstance(inside, dict) and isinstance(file, str) and not named(file):
            inside[field] = str(Path(name).parent / file)


def _able_models(scene: Scene) -> tuple[str, ...]:
    """Models that know the scene's bimorph and support."""
    bimorph = scene.bimorph
    unable = set()
    if bimorph.profiles or scene.support.kind == "rod":
        unable.add("solid")
    if beyond_plain_layers(bimorph):
        unable.add("cad")
    if scene.measurement.below_tip:
        unable.add("lumped")
    return tuple(name for name in scene.models if name not in unable)
