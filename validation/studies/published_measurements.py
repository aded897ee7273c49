"""What the paper measured beside what its device is predicted to do, unknowns left unknown.

The paper leaves open where its laser looked, what each spring was set to and how much of a weight
a tip bore; other numbers are assumed because no source has them.  So a prediction is a band: what
comes out where all of them lie somewhere in their ranges.  Nothing is fitted.  The contact is
linear; the rows ROCK of the book have a head that rocks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import TipLoad
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.transfer_matrix import sections
from tactgen.tmm.generator.contact import moving_rod
from tactgen.tmm.generator.equilibrium import AxialForces, axial_forces, resting_place
from tactgen.tmm.ports.multiport import respond
from tactgen.tmm.ports.readout import measured
from tactgen.tmm.ports.supports_and_loads import attach
from tactgen.tmm.reluctance.map_range import network_map
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.backbone import STATES, State, bimorph_mass, five_port
from tactgen.validation.models.small_signal import ScaledMap
from tactgen.validation.scene.keys import declaration
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.parameter_list import ranges
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.tolerances import unit_of
from tactgen.validation.scene.variation import value_of, with_values

#: Values of the unknowns by name (SI).
Values = Mapping[str, float]

#: Samples of a figure, a power of two; of one with few unknowns.
SAMPLES, _FEW = 128, 32
#: Ranges by which shares of a band's variance are told.
_BINS = 8
#: Stated of the normal actuator (sections 2.2 and 5.1, set-up of Fig 3): working gap, height of
#: both actuators together (m); force of the spring on the finger (N), which the magnet must
#: overcome; currents (A) that pull the rod down, that hold it, that drove it in Fig 16.
GAP, TOTAL_HEIGHT, FORCE = 0.2e-3, 41e-3, 0.11
PULL_IN, HELD, DRIVEN = 0.13, 0.05, 0.12
#: Settings of the spring's preload that are compared (N).
PRELOADS = (80e-3, 90e-3, 100e-3, 110e-3)
#: Amplitude (V) of Fig 15, and its frequencies (Hz).
_VOLTS, _SWEEP = 50.0, np.linspace(10.0, 1000.0, 67)
#: Frequencies (Hz) at which the text on Fig 17 states a threshold and a voltage.
_FELT = np.array([10.0, 250.0, 1000.0])
#: A rod so close to a stop (m) is on it; what takes longer (s) stays.
_NEAR, _LONGEST = 2e-6, 20e-3
#: Name of the factor on the pull of the network.
_PULL = "magnetic pull"


class Unknown(NamedTuple):
    """A number that no source fixes: its range, every place in it alike, and why that range."""

    name: str
    low: float
    high: float
    unit: str
    reason: str
    usual: float  # what answers elsewhere are given for
    logarithmic: bool = False

    def at(self, share: Floats | float) -> Floats:
        """Value at a share of the range."""
        share = np.asarray(share)
        if self.logarithmic:
            return np.asarray(self.low * (self.high / self.low) ** share)
        return np.asarray(self.low + share * (self.high - self.low))


class Published(NamedTuple):
    """A number that the paper prints, or a range in which it says that it lies."""

    words: str
    low: float
    high: float
    unit: str

    @property
    def middle(self) -> float:
        """Middle of the range, or its limit if it begins at 0."""
        return 0.5 * (self.low + self.high) if self.low else self.high

    def off(self, value: Floats | float) -> Floats:
        """Relative distance of values from what is printed, 0 inside."""
        nearest = np.clip(value, self.low, self.high)
        return np.asarray(np.abs(np.asarray(value) - nearest) / np.abs(nearest))


@dataclass(frozen=True)
class Figure:
    """Published numbers that one measurement gave, and the unknowns behind their prediction."""

    title: str
    source: str
    numbers: tuple[Published, ...]
    unknowns: tuple[Unknown, ...]
    #: Gives the numbers' predictions in order
    predict: Callable[[Values], Floats]
    samples: int = SAMPLES


@dataclass(frozen=True)
class Prediction:
    """One number beside its prediction."""

    published: Published
    usual: float  #: At the usual values of all unknowns
    band: tuple[float, float]
    alone: dict[str, tuple[float, float]]  #: What each unknown by itself makes of it
    shares: dict[str, float]  #: Part of the band's variance that each unknown is worth by itself
    by_preload: dict[float, tuple[float, float]]  #: The band at each of :data:`PRELOADS`

    @property
    def covered(self) -> bool:
        """Whether the band and what is published have a value in common."""
        return _meets(self.band, self.published)

    @property
    def widest(self) -> list[str]:
        """Unknowns by what they are worth alone, the most first."""
        return sorted(self.alone, key=lambda name: -float(np.ptp(self.alone[name])))

    def meets(self, preload: float) -> bool:
        """Whether it is covered at a preload."""
        return _meets(self.by_preload[preload], self.published)


@dataclass(frozen=True)
class Comparison:
    """A figure with its predictions."""

    figure: Figure
    predictions: tuple[Prediction, ...]
    #: The sample whose worst number is the least off: its values, and that number's distance
    nearest: dict[str, float]
    worst: float
    worst_by_preload: dict[float, float]  #: That distance at each of :data:`PRELOADS`


def _meets(band: tuple[float, float], published: Published) -> bool:
    return band[0] <= published.high and published.low <= band[1]


PLACE = Unknown(
    "measurement.below_tip", 4e-3, 8e-3, "m",
    "Fig 13: below the support plate and above the upper board; assumed: as seen there", 6e-3,
)  # fmt: skip
_PRELOAD = Unknown(
    "spring.preload", PRELOADS[0], PRELOADS[-1], "N",
    "set by a screw: at most the 110 mN of section 5.1", 110e-3,
)  # fmt: skip
_SHARE = Unknown(
    "load.normal_force", 0.0, 60e-3, "N",
    "of the 490 mN that sixteen tips and the support plate bear: none to twice a sixteenth", 0.0,
)  # fmt: skip
#: A share of the way from small signals (0) to the most that 192 V/mm is assumed to do (1).
_FIELD = Unknown(
    "field in the ceramic", 0.0, 1.0, "1",
    "assumed: at 192 V/mm a soft ceramic has up to 1.4 times the d31, 1.08 times the s11 and 1.5 "
    "times the eps33 of small signals, with the losses of Rayleigh's law", 0.0,
)  # fmt: skip
_LOWEST = Unknown(
    "lowest setting of the spring", 5e-3, 40e-3, "N",
    "section 6: adjusted by its screw, no setting is printed; assumed", 20e-3, logarithmic=True,
)  # fmt: skip
#: Growth (m/V) of the constants at the end of that way.
_GROWTHS = {
    "piezo.field_growth_d31": 0.4 / 192e3, "piezo.field_growth_s11": 0.08 / 192e3,
    "piezo.field_growth_eps33": 0.5 / 192e3,
}  # fmt: skip
_FINGER = Unknown(
    "stiffness of the finger", 1.0, 4.0, "1",
    "over that of 2.5 g: on the display it was pressed with 50 g; assumed: up to four times", 1.0,
    logarithmic=True,
)  # fmt: skip


def _assumed(*keys: str) -> tuple[Unknown, ...]:
    """Unknowns that are scene keys, in the ranges that their sources or assumptions have."""
    scene, found = _scene("not activated", "pad"), []
    known = ranges(scene)
    for key in keys:
        (low, high, reason, _), unit = known[key], unit_of(declaration(key))
        si, wide = unit.si if unit and unit.si else "1", 0.0 < 4.0 * low < high
        found.append(Unknown(key, low, high, si, reason, float(value_of(scene, key)), wide))
    return tuple(found)


@cache
def _scene(state: State, load: str) -> Scene:
    """The paper's 20 mm bimorph on its rod, at 50 V."""
    given = ("support.kind=contact", "models=tmm", f"load.kind={load}", *STATES[state])
    return load_scene("paper", given)[0]


def deflection(state: State, load: str, values: Values, frequencies: Floats) -> Floats:
    """Displacement per volt (n,) in m/V at 50 V where it is measured, the contact linear."""
    keys = {key: value for key, value in values.items() if "." in key}
    if field := values.get(_FIELD.name, 0.0):
        keys |= {key: field * growth for key, growth in _GROWTHS.items()}
    scene = with_values(_scene(state, load), keys)
    ends, stiffer = scene.ends, values.get(_FINGER.name, 1.0)
    law = ends.tip
    if stiffer != 1.0 and not isinstance(law, TipLoad):
        ends = replace(ends, tip=lambda f: stiffer * law(f))
    port = five_port(scene, "tmm")(frequencies)
    motion = respond(attach(port, ends), {"voltage": 1.0}).motion
    return np.asarray(np.abs(measured(motion)))


def _spans(values: Values) -> Floats:
    """Largest and smallest displacement (m) at 50 V, and the line's slope (m/Hz), up and held."""
    each: list[float] = []
    for state in ("not activated", "held"):
        found = _VOLTS * deflection(state, "pad", values, _SWEEP)
        each += [found.max(), found.min(), np.polyfit(_SWEEP, found, 1)[0]]
    return np.array(each)


def _felt(values: Values) -> Floats:
    """Voltages (V) at which the threshold is reached.

    What a volt moves grows in proportion to the voltage: V (small + (large − small) V/50) = level.
    """
    level = DISPLAY_THRESHOLD.at(_FELT)
    small = deflection("not activated", "finger", {**values, _FIELD.name: 0.0}, _FELT)
    if not values[_FIELD.name]:
        return np.asarray(level / small)
    large = deflection("not activated", "finger", values, _FELT)
    growth = 4.0 * level * (large - small) / _VOLTS
    return np.asarray(2.0 * level / (small + np.sqrt(np.maximum(small**2 + growth, 0.0))))


def _on_stop(values: Values) -> Floats:
    """Hz by which the spring tunes the free tip, N/m of the support along x, V to the first limit.

    The limit is that of the field against the poling.
    """
    keys = {key: value for key, value in values.items() if key != _LOWEST.name}
    scene = with_values(_scene("not activated", "none"), keys)
    preloads = values[_PRELOAD.name], values[_LOWEST.name]
    row = sections(scene.device, scene.held, scene.beam, lossy=False)
    high, low = (
        float(bending_frequencies(row, at.ends, 1, open_circuit=False)[0])
        for at in (with_values(scene, {_PRELOAD.name: preload}) for preload in preloads)
    )
    limit = scene.limits.depoling_field * scene.bimorph.electrode_distance
    return np.array([high - low, scene.held.lateral_stiffness, limit])


@cache
def _pulls() -> tuple[float, float]:
    """Pull of the network, times which the field's lies: its modelling error at this device."""
    scene, _ = load_scene("reluctance", ("models=network",))
    found = solve(scene, ("network",), ("magnetic_force",)).quantities[0]
    assert found.modelling is not None
    middle, error = (float(v) for v in (found.modelling.expected, found.modelling.error))
    return (middle - error) / float(found.value), (middle + error) / float(found.value)


def rod_times(values: Values) -> Floats:
    """Current (A) that pulls the rod in; times (s) in which 120 mA bring it down, the spring up.

    Along the axis alone, without the finger, against friction in the bore.  What is not pulled in
    never comes down.
    """
    friction = values.get("guide.friction", 0.0)
    device = with_values(Scene(), {_PRELOAD.name: values[_PRELOAD.name]}).device
    forces = axial_forces(device, ScaledMap(network_map(device), values[_PULL]))
    stroke = device.gap - device.spring.stop_gap
    currents = np.linspace(0.5, 1.5, 201) * DRIVEN
    pulls_in = float(np.interp(friction, -forces.finger_force(currents, 0.0), currents))
    top = resting_place(forces, 0.0, "rising").lift
    down = _flight(forces, DRIVEN, top, _NEAR - stroke, friction)
    bottom = resting_place(forces, 1.5 * DRIVEN, "rising").lift
    return np.array([pulls_in, down, _flight(forces, 0.0, bottom, -_NEAR, friction)])


def _flight(
    forces: AxialForces, current: float, start: float, end: float, friction: float
) -> float:
    """Time (s) from rest at one lift (m) to another at a current (A); inf if it stays."""
    from scipy.integrate import solve_ivp  # slow to import

    device = forces.device
    mass = moving_rod(device).mass + bimorph_mass(Scene())
    stroke = device.gap - device.spring.stop_gap
    near = np.linspace(-3e-6, 3e-6, 301)
    lifts = np.unique([*near, *(near - stroke), *np.linspace(-stroke, 0.0, 200)])
    # friction acts against the one way that it flies
    total = forces.total(current, lifts) - np.sign(end - start) * friction

    def rate(_: float, state: Floats) -> list[float]:
        force = float(np.interp(state[0], lifts, total))
        return [state[1], (force - device.guide.axial_damping * state[1]) / mass]

    def there(_: float, state: Floats) -> float:
        return float(state[0] - end)

    there.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(rate, (0.0, _LONGEST), [start, 0.0], events=there, rtol=1e-6, atol=1e-9)
    return float(found.t_events[0][0]) if found.t_events[0].size else float("inf")


def _printed(words: str, value: float, unit: str, digit: float) -> Published:
    return Published(words, value - 0.5 * digit, value + 0.5 * digit, unit)


_PAD = ("load.pad_modulus", "load.pad_loss_factor", "load.pad_thickness", "load.pad_radius",
        "load.pad_backing")  # fmt: skip
_CONTACT = ("contact.decay_length", "contact.relaxation_time")


#: Title, source and numbers of two measurements.
FIG_15 = (
    "50 V on skin imitation under 50 g", "paper section 6, Fig 15",
    tuple(
        _printed(f"{state}: {words}", value, unit, digit)
        for state, largest, smallest, slope in (
            ("not activated", 24.8e-6, 3.1e-6, 1.164e-8), ("held", 72.4e-6, 13.6e-6, 3.441e-8),
        )
        for words, value, unit, digit in (
            ("largest displacement, 10 to 1000 Hz", largest, "m", 1e-7),
            ("smallest displacement", smallest, "m", 1e-7),
            ("slope of the fitted line", slope, "m/Hz", 1e-11),
        )
    ),
)  # fmt: skip
FIG_17 = (
    "Voltage that is felt, finger at 50 g", "paper section 6, Fig 17",
    (
        _printed("2 um at the lowest frequency", 8.0, "V", 1.0),
        _printed("0.2 um at 250 Hz", 3.0, "V", 1.0),
        Published("1 um at 1 kHz", 2.5, 4.0, "V"),
    ),
)  # fmt: skip


def figures() -> tuple[Figure, ...]:
    """The paper's measurements of the machine that print numbers."""
    loaded = (PLACE, _PRELOAD, _SHARE, *_assumed(*_CONTACT))
    on_skin = (*loaded, *_assumed(*_PAD), _FIELD)
    low, high = _pulls()
    pull = Unknown(_PULL, low, high, "1",
                   "of the network's: its modelling error beside the field", 1.0)  # fmt: skip
    return (
        Figure(*FIG_15, on_skin, _spans),
        Figure(*FIG_17, (*loaded, _FINGER, _FIELD), _felt),
        Figure(
            "Support and limits", "paper sections 4, 6 and 7",
            (Published("resonance adjusted by the spring, about 300 Hz", 250.0, 350.0, "Hz"),
             Published("lateral stiffness of the support, as fitted", 2.5e6, 3.5e6, "N/m"),
             Published("voltage up to which it works", 230.0, 230.0, "V")),
            (_PRELOAD, _LOWEST, *_assumed("contact.decay_length", "contact.tangential_ratio",
                                          "limits.depoling_field")), _on_stop, 2 * _FEW,
        ),
        Figure(
            "The rod at 120 mA", "paper section 6, Fig 16",
            (Published("current that pulls it in", 0.0, DRIVEN, "A"),
             Published("time down", 1.5e-3, 2.5e-3, "s"),
             Published("time up", 0.5e-3, 1.5e-3, "s")),
            (_PRELOAD, pull, *_assumed("guide.friction")), rod_times, _FEW,
        ),
    )  # fmt: skip


def all_compared() -> list[Comparison]:
    """All figures beside their predictions."""
    return [compared(figure) for figure in figures()]


def compared(figure: Figure) -> Comparison:
    """Predictions of a figure's numbers over all its unknowns."""
    from scipy.stats.qmc import Sobol  # slow to import

    unknowns = figure.unknowns
    usual = {u.name: u.usual for u in unknowns}
    shares = Sobol(len(unknowns), seed=1).random(figure.samples)
    # settings in place of all values, which cost a map of the pull each
    preload = [u.name for u in unknowns].index(_PRELOAD.name)
    setting = (shares[:, preload] * len(PRELOADS)).astype(int)
    columns = [u.at(share) for u, share in zip(unknowns, shares.T, strict=True)]
    columns[preload] = np.array(PRELOADS)[setting]
    names = [u.name for u in unknowns]
    samples = [dict(zip(names, map(float, row), strict=True)) for row in zip(*columns, strict=True)]
    found = np.array([figure.predict(values) for values in samples])
    alone = {
        u.name: np.array([figure.predict(usual | {u.name: float(u.at(s))}) for s in (0.0, 1.0)])
        for u in unknowns
    }
    at_usual = figure.predict(usual)
    every = np.vstack([found, *alone.values(), at_usual])
    predictions = []
    for k, published in enumerate(figure.numbers):
        predictions.append(Prediction(
            published, float(at_usual[k]), _range(every[:, k]),
            {name: _range(np.append(ends[:, k], at_usual[k])) for name, ends in alone.items()},
            # few samples may resemble a place in a range that does nothing
            {name: _share(shares[:, n], found[:, k]) if np.ptp(alone[name][:, k]) else 0.0
             for n, name in enumerate(names)},
            {level: _range(found[setting == n, k]) for n, level in enumerate(PRELOADS)},
        ))  # fmt: skip
    off = np.array([p.off(found[:, k]) for k, p in enumerate(figure.numbers)]).max(axis=0)
    best = int(np.argmin(off))
    by_preload = {level: float(off[setting == n].min()) for n, level in enumerate(PRELOADS)}
    return Comparison(figure, tuple(predictions), samples[best], float(off[best]), by_preload)


def _range(values: Floats) -> tuple[float, float]:
    return float(np.min(values)), float(np.max(values))


def _share(place: Floats, values: Floats) -> float:
    """Part of the variance of values (n,) that goes with a place in a range (n,), 0 to 1."""
    known = np.isfinite(values)
    place, values = place[known], values[known]
    total = float(np.var(values)) if values.size else 0.0
    if total == 0.0:
        return 0.0
    bins = np.minimum((place * _BINS).astype(int), _BINS - 1)
    groups = [values[bins == b] for b in np.unique(bins)]
    left = sum(float(np.sum((group - group.mean()) ** 2)) for group in groups)
    if values.size <= len(groups):
        return 0.0
    # per degree of freedom, since bins of so few samples differ by chance, too
    free = (values.size - len(groups)) / (values.size - 1)
    return float(np.clip(1.0 - left / (free * total * values.size), 0.0, 1.0))
