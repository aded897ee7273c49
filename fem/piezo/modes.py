"""Natural modes of an assembled solid, solved for on its mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tactgen.fem.piezo.modal_model import SHIFT, ModeClass, classify
from tactgen.fem.piezo.system import SolidSystem
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Floats, Numbers, Sparse
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.tmm.ports.excitation_and_circuit import PortState

#: Residual of a mode against its inverse eigenvalue; the frequency's error is its square.
_RESIDUAL = 1e-9


def eigenpairs(
    system: SolidSystem, ends: Ends, count: int, *, open_circuit: bool = False
) -> tuple[list[float], list[Floats]]:
    """Ω² of the lowest `count` modes, ascending, and the modes, of unit modal mass.

    Inverse Lanczos at 0 Hz with the factor that statics uses as well; the potential is part of
    the indefinite operator and has no mass.  A base on springs borders that factor, tip load
    and open circuit (the electrode's charge stays zero) are updates of rank one.  Where a
    spring of the base is zero, the shift lies below 0 Hz; rigid motions are left out, and so
    is all damping at the ends.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    if not system.has_ports:  # the mean motion of such a tip is zero
        ends = Ends(ends.across if system.motion == "bending_y" else None)
    base, load = ends.base, ends.conservative_tip
    if base is not None and 0.0 in (base.lateral_stiffness, base.rotational_stiffness):
        shift = SHIFT
        mass, solve, tip = _shifted(system, base)
    else:
        shift = 0.0
        mass, solve, tip = _attached(system, base)
    n = mass.shape[0]
    updates = []
    seats = [(tip @ load.arm, load.stiffness, load.mass), (tip[:, 1], 0.0, load.inertia)]
    for seat, stiffness, inertia in seats:
        if stiffness + shift * inertia > 0.0:
            updates.append((seat, stiffness + shift * inertia))
    if open_circuit and system.has_ports:
        charge = system.charge.real  # the last per volt: the capacitance
        updates.append((charge[:n], 1.0 / float(charge[-1])))
    solve = _updated(solve, updates)

    def weigh(v: Floats) -> Floats:
        carried = sum(inertia * seat * (seat @ v) for seat, _, inertia in seats if inertia)
        return np.asarray(mass @ v + carried)

    rng = np.random.default_rng(0)
    loose = ends.rigid_motions
    wanted = min(count + loose, n - 2)
    # in inverse mode the stiffness itself is not asked for
    values, vectors = eigsh(
        LinearOperator((n, n), matvec=lambda v: v, dtype=float),
        k=wanted,
        M=LinearOperator((n, n), matvec=weigh, dtype=float),
        sigma=-shift,
        which="LM",
        OPinv=LinearOperator((n, n), matvec=solve, dtype=float),
        v0=solve(mass @ rng.standard_normal(n)),
        ncv=min(wanted + wanted // 2 + 3, n - 1),
        tol=_RESIDUAL,
    )
    elastic = np.argsort(values)[loose:]
    return [float(values[i]) for i in elastic], [vectors[:, i] for i in elastic]


def _shifted(
    system: SolidSystem, base: Springs
) -> tuple[Sparse, Callable[[Floats], Floats], Floats]:
    """Mass, inverse of K + shift · M and tip functionals, for a base that is not held."""
    mass = system.mass.with_base(np.diag([0.0, base.rotational_inertia]))
    springs = np.diag([base.lateral_stiffness, base.rotational_stiffness])
    stiffness = system.stiffness.with_base(springs)
    factor = factorise((stiffness + SHIFT * mass).tocsr())
    return mass, factor.solve, system.tip[:-1]


def _attached(
    system: SolidSystem, base: Springs | None
) -> tuple[Sparse, Callable[[Floats], Floats], Floats]:
    """Mass, inverse stiffness and tip functionals at U = 0 with the support attached."""
    held, factor = system.inner, system.held_factor
    if base is None:
        return system.mass.inner, factor.solve, system.tip[:held]
    mass = system.mass.with_base(np.diag([0.0, base.rotational_inertia]))
    follows = -factor.solve(system.stiffness.border[:, :2])
    # a body held by its base alone follows it without force, so only the springs resist
    springs = np.array([base.lateral_stiffness, base.rotational_stiffness])

    def solve(right: Floats) -> Floats:
        moved = ((right[held:] + follows.T @ right[:held]).T / springs).T
        return np.concatenate([factor.solve(right[:held]) + follows @ moved, moved])

    return mass, solve, system.tip[:-1]


def _updated(
    inverse: Callable[[Floats], Floats], updates: list[tuple[Floats, float]]
) -> Callable[[Floats], Floats]:
    """V ↦ (A + Σ weight c cᵀ)⁻¹ v by the Woodbury identity."""
    if not updates:
        return inverse
    c = np.column_stack([u for u, _ in updates])
    z = inverse(c)
    small = np.linalg.inv(np.diag([1.0 / w for _, w in updates]) + c.T @ z)

    def solve(v: Floats) -> Floats:
        x = inverse(np.asarray(v).ravel())
        return np.asarray(x - z @ (small @ (c.T @ x)))

    return solve


@dataclass(frozen=True)
class SolidState:
    """One state of motion of the solid, lossless modes real and driven states complex."""

    frequency: float  #: Hz; 0 of a static state
    values: Numbers  #: (n_nodes, 4) (u_x, u_y, u_z) in m and φ in V at the system's nodes
    tip: complex  #: Mean of u_x over the tip face, or the section where motion is measured (m)
    charge: complex  #: On the outer electrodes (C), layers in parallel
    #: Class of a mode; "bending_x" of driven states, the only motion that the ports drive
    kind: ModeClass = "bending_x"

    def scaled(self, factor: float) -> SolidState:
        """State times a real factor."""
        tip, charge = factor * self.tip, factor * self.charge
        return replace(self, values=factor * self.values, tip=tip, charge=charge)


def natural_modes(
    system: SolidSystem, ends: Ends, count: int, *, open_circuit: bool = False
) -> list[SolidState]:
    """Lowest `count` modes of a lossless system, ascending, of unit modal mass."""
    pairs = zip(*eigenpairs(system, ends, count, open_circuit=open_circuit), strict=True)
    return [mode_state(system, *pair, open_circuit=open_circuit) for pair in pairs]


def mode_state(
    system: SolidSystem, value: float, vector: Numbers, *, open_circuit: bool = False
) -> SolidState:
    """Mode of an eigenpair of :func:`eigenpairs`."""
    y = np.zeros(system.size)
    y[: vector.size] = vector
    charge = system.charge
    if open_circuit and system.has_ports:
        y[-1] = -(charge[:-1] @ y[:-1]) / charge[-1]  # no charge is left
    state = _state(system, float(np.sqrt(value)) / (2.0 * np.pi), y, complex(charge @ y))
    kind, _ = classify(system.nodes, system.node_mass, state.values[:, :3].real)
    return replace(state, kind=kind)


def driven_state(system: SolidSystem, state: PortState) -> SolidState:
    """Motion, relative to the ground, of a solid whose ports move as given.

    The system is lossy for harmonic states, lossless at 0 Hz.  Force and moment on the tip are what
    moves it so beside the base's motion and the voltage.
    """
    omega2, n = (2.0 * np.pi * state.frequency) ** 2, system.inner
    ports = system.stiffness.border - omega2 * system.mass.border
    # columns: w_base, ψ_base, U, F_tip, M_tip
    x = np.zeros((system.size, 5), dtype=np.result_type(ports, system.stiffness.inner.dtype))
    x[n:, :3] = np.eye(3)
    x[:n] = -system.dynamic_factor(omega2).solve(np.hstack([ports, -system.tip[:n]]))
    moved, given = system.tip.T @ x, state.ports[[0, 1, 4]]
    forces = np.linalg.solve(moved[:, 3:], state.ports[2:4] - moved[:, :3] @ given)
    found = _state(system, state.frequency, x @ np.append(given, forces), state.charge)
    values = found.values - state.ground * np.eye(1, 4)
    return replace(found, values=values, tip=found.tip - state.ground)


def _state(system: SolidSystem, frequency: float, y: Numbers, charge: complex) -> SolidState:
    values = (system.expand @ y).reshape(4, -1).T
    read = system.tip[:, :1] if system.measured is None else system.measured
    return SolidState(frequency, values, complex((read.T @ y)[0]), complex(charge))
