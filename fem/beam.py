"""Timoshenko beam finite elements with voltage: the discretised twin of the TMM.

Weak form, for all (v, φ):  ∫ EI ψ' φ' + GA (w' + ψ)(v' + φ) − Ω² (m w v + ρI ψ φ) dz
= U ∫ K φ' dz + end forces.  Section constants are integrated over the layers here, by
Gauss quadrature of the constitutive law, not taken from closed forms.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from geometry.arrays import Complex, Floats, Ints
from geometry.beam_pieces import Piece, beam_pieces
from geometry.materials import EPS0
from geometry.parameters import Beam, Device, Support
from tmm.multiport import Multiport

#: Polynomial order of w and ψ (equal orders lock only at low order).
ORDER = 5


@dataclass(frozen=True)
class BeamMatrices:
    """Assembled beam, all (n, n) or (n,): dofs of w and ψ, then the scalar capacitance.

    `ports` are the dofs of w and ψ at the base, then at the tip.
    """

    stiffness: Complex
    mass: Floats
    coupling: Complex
    capacitance: complex
    ports: Ints


def multiport(
    device: Device,
    support: Support,
    beam: Beam,
    frequencies: Floats,
    *,
    elements: int = 8,
    lossy: bool = True,
) -> Multiport:
    """Return the beam-element model over its five ports (parallel wiring).

    Parameters
    ----------
    elements : int
        Elements along the whole row.
    """
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    matrices = assemble(device, support, beam, elements=elements, lossy=lossy)
    return Multiport(frequencies, _condense(matrices, 2.0 * np.pi * frequencies))


def elements_for(device: Device, highest: float) -> int:
    """Return a number of elements that resolves waves up to `highest` Hz along the row.

    One radian of the slowest wave per element of order five; even, at least 8.
    """
    piezo, bimorph = device.piezo, device.bimorph
    slowest = math.sqrt(min(1.0 / piezo.s55, device.shim.shear_modulus) / piezo.density)
    modulus = 1.0 / (piezo.s11 * piezo.density)
    omega = 2.0 * math.pi * highest
    bending = math.sqrt(omega / math.sqrt(modulus) / bimorph.thickness * math.sqrt(12.0))
    radians = (bimorph.length + bimorph.tab_length) * max(bending, omega / slowest)
    return int(2 * max(4, math.ceil(radians / 2.0)))


def assemble(
    device: Device, support: Support, beam: Beam, *, elements: int, lossy: bool
) -> BeamMatrices:
    """Assemble the row of beams, `elements` shared out by length, at least one a piece."""
    from skfem import Basis, BilinearForm, ElementLinePp, LinearForm, MeshLine, asm

    pieces = beam_pieces(device, support)
    constants = [_section(piece, device, beam, lossy=lossy) for piece in pieces]
    ends = np.concatenate([[0.0], np.cumsum([piece.length for piece in pieces])])
    counts = [max(1, round(elements * piece.length / ends[-1])) for piece in pieces]
    nodes = [np.linspace(a, b, n + 1)[1:] for (a, b), n in zip(pairwise(ends), counts, strict=True)]
    mesh = MeshLine(np.concatenate([[0.0], *nodes]))
    w_space = Basis(mesh, ElementLinePp(ORDER), intorder=2 * ORDER)
    basis = w_space * w_space
    ei, ga, m, rho_i, k, c = (
        np.repeat(column, counts)[:, None] for column in zip(*constants, strict=True)
    )

    @BilinearForm(dtype=complex)  # type: ignore[untyped-decorator]
    def elastic(w: Any, psi: Any, v: Any, phi: Any, _: Any) -> Any:
        shear = (w.grad[0] + psi) * (v.grad[0] + phi)
        return ei * psi.grad[0] * phi.grad[0] + ga * shear

    @BilinearForm  # type: ignore[untyped-decorator]
    def inertial(w: Any, psi: Any, v: Any, phi: Any, _: Any) -> Any:
        return m.real * w * v + rho_i.real * psi * phi

    @LinearForm(dtype=complex)  # type: ignore[untyped-decorator]
    def moment_per_voltage(v: Any, phi: Any, _: Any) -> Any:
        return k * phi.grad[0] + 0.0 * v

    w_dofs = w_space.nodal_dofs[0]
    first, last = (w_dofs[np.argmin(mesh.p[0])], w_dofs[np.argmax(mesh.p[0])])
    return BeamMatrices(
        stiffness=asm(elastic, basis).toarray(),
        mass=asm(inertial, basis).toarray(),
        coupling=asm(moment_per_voltage, basis),
        capacitance=complex(np.sum(c[:, 0] * np.diff(np.sort(mesh.p[0])))),
        ports=np.array([first, first + w_space.N, last, last + w_space.N]),
    )


def bending_frequencies(
    matrices: BeamMatrices,
    *,
    clamped: bool,
    base: tuple[float, float, float],
    tip: tuple[float, float],
    count: int,
    open_circuit: bool,
) -> Floats:
    """Return the lowest elastic natural frequencies (Hz) of lossless matrices.

    Parameters
    ----------
    base : tuple of float
        Lateral and rotational stiffness and rotational inertia of the support.
    tip : tuple of float
        Stiffness and mass of the load.
    """
    from scipy.linalg import eigh

    k, m = matrices.stiffness.real.copy(), matrices.mass.copy()
    w0, psi0, w1, _ = matrices.ports
    if open_circuit:
        charge = matrices.coupling.real
        k += np.outer(charge, charge) / matrices.capacitance.real
    k[w1, w1] += tip[0]
    m[w1, w1] += tip[1]
    held = matrices.ports[: 2 if clamped else 0]
    if not clamped:
        k[w0, w0] += base[0]
        k[psi0, psi0] += base[1]
        m[psi0, psi0] += base[2]
    free = np.setdiff1d(np.arange(k.shape[0]), held)
    k, m = k[np.ix_(free, free)], m[np.ix_(free, free)]
    rough = eigh(k, m, eigvals_only=True)
    elastic = rough[rough > 1e-9 * rough[min(count + 2, rough.size) - 1]]
    # the lowest values of (k, m) carry the rounding of the highest; as the highest of the
    # inverse pencil they are exact to a few digits of machine precision
    shift = float(elastic[0])
    inverse = eigh(m, k + shift * m, eigvals_only=True, subset_by_index=_top(k.shape[0], count + 2))
    values = np.sort(1.0 / inverse) - shift
    return np.asarray(np.sqrt(values[values > 0.5 * shift][:count]) / (2.0 * np.pi))


def _top(size: int, count: int) -> list[int]:
    return [max(size - count, 0), size - 1]


def _condense(matrices: BeamMatrices, omega: Floats) -> Complex:
    """Return D (n, 5, 5): interior dofs, a band when numbered along z, eliminated."""
    from scipy.linalg import solve_banded
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    ports = matrices.ports
    inner = np.setdiff1d(np.arange(matrices.mass.shape[0]), ports)
    pattern = csr_matrix(
        matrices.mass[np.ix_(inner, inner)] + abs(matrices.stiffness[np.ix_(inner, inner)])
    )
    inner = inner[reverse_cuthill_mckee(pattern, symmetric_mode=True)]
    inside = np.ix_(inner, inner)
    width, k_band, m_band = _bands(matrices.stiffness[inside], matrices.mass[inside])
    held = np.concatenate([matrices.stiffness[:, ports], -matrices.coupling[:, None]], axis=1)
    moving = np.concatenate(
        [matrices.mass[:, ports], np.zeros((matrices.mass.shape[0], 1))], axis=1
    )
    d = np.zeros((omega.size, 5, 5), dtype=complex)
    for i, o2 in enumerate(omega**2):
        to_ports = held - o2 * moving
        solved = solve_banded((width, width), k_band - o2 * m_band, to_ports[inner])
        d[i, :4] = to_ports[ports]
        d[i, 4, :4], d[i, 4, 4] = matrices.coupling[ports], matrices.capacitance
        d[i] -= np.vstack([to_ports[inner, :4].T, matrices.coupling[inner]]) @ solved
    return d


def _bands(k: Complex, m: Floats) -> tuple[int, Complex, Floats]:
    """Return the half bandwidth and both matrices in LAPACK's band storage."""
    rows, columns = np.nonzero(abs(k) + abs(m))
    width = int(np.abs(rows - columns).max())
    k_band = np.zeros((2 * width + 1, k.shape[0]), dtype=complex)
    m_band = np.zeros((2 * width + 1, k.shape[0]))
    k_band[width + rows - columns, columns] = k[rows, columns]
    m_band[width + rows - columns, columns] = m[rows, columns]
    return width, k_band, m_band


def _section(piece: Piece, device: Device, beam: Beam, *, lossy: bool) -> tuple[complex, ...]:
    """Return (EI, GA, m, rhoI, K, C) of a piece by integration over its section."""
    if piece.section == "cylinder":
        return _cylinder_section(piece.radius, device)
    bimorph, piezo, shim = device.bimorph, device.piezo, device.shim
    half, hp, b = 0.5 * bimorph.shim_thickness, bimorph.piezo_thickness, bimorph.width
    layers: list[tuple[float, float, complex, float, float, float]] = [
        (-half, half, shim.youngs_modulus, shim.shear_modulus, shim.density, 0.0)
    ]
    modulus = (1.0 + 1j / piezo.quality_factor if lossy else 1.0) / piezo.s11
    if piece.section == "bimorph":
        # field along x per volt between outer electrode and shim
        layers.append((half, half + hp, modulus, 1.0 / piezo.s55, piezo.density, -1.0 / hp))
        layers.append((-half - hp, -half, modulus, 1.0 / piezo.s55, piezo.density, 1.0 / hp))
    d31 = bimorph.poling_sign * piezo.d31
    eps = piezo.eps33 * EPS0 * (1.0 - 1j * piezo.loss_tangent if lossy else 1.0)
    out = np.zeros(6, dtype=complex)
    for low, high, e, g, rho, field in layers:
        for x, weight in _gauss(low, high):
            area = b * weight
            # stress per curvature: E x; per volt: −E d31 field.  D = d31 E x ψ' + eps* field,
            # and the charge on the electrodes is −∫ D field dA
            out += area * np.array(
                [
                    e * x**2,
                    beam.shear_correction * g,
                    rho,
                    rho * x**2,
                    e * d31 * field * x,
                    (eps - e * d31**2) * field**2,
                ]
            )
    return tuple(out)


def _cylinder_section(radius: float, device: Device) -> tuple[complex, ...]:
    """Integrate a solid disc in strips; Cowper's (1966) shear correction."""
    rod = device.rod
    area = inertia = 0.0
    for angle, weight in _gauss(-0.5 * math.pi, 0.5 * math.pi, points=16):
        x, strip = radius * math.sin(angle), 2.0 * (radius * math.cos(angle)) ** 2
        area += weight * strip
        inertia += weight * strip * x**2
    shear = rod.youngs_modulus / (2.0 * (1.0 + rod.poisson_ratio))
    shear *= 6.0 * (1.0 + rod.poisson_ratio) / (7.0 + 6.0 * rod.poisson_ratio)
    e, rho = rod.youngs_modulus, rod.density
    return (e * inertia, shear * area, rho * area, rho * inertia, 0.0, 0.0)


def _gauss(low: float, high: float, points: int = 3) -> Iterable[tuple[float, float]]:
    x, weights = np.polynomial.legendre.leggauss(points)
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    return [(centre + half * float(a), half * float(b)) for a, b in zip(x, weights, strict=True)]
