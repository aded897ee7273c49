"""A reduced solid on its support as a real, stable, passive state space for time simulation.

    x' = A x + B u,   y = C x + D u,   u = forces and voltage,   y = velocities and current

In each mode i of the short-circuited actuator on its support, of unit mass,

    q_i'' + 2 ζ_i ω_i q_i' + ω_i² q_i = Σ forces · φ_i + θ_i U,

and with x = [q', ω q, √C_k u_k] the stored energy is ½ xᵀx, so that

    yᵀu − d/dt ½ xᵀx = Σ 2 ζ_i ω_i q_i'² + d_ψ ψ_base'² + Σ R_k i_k²  ≥ 0:

passive by its structure, whatever the numbers.  What differs from the reduced solid, whose
constant Q and constant tan δ no causal system has:

- each mode has viscous damping that puts its pole where the lossy solid has it, so responses
  agree at resonances, and losses between them follow the nearest resonances;
- shapes and coupling θ are those without losses (an error of the order of 1/Q of the part
  that is not the resonating mode's: dips are shallower or deeper than in the solid);
- the blocked capacitance is C − j C tan δ in the middle (geometric mean) of the frequency
  range; branches R_k C_k, two per decade, hold tan δ over the range, and with it comes the
  fall of C with frequency that causality demands, 2/π tan δ per factor e;
- what is left of C has a resistor in series, 1e-3 of its reactance at the top of the range:
  a pure capacitor's current would need the rate of U.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tactgen.fem.piezo.port_model import PortModel, extremes, motions, undamped_modes
from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.files import written_whole

#: Relaxations of the capacitance per factor e (two per decade hold tan δ to 1e-3), and how far
#: beyond the range they go (decades).
_SPACING = 0.5 * np.log(10.0)
_BEYOND = 1.5
#: Series resistance of the last branch over its reactance at the top of the range.
_SERIES = 1e-3


@dataclass(frozen=True)
class StateSpace:
    """Matrices of x' = A x + B u, y = C x + D u, energy ½ xᵀx."""

    #: (m, m), (m, p), (p, m), (p, p)
    a: Floats
    b: Floats
    c: Floats
    d: Floats
    #: Conjugate pairs, each with its unit; their products are powers (W)
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def frequency_response(self, frequencies: Floats) -> Complex:
        """C (jΩ − A)⁻¹ B + D (n, p, p)."""
        jw = 2j * np.pi * np.atleast_1d(np.asarray(frequencies, dtype=float))
        inner = jw[:, None, None] * np.eye(self.a.shape[0]) - self.a
        return np.asarray(self.c @ np.linalg.solve(inner, self.b[None].astype(complex)) + self.d)


_FORCES = ("base force (N)", "base moment (N m)", "tip force (N)", "tip moment (N m)")
_RATES = (
    "base velocity (m/s)", "base angular velocity (rad/s)",
    "tip velocity (m/s)", "tip angular velocity (rad/s)",
)  # fmt: skip


def state_space(
    model: PortModel, base: Springs | None, frequencies: tuple[float, float]
) -> StateSpace:
    """Causal model of a solid that was reduced with losses.

    `base` holds it; None is a clamp, and the base is then no port.  In the range of frequencies
    (Hz), both above 0, tan δ is held.
    """
    held = 3 if base is None else 1
    n = model.stiffness.shape[0] - held
    stiffness, mass = model.stiffness[:n, :n].copy(), model.mass[:n, :n].copy()
    ports = model.tip[:n]
    damper = np.zeros(n)
    if base is not None:
        stiffness[n - 2, n - 2] += base.lateral_stiffness
        stiffness[n - 1, n - 1] += base.rotational_stiffness
        mass[n - 1, n - 1] += base.rotational_inertia
        damper[n - 1] = np.sqrt(base.rotational_damping)
        ports = np.hstack([np.eye(n)[:, n - 2 :], ports])
    modes, s2 = undamped_modes(stiffness.real, mass)
    # Rayleigh's quotient is stationary, so the pole is right to the second order in 1/Q
    pole = np.sqrt((1.0 + 1j * np.einsum("ij,ij->j", modes, stiffness.imag @ modes)) / s2)
    omega, loss = np.abs(pole), 2.0 * np.maximum(pole.imag, 0.0)
    modes = modes / np.sqrt(s2)
    electrode = model.stiffness[:n, -1].real
    excite = np.hstack([modes.T @ ports, -(modes.T @ electrode)[:, None]])
    damping = np.diag(loss) + np.outer(modes.T @ damper, modes.T @ damper)
    capacities, times = _branches(-complex(model.stiffness[-1, -1]), *frequencies)
    return _joined(omega, damping, excite, capacities, times)


def _joined(
    omega: Floats, damping: Floats, excite: Floats, capacities: Floats, times: Floats
) -> StateSpace:
    """Put mechanics and the capacitance's branches side by side; both answer to U."""
    k, p = excite.shape
    m = 2 * k + times.size
    a, b, c, d = np.zeros((m, m)), np.zeros((m, p)), np.zeros((p, m)), np.zeros((p, p))
    a[:k, :k], a[:k, k : 2 * k], a[k : 2 * k, :k] = -damping, -np.diag(omega), np.diag(omega)
    a[2 * k :, 2 * k :] = -np.diag(1.0 / times)
    b[:k], c[:, :k] = excite, excite.T
    b[2 * k :, -1] = np.sqrt(capacities) / times
    c[-1, 2 * k :] = -b[2 * k :, -1]
    d[-1, -1] = (capacities / times).sum()
    return StateSpace(
        a, b, c, d, (*_FORCES[5 - p :], "voltage (V)"), (*_RATES[5 - p :], "current (A)")
    )


def _branches(capacitance: complex, low: float, high: float) -> tuple[Floats, Floats]:
    """Capacities (F) and time constants (s) of parallel R C branches.

    Relaxations h apart in ln τ, of C tan δ 2h/π each, make tan δ constant between them.
    """
    loss = max(-capacitance.imag, 0.0)
    first = 1.0 / (2.0 * np.pi * high * 10.0**_BEYOND)
    last = 10.0**_BEYOND / (2.0 * np.pi * low)
    times = np.exp(np.arange(np.log(first), np.log(last) + _SPACING, _SPACING))
    each = np.full(times.size if loss else 0, 2.0 * _SPACING / np.pi * loss)
    times = times[: each.size]
    middle = 4.0 * np.pi**2 * low * high
    rest = capacitance.real - (each / (1.0 + middle * times**2)).sum()
    return np.append(each, rest), np.append(times, _SERIES / (2.0 * np.pi * high))


#: What the entry `title` says.
TITLE = "state space of a piezoelectric solid on its support"
_CONVENTIONS = (
    "SI; x' = a x + b u, y = c x + d u; energy x.x / 2; inputs and outputs are conjugate, their "
    "products are powers; the load is what you connect at the tip (force = -what it takes); "
    "each mode has viscous damping in place of constant Q, the capacitance has branches of "
    "resistor and capacitor in place of a constant loss tangent"
)


def write_state_space(
    path: str | Path, model: PortModel, base: Springs | None, frequencies: tuple[float, float]
) -> None:
    """Write the state space of a reduced solid on its support, whole or not at all.

    Beside the matrices: the frequencies of all peaks and dips of the solid's response to a
    voltage in the range (Hz), its amplitudes there, and how far (relative) those of the state
    space lie, for tip velocity, tip angular velocity and current (rows).

    Raises InputError if the file cannot be written.
    """
    found = state_space(model, base, frequencies)
    at, solid, error = differences(model, base, found, frequencies)
    with written_whole(path) as temporary:
        np.savez_compressed(
            temporary,
            title=TITLE,
            conventions=_CONVENTIONS,
            **vars(found),
            range=frequencies,
            extreme_frequencies=at,
            extreme_amplitudes=np.abs(solid),
            extreme_errors=error,
        )


def differences(
    model: PortModel, base: Springs | None, found: StateSpace, frequencies: tuple[float, float]
) -> tuple[Floats, Complex, Floats]:
    """Compare with the solid at every peak and dip of its response to 1 V, the tip free.

    Frequencies (n,) in Hz; tip velocity, tip angular velocity and current of the lossy solid (3,
    n), complex; distance of the state space's (3, n), relative.
    """
    ends = Ends(base)
    at = extremes(model, *frequencies, (ends,))
    solid = 2j * np.pi * at * motions(model.multiport(at), ends)
    causal = found.frequency_response(at)[:, -3:, -1].T
    return at, solid, np.asarray(np.abs(causal - solid) / np.abs(solid))
