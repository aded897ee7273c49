"""Support and load of the lateral actuator at its ports (paper sections 3, 4)."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Bools, Complex, Floats
from tactgen.geometry.bimorph.ends import Ends, Law, Springs, TipLoad
from tactgen.geometry.device.parameters import Load, Support
from tactgen.tmm.ports.loads.finger import FINGER_RANGE, finger_stiffness
from tactgen.tmm.ports.loads.measured_law import measured_law, outside
from tactgen.tmm.ports.loads.skin_pad import SkinPad
from tactgen.tmm.ports.multiport import Multiport, hold, terminate


def known_range(load: Load) -> tuple[float, float] | None:
    """Return lowest and highest frequency (Hz) at which a load is known; None if at all.

    Raises
    ------
    InputError
        If it is a table that cannot be used.
    """
    if load.kind == "table":
        return measured_law(load).table.band
    return FINGER_RANGE if load.kind == "finger" else None


def outside_known_range(load: Load, frequencies: Floats) -> Bools:
    """Return which frequencies (n,) the load model does not cover."""
    known = known_range(load)
    if known is None:
        return np.zeros(np.shape(frequencies), dtype=bool)
    return outside(known, frequencies)


def ends_of(support: Support, load: Load) -> Ends:
    """Return what a scene's support and load are at the ports.

    A base in the rod is part of the row of pieces or of the solid, whose own lower end is held.
    What a contact is depends on the force that presses it: tmm.generator gives its springs.
    """
    if support.kind == "contact":
        raise ValueError("a contact's springs depend on its load; see tmm.generator.held_base")
    base = None
    if support.kind == "spring":
        base = Springs(
            support.lateral_stiffness,
            support.rotational_stiffness,
            support.rotational_damping,
            support.rotational_inertia,
        )
    if load.kind == "finger":
        return Ends(base, finger_stiffness)
    if load.kind == "table":
        return Ends(base, measured_law(load))
    if load.kind == "pad":
        return Ends(base, _pad(load))
    if load.kind == "mass":
        return Ends(base, TipLoad(mass=load.mass))
    if load.kind == "spring_damper":
        return Ends(base, TipLoad(load.stiffness, load.damping))
    return Ends(base)


def _pad(load: Load) -> SkinPad:
    return SkinPad(
        load.pad_modulus,
        load.pad_loss_factor,
        load.pad_thickness,
        load.pad_radius,
        load.pad_weight,
        load.pad_backing,
    )


def base_stiffness(base: Springs, frequencies: Floats) -> tuple[Complex, Complex]:
    """Return the lateral (N/m) and rotational (N m/rad) dynamic stiffness (n,) of springs.

    jΩ times the paper's R41 and R32 (eqs 7, 8).
    """
    omega = 2.0 * np.pi * np.asarray(frequencies, dtype=float)
    lateral = np.full(omega.shape, base.lateral_stiffness, dtype=complex)
    rotational = (
        base.rotational_stiffness
        + 1j * omega * base.rotational_damping
        - omega**2 * base.rotational_inertia
    )
    return lateral, rotational


def tip_stiffness(tip: TipLoad | Law, frequencies: Floats) -> Complex:
    """Return a load's lateral dynamic stiffness (n,) in N/m; jΩ times paper eq 11."""
    f = np.asarray(frequencies, dtype=float)
    if not isinstance(tip, TipLoad):
        return tip(f)
    omega = 2.0 * np.pi * f
    return np.asarray(tip.stiffness + 1j * omega * tip.damping - omega**2 * tip.mass)


def attach(port: Multiport, ends: Ends) -> Multiport:
    """Return the lateral actuator with its support and load; a clamped base is no port."""
    loads = {"w_tip": tip_stiffness(ends.tip, port.frequencies)}
    if ends.base is None:
        return terminate(hold(port, "w_base", "psi_base"), loads)
    loads["w_base"], loads["psi_base"] = base_stiffness(ends.base, port.frequencies)
    return terminate(port, loads)
