"""Supports and loads of a scene as springs, dampers and masses, and how ports carry them.

Reciprocal and passive, with a finite D(Ω) at 0 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tactgen.geometry.arrays import Bools, Complex, Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends, Law, Springs, TipLoad
from tactgen.geometry.device.parameters import Load, Support
from tactgen.geometry.device.support_table import support_table
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.finger_and_pad import (
    FINGER_RANGE,
    SkinPad,
    finger_impedance,
    finger_stiffness,
)
from tactgen.tmm.ports.measured_loads import (
    Dictionary,
    MeasuredLaw,
    MeasuredSupport,
    PassiveFit,
    measured_law,
    outside,
    passive_fit,
)
from tactgen.tmm.ports.multiport import Multiport, Pair, Port, hold, terminate


def spring(
    frequencies: Floats,
    pair: Pair,
    *,
    stiffness: float,
    damping: float = 0.0,
    ends: tuple[str, str] = ("low", "high"),
) -> Multiport:
    """Spring with a viscous damper between two motions of one kind, at frequencies (n,) in Hz.

    Stiffness and damping are efforts per motion, and per rate of motion: N/m and N s/m, or N m/rad
    and N m s/rad.  `ends` are the names of the two ports.
    """
    f = np.atleast_1d(np.asarray(frequencies, dtype=float))
    value = stiffness + 2j * np.pi * f * damping
    between = np.array([[1.0, -1.0], [-1.0, 1.0]])
    ports = tuple(Port(name, pair) for name in ends)
    return Multiport(f, value[:, None, None] * between, ports)


#: Points over the finger's range to which its load is fitted.
_POINTS = 200
#: A few resonators for the finger.  Its magnitude and phase were fitted each by itself, and no
#: passive load has both: five times as many parts come as near as 8 % (root mean square), these 9.
_FEW = Dictionary(per_decade=3, ratios=(0.7,), reach=3.0)


#: Stiffness of a hinge (N/m): a bimorph beside it has 1e6 at most.
_HINGE = 1e12


@dataclass(frozen=True)
class Chain:
    """A mechanical network whose first coordinate is the tip."""

    #: (q, q) Symmetric, none negative; coordinates without mass are held by a damper
    mass: Floats
    damping: Floats
    stiffness: Floats
    carried: float = 0.0  #: What moves with the tip along the axis too (kg)
    #: Largest relative distance from the law that it stands for, in the law's own range
    misfit: float = 0.0

    def stiffness_at(self, frequencies: Floats) -> Complex:
        """Dynamic stiffness (n,) in N/m at the tip, at frequencies above 0 (Hz)."""
        s = 2j * np.pi * np.asarray(frequencies, dtype=float)[:, None, None]
        whole = self.mass * s**2 + self.damping * s + self.stiffness
        if whole.shape[1] == 1:
            return np.asarray(whole[:, 0, 0])
        inner = np.linalg.solve(whole[:, 1:, 1:], whole[:, 1:, :1])
        return np.asarray(whole[:, 0, 0] - (whole[:, :1, 1:] @ inner)[:, 0, 0])


def chain_of(tip: TipLoad | Law) -> Chain:
    """Load of a tip as parts.

    Raises InputError if it is a law of frequency to which no parts are fitted.
    """
    if isinstance(tip, TipLoad):
        if tip.has_size:
            raise InputError(
                f"load.offset = {1e3 * tip.offset:g} mm and load.rotational_inertia = "
                f"{tip.inertia:g} kg*m^2 are not known to time simulation and rocking; set both "
                "to 0"
            )
        mass, damping, stiffness = np.reshape([tip.mass, tip.damping, tip.stiffness], (3, 1, 1))
        return Chain(mass, damping, stiffness, carried=tip.mass)
    if tip is finger_stiffness:
        return finger_chain()
    if isinstance(tip, MeasuredLaw) and tip.fits:
        return _of_fit(tip.fits[0], tip.misfit[0])
    remedy = 'load.kind = "none", "mass", "spring_damper" or "finger"'
    if isinstance(tip, MeasuredLaw):
        remedy = "load.extrapolation = passive_fit"
    raise InputError(
        "the load is a law of frequency, which time simulation takes as springs, dampers and "
        f"masses only; set {remedy}"
    )


@lru_cache(maxsize=1)
def finger_chain() -> Chain:
    """Paper's finger (eqs 1-3) as parts, fitted over its own range."""
    frequencies = np.geomspace(*FINGER_RANGE, _POINTS)
    impedance = finger_impedance(frequencies)
    fit = passive_fit(frequencies, impedance, _FEW)
    off = fit.stiffness_at(frequencies) / (2j * np.pi * frequencies * impedance) - 1.0
    return _of_fit(fit, float(np.abs(off).max()))


def _of_fit(fit: PassiveFit, misfit: float) -> Chain:
    """Parts of a fit."""
    width = 2.0 * fit.ratio * fit.omega
    grounded = fit.b / width
    rows = [(k, w, d) for k, w, d in zip(grounded, fit.omega, width, strict=True) if k > 0.0]
    series = [
        (k, w, d) for k, w, d in zip(fit.a - grounded, fit.omega, width, strict=True) if k > 0.0
    ]
    count = 1 + len(rows) + 2 * len(series)
    mass, damping, stiffness = (np.zeros((count, count)) for _ in range(3))
    mass[0, 0], damping[0, 0], stiffness[0, 0] = fit.mass, fit.damping, fit.stiffness
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    at = 1
    for k, w, d in rows:
        stiffness[np.ix_([0, at], [0, at])] += k * pair
        mass[at, at], damping[at, at] = k / w**2, k * d / w**2
        at += 1
    for k, w, d in series:
        stiffness[np.ix_([0, at], [0, at])] += k * pair
        damping[np.ix_([at, at + 1], [at, at + 1])] += (k / d) * pair
        mass[at + 1, at + 1] = k / w**2
        at += 2
    return Chain(mass, damping, stiffness, misfit=misfit)


def outside_known_range(load: Load, frequencies: Floats) -> Bools:
    """Mask (n,) of frequencies (Hz) that the load model does not cover.

    Raises InputError if it is a table that cannot be used.
    """
    if load.kind == "table":
        return outside(measured_law(load).table.band, frequencies)
    if load.kind == "finger":
        return outside(FINGER_RANGE, frequencies)
    return np.zeros(np.shape(frequencies), dtype=bool)


def ends_of(support: Support, load: Load) -> Ends:
    """Boundary conditions at the ports of a scene's support and load.

    A base in the rod is part of the row of pieces or of the solid, whose own lower end is held.
    What a contact is depends on the force that presses it: tmm.generator gives its springs.
    """
    if support.kind == "contact":
        raise ValueError("a contact's springs depend on its load; see tmm.generator.equilibrium")
    base = None
    if support.kind == "pinned":
        base = Springs(_HINGE, 0.0)
    if support.kind == "table":
        law = MeasuredSupport(support_table(support), _HINGE)
        lateral, rotational = law.at_rest
        base = Springs(lateral, rotational, law=law)
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
        sheet = load.pad_modulus, load.pad_loss_factor, load.pad_thickness, load.pad_radius
        return Ends(base, SkinPad(*sheet, load.pad_weight, load.pad_backing))
    if load.kind == "mass":
        tip = TipLoad(mass=load.mass, offset=load.offset, inertia=load.rotational_inertia)
        return Ends(base, tip)
    if load.kind == "pinned":
        return Ends(base, TipLoad(_HINGE))
    if load.kind == "spring_damper":
        return Ends(base, TipLoad(load.stiffness, load.damping))
    return Ends(base)


def base_stiffness(base: Springs, frequencies: Floats) -> tuple[Complex, Complex]:
    """Lateral (N/m) and rotational (N m/rad) dynamic stiffness (n,) of springs.

    jΩ times the paper's R41 and R32 (eqs 7, 8).
    """
    if base.law is not None:
        return base.law(np.asarray(frequencies, dtype=float))
    omega = 2.0 * np.pi * np.asarray(frequencies, dtype=float)
    lateral = np.full(omega.shape, base.lateral_stiffness, dtype=complex)
    rotational = (
        base.rotational_stiffness
        + 1j * omega * base.rotational_damping
        - omega**2 * base.rotational_inertia
    )
    return lateral, rotational


def tip_stiffness(tip: TipLoad | Law, frequencies: Floats) -> Complex:
    """Load's lateral dynamic stiffness (n,) in N/m at its arm's end; jΩ times paper eq 11."""
    f = np.asarray(frequencies, dtype=float)
    if not isinstance(tip, TipLoad):
        return tip(f)
    omega = 2.0 * np.pi * f
    return np.asarray(tip.stiffness + 1j * omega * tip.damping - omega**2 * tip.mass)


def tip_matrix(tip: TipLoad | Law, frequencies: Floats) -> Complex:
    """Load's dynamic stiffness (n, 2, 2) over the tip's [w, ψ]."""
    lateral = tip_stiffness(tip, frequencies)
    found = np.zeros((*np.shape(frequencies), 2, 2), dtype=complex)
    found[..., 0, 0] = lateral
    if isinstance(tip, TipLoad) and tip.has_size:
        omega = 2.0 * np.pi * np.asarray(frequencies, dtype=float)
        found[..., 0, 1] = found[..., 1, 0] = -lateral * tip.offset
        found[..., 1, 1] = lateral * tip.offset**2 - omega**2 * tip.inertia
    return found


def load_motion(tip: TipLoad | Law, w: Complex, psi: Complex) -> Complex:
    """Lateral motion (n,) of the load from the tip's."""
    return w - tip.offset * psi if isinstance(tip, TipLoad) else w


def load_tip(port: Multiport, tip: TipLoad | Law) -> Multiport:
    """Lateral actuator, or what it is part of, with a load at its tip."""
    at = [port.index("w_tip"), *([port.index("psi_tip")] if "psi_tip" in port.names else [])]
    stiffness = port.stiffness.copy()
    rows = np.ix_(range(stiffness.shape[0]), at, at)
    stiffness[rows] += tip_matrix(tip, port.frequencies)[:, : len(at), : len(at)]
    return replace(port, stiffness=stiffness)


def attach(port: Multiport, ends: Ends) -> Multiport:
    """Lateral actuator with its support and load; a clamped base is no port."""
    loaded = load_tip(port, ends.tip)
    if ends.base is None:
        return hold(loaded, "w_base", "psi_base")
    lateral, rotational = base_stiffness(ends.base, port.frequencies)
    return terminate(loaded, {"w_base": lateral, "psi_base": rotational})
