"""Scene: device, support, load, drive and wanted quantities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field, PrivateAttr, ValidationInfo, field_validator

from tactgen.geometry import units as u
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.device import parameters as p
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import WholeNumber, quoted
from tactgen.tmm.ports.supports_and_loads import ends_of
from tactgen.validation.catalogue.models import MODELS, WITNESSES, all_given, map_model, models_of
from tactgen.validation.catalogue.quantities import QUANTITIES, quantities_of
from tactgen.validation.scene.files import LONGEST_NAME, choices, parse_frequencies, scene_name
from tactgen.validation.scene.tolerances import Tolerance

if TYPE_CHECKING:
    from tactgen.tmm.generator.equilibrium import RestingPlace
    from tactgen.tmm.reluctance.coenergy_map import CoenergyMap


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


@lru_cache(maxsize=64)
def _held_by_contact(
    device: p.Device, pressed: float, pull: CoenergyMap | None
) -> tuple[RestingPlace, p.Support]:
    """Resting place and springs of a device, found once: they are asked for very often."""
    from tactgen.tmm.generator.equilibrium import held_support

    coil = device.coil
    return held_support(device, pull, abs(coil.current), coil.history, pressed)
