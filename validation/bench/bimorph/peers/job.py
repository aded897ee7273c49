"""The bimorph as plain numbers, for programs that know nothing of this package.

A peer gets a :class:`Job` as JSON, meshes it by itself and gives back an :class:`Answer`.
Nothing here imports a model, so that a peer can run where only numpy is installed.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypedDict

import numpy as np

from tactgen.geometry.arrays import Floats, Numbers
from tactgen.validation.bench.one_core import peak_memory


class Material(TypedDict):
    """Constants of one layer in the device's axes, real and imaginary parts apart.

    Stiffness (6, 6) at constant field (Pa), coupling (3, 6) (C/m²), permittivity (3, 3) at
    constant strain (F/m); the last two are empty where there is no field.  Voigt order xx,
    yy, zz, yz, xz, xy with engineering shear strains.
    """

    stiffness: list[list[float]]
    stiffness_loss: list[list[float]]
    coupling: list[list[float]]
    coupling_loss: list[list[float]]
    permittivity: list[list[float]]
    permittivity_loss: list[list[float]]
    density: float


class Job(TypedDict):
    """Three layers across x, standing on z = 0, which is clamped; free tip; 1 V.

    Lengths in m.  Both outer faces of the ceramic are at 1 V, its faces on the shim at 0 V.
    `frequencies` (Hz) are those of the damped sweep; without any, the job is lossless:
    deflection, capacitance and natural frequencies.

    The rest says how fine: `kind` "brick" or "tetra", polynomial `order`; bricks through a
    ceramic layer, through the shim and across the width; the longest brick (m), the first
    one at the clamp (m) and the ratio of neighbours.  Tetrahedra take `longest` and `first`
    as edge lengths far from the clamp and at it.
    """

    piezo_thickness: float
    shim_thickness: float
    width: float
    length: float
    ceramic: Material
    shim: Material
    modes: int
    frequencies: list[float]
    kind: str
    order: int
    through_piezo: int
    through_shim: int
    across: int
    longest: float
    first: float
    growth: float


class Answer(TypedDict):
    """What a peer gives back; a sweep has no natural frequencies, and the other way round.

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
    solver: str


@dataclass
class Clock:
    """Processor time of one phase after the other."""

    seconds: dict[str, float] = field(default_factory=dict)
    _since: float = field(default_factory=time.process_time)

    def stop(self, phase: str) -> None:
        """Give the time since the last stop to a phase."""
        now = time.process_time()
        self.seconds[phase] = now - self._since
        self._since = now


def tensor(values: list[list[float]], loss: list[list[float]], *, lossy: bool) -> Numbers:
    """Return one of a material's tensors, complex if `lossy`."""
    return np.array(values) + 1j * np.array(loss) if lossy else np.array(values)


def potential_unit(material: Material) -> float:
    """Return the voltage (V) that makes entries of displacement and potential alike."""
    return float(np.sqrt(material["stiffness"][0][0] / material["permittivity"][0][0]))


def lowest_frequencies(
    inverse: Callable[[Floats], Floats], weigh: Callable[[Floats], Floats], size: int, count: int
) -> list[float]:
    """Return the lowest natural frequencies (Hz) by SciPy's Lanczos with a given inverse.

    The potential has no mass; starting from inverse times mass keeps it where the
    displacement puts it.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    mass = LinearOperator((size, size), matvec=weigh, dtype=float)
    start = inverse(weigh(np.random.default_rng(0).standard_normal(size)))
    found = eigsh(
        mass,  # in inverse mode the stiffness itself is not asked for
        k=count,
        M=mass,
        sigma=0.0,
        OPinv=LinearOperator((size, size), matvec=inverse, dtype=float),
        v0=start,
        ncv=3 * count,
        tol=1e-8,
        return_eigenvectors=False,
    )
    return [float(f) for f in np.sort(np.sqrt(found)) / (2.0 * np.pi)]


def answer(
    clock: Clock,
    unknowns: int,
    solver: str,
    *,
    static: tuple[float, float] = (0.0, 0.0),
    natural: list[float] | None = None,
    sweep: list[complex] | None = None,
) -> Answer:
    """Return the answer with what this process has used so far."""
    return Answer(
        deflection=static[0],
        capacitance=static[1],
        natural=natural or [],
        sweep=[[value.real, value.imag] for value in sweep or []],
        unknowns=unknowns,
        seconds=clock.seconds,
        process_seconds=time.process_time(),
        peak_memory=peak_memory(),
        solver=solver,
    )
