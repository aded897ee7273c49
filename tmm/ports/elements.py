"""Elements that join others at their ports: rigid rod, spring, contact, lumped mass, coil circuit.

Each is reciprocal and passive and has a finite D(Ω) at 0 Hz.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.ports.multiport import Multiport, connect
from tactgen.tmm.ports.port import (
    AXIAL,
    CHARGE,
    LATERAL,
    LINK_FORCE,
    LINK_MOMENT,
    ROTATION,
    Pair,
    Port,
)

#: Both ends of a rod that moves in the bending plane, and what goes through it.
RIGID_ROD = (
    Port("w_low", LATERAL),
    Port("psi_low", ROTATION),
    Port("w_high", LATERAL),
    Port("psi_high", ROTATION),
    Port("link_force", LINK_FORCE),
    Port("link_moment", LINK_MOMENT),
)


def rigid_rod(
    frequencies: Floats,
    *,
    length: float,
    mass: float = 0.0,
    inertia: float = 0.0,
    centre: float | None = None,
) -> Multiport:
    """Return a rigid body in the bending plane, with ports at two heights.

    Its ends have one motion, w_high = w_low − l ψ_low and ψ_high = ψ_low, which no stiffness
    can say.  So the force and the moment through it are ports too, answered by gap and kink,
    w_low − l ψ_low − w_high and ψ_low − ψ_high; left free they close both (a Lagrange
    multiplier).  :func:`tmm.ports.multiport.reduce` removes them with the end that is joined.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    length : float
        Height (m) of the upper end above the lower one.
    mass : float
        kg.
    inertia : float
        About the centre of mass (kg m²).
    centre : float, optional
        Height (m) of the centre of mass above the lower end; the middle by default.
    """
    f = np.atleast_1d(np.asarray(frequencies, dtype=float))
    c = 0.5 * length if centre is None else centre
    at_rest, masses = np.zeros((6, 6)), np.zeros((6, 6))
    # w = w_low − c ψ_low at the centre of mass
    masses[:2, :2] = [[mass, -c * mass], [-c * mass, inertia + c * c * mass]]
    arm = np.array([[1.0, -length], [0.0, 1.0]])
    at_rest[4:, :4] = np.hstack([arm, -np.eye(2)])
    at_rest[:4, 4:] = at_rest[4:, :4].T
    omega2 = (2.0 * np.pi * f)[:, None, None] ** 2
    return Multiport(f, at_rest - omega2 * masses + 0j, RIGID_ROD)


def spring(
    frequencies: Floats,
    pair: Pair,
    *,
    stiffness: float,
    damping: float = 0.0,
    ends: tuple[str, str] = ("low", "high"),
) -> Multiport:
    """Return a spring with a viscous damper between two motions of one kind.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    pair : Pair
        LATERAL, AXIAL or ROTATION.
    stiffness, damping : float
        Effort per motion, and per rate of motion: N/m and N s/m, or N m/rad and N m s/rad.
    ends : (str, str)
        Names of the two ports.
    """
    f = np.atleast_1d(np.asarray(frequencies, dtype=float))
    value = stiffness + 2j * np.pi * f * damping
    between = np.array([[1.0, -1.0], [-1.0, 1.0]])
    ports = tuple(Port(name, pair) for name in ends)
    return Multiport(f, value[:, None, None] * between, ports)


def contact(
    frequencies: Floats,
    *,
    normal: tuple[float, float],
    tangential: tuple[float, float] = (0.0, 0.0),
) -> Multiport:
    """Return a contact of two bodies about the state that presses them together.

    What moves is what is added to that state, so small that the bodies keep touching.  Ports
    are u_low and u_high across the contact, along the axis, and w_low and w_high in its plane.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    normal, tangential : (float, float)
        Slope of the contact's law there (N/m), and damping (N s/m).
    """
    across, along = (
        spring(
            frequencies,
            pair,
            stiffness=stiffness,
            damping=damping,
            ends=(f"{pair.motion}_low", f"{pair.motion}_high"),
        )
        for pair, (stiffness, damping) in ((AXIAL, normal), (LATERAL, tangential))
    )
    return connect(across, along, {})


def lumped_mass(frequencies: Floats, pair: Pair, mass: float, name: str = "mass") -> Multiport:
    """Return a mass (kg) that moves along, or an inertia (kg m²) that turns about, one port."""
    f = np.atleast_1d(np.asarray(frequencies, dtype=float))
    value = -((2.0 * np.pi * f) ** 2) * mass + 0j
    return Multiport(f, value[:, None, None], (Port(name, pair),))


def coil(frequencies: Floats, *, resistance: float, inductance: float) -> Multiport:
    """Return a coil's circuit over the charge that went through it: V = (jΩ R − Ω² L) q.

    In charge and not in current, so that a direct current's rest is no pole at 0 Hz.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    resistance : float
        Ω.
    inductance : float
        Of the linearised coil, the slope of flux linkage over current (H).
    """
    f = np.atleast_1d(np.asarray(frequencies, dtype=float))
    omega = 2.0 * np.pi * f
    value = 1j * omega * resistance - omega**2 * inductance
    return Multiport(f, value[:, None, None], (Port("charge", CHARGE),))
