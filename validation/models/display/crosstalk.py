"""What one driven unit moves at the tips of the others, with what judges it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.display.bill import bill_of_parts
from tactgen.geometry.display.layout import unit_names
from tactgen.tmm.display.array import board, joined, sheet, tip_motions, unit_ports
from tactgen.tmm.ports.multiport import Multiport, in_series
from tactgen.validation.engine.model import Refined
from tactgen.validation.engine.results import Estimate
from tactgen.validation.scene.scene import Scene

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
        """How the error bars come about."""
        return f"of the bimorph's ports: {self.ports.method}; board and skin are model form"

    @property
    def driven(self) -> tuple[int, int]:
        """Row and column of the driven unit, from 0."""
        display = self.scene.display
        return (display.rows - 1) // 2, (display.columns - 1) // 2

    def beside(self) -> Estimate:
        """Motion of the next unit along x over the driven one's; nan without one."""
        row, column = self.driven
        return self._of_unit(row, column + 1)

    def behind(self) -> Estimate:
        """Motion of the next unit along y over the driven one's; nan without one."""
        row, column = self.driven
        return self._of_unit(row + 1, column)

    def largest(self) -> Estimate:
        """Largest motion of any other unit over the driven one's, (n,) real."""
        return self._judged(
            lambda ratios: np.abs(np.delete(ratios, self._at(*self.driven), axis=1)).max(
                axis=1, initial=0.0
            )
        )

    def by_board(self) -> Estimate:
        """:meth:`largest` with no skin on the tips: what the board alone passes on."""
        return replace(self, bare=True).largest()

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
        return tuple(self._solved(port)[1] for port in every)

    @cached_property
    def _rounding(self) -> Floats:
        """How far any ratio (n,) goes when the bimorph's matrix moves by its rounding, absolute.

        A condition number of the whole does not see what its parts lost when they were joined.
        """
        fine, chance = self.ports.fine, np.random.default_rng(0)
        found = np.zeros(len(fine.frequencies))
        for _ in range(_DRAWS):
            signs = np.triu(chance.choice((-1.0, 1.0), fine.stiffness.shape[1:]))
            moved = 1.0 + _ROUNDING * (signs + np.triu(signs, 1).T)
            _, ratios = self._solved(replace(fine, stiffness=fine.stiffness * moved))
            found = np.maximum(found, np.abs(ratios - self._levels[0]).max(axis=1))
        return found

    def _solved(self, bimorph: Multiport) -> tuple[Multiport, Complex]:
        whole = display_ports(self.scene, bimorph, bare=self.bare)
        units = unit_names(self.scene.display)
        at = self._at(*self.driven)
        motions = tip_motions(whole, units[at], units)
        return whole, motions / motions[:, at, None]


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
    if scene.bimorph.wiring == "series":
        bimorph = in_series(bimorph)
    assert scene.rest is not None, "units stand on their contacts"
    unit = unit_ports(bimorph, device, scene.rest[0], scene.ends.tip)
    units = unit_names(display)
    masses = {line.name: line.mass for line in bill_of_parts(device, display)}
    on = board(device, display, f, units, masses["upper_board"])
    covered = scene.load.kind != "none" and scene.skin.thickness > 0.0 and not bare
    over = sheet(scene.skin, display, f, units) if covered else None
    return joined(dict.fromkeys(units, unit), on, over)
