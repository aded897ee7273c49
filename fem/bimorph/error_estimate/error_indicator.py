"""How far tetrahedra are from the answer, goal by goal, and which elements are to blame.

A goal is a product of two solutions of one symmetric system: tip motion per voltage is the
response to U tested with the response to F_tip, compliance and capacitance are each response
tested with itself, a natural frequency its mode with itself.  Its error is then a(e_i, e_j)
of the two solutions' errors, so no further dual problem is solved; what each solution misses
is estimated by :mod:`fem.bimorph.error_estimate.cubic_surplus`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.fem.bimorph.error_estimate.cubic_surplus import cubic_surplus
from tactgen.fem.bimorph.system import SolidSystem
from tactgen.fem.solvers.linear_solver import refined_solution
from tactgen.geometry.arrays import Floats, Sparse
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh

#: Error over what cubics find of it.  At edges where the field is singular, and in layers as
#: thick as their elements, one degree more removes about half of the error.  Measured on job
#: J1: 1.1 to 2.2 on uniform, graded and adapted meshes of 6 000 to 150 000 unknowns, against
#: four codes' consensus and fine hexahedra (a test checks coarse ones).
#: At the sharp corners of the rod's slot it is about 3 on coarse meshes, by extrapolation, so
#: error bars are not taken from the estimate alone but from two meshes and the estimated gain.
SATURATION = 2.0
#: Share of a vector that must be new for it to extend a basis.
_NEW = 1e-8

#: Bending modes whose frequencies are goals.
_MODES = 2

#: Blocks of the Krylov space in which these modes are found.
_BLOCKS = 6


@dataclass(frozen=True)
class GoalError:
    """A goal on a mesh.

    Attributes
    ----------
    value : float
        The goal's value, SI.
    error : float
        Estimated relative error, signed: value x (1 + error) is nearer to the truth.
    shares : (n_cells,) array
        Relative contributions of the elements, not negative; they add up to the size of
        `error` or, where signs differ, to more.
    """

    value: float
    error: float
    shares: Floats


def goal_errors(device: Device, mesh: Mesh, system: SolidSystem) -> dict[str, GoalError]:
    """Return the goals and their estimated errors, base clamped, lossless.

    Parameters
    ----------
    device : Device
        Materials and poling.
    mesh : Mesh
        Tetrahedra.
    system : SolidSystem
        `device` assembled on `mesh`, lossless.

    Returns
    -------
    dict of str to GoalError
        ``tip_displacement`` (m/V), ``tip_compliance`` (m/N), ``capacitance`` (F), tip free,
        and the first ``bending_1`` … in Hz, electrodes short-circuited.
    """
    voltage, force = _static_responses(system)
    shapes, squares = _bending(system, voltage[:-3], force[:-3])
    fields = np.column_stack([voltage, force, np.vstack([shapes, np.zeros((3, squares.size))])])
    still = np.zeros(2)
    surplus = cubic_surplus(
        device,
        mesh,
        system,
        fields,
        inertia=np.concatenate([still, squares]),
        force=np.concatenate([[0.0, 1.0], np.zeros(squares.size)]),
    )
    moved, given = system.tip[:, 0], (system.stiffness @ voltage)[-1]
    found = {
        "tip_displacement": _goal(float(moved @ voltage), surplus.shares(0, 1), 1.0),
        "tip_compliance": _goal(float(moved @ force), surplus.shares(1, 1), 1.0),
        "capacitance": _goal(-float(given), surplus.shares(0, 0), 1.0),
    }
    if found["tip_displacement"].value == 0.0:  # a passive ceramic
        del found["tip_displacement"]
    for k, square in enumerate(squares):
        # modes have unit mass: a(e, e) is the error of Ω², and f goes with its root
        shares = surplus.shares(2 + k, 2 + k) / (2.0 * square)
        frequency = float(np.sqrt(square) / (2.0 * np.pi))
        found[f"bending_{k + 1}"] = _goal(frequency, frequency * shares, -1.0)
    return found


def _goal(value: float, shares: Floats, sign: float) -> GoalError:
    relative = SATURATION * shares / value if value else np.zeros_like(shares)
    return GoalError(value, sign * float(relative.sum()), np.abs(relative))


def _static_responses(system: SolidSystem) -> tuple[Floats, Floats]:
    """Return y per volt and y per newton of lateral tip force, the base held."""
    loads = np.column_stack([-system.stiffness.border[:, -1], system.tip[:-3, 0]])
    x = refined_solution(system.held, system.held_factor, loads)
    return np.append(x[:, 0], [0.0, 0.0, 1.0]), np.append(x[:, 1], [0.0, 0.0, 0.0])


def _bending(system: SolidSystem, voltage: Floats, force: Floats) -> tuple[Floats, Floats]:
    """Return the modes (n - 3, k) of unit mass that the tip force moves most, and Ω² (k,).

    Rayleigh and Ritz in the Krylov space of the static responses: the first bending modes
    come out of it far better than the mesh deserves, and nothing is factorised again.
    """
    mass, factor = system.mass.inner, system.held_factor
    basis: Floats = np.zeros((voltage.size, 0))
    block = np.column_stack([voltage, force])
    for _ in range(_BLOCKS):
        basis = _mass_orthonormal(basis, block, mass)
        block = factor.solve(mass @ basis[:, -2:])
    flexible = basis.T @ (mass @ factor.solve(mass @ basis))
    inverses, vectors = np.linalg.eigh(0.5 * (flexible + flexible.T))
    moved = (vectors.T @ (basis.T @ system.tip[:-3, 0])) ** 2 * inverses
    chosen = np.argsort(-moved)[:_MODES]
    chosen = chosen[np.argsort(-inverses[chosen])]
    # one more inverse iteration also gives the potential that belongs to each mode
    shapes = factor.solve(mass @ (basis @ vectors[:, chosen]))
    shapes = shapes / np.sqrt(np.einsum("ij,ij->j", shapes, mass @ shapes))
    return shapes, np.einsum("ij,ij->j", shapes, system.held @ shapes)


def _mass_orthonormal(basis: Floats, block: Floats, mass: Sparse) -> Floats:
    """Extend a basis that is orthonormal in the mass by what is new in a block of two."""
    for column in block.T:
        before = np.sqrt(column @ (mass @ column))
        for _ in range(2):  # twice is enough (Kahan, Parlett)
            column = column - basis @ (basis.T @ (mass @ column))
        size = np.sqrt(column @ (mass @ column))
        if size > _NEW * before:  # a voltage that moves nothing adds nothing
            basis = np.column_stack([basis, column / size])
    return basis
