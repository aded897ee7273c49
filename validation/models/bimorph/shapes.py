"""Which natural modes of the solid are the lowest, without solving for all of them twice.

On bricks every class of motion is an eigenproblem of its own.  The coarser mesh, which is
needed anyway to judge the finer one by, says which classes hold the lowest modes and how
many each; only these are solved on the finer mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fem.bimorph.modes import SolidMode, natural_modes
from fem.bimorph.system import Motion, SolidSystem
from geometry.bimorph.ends import Ends

#: Classes of motion in which the ports take no part; the same at open circuit.
_OTHERS: tuple[Motion, ...] = ("bending_y", "torsion", "axial")
#: Where the search for a bending mode in x ends.
_MOST_MODES = 40
#: Modes of the coarser mesh this close above the last one wanted may come below it on the finer.
_CLOSE = 1.03

Shapes = tuple[Sequence[SolidMode], Sequence[SolidMode]]


@dataclass(frozen=True)
class ShapeSearch:
    """The search for modes on a finer and a coarser mesh.

    Attributes
    ----------
    systems : (SolidSystem, SolidSystem)
        Those with ports, on the finer and the coarser mesh.
    known : dict
        Modes found, so that what both circuits share is solved once.
    """

    systems: tuple[SolidSystem, SolidSystem]
    ends: Ends
    known: dict[tuple[int, Motion, bool], list[SolidMode]]

    def lowest(self, count: int, *, open_circuit: bool) -> Shapes:
        """Return the lowest modes on both meshes: `count`, or up to the first bending in x.

        The coarser list is longer where modes are close, so that each finer one has a partner.
        """
        enough = count
        coarse = self._coarse(enough, open_circuit=open_circuit)
        # a narrow bimorph bends in y first; the coupling factor needs bending in x
        while all(m.kind != "bending_x" for m in _all(coarse)) and enough < _MOST_MODES:
            enough = 2 * enough + 2
            coarse = self._coarse(enough, open_circuit=open_circuit)
        last = _reach(_all(coarse), count)
        fine = {
            motion: self._modes(0, motion, wanted, open_circuit=open_circuit)
            for motion, modes in coarse.items()
            if (wanted := sum(m.frequency <= _CLOSE * last for m in modes))
        }
        found = _all(fine)
        limit = _reach(found, count)
        return [m for m in found if m.frequency <= limit], _all(coarse)

    def _coarse(self, count: int, *, open_circuit: bool) -> dict[Motion, list[SolidMode]]:
        motions: tuple[Motion, ...] = ("all",)
        if self.systems[1].related is not None:
            motions = ("bending_x", *_OTHERS)
        return {m: self._modes(1, m, count, open_circuit=open_circuit) for m in motions}

    def _modes(
        self, mesh: int, motion: Motion, count: int, *, open_circuit: bool
    ) -> list[SolidMode]:
        key = (mesh, motion, open_circuit and motion not in _OTHERS)
        if len(self.known.get(key, ())) < count:
            system = self.systems[mesh]
            if motion in _OTHERS and system.related is not None:
                system = system.related(motion)
            self.known[key] = natural_modes(system, self.ends, count, open_circuit=open_circuit)
        return self.known[key][:count]


def _all(by_motion: dict[Motion, list[SolidMode]]) -> list[SolidMode]:
    """Return all modes in ascending order."""
    return sorted(
        (m for modes in by_motion.values() for m in modes), key=lambda mode: mode.frequency
    )


def _reach(modes: list[SolidMode], count: int) -> float:
    """Return the frequency up to which modes are wanted: `count`, and one that bends in x."""
    first = next((m.frequency for m in modes if m.kind == "bending_x"), 0.0)
    return max(modes[min(count, len(modes)) - 1].frequency, first)
