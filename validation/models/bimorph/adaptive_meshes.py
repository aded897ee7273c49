"""Meshes of tetrahedra refined where the goals need it, until the wanted accuracy is met.

Coarse mesh, solution, estimate, finer mesh.  The estimate
(fem.piezo.tetrahedra_error) says where to refine and when to stop; the last mesh
and an earlier one give the error bars.
Every mesh is kept on disk under its geometry and sizes, so a study that was stopped goes on
where it was.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.geometry.device.parts import Standing, bimorph_parts
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.tetwild.mesher import Mesher, Sizing, sizing_for
from tactgen.validation.models.bimorph.mesh_pair import MeshPair
from tactgen.validation.models.bimorph.natural_modes import (
    LEAST_GAIN,
    MOST_GAIN_OF_MODES,
    Estimate,
    gain_factor,
)
from tactgen.validation.models.model import SAFETY, two_mesh_factor
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.piezo.system import SolidSystem
    from tactgen.fem.piezo.tetrahedra_error import GoalError

#: Edge length of the first mesh, in thicknesses of the shim, and shortest edge of any, relative to
#: the thinnest layer or the width.
_START, _SHORTEST = 2.0, 0.04

#: Elements of the bimorph's first mesh if its edges are what they are asked to be, at most.
_FIRST_ELEMENTS = 4_000

#: One mesh is aimed at a share of the last one's error in this range.  Less, and a coarse mesh
#: decides about one much finer; more, and the mesher's scatter hides the gain.
_LEAST_SHARE, _MOST_SHARE = 0.2, 0.6

#: Share of the error allowed that a mesh is aimed at: the error bar, of the goal that gained
#: least, is wider than the estimate.
_AIM = 0.5

#: Accuracy that each level stands for, and elements that its largest mesh may have (20 000 of a
#: quarter are 100 000 unknowns, some 20 s to solve); the first row is for no level.
_LEVELS = (
    (0.0, 20_000), (1e-2, 20_000), (3e-3, 20_000), (1e-3, 20_000), (6e-4, 40_000), (2.5e-4, 60_000)
)  # fmt: skip
_MOST_MESHES = 7

#: Times the most elements beyond which a mesh is made again with larger sizes.
_OVERSHOOT = 2.0
#: Share of the most elements from which on a mesh is the last: sizes are met no better.
_ENOUGH = 0.7

#: A mesh that keeps more than this of the last one's error, with less than so many times its
#: elements, is the last: its smallest elements are as small as they may be, so another one would be
#: its like.  With more elements it was bad luck: the mesher's results scatter.
_STUCK, _MORE = 0.95, 1.5

#: Gain in error of every goal from which on the difference of two meshes says enough: a little
#: less than any mesh is aimed at, since the mesher meets its sizes roughly.
_TELLING = 1.5

#: Gain that is counted with at most: more than a mesh was aimed at is scatter.
_MOST_GAIN = 1.0 / _LEAST_SHARE

#: Order in the elements' size, as unknowns tell it, that modes count with of which there is no
#: estimate.  They share the clamp's edges with those that are goals: orders of 2.4 to 7 were seen
#: on the adapted meshes of four random bimorphs.
_ORDER_OF_OTHERS = 2.0


@dataclass(frozen=True)
class Solved:
    """Mesh with the lossless solid and its results."""

    mesh: Mesh  #: Tetrahedra
    system: SolidSystem  #: The solid
    goals: dict[str, GoalError]  #: Values and estimated errors

    @property
    def error(self) -> float:
        """Largest estimated relative error of a goal."""
        return max(abs(goal.error) for goal in self.goals.values())


@dataclass(frozen=True)
class AdaptedPair(MeshPair):
    """The last mesh of a refinement, and an earlier one to judge it by."""

    device: Device
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
        return self._factor(self._static, _MOST_GAIN)

    @property
    def mode_factors(self) -> tuple[float, float]:
        """The same of frequencies: of bending in x, and of modes without an estimate.

        Of the latter nothing is known of the gain but how many more unknowns there are.
        """
        bending = self._factor(self._bending, MOST_GAIN_OF_MODES)
        # the last mesh of a study that got no further may have no more unknowns
        ratio = max(self.fine.system.size / self.coarse.system.size, 1.0 + LEAST_GAIN)
        return bending, max(bending, two_mesh_factor(ratio ** (1.0 / 3.0), _ORDER_OF_OTHERS))

    @property
    def bending_errors(self) -> tuple[float, ...]:
        """Estimates of the goals that are frequencies."""
        return tuple(abs(self.fine.goals[name].error) for name in self._bending)

    def estimate(self, which: int) -> Estimate:
        """Estimate of natural frequencies by cubics."""
        from tactgen.fem.piezo.tetrahedra_error import mode_errors

        return partial(mode_errors, self.device, self.meshes[which])

    @property
    def static_share(self) -> float:
        """Relative error that every static quantity counts with at least, the response besides.

        What a voltage moves is a product of two solutions: their errors can cancel on one of
        two meshes, and the difference is then too small.  The least estimate of a static goal
        does not know of that.
        """
        return SAFETY * min(abs(self.fine.goals[name].error) for name in self._static)

    @property
    def largest_bar(self) -> float:
        """Largest relative error bar of a goal, static ones as the response counts them."""
        apart = {
            name: abs(1.0 - self.coarse.goals[name].value / goal.value)
            for name, goal in self.fine.goals.items()
        }
        return max(
            *(self.static_factor * apart[name] + self.static_share for name in self._static),
            *(self.mode_factors[0] * apart[name] for name in self._bending),
        )

    @property
    def method(self) -> str:
        """Description of the error estimate."""
        fine, coarse = self.fine.system.size, self.coarse.system.size
        return (
            f"two adapted meshes ({fine} and {coarse} unknowns), gain in error from a "
            f"goal-oriented estimate, safety factor {SAFETY}"
        )

    @property
    def _static(self) -> list[str]:
        return [name for name in self.fine.goals if not name.startswith("bending")]

    @property
    def _bending(self) -> list[str]:
        return [name for name in self.fine.goals if name.startswith("bending")]

    def _factor(self, names: list[str], most: float) -> float:
        """Error per difference, by the goal that gained least."""
        return float(gain_factor(min(_gain(self.coarse, self.fine, n) for n in names), most))


def _gain(coarse: Solved, fine: Solved, name: str) -> float:
    """Estimated ratio of the errors of a goal on two meshes."""
    least = np.finfo(float).tiny
    return abs(coarse.goals[name].error) / max(abs(fine.goals[name].error), least)


def _judged(device: Device, solved: list[Solved]) -> AdaptedPair:
    """Last mesh with the last one that is far enough from it, else the first."""
    fine = solved[-1]
    far = [s for s in solved[:-1] if all(_gain(s, fine, n) >= _TELLING for n in fine.goals)]
    return AdaptedPair(device, fine, far[-1] if far else solved[0])


def level_limits(scene: Scene) -> tuple[float, int]:
    """Accuracy that the scene asks for, and the most elements for it."""
    accuracy, most = _LEVELS[scene.mesh.level]
    return accuracy or scene.accuracy, most


def adapted_pair(scene: Scene, accuracy: float, most_elements: int = 20_000) -> AdaptedPair:
    """Refine until the goals' error bars are within `accuracy`, or a limit is reached.

    Parameters
    ----------
    scene : Scene
        The bimorph alone or in its rod.
    accuracy : float
        Largest relative error bar wanted.
    most_elements : int
        About how many elements the finest mesh may have; then its error is what it is.

    Raises MeshError if a mesh cannot be made.
    """
    with Mesher() as mesher:
        mesher.meanwhile = _import_solvers
        solved = [_solved(scene, _meshed(scene, mesher, None, most_elements))]
        while len(solved) < _MOST_MESHES:
            last = solved[-1]
            allowed = accuracy / (SAFETY * last.error)
            solved.append(_finer(scene, mesher, last, allowed, most_elements))
            pair = _judged(scene.device, solved)
            finer = len(pair.fine.mesh.cells) > _MORE * len(last.mesh.cells)
            for one in solved:  # factors of meshes that are not judged by: each may be a gigabyte
                if one is not pair.fine and one is not pair.coarse:
                    one.system.drop_factor()
            enough = len(pair.fine.mesh.cells) > _ENOUGH * most_elements
            stuck = pair.fine.error > _STUCK * last.error and not finer
            if pair.largest_bar <= accuracy or enough or stuck:
                break
    return pair


def _import_solvers() -> None:
    """Import the solver ahead of the first mesh."""
    import scipy.sparse.linalg  # noqa: F401
    import skfem  # noqa: F401

    import tactgen.fem.piezo.solid  # noqa: F401


def _finer(
    scene: Scene, mesher: Mesher, last: Solved, allowed: float, most_elements: int
) -> Solved:
    """Next mesh, solved; its error is allowed to be this share of the last one's."""
    from tactgen.geometry.bimorph.tets import squeezed

    # each element is as fine as the goal that needs it most
    shares = np.max([goal.shares for goal in last.goals.values()], axis=0)
    # shares of either sign cancel in a goal, and the largest of several goals add up to more
    spread = float(shares.sum()) / last.error
    share = float(np.clip(_AIM * allowed, _LEAST_SHARE, _MOST_SHARE))
    wanted = share * last.error * spread
    seen = replace(last.mesh, points=squeezed(scene.device, _standing(scene), last.mesh.points))
    widths = (scene.bimorph.width, *(width for _, width in scene.bimorph.width_profile))
    shortest = _SHORTEST * min(*_thicknesses(scene.bimorph), *widths)
    sizing = sizing_for(seen, shares, wanted, shortest=shortest, most=most_elements)
    return _solved(scene, _meshed(scene, mesher, sizing, most_elements))


def _solved(scene: Scene, mesh: Mesh) -> Solved:
    """Solve on a mesh, and estimate errors."""
    from tactgen.fem.piezo.solid import assemble
    from tactgen.fem.piezo.tetrahedra_error import goal_errors

    system = assemble(scene.device, mesh, lossy=False)
    return Solved(mesh, system, goal_errors(scene.device, mesh, system))


def _meshed(scene: Scene, mesher: Mesher, sizing: Sizing | None, most_elements: int) -> Mesh:
    """Mesh with the given sizes, by default uniform and coarse.

    Below a foil's thickness the mesher takes many more elements than sizes tell; then they are made
    larger until it keeps to the limit, which is one of memory, or takes no fewer.
    """
    from tactgen.geometry.bimorph.tets import TetMeshing, tetrahedralise

    regions = bimorph_parts(scene.device)
    if _standing(scene) == "rod":
        regions += ("glue", "rod")
    options = TetMeshing(
        edge_length=_first_edge(scene),
        mirrors=(1,) if scene.bimorph.layers else (0, 1),
        time_limit=scene.mesh.time_limit,
    )
    before = np.inf
    while True:
        mesh = tetrahedralise(scene.device, _standing(scene), regions, options, sizing, mesher)
        over = len(mesh.cells) / most_elements
        if sizing is None or over <= _OVERSHOOT or over > _STUCK * before:
            return mesh
        before = over
        sizing = replace(sizing, lengths=sizing.lengths * over ** (1.0 / 3.0))


def _first_edge(scene: Scene) -> float:
    """Edge length (m) of the first mesh: a foil of a shim does not ask for millions."""
    b = scene.bimorph
    volume = b.width * b.thickness * b.length
    # a tetrahedron of edge a has the volume a³ / 8.5
    few = (8.5 * volume / _FIRST_ELEMENTS) ** (1.0 / 3.0)
    thin = min(_thicknesses(b)) if b.layers else b.shim_thickness
    return float(max(_START * thin, few))


def _thicknesses(bimorph: Bimorph) -> list[float]:
    """Of the layers (m)."""
    listed = [layer.thickness for layer in bimorph.layers]
    tapers = (bimorph.piezo_thickness_profile, bimorph.shim_thickness_profile)
    varying = [thickness for profile in tapers for _, thickness in profile]
    return listed or [bimorph.shim_thickness, bimorph.piezo_thickness, *varying]


def _standing(scene: Scene) -> Standing:
    return "rod" if scene.support.kind == "rod" else "alone"
