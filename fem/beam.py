"""Timoshenko beam finite elements with voltage: the discretised twin of the TMM.

Weak form, for all (v, φ):  ∫ EI ψ' φ' + GA (w' + ψ)(v' + φ) − Ω² (m w v + ρI ψ φ) dz
= U ∫ K φ' dz + end forces.  A taper is known to the elements at every quadrature point.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints, Numbers
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.segments import (
    CentreLine,
    Piece,
    StackLayer,
    beam_pieces,
    measured_pieces,
    stack,
)
from tactgen.geometry.device.materials import EPS0, lossy_coupling, lossy_modulus
from tactgen.geometry.device.parameters import Beam, Device, Piezo, Shim, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.excitation_and_circuit import PortState
from tactgen.tmm.ports.multiport import BIMORPH, MEASURED, Multiport


def section_constants(
    piece: Piece, device: Device, beam: Beam, share: Floats, *, lossy: bool
) -> Complex:
    """EI, GA, m, rhoI, K, C (6, n) at n shares of a piece's length.

    By integration over the layers, of which no axial force acts on the whole: the strain at x = 0
    is an unknown beside curvature and voltage.  Where a ceramic has no electrodes its own voltage
    is one more, by which it stays without charge.
    """
    if piece.section == "cylinder":
        cylinder = _cylinder_section(piece.radius, device, lossy=lossy)
        return np.repeat(cylinder[:, None], share.size, axis=1)
    layers = stack(piece, device, share)
    bare = [layer for layer in layers if isinstance(layer.material, Piezo) and not layer.electrodes]
    # energy ½ vᵀ H v of v = (ε, κ, U, voltages of bare layers), charges being minus its slopes
    energy = np.zeros((share.size, 3 + len(bare), 3 + len(bare)), dtype=complex)
    inertia, shear = np.zeros((3, share.size)), np.zeros(share.size, dtype=complex)
    for layer in layers:
        at = 3 + bare.index(layer) if layer in bare else 2
        _integrate(layer, at, energy, inertia, shear, lossy=lossy)
    without_charge = _condensed(energy, list(range(3, 3 + len(bare))), [0, 1, 2])
    kept = _condensed(without_charge, [0], [1, 2])
    axis = (without_charge[:, 0, 1] / without_charge[:, 0, 0]).real
    width = piece.layers(device.bimorph, share).width
    turning = inertia[2] - 2.0 * axis * inertia[1] + axis**2 * inertia[0]
    found = (kept[:, 0, 0], beam.shear_correction * shear, inertia[0], turning)
    return np.asarray(width * np.stack([*found, -kept[:, 0, 1], -kept[:, 1, 1]]))


def _condensed(energy: Complex, free: list[int], kept: list[int]) -> Complex:
    """Quadratic form (n, k, k) over some unknowns, the `free` ones following them."""
    own, tied = energy[:, free][:, :, free], energy[:, free][:, :, kept]
    change = np.swapaxes(tied, 1, 2) @ np.linalg.solve(own, tied)
    return np.asarray(energy[:, kept][:, :, kept] - change)


def _integrate(
    layer: StackLayer,
    voltage: int,
    energy: Complex,
    inertia: Floats,
    shear: Complex,
    *,
    lossy: bool,
) -> None:
    """Add one layer's share; `voltage` is the place of its own among the unknowns."""
    of = layer.material
    none = np.zeros(shear.size)
    low, high = layer.low + none, layer.high + none
    if isinstance(of, Piezo):
        young = (1.0 + 1j / of.quality_factor if lossy else 1.0) / of.s11
        stiffness = 1.0 / of.s55
    else:
        young = lossy_modulus(of.youngs_modulus, of.loss_factor, lossy=lossy)
        stiffness = 0.5 * young / (1.0 + of.poisson_ratio)
        if isinstance(of, Shim):
            stiffness = lossy_modulus(of.shear_modulus, of.loss_factor, lossy=lossy)
    for x, thick in gauss(low, high):
        weight = layer.share * thick
        strain = np.zeros((shear.size, energy.shape[1]), dtype=complex)
        strain[:, 0], strain[:, 1] = 1.0, x
        energy += (young * weight)[:, None, None] * strain[:, :, None] * strain[:, None, :]
        shear += stiffness * weight
        inertia += of.density * weight * np.stack([none + 1.0, x, x**2])
        if not isinstance(of, Piezo):
            continue
        # field along x per volt; T = E (S − d E_x), D = d E S + (ε − d² E) E_x
        field = np.zeros_like(strain)
        field[:, voltage] = -(layer.hot if layer.electrodes else 1.0) / (high - low)
        d31 = layer.poling * lossy_coupling(of.d31, of.coupling_loss, lossy=lossy)
        clamped = of.eps33 * EPS0 * (1.0 - 1j * of.loss_tangent if lossy else 1.0)
        clamped -= d31**2 * young
        crossed = strain[:, :, None] * field[:, None, :]
        both = crossed + np.swapaxes(crossed, 1, 2)
        energy -= (young * d31 * weight)[:, None, None] * both
        energy -= (clamped * weight)[:, None, None] * field[:, :, None] * field[:, None, :]


def _cylinder_section(radius: float, device: Device, *, lossy: bool) -> Numbers:
    """Integrate a solid disc in strips; Cowper's (1966) shear correction."""
    rod = device.rod
    area = inertia = 0.0
    for angle, weight in gauss(-0.5 * math.pi, 0.5 * math.pi, points=16):
        x, strip = radius * math.sin(angle), 2.0 * (radius * math.cos(angle)) ** 2
        area += weight * strip
        inertia += weight * strip * x**2
    e, rho = lossy_modulus(rod.youngs_modulus, rod.loss_factor, lossy=lossy), rod.density
    shear = e / (2.0 * (1.0 + rod.poisson_ratio))
    shear *= 6.0 * (1.0 + rod.poisson_ratio) / (7.0 + 6.0 * rod.poisson_ratio)
    return np.array([e * inertia, shear * area, rho * area, rho * inertia, 0.0, 0.0])


def gauss(low: Any, high: Any, points: int = 3) -> list[tuple[Any, Any]]:
    """Points and weights between two ends, numbers or arrays."""
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    return [(centre + half * a, half * b) for a, b in _rule(points)]


@cache
def _rule(points: int) -> list[tuple[float, float]]:
    """Points and weights of Gauss' rule on −1 to 1."""
    x, weights = np.polynomial.legendre.leggauss(points)
    return list(zip(x.tolist(), weights.tolist(), strict=True))


#: Elements along a row whose nodes are its stations.
ELEMENTS = 64


def mode_lines(
    matrices: BeamMatrices, ends: Ends, count: int, *, open_circuit: bool
) -> list[CentreLine]:
    """Lowest `count` elastic modes of lossless matrices, of unit tip displacement."""
    from scipy.linalg import eigh

    coupling, capacitance = matrices.coupling.real, matrices.capacitance.real
    k, m, free = _supported(matrices, ends, open_circuit=open_circuit)
    wanted = ends.rigid_motions + count
    values, vectors = eigh(k, m, subset_by_index=[0, wanted - 1])
    found = []
    for value, vector in list(zip(values, vectors.T, strict=True))[ends.rigid_motions :]:
        motion = np.zeros(coupling.size)
        motion[free] = vector
        motion /= motion[matrices.ports[2]]
        held = float(coupling @ motion)
        voltage = -held / capacitance if open_circuit else 0.0
        charge = 0.0 if open_circuit else held
        found.append(_line(matrices, motion, charge, voltage, np.sqrt(value) / (2.0 * np.pi)))
    return found


def _supported(
    matrices: BeamMatrices, ends: Ends, *, open_circuit: bool
) -> tuple[Floats, Floats, Ints]:
    """Lossless stiffness and mass with support and load, over the dofs that are free, and these.

    Damping at the ends is left out.
    """
    k, m = matrices.stiffness.real / matrices.unit, matrices.mass / matrices.unit
    w0, psi0, *at_tip = matrices.ports
    if open_circuit:
        charge = matrices.coupling.real / matrices.unit
        k += np.outer(charge, charge) / (matrices.capacitance.real / matrices.unit)
    for matrix, loaded in zip((k, m), ends.conservative_tip.at_tip, strict=True):
        matrix[np.ix_(at_tip, at_tip)] += loaded
    base = ends.base
    if base is not None:
        k[w0, w0] += base.lateral_stiffness
        k[psi0, psi0] += base.rotational_stiffness
        m[psi0, psi0] += base.rotational_inertia
    free = np.setdiff1d(np.arange(k.shape[0]), matrices.ports[: 2 if base is None else 0])
    inside = np.ix_(free, free)
    return k[inside], m[inside], free


def driven_line(matrices: BeamMatrices, state: PortState) -> CentreLine:
    """Motion, relative to the ground, between ends that move as given."""
    dynamic = matrices.stiffness - (2.0 * np.pi * state.frequency) ** 2 * matrices.mass
    *ends, voltage = state.ports
    motion = np.zeros(dynamic.shape[0], dtype=complex)
    motion[list(matrices.ports)] = ends
    inner = np.setdiff1d(np.arange(motion.size), matrices.ports)
    right = matrices.coupling[inner] * voltage - dynamic[inner] @ motion
    motion[inner] = np.linalg.solve(dynamic[np.ix_(inner, inner)], right)
    z, w, psi = _stations(matrices)
    return state.line(z, motion[w], motion[psi])


def _line(
    matrices: BeamMatrices, motion: Numbers, charge: complex, voltage: complex, frequency: float
) -> CentreLine:
    z, w, psi = _stations(matrices)
    return CentreLine(z, motion[w], motion[psi], charge, voltage, frequency)


def _stations(matrices: BeamMatrices) -> tuple[Floats, Ints, Ints]:
    z, w, psi = (np.array(column) for column in zip(*matrices.stations, strict=True))
    return z, w, psi


def thinnest(piece: Piece, device: Device) -> float:
    """Least thickness (m) of a piece in the direction in which it bends."""
    if piece.section == "cylinder":
        return 2.0 * piece.radius
    layers = stack(piece, device, np.array([0.0, 1.0]))
    total: Any = sum(np.broadcast_to(layer.thickness, 2) for layer in layers)
    return float(total.min())


def row_mesh(
    pieces: Sequence[Piece], device: Device, elements: int, halvings: int = 0, shift: float = 0.0
) -> tuple[Any, Ints, list[tuple[int, float]]]:
    """Line mesh from base to tip, the beam of each element, and the joints.

    Bending waves are the shorter the thinner a piece is: their number goes as its length over
    the root of its thickness, and so does its share of the elements.

    `elements` are shared out, rounded up in each piece; then each is halved so many times:
    a mesh and its halved one differ in every piece.  Nodes inside of a piece lie `shift` elements
    higher than evenly.

    A joint is a node, whose successor lies at the same height and which no element connects
    to it, and the depth of the slot (m).
    """
    from skfem import MeshLine

    waves = [piece.length / math.sqrt(thinnest(piece, device)) for piece in pieces]
    total = sum(n for n, piece in zip(waves, pieces, strict=True) if piece.section != "bond")
    nodes, cells, piece_of, joints = [0.0], [], [], []
    beams = 0
    for piece, share in zip(pieces, waves, strict=True):
        last = len(nodes) - 1
        if piece.section == "bond":
            joints.append((last, piece.length))
            nodes.append(nodes[-1])
            continue
        count = math.ceil(elements * share / total) * 2**halvings
        inside = piece.length * (np.arange(1, count) + shift) / count
        nodes += [*(nodes[-1] + inside), nodes[-1] + piece.length]
        cells += [(last + i, last + i + 1) for i in range(count)]
        piece_of += count * [beams]
        beams += 1
    mesh = MeshLine(np.array([nodes]), np.array(cells).T, sort_t=False)
    return mesh, np.array(piece_of), joints


#: Polynomial order of w and ψ (equal orders lock only at low order).
ORDER = 5
#: Elements of the glued part of the tab, halved with the others.
_TAB_ELEMENTS = 8
#: Most elements along a row: beyond, its dense matrices and their condition take minutes.
MOST_ELEMENTS = 200
#: Place of the voltage among the ports.
_VOLTAGE = 4


@dataclass(frozen=True)
class BeamMatrices:
    """Assembled beam, all (n, n) or (n,): dofs of w and ψ, then the scalar capacitance.

    `ports` are the dofs of w and ψ at the base, then at the tip; `stations` (k, 3) the height (m)
    of every node between elements and its dofs of w and ψ, from base to tip.  Forces and charges
    are counted in 1/`unit` (N, C).
    """

    stiffness: Complex
    mass: Floats
    coupling: Complex
    capacitance: complex
    ports: Ints
    stations: list[tuple[float, int, int]]
    unit: float = 1.0
    measured: int | None = None  #: Dof of w at the place of measurement, if that is not the tip

    @property
    def seen(self) -> int:
        """Dof of the motion that is measured."""
        return int(self.ports[2]) if self.measured is None else self.measured


def multiport(
    device: Device,
    support: Support,
    beam: Beam,
    frequencies: Floats,
    *,
    elements: int = 8,
    lossy: bool = True,
) -> Multiport:
    """Beam-element model over its ports (parallel wiring), `elements` along the whole row."""
    matrices = assemble(device, support, beam, elements=elements, lossy=lossy, measured=True)
    return condense(matrices, np.atleast_1d(np.asarray(frequencies, dtype=float)))


def condense(matrices: BeamMatrices, frequencies: Floats) -> Multiport:
    """D(Ω) at frequencies (n,) in Hz: interior dofs, a band when numbered along z, eliminated."""
    from scipy.linalg import solve_banded
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    place = [] if matrices.measured is None else [matrices.measured]
    ports = np.array([*matrices.ports, *place])
    inner = np.setdiff1d(np.arange(matrices.mass.shape[0]), ports)
    pattern = csr_matrix(
        matrices.mass[np.ix_(inner, inner)] + abs(matrices.stiffness[np.ix_(inner, inner)])
    )
    inner = inner[reverse_cuthill_mckee(pattern, symmetric_mode=True)]
    inside = np.ix_(inner, inner)
    width, k_band, m_band = _bands(matrices.stiffness[inside], matrices.mass[inside])
    held = np.insert(matrices.stiffness[:, ports], _VOLTAGE, -matrices.coupling, axis=1)
    moving = np.insert(matrices.mass[:, ports], _VOLTAGE, 0.0, axis=1)
    at = np.delete(np.arange(held.shape[1]), _VOLTAGE)
    d = np.zeros((frequencies.size, held.shape[1], held.shape[1]), dtype=complex)
    for i, o2 in enumerate((2.0 * np.pi * frequencies) ** 2):
        to_ports = held - o2 * moving
        solved = solve_banded((width, width), k_band - o2 * m_band, to_ports[inner])
        d[i, at] = to_ports[ports]
        d[i, _VOLTAGE, at] = matrices.coupling[ports]
        d[i, _VOLTAGE, _VOLTAGE] = matrices.capacitance
        answers = to_ports[inner].T.copy()
        answers[_VOLTAGE] = matrices.coupling[inner]
        d[i] -= answers @ solved
    d /= matrices.unit
    return Multiport(frequencies, d, (*BIMORPH, MEASURED)[: held.shape[1]])


def _bands(k: Complex, m: Floats) -> tuple[int, Complex, Floats]:
    """Half bandwidth and both matrices in LAPACK's band storage."""
    rows, columns = np.nonzero(abs(k) + abs(m))
    width = int(np.abs(rows - columns).max())
    k_band = np.zeros((2 * width + 1, k.shape[0]), dtype=complex)
    m_band = np.zeros((2 * width + 1, k.shape[0]))
    k_band[width + rows - columns, columns] = k[rows, columns]
    m_band[width + rows - columns, columns] = m[rows, columns]
    return width, k_band, m_band


def elements_for(device: Device, highest: float) -> int:
    """Number of elements that resolves waves up to `highest` Hz along the row.

    One radian of the slowest wave per element of order five; even, at least 8.

    Raises InputError if that is more than dense matrices bear.
    """
    omega, ends = 2.0 * math.pi * highest, np.array([0.0, 1.0])
    pieces = beam_pieces(device, Support())
    radians = 0.0
    for piece in pieces:
        bending, shear, mass, *_ = section_constants(piece, device, Beam(), ends, lossy=False).real
        waves = np.maximum((omega**2 * mass / bending) ** 0.25, omega * np.sqrt(mass / shear))
        radians += piece.length * float(waves.max())
    if not radians <= MOST_ELEMENTS:
        raise InputError(
            f"frequency = {highest:g} Hz makes waves so short that the model beam would need "
            f"{radians:.0f} elements along {1e3 * sum(p.length for p in pieces):g} mm of bimorph "
            f"and tab, and it takes {MOST_ELEMENTS}; ask for lower frequencies, or take the model "
            "tmm, which is exact"
        )
    return int(2 * max(4, math.ceil(radians / 2.0)))


def assemble(
    device: Device,
    support: Support,
    beam: Beam,
    *,
    elements: int,
    lossy: bool,
    halvings: int = 0,
    unit: float = 1.0,
    shift: float = 0.0,
    measured: bool = False,
) -> BeamMatrices:
    """Assemble the row of beams, `elements` shared out by waves, rounded up in each piece.

    All elements are then halved so many times.  `unit` is how many units of force and charge make a
    newton and a coulomb.  It goes in before the elements are summed: another one changes nothing
    but how every sum is rounded.  By `shift` of an element the nodes inside of a piece lie higher:
    little of it changes little but what lengths are rounded to, which is alike in all units.  If
    `measured`, a node lies where motion is measured.
    """
    from skfem import Basis, ElementLinePp, LinearForm, asm

    below = device.measurement.below_tip if measured else 0.0
    pieces = measured_pieces(device, support) if below else beam_pieces(device, support)
    beams = [piece for piece in pieces if piece.section != "bond"]
    mesh, piece_of, joints = row_mesh(pieces, device, elements, halvings, shift)
    w_space = Basis(mesh, ElementLinePp(ORDER), intorder=2 * ORDER)
    shares = _shares(w_space, piece_of)
    constants = unit * np.concatenate(
        [
            section_constants(
                piece, device, beam, shares[piece_of == k].ravel(), lossy=lossy
            ).reshape(6, -1, shares.shape[1])
            for k, piece in enumerate(beams)
        ],
        axis=1,
    )
    basis = w_space * w_space
    stiffness = asm(_elastic(*constants[:2]), basis).toarray()
    for node, depth in joints:
        dofs = w_space.nodal_dofs[0][[node, node + 1]]
        ports = np.ix_(*2 * [[*dofs, *(dofs + w_space.N)]])
        number = _TAB_ELEMENTS * 2**halvings
        spring = bonded_tab(device, beam, depth, number, lossy=lossy, unit=unit)
        stiffness[ports] += np.kron(spring, [[1.0, -1.0], [-1.0, 1.0]])

    @LinearForm(dtype=complex)  # type: ignore[untyped-decorator]
    def moment_per_voltage(v: Any, phi: Any, _: Any) -> Any:
        return constants[4] * phi.grad[0] + 0.0 * v

    ends = w_space.nodal_dofs[0][[0, -1]]
    place = np.abs(mesh.p[0] - (mesh.p[0, -1] - below)).argmin()
    return BeamMatrices(
        stiffness=stiffness,
        mass=asm(_inertial(*constants[2:4].real), basis).toarray(),
        coupling=asm(moment_per_voltage, basis),
        capacitance=complex(np.sum(constants[5] * w_space.dx)),
        unit=unit,
        measured=int(w_space.nodal_dofs[0][place]) if below else None,
        ports=np.array([ends[0], ends[0] + w_space.N, ends[1], ends[1] + w_space.N]),
        stations=[
            (float(z), int(dof), int(dof) + int(w_space.N))
            for z, dof in zip(mesh.p[0], w_space.nodal_dofs[0], strict=True)
        ],
    )


def _shares(space: Any, piece_of: Ints) -> Floats:
    """Where each quadrature point lies in its beam (n_elements, n_points), 0 to 1."""
    z = np.asarray(space.global_coordinates())[0]
    low, high = space.mesh.p[0][space.mesh.t]
    lower = np.array([low[piece_of == k].min() for k in piece_of])[:, None]
    upper = np.array([high[piece_of == k].max() for k in piece_of])[:, None]
    return np.asarray((z - lower) / (upper - lower))


def _elastic(ei: Complex, ga: Complex) -> Any:
    from skfem import BilinearForm

    @BilinearForm(dtype=complex)  # type: ignore[untyped-decorator]
    def form(w: Any, psi: Any, v: Any, phi: Any, _: Any) -> Any:
        shear = (w.grad[0] + psi) * (v.grad[0] + phi)
        return ei * psi.grad[0] * phi.grad[0] + ga * shear

    return form


def _inertial(m: Any, rho_i: Any) -> Any:
    from skfem import BilinearForm

    @BilinearForm  # type: ignore[untyped-decorator]
    def form(w: Any, psi: Any, v: Any, phi: Any, _: Any) -> Any:
        return m * w * v + rho_i * psi * phi

    return form


def bonded_tab(
    device: Device,
    beam: Beam,
    depth: float,
    elements: int = _TAB_ELEMENTS,
    *,
    lossy: bool = False,
    unit: float = 1.0,
) -> Numbers:
    """Stiffness (2, 2) of the tab in the slot at the slot's edge, to the head.

    Weak form of a beam on its bond lines, its end on the glue below it:
    ∫ EI θ' φ' + GA (v' + θ)(ν' + φ) + k_w v ν + k_r θ φ dz + end springs, with the glue's
    energy integrated over the tab's perimeter: per area (E' n² + G s²)/(2 t) for
    displacements n across and s along the bond line.
    """
    from skfem import Basis, ElementLinePp, MeshLine, asm

    glue, bimorph = device.glue, device.bimorph
    half, b, t = 0.5 * bimorph.shim_thickness, bimorph.width, glue.thickness
    nu = glue.poisson_ratio
    modulus = unit * lossy_modulus(glue.youngs_modulus, glue.loss_factor, lossy=lossy)
    lame = modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    shear = modulus / (2.0 * (1.0 + nu))
    squeezed = lame + 2.0 * shear
    across = sum(weight for _, weight in gauss(-half, half))
    turned = sum(weight * x**2 for x, weight in gauss(-half, half))
    lateral = 2.0 * (b * squeezed + across * shear) / t
    rotational = 2.0 * (b * shear * half**2 + turned * shear) / t
    tab = unit * section_constants(Piece("shim", depth), device, beam, np.zeros(1), lossy=lossy)[:2]
    mesh = MeshLine(np.linspace(0.0, depth, elements + 1))
    space = Basis(mesh, ElementLinePp(ORDER), intorder=2 * ORDER)
    # what holds the tab along its length has the form of an inertia
    per_loss = lossy_modulus(1.0, glue.loss_factor, lossy=lossy)
    springs = asm(_inertial((lateral / per_loss).real, (rotational / per_loss).real), space * space)
    k = (asm(_elastic(*tab), space * space) + per_loss * springs).toarray()
    if not lossy:
        k = k.real
    low, high = space.nodal_dofs[0][[0, -1]]
    k[low, low] += shear * b * across / t
    k[low + space.N, low + space.N] += squeezed * b * turned / t
    edge = [high, high + space.N]
    inner = np.setdiff1d(np.arange(k.shape[0]), edge)
    solved = np.linalg.solve(k[np.ix_(inner, inner)], k[np.ix_(inner, edge)])
    return np.asarray(k[np.ix_(edge, edge)] - k[np.ix_(edge, inner)] @ solved)


def bending_frequencies(
    matrices: BeamMatrices, ends: Ends, count: int, *, open_circuit: bool
) -> Floats:
    """Lowest elastic natural frequencies (count,) in Hz of lossless matrices."""
    from scipy.linalg import eigh

    k, m, _ = _supported(matrices, ends, open_circuit=open_circuit)
    rough = eigh(k, m, eigvals_only=True)
    elastic = rough[rough > 1e-9 * rough[min(count + 2, rough.size) - 1]]
    # the lowest values of (k, m) carry the rounding of the highest; as the highest of the
    # inverse pencil they are exact to a few digits of machine precision
    shift = float(elastic[0])
    size = k.shape[0]
    top = [max(size - count - 2, 0), size - 1]
    inverse = eigh(m, k + shift * m, eigvals_only=True, subset_by_index=top)[::-1]
    rigid = ends.rigid_motions
    return np.asarray(np.sqrt(1.0 / inverse[rigid : rigid + count] - shift) / (2.0 * np.pi))
