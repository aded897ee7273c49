"""A uniform stretch of a bimorph between two sections, whatever its length.

Far from all ends no section sees more than a few shapes, those of
:mod:`fem.piezo.parts.section_functions`, so all of a stretch is u(x, y, z) = Σ sᵢ(x, y) aᵢ(z)
with polynomials aᵢ on intervals along z.  What is integrated over the section is worked out once;
a length then costs products of small matrices,

    K = Σ_ab S_ab ⊗ ∫ ∂^a N ∂^b N dz .
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from tactgen.fem.elements.line_basis import LineMatrices, line_matrices
from tactgen.fem.piezo.bricks import loss_matrix, quarter_matrices, quarter_unknowns
from tactgen.fem.piezo.parts.section_functions import SectionFunctions
from tactgen.fem.piezo.symmetry import PORTS, Bordered, Motion, lumped, mirror_signs
from tactgen.fem.piezo.system import Material, volts_per_unit
from tactgen.geometry.arrays import Floats, Numbers, Sparse
from tactgen.geometry.bimorph.bimorph_bricks import uniform
from tactgen.geometry.bimorph.bricks import Axis, Bricks, mirrored_axis
from tactgen.geometry.store.values import storable


@storable
@dataclass(frozen=True)
class Section:
    """A section's shapes, and what is integrated over it: [a, b] of the a-th and b-th ∂/∂z.

    Attributes
    ----------
    functions : SectionFunctions
        The s shapes.
    stiffness : (2, 2, s + 1, s + 1) array
        Of the shapes and of the outer electrodes at 1 V, lossless.
    losses : (2, 2, s + 1, s + 1) array
        Its imaginary part with losses; zero where no port takes part.
    mass : (s, s) array
        Mass per length.
    points : (m, 2) array
        Places x, y of the whole section (m), …
    point_mass : (m,) array
        … the mass per length (kg/m) that each stands for, …
    seen : (4, m, s) array
        … and (u_x, u_y, u_z, φ) there in each shape, in metres and volts.
    """

    functions: SectionFunctions
    stiffness: Floats
    losses: Floats
    mass: Floats
    points: Floats
    point_mass: Floats
    seen: Floats


def section_of(
    middle: Bricks,
    functions: SectionFunctions,
    known: dict[str, Material],
    losses: dict[str, Material],
    motion: Motion,
) -> Section:
    """Integrate over the section of a uniform stretch.

    Parameters
    ----------
    middle : Bricks
        A stretch of it.
    functions : SectionFunctions
        Its shapes.
    known, losses : dict of str to Material
        Lossless materials, and the imaginary parts of those with losses.
    motion : str
        Class of motion.
    """
    unit, s = volts_per_unit(known), functions.values.shape[1]
    length = float(middle.x.breaks[-1])
    slice_ = uniform(middle, np.array([0.0, length]), 1)
    voltage = quarter_unknowns(slice_, motion, unit, has_base=False).ports[:, -1]
    shapes = np.repeat(functions.values.reshape(-1, 1, 4, s), 2, axis=1)
    still = np.column_stack([shapes.reshape(-1, s), voltage])
    along = (still.reshape(-1, 2, 4 * (s + 1)) * [[-0.5 * length], [0.5 * length]]).reshape(
        still.shape
    )
    stiffness, mass = quarter_matrices(slice_, known, unit)
    lost = np.zeros((2, 2, s + 1, s + 1))
    if motion == "bending_x":
        lost = _integrals(loss_matrix(slice_, losses, unit), still, along, length)
    points, seen = _points(middle, functions, motion, unit)
    return Section(
        functions,
        _unstrained(_integrals(stiffness, still, along, length)),
        _unstrained(lost),
        still[:, :s].T @ (mass @ still[:, :s]) / length,
        points,
        _point_mass(middle, known, unit),
        seen,
    )


def _integrals(matrix: Sparse, still: Floats, along: Floats, length: float) -> Floats:
    """Return the integrals over the section from a slice, by fields 1 and z of zero mean."""
    on_still, on_along = matrix @ still, matrix @ along
    plain = still.T @ on_still / length
    mixed = along.T @ on_still / length
    both = along.T @ on_along / length - plain * length**2 / 12.0
    found = np.array([[plain, mixed.T], [mixed, both]])
    # the same to rounding, and symmetric
    return np.asarray(0.5 * (found + found.transpose(1, 0, 3, 2)))


def _unstrained(stiffness: Floats) -> Floats:
    """Return the integrals less what rounding lets the first shape strain the section.

    In a slender bimorph bending is (L/h)⁴ times softer than that rounding's terms.
    """
    stiffness[0, :, 0, :] = 0.0
    stiffness[:, 0, :, 0] = 0.0
    return stiffness


def _points(
    middle: Bricks, functions: SectionFunctions, motion: Motion, unit: float
) -> tuple[Floats, Floats]:
    """Return the corners of the whole section's bricks (m, 2) and what is seen there (4, m, s)."""
    x, from_x, turned_x = mirrored_axis(middle.x.breaks)
    y, from_y, turned_y = mirrored_axis(middle.y.breaks)
    nx, ny, _ = middle.shape
    shapes = functions.values.reshape(nx, ny, 4, -1)
    corners = shapes[:: middle.x.degree, :: middle.y.degree][np.ix_(from_x, from_y)]
    turned = np.stack(np.broadcast_arrays(turned_x[:, None], turned_y), axis=-1).reshape(-1, 2)
    sign = mirror_signs(motion, turned) * np.array([1.0, 1.0, 1.0, unit])
    seen = sign[:, :, None] * corners.reshape(*sign.shape, -1)
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return points, seen.transpose(1, 0, 2)


def _point_mass(middle: Bricks, known: dict[str, Material], unit: float) -> Floats:
    """Return the mass per length (m,) of the whole section at the corners of its bricks."""
    corners = Bricks(
        Axis(middle.x.breaks, 1), Axis(middle.y.breaks, 1), middle.z, middle.slabs, middle.electrode
    )
    _, mass = quarter_matrices(uniform(corners, np.array([0.0, 1.0]), 1), known, unit)
    nodal = lumped(mass).reshape(corners.shape[0], corners.shape[1], 2).sum(axis=2)
    source = np.arange(nodal.size).reshape(nodal.shape)
    source = source[np.ix_(*(mirrored_axis(axis.breaks)[1] for axis in (middle.x, middle.y)))]
    copies = np.bincount(source.ravel())
    return np.asarray((nodal.ravel() / copies)[source.ravel()])


@dataclass(frozen=True)
class Stretch:
    """The stretch over [shapes at its nodes, node by node upwards, w_base, ψ_base, U]."""

    section: Section
    axis: Axis

    @property
    def nodes(self) -> int:
        """Number of nodes along z."""
        return int(self.axis.nodes.size)

    def stiffness(self, *, lossy: bool) -> Bordered:
        """Return the stiffness, the last row minus the charge."""
        integrals = self.section.stiffness
        of = integrals + 1j * self.section.losses if lossy else integrals
        s, along = of.shape[2] - 1, self._line.integrals
        blocks = sum(
            along[a, b][:, None, None] * of[a, b, :s, :s] for a in range(2) for b in range(2)
        )
        # a voltage is the same all along: its ∂/∂z is none
        by_voltage = np.kron(self._row_sums(along[0, 0]), of[0, 0, :s, s])
        by_voltage = by_voltage + np.kron(self._row_sums(along[1, 0]), of[1, 0, :s, s])
        corner = float(self.axis.breaks[-1]) * of[0, 0, s, s]
        return _bordered(self._sparse(blocks), by_voltage, corner)

    def mass(self) -> Bordered:
        """Return the mass."""
        inner = self._sparse(self._line.integrals[0, 0][:, None, None] * self.section.mass)
        return _bordered(inner, np.zeros(inner.shape[0]), 0.0)

    @cached_property
    def _line(self) -> LineMatrices:
        """What is integrated along z: [a, b] ∫ ∂^a N ∂^b N dz."""
        return line_matrices(self.axis)

    def _row_sums(self, entries: Floats) -> Floats:
        """Return the sums (nodes,) of the rows of a matrix along z, given by its entries."""
        return np.asarray(np.bincount(self._line.rows, entries, minlength=self.nodes))

    def _sparse(self, blocks: Numbers) -> Sparse:
        """Return the matrix of blocks (nnz, s, s) that belong to the entries along z."""
        n, s = self.nodes, blocks.shape[1]
        starts = np.searchsorted(self._line.rows, np.arange(n + 1))
        entries = (blocks, self._line.columns, starts)
        matrix = sparse.bsr_matrix(entries, shape=(n * s, n * s)).tocsr()
        matrix.eliminate_zeros()  # potentials have no mass
        return matrix

    def whole_nodes(self) -> tuple[Floats, Sparse, Floats]:
        """Return nodes (n, 3), what is seen at them component by component, and their mass."""
        section, z = self.section, self.axis.nodes
        flat = np.tile(section.points, (z.size, 1))
        nodes = np.column_stack([flat, np.repeat(z, section.points.shape[0])])
        seen = sparse.vstack(
            [sparse.kron(sparse.identity(z.size), component) for component in section.seen],
            format="csr",
        )
        along = self._row_sums(self._line.integrals[0, 0])
        return nodes, seen, np.outer(along, section.point_mass).ravel()


def _bordered(inner: Sparse, by_voltage: Numbers, corner: complex) -> Bordered:
    """Return a matrix with its ports, of which only the voltage acts on a stretch."""
    border = np.zeros((inner.shape[0], PORTS), dtype=inner.dtype)
    border[:, -1] = by_voltage
    ports = np.zeros((PORTS, PORTS), dtype=inner.dtype)
    ports[-1, -1] = corner
    return Bordered(inner, border, ports)
