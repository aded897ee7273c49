"""Every quantity by name, read by all commands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.device.parameters import Limits
from tactgen.geometry.units import Unit
from tactgen.tmm.ports.excitation_and_circuit import (
    ELECTRICAL,
    OPEN_CIRCUIT,
    UNIT_VOLTAGE,
    ElectricalResponse,
    Excitation,
)
from tactgen.tmm.ports.readout import MECHANICAL, ModalReadout, PortMatrix, Readout
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD

if TYPE_CHECKING:
    from tactgen.tmm.beam.ceramic_stress import DrivenCeramic


Need = Literal[
    "static", "modes_short", "modes_open", "harmonic", "magnetic_point", "magnetic_map", "rest",
    "small_signal", "machine_poles", "crosstalk", "spread", "neighbours", "load",
]  # fmt: skip
#: The two, the machine that both make, and many of these side by side.
Actuator = Literal["bimorph", "reluctance", "generator", "display"]


#: Kinds of answer, each with its actuator and its name in words.
NEEDS: dict[Need, tuple[Actuator, str]] = {
    "static": ("bimorph", "a static value"),
    "modes_short": ("bimorph", "short-circuit modes"),
    "modes_open": ("bimorph", "open-circuit modes"),
    "harmonic": ("bimorph", "the response at given frequencies"),
    "load": ("bimorph", "what the tip touches"),
    "magnetic_point": ("reluctance", "the magnetic circuit at one current and gap"),
    "magnetic_map": ("reluctance", "the magnetic circuit over the stroke"),
    "rest": ("reluctance", "where the rod rests"),
    "small_signal": ("generator", "the machine's response at given frequencies"),
    "machine_poles": ("generator", "the poles of the rod and its coil"),
    "crosstalk": ("display", "what one unit moves at the others"),
    "spread": ("display", "how far the units differ"),
    "neighbours": ("display", "the field between neighbouring units"),
}


@dataclass(frozen=True)
class AnswerReadout:
    """A value with its error bar, as a model's answer holds it."""

    need: Need  #: The answer that is asked for
    #: Takes the answer, gives a :class:`validation.models.model.Estimate`
    of: Callable[[Any], Any]


@dataclass(frozen=True)
class DrivenReadout:
    """Load of ceramic and amplifier of the driven bimorph."""

    #: Takes a :class:`tmm.beam.ceramic_stress.DrivenCeramic` and the scene's limits, gives an array
    #: (n,) over the frequencies
    of: Callable[[Any, Limits], Any]
    under: Excitation | None = None  #: The scene's if None


@dataclass(frozen=True)
class LoadReadout:
    """Value of the load at the tip."""

    #: Takes the load's dynamic stiffness (n,) in N/m, the tip's displacement (n,) in m at the drive
    #: voltage and the angular frequency (n,) in rad/s, gives an array (n,)
    of: Callable[[Complex, Complex, Floats], Any]


@dataclass(frozen=True)
class CircuitReadout:
    """Value of the circuit across the electrodes, (n,) over the frequencies."""

    of: Callable[[ElectricalResponse], Floats]


@dataclass(frozen=True)
class QuantityRow:
    """One quantity that can be asked for."""

    #: Name in the interface, SI unit, one line of explanation
    name: str
    unit: str
    meaning: str
    #: How it is read off a model; all that follows from it are properties
    read: (
        Readout | ModalReadout | PortMatrix | AnswerReadout | DrivenReadout | LoadReadout
        | CircuitReadout
    )  # fmt: skip
    label: str = ""  #: What people call it; the name in words if left out
    headline: bool = False  #: Whether it stands at the head of a report
    by_name: bool = False  #: Whether it is computed only where it is asked for by name
    #: Whether studies of uncertainty look at it: a response at a few frequencies, of modes the
    #: first
    varied: bool = False
    is_limit: bool = False  #: Whether its least value over a band counts, not its largest
    peak_of: str = ""  #: Response at whose largest value over a band it counts, if not at its own
    #: If it can be measured as a frequency response: what its column is called, and the magnitudes
    #: that can be meant
    curve: Unit | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "label", self.label or self.name.replace("_", " "))

    @cached_property
    def needs(self) -> tuple[Need, ...]:
        """Answers of a model that it is computed from."""
        match self.read:
            case Readout(static=True):
                return ("static",)
            case ModalReadout(circuits=circuits):
                of: dict[str, Need] = {"short": "modes_short", "open": "modes_open"}
                return tuple(of[circuit] for circuit in circuits)
            case AnswerReadout(need=need):
                return (need,)
            case _:
                return ("harmonic",)

    @cached_property
    def port_readout(self) -> Readout:
        """Readout from terminated ports, if there is one."""
        assert isinstance(self.read, Readout), f"{self.name} is not read off terminated ports"
        return self.read

    @cached_property
    def actuator(self) -> Actuator:
        """Actuator that the quantity belongs to."""
        return NEEDS[self.needs[0]][0]

    @cached_property
    def by_frequency(self) -> bool:
        """Whether it is an array over the frequencies asked for."""
        return bool({"harmonic", "small_signal", "crosstalk", "load"} & set(self.needs))

    @cached_property
    def static(self) -> bool:
        """Whether it is a value at 0 Hz."""
        return "static" in self.needs

    @cached_property
    def loaded(self) -> bool:
        """Whether the tip's load enters with its losses."""
        if isinstance(self.read, Readout):
            return self.read.is_loaded
        driven = isinstance(self.read, DrivenReadout | LoadReadout | CircuitReadout)
        return driven or bool({"small_signal", "crosstalk", "load"} & set(self.needs))

    @cached_property
    def held_by_support(self) -> bool:
        """Whether only the support keeps the actuator from moving as a rigid body."""
        if isinstance(self.read, Readout):
            return self.read.has_free_ports
        return isinstance(self.read, DrivenReadout | LoadReadout | CircuitReadout)

    @cached_property
    def has_level(self) -> bool:
        """Whether it is held against a level, which is stated in a range only."""
        return isinstance(self.read, Readout) and self.read.level is not None

    @cached_property
    def is_response(self) -> bool:
        """Whether it is one number at each frequency of the bimorph's drive."""
        return self.needs == ("harmonic",) and not isinstance(self.read, PortMatrix)

    @cached_property
    def is_amplitude(self) -> bool:
        """Whether it is the amplitude of a sinusoid under the scene's excitation."""
        match self.read:
            case Readout(static=False, level=None, under=None):
                return True
            case DrivenReadout():
                return not self.is_limit
            case LoadReadout():
                return self.unit == "N"
        return False

    @cached_property
    def is_transduced(self) -> bool:
        """Whether it is nothing without piezoelectricity."""
        return isinstance(self.read, Readout | ModalReadout) and self.read.is_transduced


#: What limits the voltage, in the order of :func:`voltage_limits`.
REASONS = ("the ceramic's strength", "the field against the poling", "the amplifier's current")


def voltage_limits(driven: DrivenCeramic, limits: Limits) -> Floats:
    """Voltage (3, n) at which each of :data:`REASONS` is reached (V), of a ceramic driven by 1 V.

    Infinite where nothing is strained or drawn, or where the stress is not known.
    """
    share = limits.amplifier_current / limits.amplifier_channels
    with np.errstate(divide="ignore"):
        strength = limits.ceramic_strength / np.abs(driven.stress)
        found = np.broadcast_arrays(
            np.where(np.isnan(strength), np.inf, strength),
            limits.depoling_field / driven.field,
            np.abs(share) / driven.current,
        )
    return np.asarray(found)


#: Largest plausible magnitude of any measured curve (SI).
_LARGEST = 1e3


def coupling_factor(short: Any, opened: Any) -> Any:
    """Electromechanical coupling factor of a mode from its two frequencies."""
    return np.sqrt(np.maximum(1.0 - (short / opened) ** 2, 0.0))


def coupling_rounding(value: float, of: float) -> float:
    """Error of a coupling factor from relative rounding of both frequencies.

    k² is the difference of nearly equal numbers, and k its root, also where nothing is left of it.
    """
    square, off = value**2, 2.0 * (1.0 - value**2) * of
    return float(max(np.sqrt(square + off) - value, value - np.sqrt(max(square - off, 0.0))))


TIP_DISPLACEMENT = QuantityRow(
    "tip_displacement", "m", "lateral displacement of the tip under the drive",
    Readout("w_tip", "motion"), varied=True,
    curve=Unit("m", "displacement", "12.3 um", limits=(1e-15, _LARGEST)),
)  # fmt: skip
TIP_VELOCITY = QuantityRow(
    "tip_velocity", "m/s", "lateral velocity of the tip under the drive",
    Readout("w_tip", "motion", rate=1),
    curve=Unit("m/s", "velocity", "12.3 mm/s", limits=(1e-12, _LARGEST)),
)  # fmt: skip
ADMITTANCE = QuantityRow(
    "admittance", "S", "input current per drive voltage",
    Readout(ELECTRICAL, "effort", rate=1, under=UNIT_VOLTAGE),
    curve=Unit("S", "admittance", "12.3 uS", limits=(1e-15, _LARGEST)),
)  # fmt: skip
STATIC_TIP_DISPLACEMENT = QuantityRow(
    "static_tip_displacement", "m", "tip displacement at 0 Hz, lossless, no finger",
    Readout("w_tip", "motion", static=True), headline=True, varied=True,
)  # fmt: skip
SHORT_CIRCUIT_FREQUENCIES = QuantityRow(
    "short_circuit_frequencies", "Hz", "natural frequencies in short circuit, lossless, no finger",
    ModalReadout(("short",)), label="first frequency, short circuit", headline=True, varied=True,
)  # fmt: skip
OPEN_CIRCUIT_FREQUENCIES = QuantityRow(
    "open_circuit_frequencies", "Hz", "natural frequencies in open circuit, lossless, no finger",
    ModalReadout(("open",)), label="first frequency, open circuit", varied=True,
)  # fmt: skip
COUPLING_FACTOR = QuantityRow(
    "coupling_factor", "1", "sqrt(1 - (f_short/f_open)^2) of the first bending mode in x",
    ModalReadout(("short", "open"), coupling_factor, coupling_rounding), varied=True,
)  # fmt: skip
CAPACITANCE_FREE = QuantityRow(
    "capacitance_free", "F", "static charge per voltage, tip free, lossless",
    Readout(ELECTRICAL, "effort", static=True, under=UNIT_VOLTAGE),
    label="free capacitance", headline=True, varied=True,
)  # fmt: skip
CAPACITANCE_BLOCKED = QuantityRow(
    "capacitance_blocked", "F", "static charge per voltage, base and tip held, lossless",
    Readout(ELECTRICAL, "effort", static=True, under=UNIT_VOLTAGE, held=MECHANICAL),
    label="blocked capacitance",
)  # fmt: skip

CERAMIC_STRESS = QuantityRow(
    "ceramic_stress", "Pa",
    "largest stress amplitude along the ceramic, by beam theory from the tip's motion",
    DrivenReadout(lambda driven, _: driven.stress),
)  # fmt: skip
VOLTAGE_LIMIT = QuantityRow(
    "voltage_limit", "V",
    "voltage that alone reaches the first limit: strength, depoling field, amplifier current",
    DrivenReadout(
        lambda driven, limits: np.min(voltage_limits(driven, limits), axis=0), under=UNIT_VOLTAGE
    ),
    is_limit=True,
)  # fmt: skip


ELECTRODE_VOLTAGE = QuantityRow(
    "electrode_voltage", "V", "voltage across the electrodes",
    Readout(ELECTRICAL, "motion"), by_name=True,
)  # fmt: skip
CIRCUIT_POWER = QuantityRow(
    "circuit_power", "W", "mean power into the circuit's resistance",
    CircuitReadout(lambda found: found.power), by_name=True,
)  # fmt: skip


def _sensed(
    of: Literal["voltage", "charge"], unit: str, per: str, excitation: Excitation
) -> QuantityRow:
    """Row of a sensor: the open electrodes' voltage, or the charge in short circuit."""
    under, electrodes = excitation, "short-circuited"
    if of == "voltage":
        under, electrodes = replace(excitation, circuit=OPEN_CIRCUIT), "open"
    read = Readout(ELECTRICAL, "motion" if of == "voltage" else "effort", under=under)
    meaning = f"{of} of the {electrodes} electrodes per {per}"
    return QuantityRow(f"{of}_per_{per.rsplit(maxsplit=1)[-1]}", unit, meaning, read, by_name=True)


_FORCE, _ACCELERATION = Excitation(force=1.0), Excitation(acceleration=1.0)
_SENSORS = (
    QuantityRow("tip_acceleration", "m/s^2",
        "absolute acceleration of the tip, that of the base included",
        Readout("w_tip", "motion", rate=2, absolute=True), by_name=True),
    ELECTRODE_VOLTAGE,
    CIRCUIT_POWER,
    QuantityRow("optimum_resistance", "ohm",
        "resistance across the electrodes that takes the most power",
        CircuitReadout(lambda found: found.optimum_resistance), by_name=True,
        peak_of="optimum_power"),
    QuantityRow("optimum_power", "W",
        "mean power into the optimum resistance, by tip force and acceleration",
        CircuitReadout(lambda found: found.optimum_power), by_name=True),
    _sensed("voltage", "V/N", "tip force", _FORCE),
    _sensed("charge", "C/N", "tip force", _FORCE),
    _sensed("voltage", "V*s^2/m", "base acceleration", _ACCELERATION),
    _sensed("charge", "C*s^2/m", "base acceleration", _ACCELERATION),
)  # fmt: skip

_BIMORPH = (
    TIP_DISPLACEMENT,
    TIP_VELOCITY,
    QuantityRow("tip_rotation", "rad", "section rotation psi of the tip (about -dw/dz)",
        Readout("psi_tip", "motion")),
    QuantityRow("input_current", "A", "current drawn at the drive voltage",
        Readout(ELECTRICAL, "effort", rate=1),
        curve=Unit("A", "current", "12.3 uA", limits=(1e-15, _LARGEST))),
    ADMITTANCE,
    QuantityRow("blocked_force", "N", "force that holds the tip, rotation free",
        Readout("w_tip", "effort", held=("w_tip",))),
    QuantityRow("threshold_voltage", "V",
        "voltage that alone moves the tip by the detection threshold",
        Readout("w_tip", "motion", under=UNIT_VOLTAGE, level=DISPLAY_THRESHOLD.at)),
    QuantityRow("detection_ratio", "1",
        "tip displacement under the drive over the detection threshold",
        Readout("w_tip", "motion", level=DISPLAY_THRESHOLD.at)),
    STATIC_TIP_DISPLACEMENT, SHORT_CIRCUIT_FREQUENCIES, OPEN_CIRCUIT_FREQUENCIES, COUPLING_FACTOR,
    CAPACITANCE_FREE, CAPACITANCE_BLOCKED,
    QuantityRow("dynamic_stiffness", "SI",
        "5x5 matrix [F_base, M_base, F_tip, M_tip, Q] per [w_base, psi_base, w_tip, psi_tip, U]",
        PortMatrix()),
    CERAMIC_STRESS,
    VOLTAGE_LIMIT,
    QuantityRow("load_impedance", "N*s/m", "lateral impedance of the load, force per velocity",
        AnswerReadout("load", attrgetter("impedance"))),
    QuantityRow("load_force", "N", "force of the tip on the load at the drive voltage",
        LoadReadout(lambda stiffness, tip, _: stiffness * tip)),
    QuantityRow("load_power", "W", "mean power into the load at the drive voltage",
        LoadReadout(lambda stiffness, tip, omega: 0.5 * omega * stiffness.imag * np.abs(tip) ** 2)),
)  # fmt: skip


def _answer(
    need: Need, name: str, unit: str, meaning: str, of: str | Callable[[Any], Any], **more: Any
) -> QuantityRow:
    """Quantity that an answer holds, by the name of its attribute or what reads it off."""
    read = attrgetter(of) if isinstance(of, str) else of
    return QuantityRow(name, unit, meaning, AnswerReadout(need, read), **more)


MAGNETIC_FORCE = _answer(
    "magnetic_point", "magnetic_force", "N",
    "magnetic force between rod and sleeve at the coil current and the "
    "gap", "force", label="magnetic force", headline=True,
)  # fmt: skip
FLUX_LINKAGE = _answer(
    "magnetic_point", "flux_linkage", "Wb", "flux linkage of the winding, all turns",
    "flux_linkage",
)  # fmt: skip
PULL_IN_CURRENT = _answer(
    "magnetic_map", "pull_in_current", "A", "smallest current that moves the rod to its lower stop",
    "pull_in", label="pull-in current", headline=True,
)  # fmt: skip

_RELUCTANCE = (
    MAGNETIC_FORCE,
    FLUX_LINKAGE,
    _answer("magnetic_point", "coenergy", "J", "magnetic co-energy", "coenergy", label="co-energy"),
    _answer("magnetic_point", "inductance", "H", "apparent inductance, flux linkage / current",
            "inductance", headline=True),
    _answer("magnetic_point", "incremental_inductance", "H",
            "d flux linkage / d current, gap held", "incremental_inductance"),
    PULL_IN_CURRENT,
    _answer("magnetic_map", "holding_current", "A",
            "smallest current that holds the rod at its lower stop", "holding"),
    _answer("magnetic_map", "drop_out_current", "A",
            "current below which the rod returns to its upper stop", "drop_out",
            label="drop-out current"),
    _answer("rest", "rod_position", "m",
        "equilibrium of the rod at the coil current and its history; 0 at the upper "
        "stop, negative below", "position", headline=True),
    _answer("rest", "finger_force", "N",
        "spring force minus magnetic force at the equilibrium; negative in the lower "
        "position", "finger_force", headline=True),
    _answer("rest", "contact_force", "N",
            "contact force between head and stop at the equilibrium, 0 between the "
            "stops", "contact_force"),
    _answer("rest", "resting_positions", "m",
        "all equilibria of the rod at the coil current, stable and unstable, from the "
        "top", "places"),
)  # fmt: skip

_GENERATOR = (
    _answer("small_signal", "lateral_tip_per_voltage", "m/V",
            "lateral motion of the tip per volt of the bimorph",
            lambda machine: machine.by_voltage("w_tip")),
    _answer("small_signal", "axial_tip_per_voltage", "m/V",
            "axial motion of the tip per volt of the bimorph; 0 for an upright head",
            lambda machine: machine.by_voltage("u")),
    _answer("small_signal", "axial_tip_per_current", "m/A",
            "axial motion of the tip per ampere of the coil, at constant bimorph voltage",
            lambda machine: machine.by_current("u")),
    _answer("small_signal", "lateral_tip_per_current", "m/A",
        "lateral motion of the tip per ampere of the coil; 0 for an upright head",
            lambda machine: machine.by_current("w_tip")),
    _answer("small_signal", "axial_tip_per_coil_voltage", "m/V",
        "axial motion of the tip per volt of the coil circuit",
            lambda machine: machine.by_coil_voltage("u")),
    _answer("small_signal", "coil_impedance", "ohm",
        "impedance of the coil with its source resistance and the motional voltage",
            lambda machine: machine.impedance(),
            curve=Unit("ohm", "impedance", "12.3 ohm", limits=(1e-9, 1e12))),
    _answer("machine_poles", "axial_poles", "rad/s",
            "poles of axial motion and coil circuit, without rocking", "listed"),
)  # fmt: skip

CROSSTALK_LARGEST = _answer(
    "crosstalk", "crosstalk_largest", "1",
    "largest lateral motion of another tip over that of the driven tip", "largest",
)  # fmt: skip

_DISPLAY = (
    _answer("crosstalk", "crosstalk_beside", "1",
        "lateral motion of the next tip along x over that of the driven tip", "beside"),
    _answer("crosstalk", "crosstalk_behind", "1",
        "lateral motion of the next tip along y over that of the driven tip", "behind"),
    CROSSTALK_LARGEST,
    _answer("crosstalk", "crosstalk_by_board", "1",
            "the same without skin, through the upper board alone", "by_board"),
    _answer("spread", "unit_frequencies", "Hz",
            "first natural frequency of each sampled unit, row by row",
            "as_drawn"),
    _answer("spread", "frequency_spread", "Hz",
            "range of the first natural frequencies of the units", "apart"),
    _answer("spread", "screw_turns", "1",
        "turn of each grub screw that tunes its unit to the median; positive tightens", "screws"),
    _answer("spread", "tuned_spread", "Hz", "range of the first natural frequencies after tuning",
            "left_apart"),
    _answer("spread", "tuning_range", "Hz",
        "range of the first natural frequency over the travel of a grub screw", "reach"),
    _answer("neighbours", "pull_all_driven", "N",
        "magnetic force of a unit in an endless array, all coils driven with one "
        "polarity", "same"),
    _answer("neighbours", "pull_alternating", "N",
            "the same with polarities as on a chessboard", "alternating"),
    _answer("neighbours", "magnetic_crosstalk", "N/A",
        "change of the magnetic force per ampere in the four nearest neighbours", "per_neighbour"),
    _answer("neighbours", "pull_one_driven", "N",
        "magnetic force of one driven unit among units without current", "single"),
    _answer("neighbours", "passive_pull", "N",
        "magnetic force of an undriven unit beside a driven one; negative: lifted", "passive"),
)  # fmt: skip

QUANTITIES: dict[str, QuantityRow] = {
    q.name: q for q in (*_BIMORPH, *_SENSORS, *_RELUCTANCE, *_GENERATOR, *_DISPLAY)
}


#: What is about the voltage of a source at the electrodes, or what fingers feel of one.
OF_A_SOURCE = (VOLTAGE_LIMIT.name, *(row.name for row in QUANTITIES.values() if row.has_level))
#: What a circuit across the electrodes is there for, by its kind.
OF_CIRCUIT: dict[str, tuple[str, ...]] = {
    "load": (ELECTRODE_VOLTAGE.name, CIRCUIT_POWER.name), "open": (ELECTRODE_VOLTAGE.name,),
}  # fmt: skip


def quantities_of(actuator: Actuator) -> tuple[str, ...]:
    """Names of an actuator's quantities, but for those that must be named."""
    own = (row for row in QUANTITIES.values() if row.actuator == actuator)
    return tuple(row.name for row in own if not row.by_name)


def measurable() -> dict[str, QuantityRow]:
    """Quantities that can be measured as a response, by the column's name."""
    return {row.curve.kind: row for row in QUANTITIES.values() if row.curve is not None}
