"""The piezoelectric solid on two meshes, so that its error shows.

What the models solid (bricks) and cad (tetrahedra of the CAD solids) have in common.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from tactgen.fem.piezo.modal_model import Motion
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.store.values import storable
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.models.bimorph.model import BimorphModel
from tactgen.validation.models.bimorph.natural_modes import (
    MOST_GAIN_OF_MODES,
    Estimate,
    MeshModes,
    all_modes,
    coarse_modes,
    estimated_gains,
    fine_modes,
    gain_factor,
    least_apart,
    lowest_modes,
    matched,
    moved,
    set_apart,
)
from tactgen.validation.models.model import SAFETY, Modes, Refined, least_difference

if TYPE_CHECKING:
    from tactgen.fem.piezo.brick_error import MotionEstimator
    from tactgen.fem.piezo.krylov import ReducedSolid
    from tactgen.fem.piezo.modal_model import BareMode, ModalModel
    from tactgen.fem.piezo.system import SolidSystem


class MeshPair(ABC):
    """A finer mesh, a coarser one, and how their difference becomes an error."""

    @property
    @abstractmethod
    def meshes(self) -> tuple[Mesh | Bricks, Mesh | Bricks]:
        """The finer and the coarser mesh."""

    @property
    @abstractmethod
    def systems(self) -> tuple[SolidSystem, SolidSystem]:
        """The lossless systems on them."""

    @property
    def lacking(self) -> Callable[..., MotionEstimator] | None:
        """Estimator space of the finer mesh by class of motion (and `lossy`), where it is known."""
        return None

    @property
    @abstractmethod
    def static_factor(self) -> float:
        """Error of statics and response per difference from the estimate or the coarser mesh."""

    @property
    def static_share(self) -> float:
        """Least relative error of static quantities, which the response adds."""
        return 0.0

    @property
    def mode_factors(self) -> tuple[float, float]:
        """Error per difference of frequencies: bending in x, modes without an estimate."""
        return self.static_factor, self.static_factor

    @property
    def bending_errors(self) -> tuple[float, ...]:
        """Estimated relative errors of the lowest frequencies of bending in x, base clamped."""
        return ()

    def estimate(self, which: int) -> Estimate | None:
        """Estimate of natural frequencies on the finer (0) or coarser mesh (1), if there is one."""
        return None

    @property
    @abstractmethod
    def method(self) -> str:
        """Origin of the error, for the reader."""


@storable
@dataclass(frozen=True)
class SolidModes:
    """Modes of the solid on two meshes for any support, with errors."""

    #: On the finer and the coarser mesh.  What functions that the finer one lacks make of its modes
    #: judges them, if that is known, else the coarser one does
    fine: MeshModes
    coarse: MeshModes
    #: See :class:`fem.piezo.system.SolidSystem` (N/m); of all nodes (kg)
    spurious_stiffness: float
    mass: float
    static_factor: float  #: Error bar of static quantities per difference between the two meshes
    static_share: float  #: Relative error that static quantities count with at least
    #: (float, float) The same of frequencies, see :class:`MeshPair`
    mode_factors: tuple[float, float]
    bending_errors: tuple[float, ...]  #: Estimates of the lowest that bend in x, or none
    method: str  #: How the error bars come about

    def stiffened(self, ends: Ends, count: int) -> tuple[Floats, Floats]:
        """Relative rise of Ω² by an open circuit, lowest `count` bending modes.

        On the finer and on the coarser mesh, (count,) each.
        """

        def added(ports: ModalModel) -> Floats:
            modes = (ports.modes(ends, count, open_circuit=q) for q in (False, True))
            short, opened = (np.array([m.frequency for m in found]) for found in modes)
            return np.asarray((opened / short) ** 2 - 1.0)

        return added(self.fine.ports), added(self.coarse.ports)


class TwoMeshModel(BimorphModel):
    """The piezoelectric solid on two meshes."""

    @abstractmethod
    def make_pair(self) -> MeshPair:
        """Meshes that the scene and its accuracy ask for."""

    @property
    def mesh_pair(self) -> MeshPair:
        """The finer mesh, and a coarser one to judge it by."""
        return self.run("mesh", self.make_pair)

    def meshes(self) -> tuple[Mesh | Bricks, Mesh | Bricks]:
        """Finer and the coarser mesh."""
        return self.mesh_pair.meshes

    def systems(self) -> tuple[SolidSystem, SolidSystem]:
        """Lossless systems on the finer and the coarser mesh."""
        pair = self.mesh_pair
        return self.run("assembly", lambda: pair.systems)

    def static(self) -> Refined[Multiport]:
        """Lossless D(0)."""

        def work() -> Refined[Multiport]:
            pair, (fine, *judges) = self.mesh_pair, self._at_rest()
            rounding = self._rounding(fine)
            if pair.lacking is None:
                rounding += pair.static_factor * float(least_at_rest(fine, *judges)[0])
            coarser = tuple((judge, pair.static_factor) for judge in judges)
            return Refined(fine, coarser, pair.method, rounding, least=pair.static_share)

        return self.run("static", work)

    def _at_rest(self) -> tuple[Multiport, ...]:
        """Lossless D(0) on the finer mesh, with its error."""
        from tactgen.fem.piezo.ports import static_multiport, static_multiports

        lacking, (fine, coarse) = self.mesh_pair.lacking, self.systems()
        if lacking is not None:
            return static_multiports(fine, lacking("bending_x"))
        return static_multiport(fine), static_multiport(coarse)

    def ports(self) -> Refined[Multiport]:
        """D(Ω) with losses over the scene's frequencies."""
        return self.run("ports", self._reduced)

    def _reduced(self) -> Refined[Multiport]:
        pair, frequencies = self.mesh_pair, self.frequencies
        fine = self._reduction(0)
        if pair.lacking is not None:
            judges: tuple[Multiport, ...] = fine.richer_multiports(frequencies)
        else:
            judges = (self._reduction(1).multiport(frequencies),)
        coarser = tuple((judge, pair.static_factor) for judge in judges)
        coarser += ((fine.coarse.multiport(frequencies), SAFETY),)
        # a peak magnifies what the stiffness is off by Q
        rounding = self._rounding(fine.multiport(np.zeros(1)))
        rounding = self.scene.piezo.quality_factor * rounding + pair.static_share
        method = f"{pair.method}; plus the last Krylov block of the port reduction"
        return Refined(fine.multiport(frequencies), coarser, method, rounding)

    def _reduction(self, which: int) -> ReducedSolid:
        """Solid on the finer (0) or the coarser mesh (1), reduced to its ports."""
        from tactgen.fem.piezo.reduction_files import reduced_solid

        lacking = None if which else self.mesh_pair.lacking
        return reduced_solid(
            self.scene.device,
            self.meshes()[which],
            self.frequencies,
            tolerance=1e-3 * self.scene.accuracy,
            lacking=lacking and partial(lacking, "bending_x", lossy=True),
        )

    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Lossless modes."""
        return self.run(
            "modes_open" if open_circuit else "modes_short",
            lambda: self._modes(open_circuit=open_circuit),
        )

    def _modes(self, *, open_circuit: bool) -> Refined[Modes]:
        modal = self._modal()
        fine, *judges = self._judged(open_circuit=open_circuit)
        # frequencies go as the root
        stiffness = (2.0 * np.pi * fine.frequencies) ** 2 * self._modal_masses(fine)
        rounding = 0.5 * modal.spurious_stiffness / stiffness
        if modal.fine.judges:
            coarser = tuple((judge, modal.mode_factors[0]) for judge in judges)
            beside = self._beside(fine, open_circuit=open_circuit)
            return Refined(fine, coarser, modal.method, rounding, beside=beside)
        (coarse,) = judges
        least = least_apart(fine, coarse)
        if open_circuit:
            # the same as of short circuit: what moves both alike says nothing of their coupling
            least |= least_apart(*self._judged(open_circuit=False))
        bends = np.array(fine.classes) == "bending_x"
        stiffer = fine.frequencies.copy()
        if open_circuit:
            # the charge is a static goal: what it adds is judged as one, and that alone
            added, less = modal.stiffened(self.scene.ends, int(bends.sum()))
            softer = np.sqrt((1.0 + less) / (1.0 + added))
            stiffer[bends] *= softer
            apart = modal.static_factor * np.abs(1.0 - softer)
            rounding[bends] += np.maximum(modal.static_share * added - apart, 0.0)
        bending, others = modal.mode_factors
        found, below = self._lowest(open_circuit=open_circuit)
        gains = estimated_gains(found, below)
        by_gain = np.where(np.isnan(gains), others, gain_factor(gains, MOST_GAIN_OF_MODES))
        # in one class of motion with the goals, which are its lowest modes
        with_goals = np.array([mode.motion == "bending_x" for mode in found])
        factors = np.where(with_goals, bending, by_gain)
        # two meshes may agree by chance, and then the estimate is the bar
        apart = factors * np.abs(1.0 - coarse.frequencies / fine.frequencies)
        estimates = self._estimates(found)
        rounding += np.maximum(estimates - np.where(np.isnan(apart), np.inf, apart), 0.0)
        coarser = tuple(
            (set_apart(fine, other, factors), 1.0) for other in (coarse, moved(fine, least))
        )
        coarser += ((Modes(stiffer, fine.classes), modal.static_factor),)
        return Refined(fine, coarser, modal.method, rounding)

    def _estimates(self, found: Sequence[BareMode]) -> Floats:
        """Estimated relative error (n,) of each mode, of bending in x that with a clamped base."""
        errors = iter(self._modal().bending_errors)
        of_goals = (next(errors, 0.0) if m.kind == "bending_x" else m.estimate for m in found)
        return np.array(list(of_goals))

    def _modal_masses(self, fine: Modes) -> Floats:
        """Modal masses (n,) in kg of unit displacement where a mode moves most.

        A cantilever has a quarter of its mass; the first modes that bend carry the tip's as well.
        """
        masses = np.full(fine.frequencies.size, self._modal().mass / 4.0)
        for kind in ("bending_x", "bending_y"):
            if kind in fine.classes:
                masses[fine.classes.index(kind)] += self.scene.ends.conservative_tip.mass
        return masses

    def _beside(self, fine: Modes, *, open_circuit: bool) -> tuple[tuple[Modes, float], ...]:
        """Paired difference of both circuits, by their first bending modes.

        What moves both alike, then what moves the open one beside the other.
        """
        modal = self._modal()
        short, *judges = self._judged(open_circuit=False)
        moved = [judge.first_bending / short.first_bending for judge in judges]
        moved.append(np.sqrt(1.0 + modal.fine.opened(self.scene.ends)) if open_circuit else 1.0)
        return tuple(
            (Modes(of * fine.frequencies, fine.classes), modal.mode_factors[0]) for of in moved
        )

    def _judged(self, *, open_circuit: bool) -> tuple[Modes, ...]:
        """Modes on the finer mesh, and their partners of those that judge them."""
        found, coarse = self._lowest(open_circuit=open_circuit)
        ends, judges = self.scene.ends, self._modal().fine.judges
        partners = [
            all_modes(judge.lowest(ends, len(found), open_circuit=open_circuit).values())
            for judge in judges
        ]
        fine, *others = (
            Modes(np.array([m.frequency for m in of]), tuple(m.kind for m in of))
            for of in (found, *(partners or [coarse]))
        )
        return fine, *(matched(fine, other) for other in others)

    def motions(self, *, open_circuit: bool) -> dict[Motion, int]:
        """Number of lowest modes of :meth:`modes` by class of motion."""
        return dict(Counter(mode.motion for mode in self._lowest(open_circuit=open_circuit)[0]))

    def _modal(self) -> SolidModes:
        """Modal data for any support, load and circuit."""

        def work() -> SolidModes:
            pair, systems = self.mesh_pair, self.systems()
            # a body taken whole has one class of motion
            across = self.scene.support.kind == "contact" and bool(systems[1].others)
            count = self.scene.modes
            coarse = coarse_modes(systems[1], count, pair.estimate(1), across=across)
            return SolidModes(
                fine_modes(systems[0], coarse, count, pair.lacking, pair.estimate(0)),
                coarse,
                spurious_stiffness=systems[0].spurious_stiffness,
                mass=float(systems[0].node_mass.sum()),
                static_factor=pair.static_factor,
                static_share=pair.static_share,
                mode_factors=pair.mode_factors,
                bending_errors=pair.bending_errors,
                method=pair.method,
            )

        return self.run("modal", work)

    def _lowest(self, *, open_circuit: bool) -> tuple[list[BareMode], list[BareMode]]:
        modal = self._modal()
        return lowest_modes(
            modal.fine, modal.coarse, self.scene.ends, self.scene.modes, open_circuit=open_circuit
        )

    def _rounding(self, port: Multiport) -> float:
        """Rounding error of the tip's static compliance."""
        compliance = np.linalg.inv(port.block("w_tip", "psi_tip").stiffness[0])[0, 0]
        return float(abs(compliance) * self.systems()[0].spurious_stiffness)


def least_at_rest(fine: Multiport, coarse: Multiport) -> Floats:
    """Relative difference (n,) that all at 0 Hz counts with at least.

    From D(0) of n bimorphs without losses on the finer and on the coarser level.
    """
    return least_difference(_sizes(fine), _sizes(coarse))


def _sizes(port: Multiport) -> Floats:
    """Magnitudes (n, 4) of static readings on a held base.

    The tip's compliance, its displacement per volt, the capacitance with the tip held and free.
    """
    held = port.block("w_tip", "psi_tip", "voltage").stiffness.real
    compliance, moved = np.linalg.inv(held[:, :2, :2]), held[:, :2, 2]
    per_volt = np.einsum("nij,nj->ni", compliance, moved)
    clamped = held[:, 2, 2]
    free = clamped - np.einsum("ni,ni->n", moved, per_volt)
    sizes = np.stack([compliance[:, 0, 0], per_volt[:, 0], clamped, free], axis=1)
    return np.asarray(np.abs(sizes))
