"""Scene: device, support, load, drive and wanted quantities.

A small TOML file states only what differs from the paper's device.  Units are written
there and nowhere else; unknown keys are refused with the nearest valid name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from math import sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import (
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    field_validator,
)
from pydantic.fields import FieldInfo

from tactgen.geometry import units as u
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.segments import material_of
from tactgen.geometry.device import parameters as p
from tactgen.geometry.device.bimorph import GROWTHS
from tactgen.geometry.device.checks import beyond_plain_layers, check_actuator, check_bimorph
from tactgen.geometry.device.laminate import SIZES, is_size
from tactgen.geometry.device.load_table import load_table
from tactgen.geometry.device.material_library import steel_name
from tactgen.geometry.device.plausibility import clamped_for_free, slip
from tactgen.geometry.device.support_table import support_table
from tactgen.geometry.errors import InputError
from tactgen.geometry.names import nearest
from tactgen.geometry.units import WholeNumber, quoted
from tactgen.tmm.ports.elements import ends_of
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.models import (
    MODELS,
    WITNESSES,
    all_given,
    gives,
    map_model,
    models_of,
)
from tactgen.validation.catalogue.quantities import OF_CIRCUIT, QUANTITIES, quantities_of
from tactgen.validation.scene.files import (
    LONGEST_NAME,
    assign,
    choices,
    leaves,
    parse_frequencies,
    read_scene,
    scene_name,
    sentence,
    split_override,
    with_start,
)
from tactgen.validation.scene.tolerances import Tolerance, split_tolerances, unit_of

if TYPE_CHECKING:
    from tactgen.tmm.generator.equilibrium import RestingPlace
    from tactgen.tmm.reluctance.coenergy_map import CoenergyMap


#: Keys that name a file, each with what tells values that do not.
FILE_KEYS: dict[str, Callable[[str], bool]] = {
    "steel.curve": lambda text: steel_name(text) is not None,
    "load.file": lambda text: not text,
    "support.file": lambda text: not text,
    "threshold.file": lambda text: not text,
}
#: Origin of what ``--set`` and its shorthands say.
ON_COMMAND_LINE = "set on the command line"


class MeshSettings(p.Parameters):
    """Mesh settings of the field models."""

    kind: Literal["structured", "tetwild"] = Field(
        default="structured",
        description="of magnetic3d: structured: a swept sector; tetwild: tetrahedra of CAD solids",
    )
    level: Annotated[int, BeforeValidator(WholeNumber(0, 5, "3"))] = Field(
        default=0,
        description="1 (coarse) to 5 (finest), bricks from 2; 0 follows from the accuracy wanted",
    )
    time_limit: u.Duration = Field(
        default=u.SI(600.0), description="processor time that one tetwild mesh may take"
    )


class Scene(p.Device):
    """A complete, checked scene in SI units."""

    name: str = ""
    description: str = ""
    start_from: Literal["paper", "neutral"] = Field(
        default="paper",
        description="support, load, wiring and voltage where not stated: paper: the paper's; "
        "neutral: clamped, free tip, parallel, 1 V",
    )
    support: p.Support = p.Support()
    load: p.Load = p.Load()
    threshold: p.Threshold = p.Threshold()
    drive: p.Drive = p.Drive()
    circuit: p.Circuit = p.Circuit()
    beam: p.Beam = p.Beam()
    limits: p.Limits = p.Limits()
    display: p.Display = p.Display()
    skin: p.Skin = p.Skin()
    scatter: p.Scatter = p.Scatter()
    mesh: MeshSettings = MeshSettings()
    accuracy: u.RelativeError = Field(
        default=1e-3, description="relative numerical error wanted of the field models"
    )
    modes: Annotated[int, BeforeValidator(WholeNumber(1, 20, "4"))] = Field(
        default=4, description="number of natural modes"
    )
    frequency: tuple[float, ...] = Field(
        default=parse_frequencies("10 Hz:1000 Hz:100:log"),
        description="list of frequencies, or START:STOP:N[:log]",
    )
    models: tuple[str, ...] = Field(
        default_factory=lambda: tuple(m for m in models_of("bimorph") if m in WITNESSES),
        description="models to solve; by default all of the bimorph's that apply, without cad for "
        "listed layers, profiles and a tip extension, which takes a minute",
    )
    quantities: tuple[str, ...] = Field(
        default_factory=lambda known: _usual_quantities(known.get("models", ())),
        description="quantities to compute; by default all of the bimorph, or of the normal "
        "actuator if only its models are listed",
    )

    _tolerances: dict[str, Tolerance] = PrivateAttr(default_factory=dict)
    _not_stated: tuple[str, ...] = PrivateAttr(default=())

    @property
    def tolerances(self) -> Mapping[str, Tolerance]:
        """Stated tolerances by key."""
        return self._tolerances

    @property
    def not_stated(self) -> tuple[str, ...]:
        """Conditions (support, load, wiring, voltage, gap, current) that no scene key states."""
        return self._not_stated

    @property
    def device(self) -> p.Device:
        """The device alone, its ceramic that at the field of the drive voltage."""
        groups = {name: getattr(self, name) for name in p.Device.model_fields}
        if self.piezo.grows:
            groups["piezo"] = self.piezo.at_field(self.field)
        return p.Device(**groups)

    @property
    def field(self) -> float:
        """Amplitude of the field (V/m) that the drive voltage makes in the ceramic piezo."""
        across = 2.0 if self.bimorph.wiring == "series" else 1.0
        own = [of for of in self.bimorph.layers if of.material == "piezo"]  # all of one distance
        distance = own[0].electrode_distance if own else self.bimorph.electrode_distance
        return float(abs(self.drive.voltage) / (across * distance))

    @property
    def ends(self) -> Ends:
        """Support and load as every model of the lateral actuator reads them.

        An upright head's contact is alike in all directions; of other springs only those against
        bending are known.
        """
        found = ends_of(self.held, self.load)
        if self.rest is None or found.base is None:
            return found
        from tactgen.tmm.generator.equilibrium import on_contact

        return on_contact(found, self.device, self.beam, self.rest[0])

    @property
    def held(self) -> p.Support:
        """The support, a contact as the springs that it is where the rod rests."""
        return self.support if self.rest is None else self.rest[1]

    @property
    def rest(self) -> tuple[RestingPlace, p.Support] | None:
        """Where the rod rests and the springs of its contact; None without a contact.

        Without current nothing magnetic is touched.

        Raises InputError if the rod rests nowhere.
        """
        if self.support.kind != "contact":
            return None
        pull = self.pull if self.coil.current else None
        return _held_by_contact(self.device, self.load.normal_force, pull)

    @property
    def map_model(self) -> str:
        """The model of the normal actuator by which the rod is pulled: see catalogue.models."""
        return map_model(self.models)

    @property
    def pull(self) -> CoenergyMap:
        """Co-energy map by that model: the network's formula, or a field's that was solved before.

        Raises LookupError if a field was not solved: models.classes.map_of does that.
        """
        if MODELS[self.map_model].theory == "field":
            return _FIELD_MAPS[self._circuit]
        from tactgen.tmm.reluctance.map_range import network_map

        return network_map(self.device)

    @property
    def has_map(self) -> bool:
        """Whether `pull` is at hand: always by the network, by a field once it was solved."""
        return MODELS[self.map_model].theory != "field" or self._circuit in _FIELD_MAPS

    @property
    def awaits_map(self) -> bool:
        """Whether where the rod rests follows from a field that was not solved yet."""
        return self.support.kind == "contact" and self.coil.current != 0.0 and not self.has_map

    def take_map(self, found: CoenergyMap) -> None:
        """Take the map by `map_model`, for this scene and all of the same magnetic circuit."""
        if MODELS[self.map_model].theory == "field":
            while len(_FIELD_MAPS) >= _MOST_MAPS:
                del _FIELD_MAPS[next(iter(_FIELD_MAPS))]
            _FIELD_MAPS[self._circuit] = found

    @property
    def _circuit(self) -> tuple[object, ...]:
        """All that a field's map depends on."""
        coil = self.coil.model_copy(update={"history": "rising"})
        parts = (self.rod, coil, self.sleeve, self.steel, self.gap, self.spring)
        return (self.map_model, self.mesh.kind, *parts)

    def asking(self, models: Sequence[str]) -> Scene:
        """Scene as one that asks for these models, if they bring another map."""
        brings = set(models) & set(models_of("reluctance"))
        if not brings or map_model(models) == self.map_model:
            return self
        return self.model_copy(update={"models": tuple(models)})

    @field_validator("name", mode="before")
    @classmethod
    def _name(cls, value: Any) -> Any:
        if isinstance(value, str) and scene_name(value) != value:
            raise InputError(
                f"name = {quoted(value)} is not one line of at most {LONGEST_NAME} printable "
                "characters; shorten it, and use description for more"
            )
        return value

    @field_validator("frequency", mode="before")
    @classmethod
    def _frequencies(cls, value: Any) -> Any:
        return parse_frequencies(value)

    @field_validator("models", mode="before")
    @classmethod
    def _models(cls, value: Any) -> Any:
        return chosen_models(value)

    @field_validator("quantities", mode="before")
    @classmethod
    def _quantities(cls, value: Any, info: ValidationInfo) -> Any:
        return chosen_quantities(value, info.data.get("models", ()))


def chosen_models(value: Any) -> tuple[str, ...]:
    """Names of models: one, "a,b", a list, or "all" independent ones.

    Raises InputError for an unknown one.
    """
    named = choices(value, tuple(MODELS), "model", "models")
    return WITNESSES if named == tuple(MODELS) else named


def chosen_quantities(value: Any, models: Sequence[str]) -> tuple[str, ...]:
    """Names of quantities, in the same forms; "all" is what the models give."""
    named = choices(value, tuple(QUANTITIES), "quantity", "quantities")
    return all_given(models) if named == tuple(QUANTITIES) else named


def _usual_quantities(models: Sequence[str]) -> tuple[str, ...]:
    """Quantities of a scene that states none: of the bimorph, if a model of it is asked for."""
    normal = models and all(MODELS[name].actuator == "reluctance" for name in models)
    return quantities_of("reluctance" if normal else "bimorph")


#: Maps by field models that this process has solved or read, by circuit; the oldest goes first.
_FIELD_MAPS: dict[tuple[object, ...], CoenergyMap] = {}
_MOST_MAPS = 32
#: Models of the bimorph that read s11, d31 and eps33 and no other constant of the ceramic's.
_LENGTHWISE = frozenset(("lumped", "tmm", "beam"))


@lru_cache(maxsize=64)
def _held_by_contact(
    device: p.Device, pressed: float, pull: CoenergyMap | None
) -> tuple[RestingPlace, p.Support]:
    """Resting place and springs of a device, found once: they are asked for very often."""
    from tactgen.tmm.generator.equilibrium import held_support

    coil = device.coil
    return held_support(device, pull, abs(coil.current), coil.history, pressed)


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
        if value != {} or key not in _groups():  # an empty group says nothing
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
    """Quantities of a scene; of all of them also what its circuit is there for."""
    asked, every = scene.quantities, all_given(set(scene.models) & set(models_of("bimorph")))
    further = OF_CIRCUIT.get(scene.circuit.kind, ()) if every and {*every} <= {*asked} else ()
    return tuple(dict.fromkeys((*asked, *further)))


def _check_together(scene: Scene) -> None:
    """Refuse values that do not fit together; InputError."""
    if scene.piezo.grows:
        _check_field(scene)
    try:
        if "piezo" in scene.bimorph.own_materials:
            ceramic = scene.device.piezo.ceramic()
            if _reads_tensors(scene):
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


def _reads_tensors(scene: Scene) -> bool:
    """Whether any model of the bimorph that is asked reads more than s11, d31 and eps33."""
    asked = set(scene.models) & set(models_of("bimorph"))
    return scene.support.kind == "rod" or not asked or bool(asked - _LENGTHWISE)


def no_solid(scene: Scene) -> str:
    """Warning of constants that only a solid model would refuse, or ""."""
    if _reads_tensors(scene):
        return ""
    try:
        scene.device.piezo.ceramic().check_admissible()
    except InputError as error:
        return f"a solid model would refuse this ceramic, and the models asked do not: {error}"
    return ""


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
    if bimorph.profiles or bimorph.stepped or scene.support.kind == "rod":
        unable.add("solid")
    if beyond_plain_layers(bimorph):
        unable.add("cad")
    if scene.measurement.below_tip:
        unable.add("lumped")
    return tuple(name for name in scene.models if name not in unable)


@lru_cache
def scene_keys() -> tuple[str, ...]:
    """Every key that a scene may set."""
    keys = []
    for name, info in Scene.model_fields.items():
        group = info.annotation
        if isinstance(group, type) and issubclass(group, p.Parameters):
            keys += [f"{name}.{inner}" for inner in group.model_fields]
        else:
            keys.append(name)
    return tuple(keys)


@lru_cache
def _groups() -> set[str]:
    return {key.split(".", 1)[0] for key in scene_keys() if "." in key}


def is_scene_key(key: str) -> bool:
    """Whether a scene may set a key, that of a listed layer's size among them."""
    group, _, name = key.partition(".")
    return key in scene_keys() or (group == "bimorph" and is_size(name))


def declaration(key: str) -> FieldInfo:
    """Declaration of a scene key."""
    group, _, name = key.partition(".")
    info = Scene.model_fields[group]
    of: Any = info.annotation
    return of.declaration(name) if name else info


def read_as(key: str) -> str:
    """Key that models read: of a layer's size that of all layers."""
    group, _, name = key.partition(".")
    return "bimorph.layers" if group == "bimorph" and is_size(name) else key


def number_keys(scene: Scene) -> tuple[str, ...]:
    """Every key of a scene, and those of its layers' sizes."""
    return (*scene_keys(), *(f"bimorph.{name}" for name in scene.bimorph.layers.sizes))


def check_key(key: str, also: Iterable[str] = ()) -> None:
    """Refuse a key that no scene has, with the nearest one or other name; InputError."""
    if is_scene_key(key):
        return
    known = scene_keys()
    group = key.split(".", maxsplit=1)[0]
    inside = [k for k in known if k.startswith(f"{group}.")]
    if "." not in key and inside:
        raise InputError(
            f'scene key "{key}" is a group, not a value; set one of {", ".join(inside)}'
        )
    if key.startswith("bimorph.layers."):
        raise InputError(
            f"scene key {quoted(key)} is unknown; a layer's sizes are bimorph.layers.NUMBER.SIZE, "
            f"the number from 1 at -x and the size {', '.join(SIZES)}"
        )
    plain = key.replace('"', "")
    close = nearest(plain, (*known, *sorted(_groups()), *also))
    raise InputError(
        f"scene key {quoted(plain)} is unknown{close}; "
        "tactgen init FILE.toml writes a scene with every key"
    )
