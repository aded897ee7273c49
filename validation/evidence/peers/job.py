"""The bimorph as plain numbers, for programs that know nothing of this package.

A peer gets a :class:`Job` as JSON, meshes it by itself and gives back an :class:`Answer`.
Nothing here imports a model, so that a peer can run where only numpy is installed.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypedDict

import numpy as np

from tactgen.geometry.arrays import Floats, Ints, Numbers
from tactgen.validation.evidence.bench_timing import peak_memory


class Material(TypedDict):
    """Constants of one layer in the device's axes.

    Stiffness (6, 6) at constant field (Pa), coupling (3, 6) (C/m²), permittivity (3, 3) at
    constant strain (F/m); the last two are empty where there is no field.  Voigt order xx,
    yy, zz, yz, xz, xy with engineering shear strains.
    """

    stiffness: list[list[float]]
    coupling: list[list[float]]
    permittivity: list[list[float]]
    density: float


class Fineness(TypedDict, total=False):
    """How fine: `kind` "brick" or "tetra", polynomial `order`.

    Bricks through a ceramic layer, through the shim and across the width; the longest brick (m),
    the first one at the clamp (m) and the ratio of neighbours.  Tetrahedra take `longest` and
    `first` as edge lengths far from the clamp and at it.
    """

    kind: str
    order: int
    through_piezo: int
    through_shim: int
    across: int
    longest: float
    first: float
    growth: float


class Job(Fineness):
    """Three layers across x, standing on z = 0, which is clamped; free tip; 1 V.

    Lengths in m; of each material the real part, and the imaginary one.  Both outer faces of the
    ceramic are at 1 V, its faces on the shim at 0 V.  `frequencies` (Hz) are those of the damped
    sweep; without any, the job is lossless: deflection, capacitance and natural frequencies.
    """

    piezo_thickness: float
    shim_thickness: float
    width: float
    length: float
    ceramic: list[Material]
    shim: list[Material]
    modes: int
    frequencies: list[float]


class Answer(TypedDict):
    """Answer of a peer: a sweep, or natural frequencies.

    `deflection` is the mean of u_x over the tip face per volt (m/V), `capacitance` (F) that
    of both layers together, tip free; `natural` the short-circuit frequencies (Hz); `sweep`
    the complex deflection per frequency as [re, im].  `seconds` are processor times of
    mesh, assembly, factor, solve, eigen and sweep.
    """

    deflection: float
    capacitance: float
    natural: list[float]
    sweep: list[list[float]]
    unknowns: int
    seconds: dict[str, float]
    process_seconds: float
    peak_memory: int


def solved(
    frequencies: list[float], make: Callable[[], Any], assemble: Callable[[Any], Any]
) -> Answer:
    """Solve a job, or with frequencies its sweep, phase by phase, with the resources that it took.

    `assemble` gives from what `make` gives a model: its `unknowns`, and ``sweep``, or ``factor``,
    ``static`` (deflection and capacitance) and ``natural`` (the frequencies), in this order.
    """
    seconds, since = dict[str, float](), time.process_time()

    def timed(phase: str, work: Callable[[], Any]) -> Any:
        nonlocal since
        result = work()
        now = time.process_time()
        seconds[phase], since = now - since, now
        return result

    mesh = timed("mesh", make)
    model = timed("assembly", lambda: assemble(mesh))
    sweep, static, natural = [], (0.0, 0.0), []
    if frequencies:
        sweep = timed("sweep", lambda: model.sweep(frequencies))
    else:
        timed("factor", model.factor)
        static, natural = timed("solve", model.static), timed("eigen", model.natural)
    return Answer(
        deflection=static[0], capacitance=static[1], natural=natural,
        sweep=[[value.real, value.imag] for value in sweep], unknowns=model.unknowns,
        seconds=seconds, process_seconds=time.process_time(), peak_memory=peak_memory(),
    )  # fmt: skip


def tensor(parts: list[Material], name: str, *, lossy: bool) -> Numbers:
    """One of a material's tensors, complex if `lossy`."""
    real, loss = (np.array(part[name]) for part in parts)  # type: ignore[literal-required]
    return np.asarray(real + 1j * loss if lossy else real)


def potential_unit(material: Material) -> float:
    """Voltage (V) that makes entries of displacement and potential alike."""
    return float(np.sqrt(material["stiffness"][0][0] / material["permittivity"][0][0]))


def lowest_frequencies(
    inverse: Callable[[Floats], Floats], weigh: Callable[[Floats], Floats], size: int, count: int,
    *, shift: float = 0.0, basis: int | None = None, tolerance: float = 1e-8,
) -> list[float]:  # fmt: skip
    """Lowest natural frequencies (Hz) by SciPy's Lanczos with the inverse of K + shift · M.

    The potential has no mass; starting from inverse times mass keeps it where the
    displacement puts it.  A rigid motion's Ω² may be rounded below zero.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    mass = LinearOperator((size, size), matvec=weigh, dtype=float)
    found = eigsh(
        mass,  # in inverse mode the stiffness itself is not asked for
        k=count, M=mass, sigma=-shift,
        OPinv=LinearOperator((size, size), matvec=inverse, dtype=float),
        v0=inverse(weigh(np.random.default_rng(0).standard_normal(size))),
        ncv=basis or 3 * count, tol=tolerance, return_eigenvectors=False,
    )  # fmt: skip
    return [float(f) for f in np.sqrt(np.maximum(np.sort(found), 0.0)) / (2.0 * np.pi)]


#: At x > 0, at x < 0, and between.
LAYERS = ("piezo_top", "piezo_bottom", "shim")
SHIM = 2

#: Corners of a brick's faces at the low and the high end of each axis.
SIDES = (
    ([0, 3, 7, 4], [1, 2, 6, 5]), ([0, 1, 5, 4], [3, 2, 6, 7]), ([0, 1, 2, 3], [4, 5, 6, 7]),
)  # fmt: skip


@dataclass(frozen=True)
class Face:
    """Part of a named face that belongs to one layer."""

    name: str  #: ``base``, ``tip``, ``side``, and the electrodes ``outer`` and ``inner``
    #: The layer it belongs to, and the one on its other side (None on the surface)
    layer: int
    behind: int | None
    quads: Ints  #: (n, 4) Corners


@dataclass(frozen=True)
class Bricks:
    """A grid of bricks."""

    points: Floats  #: (n_points, 3) Corners (m)
    #: (n_cells, 8) Corners of each brick, lower face counterclockwise and then the upper one
    cells: Ints
    layer: Ints  #: (n_cells,) Index into :data:`LAYERS`

    def faces(self) -> list[Face]:
        """All faces on the surface and between ceramic and shim."""
        ends = self.points.min(axis=0), self.points.max(axis=0)
        half = float(self.points[self.cells[self.layer == SHIM], 0].max())
        # name, layer, the one behind, axis, its end, and the place on it
        surface = (("base", 2, 0), ("tip", 2, 1), ("side", 1, 0), ("side", 1, 1))
        wanted = [
            (name, layer, None, axis, end, ends[end][axis])
            for layer in range(len(LAYERS)) for name, axis, end in surface
        ]  # fmt: skip
        wanted += [("outer", 0, None, 0, 1, ends[1][0]), ("outer", 1, None, 0, 0, ends[0][0])]
        inner = (("inner", 0, SHIM, 0, 0, half), ("inner", 1, SHIM, 0, 1, -half))
        found = []
        for name, layer, behind, axis, end, place in (*wanted, *inner):
            quads = self.cells[self.layer == layer][:, SIDES[axis][end]]
            on = np.isclose(self.points[quads, axis], place, atol=1e-12).all(axis=1)
            found.append(Face(name, layer, behind, quads[on]))
        return found


def planes(job: Job) -> tuple[Floats, Floats, Floats]:
    """Grid planes (m) along x, y and z.

    Bricks grow from the clamp by `growth`, and shrink by 2.5 twice at most towards layer
    faces and side edges, where stress is singular too; at the tip they are as long as a
    sixth of a ceramic layer.
    """
    half, hp = 0.5 * job["shim_thickness"], job["piezo_thickness"]
    layer = _both_ends(hp, job["through_piezo"])
    shim = np.linspace(-half, half, job["through_shim"] + 1)
    return (
        np.concatenate([-half - hp + layer[:-1], shim[:-1], half + layer]),
        -0.5 * job["width"] + _both_ends(job["width"], job["across"]),
        _from_clamp(job["length"], job["first"], hp / 6.0, job["growth"], job["longest"]),
    )


def layers_across(x: Floats, half: float) -> Ints:
    """Index into :data:`LAYERS` of each interval of planes x, of a shim between ± `half`."""
    middle = 0.5 * (x[1:] + x[:-1])
    return np.where(middle > half, 0, np.where(middle < -half, 1, SHIM))


def bricks(job: Job) -> Bricks:
    """Graded grid that the job asks for."""
    x, y, z = planes(job)
    index = np.arange(x.size * y.size * z.size).reshape(x.size, y.size, z.size)
    corners = [(i, j, k) for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    cells = [
        index[i : x.size - 1 + i, j : y.size - 1 + j, k : z.size - 1 + k].ravel()
        for i, j, k in corners
    ]
    column = layers_across(x, 0.5 * job["shim_thickness"])
    points = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    return Bricks(points, np.stack(cells, axis=1), np.repeat(column, (y.size - 1) * (z.size - 1)))


def _both_ends(length: float, count: int) -> Floats:
    """Divide [0, length] with intervals that shrink towards both ends."""
    distance = np.minimum(np.arange(count), np.arange(count)[::-1])
    steps = np.minimum(2.5**distance, 2.5**2)
    return np.concatenate([[0.0], np.cumsum(steps)]) * float(length / steps.sum())


def _from_clamp(length: float, first: float, last: float, growth: float, longest: float) -> Floats:
    """Divide [0, length] with intervals growing from both ends."""
    lower, upper = [first], [max(first, last)]
    while sum(lower) + sum(upper) < length:
        side = lower if lower[-1] <= upper[-1] else upper
        side.append(min(side[-1] * growth, longest))
    steps = np.array(lower + upper[::-1])
    return np.array([0.0, *itertools.accumulate(steps)]) * float(length / steps.sum())
