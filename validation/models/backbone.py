"""The response over frequency at several voltages, and the backbone through its peaks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Bools, Complex, Floats
from tactgen.geometry.device.checks import check_one_plane
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import share
from tactgen.geometry.store.store import cached_result
from tactgen.geometry.store.values import storable
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.generator.equilibrium import History, axial_forces, resting_place
from tactgen.tmm.generator.small_signal import RockingHead, rocking_head
from tactgen.tmm.harmonic_balance.balance import NoConvergence, Orbit
from tactgen.tmm.harmonic_balance.continuation import (
    Branch,
    SpecialPoint,
    folds,
    follow,
    peaks,
    steady_orbit,
)
from tactgen.tmm.harmonic_balance.steady import (
    Resolution,
    equilibrium,
    resolved,
    unstable_exponents,
)
from tactgen.tmm.ports.multiport import Multiport, wired
from tactgen.tmm.ports.readout import measured
from tactgen.tmm.ports.supports_and_loads import ends_of
from tactgen.validation.models.classes import map_of
from tactgen.validation.scene.inputs import values_read
from tactgen.validation.scene.scene import Scene

#: Harmonics are added until those left out would move less than this share.
RESOLUTION = Resolution(missing=1e-3, least=5, most=60)
#: Every so many points the unstable exponents are counted; where two counts differ, at all between.
_STRIDE = 6
#: Instants of a period at which the contact is looked at.
_INSTANTS = 256
#: Points of the finer branch by which a peak is judged, and how far it begins before the peak.
_JUDGED_POINTS, _BEFORE = 40, 2


@storable
@dataclass(frozen=True)
class Peak:
    """Where the tip's velocity is largest, in its first harmonic."""

    #: Hz; the bar is the change with twice the harmonics and a tenth of what was missing
    frequency: float
    frequency_bar: float
    #: m/s
    velocity: float
    velocity_bar: float
    displacement: float  #: m
    #: Largest moment on the contact over that at which the head stands on its edge
    moment_share: float


@storable
@dataclass(frozen=True)
class Curve:
    """The response at one voltage, in the order in which it was met."""

    voltage: float  #: Amplitude (V)
    frequencies: Floats  #: (n,) Hz
    displacement: Complex  #: (n,) complex First harmonic of the tip (m)
    stable: Bools  #: (n,) Whether the orbit is stable
    peaks: tuple[Peak, ...]  #: All peaks of the velocity, the largest first
    #: Frequencies at which the curve turns back (Hz), in the order in which they are met
    folds: tuple[float, ...]
    harmonics: int  #: Most harmonics taken
    missing: float  #: Largest share of a motion that they left out
    ended: str  #: Why the curve ends inside the range; empty if it does not


@dataclass(frozen=True)
class Backbone:
    """Curves by growing voltage, with their labels."""

    head: RockingHead
    curves: tuple[Curve, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the curves."""
        found = []
        for curve in self.curves:
            if curve.ended:
                found.append(f"at {curve.voltage:g} V {curve.ended}")
            if curve.missing > RESOLUTION.missing:
                found.append(
                    f"at {curve.voltage:g} V {curve.harmonics} harmonics leave out up to "
                    f"{share(curve.missing)} of the motion"
                )
        return tuple(found)


def backbone(
    head: RockingHead,
    voltages: Sequence[float],
    band: tuple[float, float],
    announce: Callable[[str], None] = lambda _: None,
) -> Backbone:
    """Response over a band of frequencies (Hz) at each voltage (V).

    Raises InputError if no steady oscillation is found at the band's lower end.
    """
    return Backbone(head, tuple(response_curve(head, u, band, announce) for u in sorted(voltages)))


def response_curve(
    head: RockingHead,
    voltage: float,
    band: tuple[float, float],
    announce: Callable[[str], None] = lambda _: None,
) -> Curve:
    """Response over a band of frequencies (Hz) at one voltage (V); refusals as above."""
    branch = response_branch(head, voltage, band, announce)
    turns = folds(head.oscillator, branch)
    announce(f"backbone: {voltage:g} V, stability")
    found = [_peak(head, branch, at) for at in peaks(head.oscillator, branch, speed(head))]
    orbits = branch.orbits
    return Curve(
        voltage=voltage,
        frequencies=np.array([o.frequency for o in orbits]),
        displacement=np.array([measured(head.response(o).motion)[1] for o in orbits]),
        stable=_stable(head, branch),
        peaks=tuple(sorted(found, key=lambda p: -p.velocity)),
        folds=tuple(at.orbit.frequency for at in turns),
        harmonics=max(o.harmonics for o in orbits),
        missing=branch.missing,
        ended=branch.ended,
    )


def response_branch(
    head: RockingHead,
    voltage: float,
    band: tuple[float, float],
    announce: Callable[[str], None] = lambda _: None,
) -> Branch:
    """Orbits over a band of frequencies (Hz) at one voltage (V); refusals as above."""
    announce(f"backbone: {voltage:g} V")
    low, high = (2.0 * np.pi * f for f in band)

    def shown(orbit: Orbit) -> None:
        announce(f"backbone: {voltage:g} V, {orbit.frequency:.4g} Hz, {orbit.harmonics} harmonics")

    try:
        start = steady_orbit(head.oscillator, low, voltage, resolution=RESOLUTION)
    except NoConvergence as error:
        raise InputError(
            f"at --voltage {voltage:g} V no response was found to begin with: {error}; begin at "
            "another --frequency, or with less voltage"
        ) from None
    return follow(head.oscillator, start, "omega", low, high, resolution=RESOLUTION, announce=shown)


def speed(head: RockingHead) -> Callable[[Orbit], complex]:
    """Readout of the tip velocity's first harmonic (m/s) off an orbit."""
    return lambda o: 1j * o.omega * complex(measured(head.response(o).motion)[1])


def moment_share(head: RockingHead, orbit: Orbit) -> float:
    """Largest moment on the contact over that at which the head stands on its edge."""
    _, moment = head.contact(orbit, _INSTANTS)
    return float(np.abs(moment).max() / head.stops.upper.tipping_moment(head.place.contact_force))


def _peak(head: RockingHead, branch: Branch, at: SpecialPoint) -> Peak:
    orbit, judge = at.orbit, _judge(head, branch, at)
    size, nan = abs(speed(head)(orbit)), float("nan")
    return Peak(
        frequency=orbit.frequency,
        frequency_bar=abs(judge.frequency - orbit.frequency) if judge else nan,
        velocity=size,
        velocity_bar=abs(abs(speed(head)(judge)) - size) if judge else nan,
        displacement=size / orbit.omega,
        moment_share=moment_share(head, orbit),
    )


def _judge(head: RockingHead, branch: Branch, at: SpecialPoint) -> Orbit | None:
    """Peak again, met on a finer branch; None if that misses it."""
    begin = branch.steps[max(0, at.after - _BEFORE)]
    fine = Resolution(0.1 * RESOLUTION.missing, 2 * at.orbit.harmonics, 2 * RESOLUTION.most)
    try:
        start = resolved(head.oscillator, begin.orbit, fine)
        again = follow(
            head.oscillator, start, "omega", begin.course.low, begin.course.high,
            direction=1 if begin.tangent[-1] > 0.0 else -1, resolution=fine, most=_JUDGED_POINTS,
        )  # fmt: skip
        found = peaks(head.oscillator, again, speed(head))
    except NoConvergence:
        return None
    return found[0].orbit if found else None


def _stable(head: RockingHead, branch: Branch) -> Bools:
    """Mask of stable orbits; between two near ones that agree, all are taken as they are."""
    orbits = branch.orbits
    counts: dict[int, int | None] = {}

    def count(i: int) -> int | None:
        if i not in counts:
            counts[i] = unstable_exponents(head.oscillator, orbits[i])
        return counts[i]

    stable = np.empty(len(orbits), dtype=bool)
    marks = [*range(0, len(orbits) - 1, _STRIDE), len(orbits) - 1]
    for first, last in zip(marks, [*marks[1:], marks[-1]], strict=True):
        alike = count(first) == count(last)
        for i in range(first, last + 1):
            stable[i] = (count(first) if alike else count(i)) == 0
    return stable


State = Literal["not activated", "held"]
#: Current (A) and history of the two states in which the paper measured.
COILS: dict[State, tuple[float, History]] = {
    "not activated": (0.0, "rising"),
    "held": (50e-3, "falling"),
}
#: What a scene says of them.
STATES: dict[State, tuple[str, ...]] = {
    state: (f"coil.current={1e3 * current:g}mA", f"coil.history={history}")
    for state, (current, history) in COILS.items()
}


def in_state(scene: Scene, state: State) -> Scene:
    """Scene in one of these states."""
    current, history = COILS[state]
    coil = scene.coil.model_copy(update={"current": current, "history": history})
    return scene.model_copy(update={"coil": coil})


def held_head(scene: Scene, model: str = "tmm") -> RockingHead:
    """Bimorph on the head that a stop carries.

    Raises InputError if the support is no contact, or the rod touches no stop.
    """
    if scene.support.kind != "contact":
        raise InputError(
            f"support.kind = {scene.support.kind} in scene {scene.name} is linear, so that nothing "
            "depends on amplitude; --set support.kind=contact holds the bimorph by the rod's head "
            "on its stop"
        )
    device, current = scene.device, abs(scene.coil.current)
    check_one_plane(device, "harmonic balance")
    pull = map_of(scene) if current else None
    forces = axial_forces(device, pull, scene.load.normal_force)
    place = resting_place(forces, current, scene.coil.history)
    if place.kind == "floating":
        raise InputError(
            f"coil.current = {1e3 * scene.coil.current:g} mA leaves the rod between its stops, "
            "where no contact holds the head; use 0 mA, or one that pulls it down"
        )
    free = scene.support.model_copy(update={"kind": "spring"})
    tip = ends_of(free, scene.load).tip
    return rocking_head(five_port(scene, model), tip, forces, place, current, bimorph_mass(scene))


def check_one_field(scene: Scene, voltages: Sequence[float]) -> None:
    """Refuse voltages (V) at which the ceramic of a scene would be another one."""
    others = [v for v in voltages if v != abs(scene.drive.voltage)]
    if scene.piezo.grows and others:
        raise InputError(
            f"{others[0]:g} V is another field than that of drive.voltage = "
            f"{scene.drive.voltage:g} V, with which piezo.field_growth_d31 and its like change the "
            "ceramic; ask for one voltage, that of drive.voltage"
        )


def bimorph_mass(scene: Scene) -> float:
    """Mass of a scene's row of beams (kg)."""
    row = transfer_matrix.sections(scene.device, scene.support, scene.beam, lossy=False)
    return float(sum(getattr(section, "m", 0.0) * length for section, length in row))


#: Far beyond the moment that tips the head the contact is nearly a kink; harmonics left out may
#: move this share there.
_RESOLUTION = Resolution(missing=3e-3, least=5, most=60)
#: Frequencies, evenly spaced, to which a line is fitted.
_FITTED = 300


@storable
@dataclass(frozen=True)
class LoadedDeflection:
    """First harmonic of the tip under load over frequency, in the order in which it was met."""

    frequencies: Floats  #: (n,) Hz
    displacement: Complex  #: (n,) complex m
    ended: str  #: Why it ends inside the band; empty if it does not

    @property
    def fitted_slope(self) -> float:
        """Slope (m/Hz) of the line fitted to its magnitude at evenly spaced frequencies."""
        at = np.linspace(self.frequencies[0], self.frequencies[-1], _FITTED)
        sizes = np.interp(at, self.frequencies, np.abs(self.displacement))
        return float(np.polyfit(at, sizes, 1)[0])


def loaded_deflection(
    head: RockingHead,
    voltage: float,
    band: tuple[float, float],
    announce: Callable[[str], None] = lambda _: None,
) -> LoadedDeflection:
    """Response to a large voltage (V) over a band (Hz).

    The voltage is raised at the lower end, then the frequency.

    Raises InputError if the response cannot be followed up to that voltage.
    """
    raised = _raised(head, band[0], voltage)
    announce(f"deflection at {voltage:g} V")
    low, high = (2.0 * np.pi * f for f in band)
    start = replace(raised[-1], omega=low)
    branch = follow(head.oscillator, start, "omega", low, high, resolution=_RESOLUTION)
    return LoadedDeflection(
        frequencies=np.array([o.frequency for o in branch.orbits]),
        displacement=np.array([_tip(head, o) for o in branch.orbits]),
        ended=branch.ended,
    )


def voltage_for(head: RockingHead, frequency: float, displacement: float, most: float) -> float:
    """Lowest voltage (V) at which the tip's first harmonic reaches a displacement (m).

    Straight between the points of the branch, which are a few percent apart at most.

    Raises InputError if it is not reached up to `most`, or the response cannot be followed so far.
    """
    orbits = _raised(head, frequency, most)
    sizes = np.abs([_tip(head, o) for o in orbits])
    after = int(np.argmax(sizes >= displacement))
    if sizes[after] < displacement:
        raise InputError(
            f"{1e6 * displacement:g} um at {frequency:g} Hz is not reached with {most:g} V; ask "
            "for less"
        )
    before = after - 1
    levels = [orbits[i].level for i in (before, after)]
    return float(np.interp(displacement, sizes[before : after + 1], levels))


def _tip(head: RockingHead, orbit: Orbit) -> complex:
    return complex(measured(head.response(orbit).motion)[1])


def _raised(head: RockingHead, frequency: float, voltage: float) -> tuple[Orbit, ...]:
    """Orbits from rest up to a voltage."""
    rest = equilibrium(head.oscillator).with_harmonics(_RESOLUTION.least)
    start = replace(rest, omega=2.0 * np.pi * frequency)
    branch = follow(head.oscillator, start, "level", 0.0, voltage, resolution=_RESOLUTION)
    if branch.ended or branch.orbits[-1].level < voltage:
        raise InputError(
            f"at {frequency:g} Hz the response cannot be followed up to {voltage:g} V "
            f"({branch.ended or 'it leads back to rest'}); ask for less"
        )
    return branch.orbits


#: Scene keys and groups that the answers depend on.
_READS = (
    "bimorph", "measurement", "piezo", "shim", "glue", "beam", "rod", "coil", "sleeve",
    "steel.curve", "gap", "spring", "contact", "guide", "support.kind", "load", "drive", "models",
)  # fmt: skip


@storable
@dataclass(frozen=True)
class RockingState:
    """One state at growing amplitude."""

    state: str  #: ``not activated`` or ``held``
    contact_force: float  #: What presses the head on its stop (N), nan if there is no such state
    curves: tuple[Curve, ...]  #: Free tip, by growing voltage
    #: Under the scene's load at the drive voltage; None where the tip is free anyway
    deflection: LoadedDeflection | None
    refused: str = ""  #: Why something of it is missing; empty if nothing is


def rocking_states(
    scene: Scene, voltages: Sequence[float], announce: Callable[[str], None] = lambda _: None
) -> tuple[RockingState, ...]:
    """Both states of a scene on the rod's contact, by the transfer-matrix model.

    Kept in the store: each takes about half a minute.  Voltages (V) are of the free tip's curves.
    """
    found = []
    for state in COILS:
        made = in_state(scene, state)
        inputs = (values_read(made, _READS), _band(made), tuple(voltages))

        def work(made: Scene = made, state: State = state) -> RockingState:
            return _state(made, state, voltages, announce)

        found.append(cached_result("amplitude", inputs, (__name__,), work, announce=announce))
    return tuple(found)


def _state(
    scene: Scene, state: State, voltages: Sequence[float], announce: Callable[[str], None]
) -> RockingState:
    free = scene.model_copy(update={"load": scene.load.model_copy(update={"kind": "none"})})
    curves: tuple[Curve, ...] = ()
    deflection = None
    force = float("nan")
    try:
        head = held_head(free)
        force = head.place.contact_force
        check_one_field(scene, voltages)
        announce(f"amplitude, {state}")
        curves = backbone(head, voltages, _band(scene), announce).curves
        if scene.load.kind != "none":
            volts = abs(scene.drive.voltage)
            deflection = loaded_deflection(held_head(scene), volts, _band(scene), announce)
    except InputError as error:
        return RockingState(state, force, curves, deflection, str(error))
    return RockingState(state, force, curves, deflection)


def _band(scene: Scene) -> tuple[float, float]:
    positive = [f for f in scene.frequency if f > 0.0]
    return min(positive), max(positive)


FivePort = Callable[[Floats], Multiport]


def five_port(scene: Scene, model: str) -> FivePort:
    """Bimorph over its ports, with losses and wired as it is, support and load apart.

    Returns
    -------
    callable
        From frequencies (n,) in Hz.  A solid is reduced for the scene's frequencies and their
        lower harmonics.

    Raises InputError if it is no model of the lateral actuator.
    """
    makers = {"tmm": _row, "lumped": _row, "beam": _beam, "solid": _solid, "cad": _solid}
    if model not in makers:
        raise InputError(f'model "{model}" has no ports; use one of {", ".join(makers)}')
    made = makers[model](scene, model)
    return lambda frequencies: wired(made(frequencies), scene.bimorph.wiring)


def _row(scene: Scene, model: str) -> FivePort:
    from tactgen.tmm.beam import lumped, transfer_matrix

    if model == "lumped":
        return lambda f: lumped.multiport(scene.device, scene.support, scene.beam, f, lossy=True)
    parts = scene.device, scene.support, scene.beam
    row = transfer_matrix.sections(*parts, lossy=True, measured=True)
    return lambda f: transfer_matrix.chain(row, f, scene.measurement.below_tip)


def _beam(scene: Scene, _: str) -> FivePort:
    from tactgen.fem import beam

    count = beam.elements_for(scene.device, _highest(scene))
    parts = scene.device, scene.support, scene.beam
    matrices = beam.assemble(*parts, elements=count, lossy=True, measured=True)
    return lambda frequencies: beam.condense(matrices, frequencies)


def _solid(scene: Scene, model: str) -> FivePort:
    from tactgen.fem.piezo.reduction_files import reduced_solid
    from tactgen.validation.models.bimorph.solid import mesh_pair

    # any support: the ports know none
    free = scene.model_copy(
        update={"support": scene.support.model_copy(update={"kind": "clamped"}), "models": (model,)}
    )
    mesh = mesh_pair(free).meshes[0]
    reach = np.array([0.0, _highest(scene)])
    tolerance = 1e-3 * scene.accuracy
    reduced = reduced_solid(scene.device, mesh, reach, tolerance=tolerance)
    return reduced.multiport


#: Harmonics of the highest frequency at which a model must still be right.
_HARMONICS = 5


def _highest(scene: Scene) -> float:
    return _HARMONICS * max(scene.frequency)
