"""Meshes of tetrahedra refined where the goals need it, until the wanted accuracy is met.

Coarse mesh, solution, estimate, finer mesh.  The estimate (fem.bimorph.refinement.error_indicator)
says where to refine and when to stop; the last two meshes give the error bars.  Every mesh is kept
on disk under its geometry and sizes, so a study that was stopped goes on where it was.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from geometry.device.layout import Standing
from geometry.meshing.mesh import Mesh
from geometry.meshing.tetwild.sizing import Sizing, sizing_for
from validation.engine.refinement import SAFETY
from validation.scene.scene import Scene

if TYPE_CHECKING:
    from fem.bimorph.refinement.error_indicator import GoalError
    from fem.bimorph.system import SolidSystem

#: Edge length of the first mesh and shortest edge of any, in thicknesses of the shim.
_START, _SHORTEST = 2.0, 0.04

#: Elements of the bimorph's first mesh if its edges are what they are asked to be, at most.
_FIRST_ELEMENTS = 4_000

#: One mesh is aimed at a share of the last one's error in this range.  Less, and a coarse mesh
#: decides about one much finer; more, and the mesher's scatter hides the gain.
_LEAST_SHARE, _MOST_SHARE = 0.3, 0.6

#: Share of the error allowed that a mesh is aimed at, so that it stays below.
_AIM = 0.8

#: Most meshes, and elements that the largest may have if nothing else is said (100 000
#: unknowns, some 20 s to solve).
_MOST_MESHES, MOST_ELEMENTS = 6, 20_000

#: Share of the most elements from which on a mesh is the last: sizes are met no better.
_ENOUGH = 0.7

#: Gain in error, less one, below which the difference of two meshes says nothing.
_LEAST_GAIN = 0.1


@dataclass(frozen=True)
class Solved:
    """A mesh with the lossless solid on it and what it gives.

    Attributes
    ----------
    mesh : Mesh
        Tetrahedra.
    system : SolidSystem
        The solid.
    goals : dict of str to GoalError
        Values and estimated errors.
    """

    mesh: Mesh
    system: SolidSystem
    goals: dict[str, GoalError]

    @property
    def error(self) -> float:
        """Largest estimated relative error of a goal."""
        return max(abs(goal.error) for goal in self.goals.values())


@dataclass(frozen=True)
class AdaptedPair:
    """The last two meshes of a refinement."""

    fine: Solved
    coarse: Solved

    @property
    def meshes(self) -> tuple[Mesh, Mesh]:
        """The finer and the coarser mesh."""
        return self.fine.mesh, self.coarse.mesh

    @property
    def systems(self) -> tuple[SolidSystem, SolidSystem]:
        """The lossless systems on them."""
        return self.fine.system, self.coarse.system

    @property
    def static_factor(self) -> float:
        """Error bar of static quantities per difference between the two meshes."""
        return self._factor([name for name in self.fine.goals if not name.startswith("bending")])

    @property
    def mode_factor(self) -> float:
        """Error bar of natural frequencies per difference between the two meshes."""
        return self._factor([name for name in self.fine.goals if name.startswith("bending")])

    @property
    def method(self) -> str:
        """How the error bars come about, for the reader."""
        fine, coarse = self.fine.system.size, self.coarse.system.size
        return (
            f"two adapted meshes ({fine} and {coarse} unknowns), gain in error from a "
            f"goal-oriented estimate, safety factor {SAFETY}"
        )

    def _factor(self, names: list[str]) -> float:
        """Return SAFETY / (gain − 1), with the estimated gain of the goal that gained least."""
        gains = [abs(self.coarse.goals[n].error / self.fine.goals[n].error) for n in names]
        return SAFETY / max(min(gains) - 1.0, _LEAST_GAIN)


def adapted_pair(
    scene: Scene, accuracy: float, *, most_elements: int = MOST_ELEMENTS
) -> AdaptedPair:
    """Refine until each goal's estimated error is within `accuracy`, or a limit is reached.

    Parameters
    ----------
    scene : Scene
        The bimorph alone or in its rod.
    accuracy : float
        Largest relative error wanted, a safety factor included.
    most_elements : int
        About how many elements the finest mesh may have; then its error is what it is.

    Raises
    ------
    MeshError
        If a mesh cannot be made.
    """
    coarse = _solved(scene, None)
    fine = _finer(scene, coarse, accuracy, most_elements)
    for _ in range(_MOST_MESHES - 2):
        if SAFETY * fine.error <= accuracy or len(fine.mesh.cells) > _ENOUGH * most_elements:
            break
        coarse, fine = fine, _finer(scene, fine, accuracy, most_elements)
    return AdaptedPair(fine, coarse)


def _finer(scene: Scene, last: Solved, accuracy: float, most_elements: int) -> Solved:
    """Return the next mesh, solved."""
    from geometry.bimorph.tets import squeezed

    # each element is as fine as the goal that needs it most
    shares = np.max([goal.shares for goal in last.goals.values()], axis=0)
    # shares of either sign cancel in a goal, and the largest of several goals add up to more
    spread = float(shares.sum()) / last.error
    share = float(np.clip(_AIM * accuracy / SAFETY / last.error, _LEAST_SHARE, _MOST_SHARE))
    wanted = share * last.error * spread
    seen = replace(last.mesh, points=squeezed(scene.device, _standing(scene), last.mesh.points))
    shortest = _SHORTEST * scene.bimorph.shim_thickness
    return _solved(scene, sizing_for(seen, shares, wanted, shortest=shortest, most=most_elements))


def _solved(scene: Scene, sizing: Sizing | None) -> Solved:
    """Mesh with the given sizes, by default uniform and coarse, solve, and estimate errors."""
    from fem.bimorph.refinement.error_indicator import goal_errors
    from fem.bimorph.solid import assemble
    from geometry.bimorph.tets import TetMeshing, tetrahedralise

    regions: tuple[str, ...] = ("piezo_top", "piezo_bottom", "shim")
    if _standing(scene) == "rod":
        regions += ("glue", "rod")
    options = TetMeshing(edge_length=_first_edge(scene), time_limit=scene.mesh.time_limit)
    mesh = tetrahedralise(scene.device, _standing(scene), regions, options, sizing)
    system = assemble(scene.device, mesh, lossy=False)
    return Solved(mesh, system, goal_errors(scene.device, mesh, system))


def _first_edge(scene: Scene) -> float:
    """Return the edge length (m) of the first mesh: a foil of a shim does not ask for millions."""
    b = scene.bimorph
    volume = b.width * b.thickness * b.length
    # a tetrahedron of edge a has the volume a³ / 8.5
    few = (8.5 * volume / _FIRST_ELEMENTS) ** (1.0 / 3.0)
    return float(max(_START * b.shim_thickness, few))


def _standing(scene: Scene) -> Standing:
    return "rod" if scene.support.kind == "rod" else "alone"
