"""Lowest natural modes of the solid on any support, load and circuit.

On bricks every class of motion is an eigenproblem of its own.  The coarser mesh, which is
needed anyway to judge the finer one by, says which classes may hold the lowest modes and how
many each; only these are solved on the finer mesh.  Classes are solved side by side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.fem.piezo.modal_model import BareMode, ModalModel, Motion
from tactgen.fem.solvers.pardiso import side_by_side
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.store.values import storable
from tactgen.validation.models.model import SAFETY, Modes, cancelling, least_difference

if TYPE_CHECKING:
    from tactgen.fem.piezo.brick_error import MotionEstimator
    from tactgen.fem.piezo.system import SolidSystem

#: Relative errors (k,) of the natural frequencies of a system on its mesh, from Ω² (k,) and shapes.
Estimate = Callable[["SolidSystem", Floats, Floats], Floats]

#: Class of motion in which a contact holds the base by the same springs.
_ACROSS: Motion = "bending_y"
#: Where the search for a bending mode in x ends.
_MOST_MODES = 40
#: Modes of the coarser mesh this close above the last one wanted may come below it on the finer.
_CLOSE = 1.03
#: Unknowns up to which the classes of motion are solved side by side: each has a factor of its
#: own, and those of larger systems take gigabytes.
_MOST_TOGETHER = 150_000


@storable
@dataclass(frozen=True)
class MeshModes:
    """The modes of the solid on one mesh."""

    ports: ModalModel  #: The motions that the ports take part in
    #: The other classes of motion; none of a body taken whole
    others: dict[Motion, tuple[BareMode, ...]]
    #: The same modes, moved by displacements that the mesh lacks, and by potentials
    moved: tuple[dict[Motion, tuple[BareMode, ...]], ...] = ()
    #: Bending across the width on any support, where the base is not held there
    across: ModalModel | None = None

    @property
    def judges(self) -> tuple[MeshModes, ...]:
        """All modes, moved by displacements that the mesh lacks, and by potentials; if known."""
        if self.ports.surplus is None:
            return ()
        each = zip(_moved(self.ports), _moved(self.across), self.moved, strict=True)
        return tuple(
            MeshModes(ports, others, across=across)
            for ports, across, others in each
            if ports is not None
        )

    def opened(self, ends: Ends) -> float:
        """Relative error of Ω² open against short circuit.

        Of the first mode that bends in x, by what the mesh lacks.
        """
        return cancelling(*self.ports.opened(ends))

    def lowest(self, ends: Ends, count: int, *, open_circuit: bool) -> dict[Motion, list[BareMode]]:
        """Lowest `count` modes of every class of motion."""
        found = {m: list(modes[:count]) for m, modes in self.others.items()}
        if self.across is not None:
            found[_ACROSS] = self.across.modes(Ends(ends.across), count)
        return {
            self.ports.motion: self.ports.modes(ends, count, open_circuit=open_circuit),
            **found,
        }


def _moved(model: ModalModel | None) -> list[ModalModel | None]:
    """Model moved by displacements that its mesh lacks, and by potentials; None of none."""
    if model is None or model.surplus is None:
        return [None, None]
    return [replace(model, missing=missing) for missing in model.surplus]


def coarse_modes(
    coarse: SolidSystem, count: int, estimate: Estimate | None = None, *, across: bool = False
) -> MeshModes:
    """Lowest `count` modes on any support, on a coarser mesh.

    If `across`, of a base that is not held in bending across the width either.
    """
    few = dict.fromkeys(coarse.others, count)
    return mesh_modes(coarse, few, count, estimate=estimate, across=across)


def fine_modes(
    fine: SolidSystem,
    coarse: MeshModes,
    count: int,
    lacking: Callable[[Motion], MotionEstimator] | None = None,
    estimate: Estimate | None = None,
) -> MeshModes:
    """Modes on the finer mesh, of the classes that are low on the coarser one.

    With what functions that are `lacking` in each class of motion make of them, or an estimate.
    """
    stiffest = {coarse.ports.motion: coarse.ports.highest(count), **coarse.others}
    last = _CLOSE * _reach(all_modes(stiffest.values()), count)
    few = {m: sum(mode.frequency <= last for mode in found) for m, found in coarse.others.items()}
    few = {motion: wanted for motion, wanted in few.items() if wanted}
    return mesh_modes(fine, few, count, lacking, estimate, across=coarse.across is not None)


def mesh_modes(
    system: SolidSystem,
    others: dict[Motion, int],
    count: int,
    lacking: Callable[[Motion], MotionEstimator] | None = None,
    estimate: Estimate | None = None,
    *,
    across: bool = False,
) -> MeshModes:
    """Modal data of `count` bending modes in x, if `across` in y, and other classes."""
    from tactgen.fem.piezo.modal_reduction import modal_model

    def model(body: SolidSystem) -> ModalModel:
        return modal_model(body, count, None if lacking is None else lacking(body.motion))

    bodies = [system, *([system.related(_ACROSS)] if across and system.related else [])]
    others = {
        motion: wanted for motion, wanted in others.items() if not across or motion != _ACROSS
    }
    jobs: list[Callable[[], Any]] = [partial(model, body) for body in bodies]
    jobs += [
        partial(_other, system, motion, wanted, lacking, estimate)
        for motion, wanted in others.items()
    ]
    if system.size <= _MOST_TOGETHER:
        made = side_by_side(lambda job: job(), jobs)
    else:
        made = [job() for job in jobs]
    models, found = made[: len(bodies)], made[len(bodies) :]
    plain, *moved = ({m: of[i] for m, of in zip(others, found, strict=True)} for i in range(3))
    further = tuple(moved) if lacking is not None else ()
    return MeshModes(models[0], plain, further, models[1] if across else None)


def lowest_modes(
    fine: MeshModes, coarse: MeshModes, ends: Ends, count: int, *, open_circuit: bool
) -> tuple[list[BareMode], list[BareMode]]:
    """Lowest modes on both meshes: `count`, or up to the first bending in x.

    The coarser list is longer where modes are close, so that each finer one has a partner.
    """
    enough = count
    below = coarse.lowest(ends, enough, open_circuit=open_circuit)
    # a narrow bimorph bends in y first; the coupling factor needs bending in x
    while all(m.kind != "bending_x" for m in all_modes(below.values())) and enough < _MOST_MODES:
        enough = 2 * enough + 2
        below = coarse.lowest(ends, enough, open_circuit=open_circuit)
    last = _CLOSE * _reach(all_modes(below.values()), count)
    above = fine.lowest(ends, enough, open_circuit=open_circuit)
    few = {m: sum(mode.frequency <= last for mode in found) for m, found in below.items()}
    found = all_modes(modes[: few[motion]] for motion, modes in above.items())
    limit = _reach(found, count)
    return [m for m in found if m.frequency <= limit], all_modes(below.values())


def _other(
    system: SolidSystem,
    motion: Motion,
    count: int,
    lacking: Callable[[Motion], MotionEstimator] | None,
    estimate: Estimate | None,
) -> list[tuple[BareMode, ...]]:
    """Modes of a class of motion, with hierarchical errors of displacement and potential."""
    from tactgen.fem.piezo.modes import eigenpairs, mode_state

    assert system.related is not None
    body = system.related(motion)
    values, vectors = eigenpairs(body, Ends(), count)
    found = [mode_state(body, *pair) for pair in zip(values, vectors, strict=True)]
    missing: Floats = np.zeros((3, len(found)))
    off: Floats = np.zeros(len(found))
    if estimate is not None:
        off = estimate(body, np.array(values), np.column_stack(vectors))
    if lacking is not None:
        surplus, omega2, states = lacking(motion), np.array(values), np.column_stack(vectors)
        states = np.vstack([states, np.zeros((body.size - len(states), len(values)))])
        stiffness, mass = surplus.residuals(states)
        for i, products in enumerate(surplus.products(stiffness - omega2 * mass)):
            # of a mode that the mesh does not resolve half is left
            missing[1 + i] = np.minimum(products.diagonal() / omega2, 0.5)
    return [
        tuple(
            BareMode(mode.frequency * float(np.sqrt(1.0 - share)), mode.kind, motion, float(by))
            for mode, share, by in zip(found, of, off, strict=True)
        )
        for of in missing
    ]


def all_modes(by_motion: Iterable[Iterable[BareMode]]) -> list[BareMode]:
    """All modes in ascending order."""
    return sorted((m for modes in by_motion for m in modes), key=lambda mode: mode.frequency)


def _reach(modes: list[BareMode], count: int) -> float:
    """Frequency up to which modes are wanted: `count`, and one that bends in x."""
    first = next((m.frequency for m in modes if m.kind == "bending_x"), 0.0)
    return max(modes[min(count, len(modes)) - 1].frequency, first)


#: Gain in error that is counted with from a coarser mesh to a finer one: at least so much more than
#: none, where no two meshes are far apart; and of modes at most, since one with a clamped base
#: tells for all supports, on which less of the error sits at the clamp, where refining gains most
#: (of the paper's second mode 3.1 where that with a clamp gained more than 5).
LEAST_GAIN, MOST_GAIN_OF_MODES = 0.1, 3.3


def gain_factor(gain: Floats | float, most: float) -> Floats:
    """Error of the finer of two meshes per difference, by an estimate of what is gained."""
    return np.asarray(SAFETY / (np.clip(gain, 1.0 + LEAST_GAIN, most) - 1.0))


def estimated_gains(fine: Sequence[BareMode], coarse: Sequence[BareMode]) -> Floats:
    """Ratio (n,) of the estimated errors of each fine mode on both meshes, like with like.

    nan where there is no estimate.
    """
    below: dict[Motion, list[BareMode]] = {}
    for mode in coarse:
        below.setdefault(mode.motion, []).append(mode)
    gains = []
    for mode in fine:
        of = below.get(mode.motion, [])
        before = of.pop(0).estimate if of else 0.0
        gains.append(before / mode.estimate if before > 0.0 < mode.estimate else np.nan)
    return np.array(gains)


def set_apart(fine: Modes, other: Modes, factors: Floats) -> Modes:
    """Modes that differ from the fine ones `factors` (n,) times as far as others do."""
    moved = fine.frequencies + factors * (other.frequencies - fine.frequencies)
    return Modes(moved, fine.classes)


def least_apart(fine: Modes, coarse: Modes) -> dict[str, float]:
    """Relative difference that the modes of each class count with at least.

    A mode that is alone in its class has all others for neighbours.
    """
    kinds, found = np.array(fine.classes), {}
    for kind in dict.fromkeys(fine.classes):
        of = kinds == kind
        near = of if of.sum() > 1 else np.ones_like(of)
        found[kind] = float(least_difference(fine.frequencies[near], coarse.frequencies[near]))
    return found


def moved(fine: Modes, least: dict[str, float]) -> Modes:
    """Modes moved by their least estimated errors."""
    shares = np.array([least[kind] for kind in fine.classes])
    return Modes(fine.frequencies * (1.0 + shares), fine.classes)


def matched(fine: Modes, coarse: Modes) -> Modes:
    """Pair coarse modes with fine ones by class and order, so that like meets like."""
    left = list(zip(coarse.classes, coarse.frequencies, strict=True))
    paired = []
    for kind, frequency in zip(fine.classes, fine.frequencies, strict=True):
        if not left:
            paired.append(np.nan)
            continue
        same = [entry for entry in left if entry[0] == kind] or left
        nearest = min(same, key=lambda entry: abs(entry[1] - frequency))
        left.remove(nearest)
        paired.append(nearest[1])
    return Modes(np.array(paired), fine.classes)
