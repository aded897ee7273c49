"""Magnetic crosstalk of the normal actuators."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.device.checks import check_one_plane
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.display.bill import bill_of_parts
from tactgen.geometry.display.layout import drawn_units, unit_names
from tactgen.geometry.errors import InputError
from tactgen.geometry.store.values import storable
from tactgen.tmm.display import NEIGHBOURS, board, joined, sheet, tip_motions, unit_ports
from tactgen.tmm.ports.multiport import Multiport, wired
from tactgen.validation.models.model import Estimate, Modes, Refined
from tactgen.validation.scene.scene import Scene


@storable
@dataclass(frozen=True)
class NeighbourField:
    """Pulls of one unit in an array in which all are driven, or one."""

    current: float  #: In every coil (A)
    #: Polarities equal, or opposite to all nearest neighbours (N)
    same: Estimate
    alternating: Estimate
    difference: Estimate  #: The first less the second (N), which shares much of their errors
    single: Estimate  #: Pull of one unit driven among others without current (N)
    #: Pull of its undriven neighbour beside it (N), below 0 if that is lifted; nan where that is
    #: not known
    passive: Estimate
    method: str  #: How the bars come about

    @property
    def per_neighbour(self) -> Estimate:
        """Force change of a unit per ampere in each of its nearest neighbours (N/A).

        In pulls that go with the products of currents, F(±) = Q i² ± 4 · 2 Q' i², the change by one
        neighbour's current is 2 Q' i, an eighth of the difference over the current.  What farther
        units of the other colour add is counted to the nearest four.
        """
        share = 2.0 * NEIGHBOURS * self.current
        return Estimate(self.difference.value / share, self.difference.error / share)


def by_network(scene: Scene) -> NeighbourField:
    """Network's estimate."""
    from tactgen.tmm.display import network_forces
    from tactgen.tmm.reluctance.magnetic_circuit import CELLS

    current, gap = scene.display.coil_current, scene.gap
    fine, coarse = (
        network_forces(scene.device, scene.display, current, gap, cells)
        for cells in (CELLS, CELLS // 2)
    )

    def judged(value: float, other: float) -> Estimate:
        return Estimate(value, abs(value - other))

    return NeighbourField(
        current,
        judged(fine.same, coarse.same),
        judged(fine.alternating, coarse.alternating),
        judged(fine.same - fine.alternating, coarse.same - coarse.alternating),
        judged(fine.single, coarse.single),
        Estimate(float("nan"), float("nan")),
        "difference from half as many ladder cells; the network's own error is not included",
    )


def by_field(scene: Scene) -> NeighbourField:
    """Crosstalk by the fields of an endless array and of nine units."""
    from tactgen.fem.magnetics.array_3d import array_forces, nine_forces

    current = scene.display.coil_current
    found = array_forces(scene.device, current, scene.gap, scene.display.pitch)
    pairs = found.same, found.alternating
    # one potential's co-energy is too small, the other's too large, whatever the polarities
    width = max(abs(a - b) / (a + b) for a, b in pairs)
    difference = [a - b for a, b in zip(*pairs, strict=True)]
    mean = 0.5 * sum(difference)

    def judged(pair: tuple[float, float]) -> Estimate:
        value = 0.5 * sum(pair)
        return Estimate(value, width * abs(value))

    driven = [{"middle": current}]
    alone = nine_forces(scene.device, driven, scene.gap, scene.display.pitch)[0]
    return NeighbourField(
        current,
        judged(found.same),
        judged(found.alternating),
        Estimate(mean, max(0.5 * abs(difference[0] - difference[1]), width * abs(mean))),
        _of_nine(alone.middle, alone.unbalanced),
        _of_nine(alone.beside, alone.unbalanced, NEIGHBOURS),
        "half the difference of vector and scalar potential, of either polarity the larger; of one "
        "driven unit, among eight without current, at least what all forces lack to balance",
    )


def _of_nine(
    pair: tuple[float, float], unbalanced: tuple[float, float], share: int = 1
) -> Estimate:
    """Force by both potentials; the imbalance is shared by `share` units."""
    half = 0.5 * abs(pair[0] - pair[1])
    return Estimate(0.5 * sum(pair), max(half, 0.5 * abs(sum(unbalanced)) / share))


#: Rounding of an entry of a bimorph's matrix: closed forms of some ten operations; and how often
#: it is drawn with other signs.
_ROUNDING, _DRAWS = 16.0 * np.finfo(float).eps, 3


@dataclass(frozen=True)
class MechanicalCrosstalk:
    """The display with one unit driven: the one next to the middle, towards r1c1."""

    scene: Scene  #: Display, skin, contact and the tips' load are read
    ports: Refined[Multiport]  #: One bimorph by its model, parallel wiring; all units are this one
    bare: bool = False  #: Whether the tips are without skin, their loads apart

    @property
    def method(self) -> str:
        """Description of the error estimate."""
        return f"of the bimorph's ports: {self.ports.method}; board and skin are model form"

    @property
    def driven(self) -> tuple[int, int]:
        """Row and column of the driven unit, from 0."""
        display = self.scene.display
        return (display.rows - 1) // 2, (display.columns - 1) // 2

    @property
    def beside(self) -> Estimate:
        """Motion of the next unit along x over the driven one's; nan without one."""
        row, column = self.driven
        return self._of_unit(row, column + 1)

    @property
    def behind(self) -> Estimate:
        """Motion of the next unit along y over the driven one's; nan without one."""
        row, column = self.driven
        return self._of_unit(row + 1, column)

    @property
    def largest(self) -> Estimate:
        """Largest motion of any other unit over the driven one's, (n,) real."""
        return self._judged(
            lambda ratios: np.abs(np.delete(ratios, self._at(*self.driven), axis=1)).max(
                axis=1, initial=0.0
            )
        )

    @property
    def by_board(self) -> Estimate:
        """:meth:`largest` without skin: through the board alone."""
        return replace(self, bare=True).largest

    def ratios(self) -> Complex:
        """Tips' motions (n, units) over the driven one's."""
        return self._levels[0]

    def _of_unit(self, row: int, column: int) -> Estimate:
        display = self.scene.display
        if row >= display.rows or column >= display.columns:
            nothing = np.full(len(self.scene.frequency), np.nan)
            return Estimate(nothing, nothing)
        at = self._at(row, column)
        return self._judged(lambda ratios: ratios[:, at])

    def _at(self, row: int, column: int) -> int:
        return row * self.scene.display.columns + column

    def _judged(self, of: Callable[[Complex], Complex | Floats]) -> Estimate:
        fine, *coarser = self._levels
        value = of(fine)
        bar = self._rounding + np.abs(value) * self.ports.rounding
        for level, (_, factor) in zip(coarser, self.ports.coarser, strict=True):
            bar = bar + factor * np.abs(value - of(level))
        return Estimate(value, np.asarray(bar, dtype=float))

    @cached_property
    def _levels(self) -> tuple[Complex, ...]:
        every = (self.ports.fine, *(coarser for coarser, _ in self.ports.coarser))
        return tuple(map(self._solved, every))

    @cached_property
    def _rounding(self) -> Floats:
        """Absolute rounding error of any ratio (n,).

        A condition number of the whole does not see what its parts lost when they were joined.
        """
        fine, chance = self.ports.fine, np.random.default_rng(0)
        found = np.zeros(len(fine.frequencies))
        for _ in range(_DRAWS):
            signs = np.triu(chance.choice((-1.0, 1.0), fine.stiffness.shape[1:]))
            moved = 1.0 + _ROUNDING * (signs + np.triu(signs, 1).T)
            ratios = self._solved(replace(fine, stiffness=fine.stiffness * moved))
            found = np.maximum(found, np.abs(ratios - self._levels[0]).max(axis=1))
        return found

    def _solved(self, bimorph: Multiport) -> Complex:
        whole = display_ports(self.scene, bimorph, bare=self.bare)
        units = unit_names(self.scene.display)
        at = self._at(*self.driven)
        motions = tip_motions(whole, units[at], units)
        return np.asarray(motions / motions[:, at, None])


def crosstalk(scene: Scene, ports: Refined[Multiport]) -> MechanicalCrosstalk:
    """Display with one unit driven, solved on all of the ports' levels."""
    found = MechanicalCrosstalk(scene, ports)
    found.ratios()
    return found


def display_ports(scene: Scene, bimorph: Multiport, *, bare: bool = False) -> Multiport:
    """Whole display over each unit's tip and voltage, all units alike.

    Skin lies on the tips where something loads them, unless they are to be `bare`.
    """
    device, display, f = scene.device, scene.display, bimorph.frequencies
    check_one_plane(device, "display")
    bimorph = wired(bimorph, scene.bimorph.wiring)
    assert scene.rest is not None, "units stand on their contacts"
    unit = unit_ports(bimorph, device, scene.rest[0], scene.ends.tip)
    units = unit_names(display)
    masses = {line.name: line.mass for line in bill_of_parts(device, display)}
    on = board(device, display, f, units, masses["upper_board"])
    covered = scene.load.kind != "none" and scene.skin.thickness > 0.0 and not bare
    over = sheet(scene.skin, display, f, units) if covered else None
    return joined(dict.fromkeys(units, unit), on, over)


#: First frequency of a scene with its error bar (Hz), by some model.
FirstFrequency = Callable[[Scene], Estimate]
#: How the bars come about.
_METHOD = "of each unit's first natural frequency, by the model's own bars"
#: Least preload that a screw leaves, as a share of the nominal one: with none the head is loose.
_LOOSE = 0.02
#: Relative distance from the target at which a search ends, and most of its steps.
_CLOSE, _MOST = 1e-6, 12
#: Slope of log f over log preload with which a search starts: f² goes with the contact's
#: stiffness, that with the preload, less what the beam bends itself.
_EXPONENT = 0.4


@dataclass(frozen=True)
class Spread:
    """The units as drawn, and after their screws were turned."""

    units: tuple[str, ...]  #: Names, row by row
    frequencies: tuple[Estimate, ...]  #: Of each unit as drawn (Hz)
    turns: tuple[float, ...]  #: Of each screw, positive tightens
    turns_bar: float  #: What the bars of the frequencies leave open in turns
    tuned: tuple[Estimate, ...]  #: After turning (Hz)
    #: Of the nominal unit with its screw as far out and in as it goes (Hz)
    lowest: Estimate
    highest: Estimate
    method: str  #: How the bars come about

    @property
    def as_drawn(self) -> Estimate:
        """Frequencies of all units as drawn."""
        values, bars = ([getattr(f, of) for f in self.frequencies] for of in ("value", "error"))
        return self._listed(values, bars)

    @property
    def screws(self) -> Estimate:
        """Turns of all screws."""
        return self._listed(list(self.turns), [self.turns_bar] * len(self.turns))

    @property
    def apart(self) -> Estimate:
        """Range of the sampled frequencies."""
        return _range(self.frequencies)

    @property
    def left_apart(self) -> Estimate:
        """Range after tuning."""
        return _range(self.tuned)

    @property
    def reach(self) -> Estimate:
        """Tuning range of the nominal unit's frequency."""
        return Estimate(
            self.highest.value - self.lowest.value, self.highest.error + self.lowest.error
        )

    def _listed(self, values: list[float], bars: list[float]) -> Estimate:
        return Estimate(np.array(values), np.array(bars), classes=self.units)


def _range(found: tuple[Estimate, ...]) -> Estimate:
    high, low = (pick(found, key=lambda f: f.value) for pick in (max, min))
    return Estimate(high.value - low.value, high.error + low.error)


def first_frequency(modes: Refined[Modes]) -> Estimate:
    """First frequency of modes with the bar that they are judged by."""
    value = float(modes.fine.frequencies[0])
    rounding = np.atleast_1d(np.asarray(modes.rounding))[0]
    bar = abs(value) * (1e-13 + float(rounding))
    for coarser, factor in modes.coarser:
        bar += factor * abs(value - float(coarser.frequencies[0]))
    return Estimate(value, bar)


def spread(scene: Scene, of: FirstFrequency) -> Spread:
    """Scatter of the units of a scene before and after tuning by screws.

    Raises InputError if a screw would leave no preload at all.
    """
    device, display = scene.device, scene.display
    rate, step = device.spring.stiffness, display.screw_pitch
    # of a grub screw within the ground plate, as a force
    travel = rate * (display.plate_thickness - display.screw_length)
    if not rate > 0.0:
        raise InputError(
            "spring.stiffness = 0 N/m lets no screw change the preload; give the spring a stiffness"
        )
    drawn = drawn_units(device, display, scene.scatter)
    scenes = [with_device(scene, unit) for unit in drawn]
    found = tuple(of(unit) for unit in scenes)
    target = float(np.median([f.value for f in found]))
    set_to = [
        _tuned(unit, of, alone, target, travel) for unit, alone in zip(scenes, found, strict=True)
    ]
    tuned = tuple(after for _, after in set_to)
    turns = tuple(
        (force - unit.spring.preload) / (rate * step)
        for unit, (force, _) in zip(scenes, set_to, strict=True)
    )
    lowest, highest = (
        of(_pressed(scene, force)) for force in _limits(scene.spring.preload, travel)
    )
    widest = max(f.error / f.value for f in found)
    bar = (2.0 * widest + _CLOSE) / _EXPONENT * device.spring.preload / (rate * step)
    return Spread(unit_names(display), found, turns, bar, tuned, lowest, highest, _METHOD)


def with_device(scene: Scene, device: Device) -> Scene:
    """Scene with another device."""
    return scene.model_copy(update={name: getattr(device, name) for name in Device.model_fields})


def _pressed(scene: Scene, preload: float) -> Scene:
    spring = scene.spring.model_copy(update={"preload": preload})
    return scene.model_copy(update={"spring": spring})


def _limits(preload: float, travel: float) -> tuple[float, float]:
    return max(preload - travel, _LOOSE * preload), preload + travel


def _tuned(
    scene: Scene, of: FirstFrequency, drawn: Estimate, target: float, travel: float
) -> tuple[float, Estimate]:
    """Preload (N) that brings a unit to a frequency, or as near as its screw goes.

    With what it then vibrates at.  Secants of log f over log preload, which is nearly straight.
    """
    if abs(drawn.value / target - 1.0) < _CLOSE:
        return scene.spring.preload, drawn
    low, high = np.log(_limits(scene.spring.preload, travel))
    before = float(np.log(scene.spring.preload)), float(np.log(drawn.value / target))
    here, found = before[0] - before[1] / _EXPONENT, drawn
    for _ in range(_MOST):
        here = float(np.clip(here, low, high))
        found = of(_pressed(scene, float(np.exp(here))))
        short = float(np.log(found.value / target))
        stuck = (here == low and short > 0.0) or (here == high and short < 0.0)
        if abs(short) < _CLOSE or stuck or here == before[0]:
            break
        slope = (short - before[1]) / (here - before[0])
        before, here = (here, short), here - short / slope
    return float(np.exp(here)), found
