"""fTetWild in a process of its own, which stays for the meshes that follow.

Its libraries take half a second to load: a process that is started before the surface is there
has them when it comes, and the second mesh need not load them again.
"""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.cad.system_libraries import require_package
from tactgen.geometry.errors import MeshError
from tactgen.geometry.meshing.mesh import TET_EDGES, Mesh, tet_volumes, unique_edges
from tactgen.geometry.meshing.structured_tets import box_tetrahedra, reflected

_WORKER = Path(__file__).with_name("worker.py")


class Mesher:
    """A process that meshes one surface after another; it ends with the ``with`` block."""

    def __init__(self) -> None:
        #: What the caller has to do anyway: called once, while the next surface is meshed
        self.meanwhile: Callable[[], object] | None = None
        #: Processor time (s) that all meshes have taken so far, less those it died of
        self.spent = 0.0
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Mesher:
        """Itself; nothing is started yet."""
        self._folder = tempfile.TemporaryDirectory(prefix="tactgen-")
        return self

    def __exit__(self, *_: object) -> None:
        """End the process and remove its folder."""
        self._end()
        self._folder.cleanup()

    def start(self) -> subprocess.Popen[bytes]:
        """Process, which loads its libraries while the caller does something else."""
        if self._process is None:
            require_package("pytetwild", "tetrahedra")
            with (Path(self._folder.name) / "log").open("wb") as log:
                # -P: the folder of the worker holds modules with everyday names; cwd: fTetWild
                # leaves files there when it meets trouble
                self._process = subprocess.Popen(
                    [sys.executable, "-P", str(_WORKER)],
                    cwd=self._folder.name,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=log,
                )
        return self._process

    def mesh(self, arrays: dict[str, NDArray[Any]], time_limit: float) -> tuple[Floats, Ints]:
        """Points (n, 3) and corners (m, 4) of fTetWild's mesh of arrays for ``worker.py``.

        After `time_limit` seconds of processor time, in whole ones, the process is ended.

        Raises MeshError if the time is up or fTetWild fails.
        """
        process = self.start()
        assert process.stdin is not None
        assert process.stdout is not None
        source, target = (Path(self._folder.name) / name for name in ("surface.npz", "tets.npz"))
        np.savez(source, allow_pickle=False, **arrays)
        try:
            process.stdin.write(f"{source}\n{target}\n{time_limit}\n".encode())
            process.stdin.flush()
        except BrokenPipeError:
            raise self._failed(process, time_limit) from None
        work, self.meanwhile = self.meanwhile, None
        if work is not None:
            work()
        took = process.stdout.readline()
        if not took:
            raise self._failed(process, time_limit)
        self.spent += float(took)
        with np.load(target) as result:
            return result["points"], result["tets"].astype(np.int64)

    def _failed(self, process: subprocess.Popen[bytes], time_limit: float) -> MeshError:
        """Error message of a mesher process that died; the next mesh gets a new one."""
        code = process.wait()
        self._end()
        if code == -getattr(signal, "SIGXCPU", 0) != 0:
            self.spent += time_limit
            return MeshError(
                f"meshing was not done after {time_limit:.3g} s of processor time; raise the time "
                "limit, or the edge length, or make the thinnest feature thicker"
            )
        log = (Path(self._folder.name) / "log").read_text(errors="replace")
        lines = log.strip().splitlines()
        reason = lines[-1] if lines else f"exit code {code}"
        return MeshError(f"fTetWild failed ({reason}); change the edge length slightly")

    def _end(self) -> None:
        if self._process is None:
            return
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):  # what it was told and did not read
                    pipe.close()
        self._process = None


#: The box that fTetWild fills is about this much of the diagonal larger on every side.
_MARGIN = 0.15

#: Passes over the mesh at most.  Good runs need 5 to 15; one that is stuck on a bad element
#: would go on for minutes, refining around it.
_PASSES = 20

#: Points of the sizing grid across x and y, and along z.
_GRID = (9, 9, 161)

#: Points around the device of a sizing field that is given at points.
_AROUND = (9, 9, 21)

#: Growth of the edge length per distance from the device.
_GROWTH_OUTSIDE = 0.5


@dataclass(frozen=True)
class SizingField:
    """Target edge lengths on a background mesh of tetrahedra (mm)."""

    points: Floats  #: (n_points, 3) Coordinates
    tets: Ints  #: (n_tets, 4) Corners
    lengths: Floats  #: (n_points,) Target edge length at each point

    def scaled(self, factor: float) -> SizingField:
        """Field with all lengths times a factor."""
        return replace(self, lengths=factor * self.lengths)


def run_ftetwild(
    points: Floats,
    triangles: Ints,
    *,
    edge_length: float,
    envelope: float,
    sizing: SizingField | None,
    time_limit: float,
    mesher: Mesher | None = None,
) -> tuple[Floats, Ints]:
    """Fill the box around a surface with tetrahedra that follow the surface.

    Parameters
    ----------
    points, triangles : (n_points, 3) and (n_triangles, 3) int array
        Surface (mm), with the interfaces inside.
    edge_length, envelope : float
        Target edge length, and largest distance of the result from the surface (mm).
    sizing : SizingField, optional
        Target edge lengths where they vary.
    time_limit : float
        Processor time (s) after which the process is ended.
    mesher : Mesher, optional
        The process that does it; one of its own by default.

    Returns points (n, 3) in mm and corners (m, 4) in VTK order, box and all.

    Raises MeshError if the time is up or fTetWild fails.
    """
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    settings = {
        "edge_length_abs": edge_length,
        "epsilon": envelope / diagonal,
        "num_opt_iter": _PASSES,
    }
    arrays: dict[str, NDArray[Any]] = {"points": points, "triangles": triangles}
    if sizing is not None:
        arrays |= {
            "bg_vertices": sizing.points,
            "bg_tets": sizing.tets,
            "bg_values": sizing.lengths,
        }
    arrays["settings"] = np.array(json.dumps(settings))
    if mesher is not None:
        return mesher.mesh(arrays, time_limit)
    with Mesher() as own:
        return own.mesh(arrays, time_limit)


def sizing_on_grid(axes: Sequence[Floats], length_at: Callable[[Floats], Floats]) -> SizingField:
    """Sizing field (mm) on the grid of three axes, its edge lengths (n,) at points (n, 3)."""
    x, y, z = axes
    cells = np.zeros((x.size - 1, y.size - 1, z.size - 1), dtype=int)
    grid = box_tetrahedra(x, y, z, cells, ("",))
    return SizingField(grid.points, grid.cells, length_at(grid.points))


def _axes_around(points: Floats, counts: tuple[int, ...]) -> list[Floats]:
    """So many positions (mm) along each axis, over all that fTetWild fills around points (mm)."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = _MARGIN * np.linalg.norm(high - low)
    ends = zip(low - margin, high + margin, counts, strict=True)
    return [np.linspace(start, end, n) for start, end, n in ends]


def sizing_along_z(surface: Floats, length_at: Callable[[Floats], Floats]) -> SizingField:
    """Sizing field around a surface (n_surface, 3) in mm that coarsens away from its box.

    `length_at` gives the target edge length (mm) at heights z (mm) within, both of shape (n,).
    """
    low, high = surface.min(axis=0), surface.max(axis=0)
    x, y, z = _axes_around(surface, _GRID)
    # the device's own sides are grid planes, so that coarsening starts outside of it
    x, y = (np.union1d(axis, [low[i], high[i]]) for i, axis in enumerate((x, y)))

    def lengths(points: Floats) -> Floats:
        away = np.maximum(np.maximum(low - points, points - high), 0.0).max(axis=1)
        return np.asarray(length_at(points[:, 2]) + _GROWTH_OUTSIDE * away)

    return sizing_on_grid((x, y, z), lengths)


def sizing_at_points(surface: Floats, points: Floats, lengths: Floats) -> SizingField:
    """Sizing field around a surface (n_surface, 3) in mm that coarsens away from given points.

    At the `points` (n_points, 3) in mm, all over the device, it has the edge lengths (n_points,) in
    mm.
    """
    from scipy.spatial import Delaunay, cKDTree

    axes = np.meshgrid(*_axes_around(surface, _AROUND), indexing="ij")
    grid = np.stack(axes, axis=-1).reshape(-1, 3)
    away, nearest = cKDTree(points).query(grid)
    around = away > lengths[nearest]
    everywhere = np.concatenate([points, grid[around]])
    outside = lengths[nearest[around]] + _GROWTH_OUTSIDE * away[around]
    tets = Delaunay(everywhere).simplices.astype(np.int64)
    volumes = 6.0 * tet_volumes(everywhere[tets])
    tets[volumes < 0.0] = reflected(tets[volumes < 0.0])
    # points in one plane can give tetrahedra without volume
    solid = np.abs(volumes) > 1e-9 * np.ptp(everywhere[tets], axis=1).max(axis=1) ** 3
    return SizingField(everywhere, tets[solid], np.concatenate([lengths, outside]))


#: Order in which an element's share of the error per volume falls with its size.  Smooth
#: solutions would give quadratic elements 4; most of the error sits at edges where the
#: solution is singular, and gives 1 to 2 while they are being resolved.
_ORDER = 1.5

#: One step makes elements at most this much smaller or larger: an estimate on a coarse mesh
#: is not to be trusted further.
_FINER, _COARSER = 0.3, 1.2

#: Growth of the edge length per distance (m/m); steeper, and the mesher's own quality
#: measure decides the size.
_GROWTH = 0.4

#: Lengths are rounded to steps of this ratio, so that the rounding of a solution they were
#: found from does not make another mesh.
_STEP = 1.02


@dataclass(frozen=True)
class Sizing:
    """Target edge lengths at points."""

    points: Floats  #: (n, 3) Where (m)
    lengths: Floats  #: (n,) Edge length (m); between the points it is interpolated


def sizing_for(
    mesh: Mesh, errors: Floats, wanted: float, *, shortest: float, most: float
) -> Sizing:
    """Edge lengths that bring the sum of the elements' errors down to `wanted`.

    With fewest elements each has the same error µ.  Since an element's share of the error falls
    with its volume and size, as h³⁺ᵠ, an element of error η becomes (η/µ)^(3/(3+q)) elements of
    size h (µ/η)^(1/(3+q)); that their errors µ add up to `wanted` gives µ.

    `errors` (n_cells,) are each tetrahedron's share of the error, not negative; `shortest` is the
    shortest edge (m), `most` a number of elements that the next mesh shall not exceed by much: if
    `wanted` needs more, its error is larger.
    """
    tets = mesh.cells[:, :4]
    errors = np.maximum(errors, 1e-12 * errors.max())
    power = _ORDER + 3.0
    sum_of_roots = (errors ** (3.0 / power)).sum()
    each = max((wanted / sum_of_roots) ** (power / _ORDER), (sum_of_roots / most) ** (power / 3.0))
    factor = np.clip((each / errors) ** (1.0 / power), _FINER, _COARSER)
    ends = mesh.points[tets[:, TET_EDGES]]
    mean_edge = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).mean(axis=1)
    logs = np.repeat(np.log(factor * mean_edge), 4)
    used, corner = np.unique(tets, return_inverse=True)
    corner = corner.ravel()
    lengths = np.exp(np.bincount(corner, logs) / np.bincount(corner))
    points = mesh.points[used]
    edges, _ = unique_edges(corner.reshape(-1, 4))
    lengths = limited_growth(points, edges, np.maximum(lengths, shortest), _GROWTH)
    rounded = _STEP ** np.round(np.log(lengths) / np.log(_STEP))
    return Sizing(points, rounded)


def limited_growth(points: Floats, edges: Ints, lengths: Floats, growth: float) -> Floats:
    """Lengths (n,) lowered until none differs along an edge by more than growth x distance.

    `points` are (n, 3), `edges` (n_edges, 2) pairs of these, lengths and distances in m.
    """
    lengths = lengths.copy()
    a, b = edges.T
    rise = growth * np.linalg.norm(points[a] - points[b], axis=1)
    while True:
        before = lengths.copy()
        np.minimum.at(lengths, a, before[b] + rise)
        np.minimum.at(lengths, b, before[a] + rise)
        if (lengths >= before * (1.0 - 1e-12)).all():
            return lengths


#: Points of the table that stands for the map between two stops: it is then its own exact
#: inverse, whatever the map.
_POINTS = 401


@dataclass(frozen=True)
class Stretching:
    """Squeezes z between two stops, less and less towards each of them."""

    #: The stops (mm): below and above, and right at them, nothing is squeezed
    low: float
    high: float
    most: float  #: Largest length of an element over its width; 1 squeezes nothing
    growth: float  #: How much longer an element may be per distance from a stop (1/mm)

    def squeezed(self, points: Floats) -> Floats:
        """Points (n, 3) in mm as the mesher gets to see them."""
        z, image = self._table()
        return _moved_along_z(points, z, image)

    def restored(self, points: Floats) -> Floats:
        """Squeezed points (n, 3) in mm put back."""
        z, image = self._table()
        return _moved_along_z(points, image, z)

    def _table(self) -> tuple[Floats, Floats]:
        z = np.linspace(self.low, self.high, _POINTS)
        middle = 0.5 * (z[1:] + z[:-1])
        away = np.minimum(middle - self.low, self.high - middle)
        length = np.minimum(self.most, 1.0 + self.growth * away)
        steps = np.diff(z) / length
        return z, self.low + np.concatenate([[0.0], np.cumsum(steps)])


#: Leaves everything as it is.
UNSTRETCHED = Stretching(low=0.0, high=1.0, most=1.0, growth=0.0)


def _moved_along_z(points: Floats, source: Floats, image: Floats) -> Floats:
    """Interpolate z between the tables; beyond them it moves along with their ends."""
    z = points[:, 2]
    beyond = np.where(z > source[-1], z - source[-1], np.minimum(z - source[0], 0.0))
    return np.column_stack([points[:, :2], np.interp(z, source, image) + beyond])
