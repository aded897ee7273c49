"""Fields of the 3D piezoelectric solid, on bricks or on tetrahedra."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from tactgen.fem.elements.skfem_mesh import SLOPES
from tactgen.fem.piezo.modal_model import Motion
from tactgen.fem.piezo.modes import SolidState, driven_state, natural_modes
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.system import Material, SolidSystem, materials
from tactgen.geometry.arrays import Floats, Ints, Numbers
from tactgen.geometry.bimorph.bricks import Axis, Bricks, lobatto_points, mirrored_axis
from tactgen.geometry.meshing.mesh import TET_EDGES, Mesh
from tactgen.geometry.meshing.structured_tets import whole_mesh
from tactgen.validation.models.bimorph.mesh_pair import TwoMeshModel
from tactgen.validation.show.field import MODE_SIZE, Array

#: Every node, or those on bricks' edges across and all along z: what a picture needs.
Detail = Literal["nodes", "edges"]


@dataclass(frozen=True)
class Block:
    """A part of the whole grid with one material: nodes along x and z; along y all of them."""

    region: str
    x: slice
    z: slice


@dataclass(frozen=True)
class BrickSampler:
    """Points of the whole bimorph, layer by layer, and how fields come to them."""

    bricks: Bricks
    detail: Detail

    @cached_property
    def axes(self) -> tuple[Axis, Axis, Axis]:
        """The axes of the whole: y mirrored, and x unless it is whole."""
        x, y = (
            Axis(np.concatenate([-a.breaks[:0:-1], a.breaks]), a.degree)
            for a in (self.bricks.x, self.bricks.y)
        )
        return x if self.bricks.mirrored_x else self.bricks.x, y, self.bricks.z

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """The blocks of one material each."""
        found, middle = [], self.bricks.x.intervals
        along_x, _, along_z = self.axes
        for slab in self.bricks.slabs:
            low, high = slab.x
            sides = {"top": (middle + low, middle + high), "bottom": (middle - high, middle - low)}
            if not self.bricks.mirrored_x:
                sides = {"": slab.x}
            elif low == 0:
                sides = {"": (middle - high, middle + high)}
            for side, part in sides.items():
                region = f"piezo_{side}" if slab.region == "piezo" else slab.region
                found.append(Block(region, along_x.nodes_of(*part), along_z.nodes_of(*slab.z)))
        return tuple(found)

    @cached_property
    def _metal(self) -> dict[str, tuple[str, int]]:
        """Regions with a face at the voltage: its name, and which end of a block along x it is."""
        if self.bricks.mirrored_x:
            sides = enumerate(("bottom", "top"))
            return {f"piezo_{side}": (f"electrode_{side}_outer", at) for at, side in sides}
        hot = (slab for slab in self.bricks.ceramics if slab.hot)
        return {s.region: (f"electrode_{s.region}", int(s.hot > 0)) for s in hot}

    @cached_property
    def _grid(self) -> tuple[Ints, tuple[int, int, int]]:
        """Where the system's nodes are in the whole grid (flat), and the grid's shape."""
        _, from_x, _ = self.bricks.continued_x(self.bricks.x.nodes)
        _, from_y, _ = mirrored_axis(self.bricks.y.nodes)
        used = self.bricks.used()[np.ix_(from_x, from_y)]
        nx, ny, nz = used.shape
        return np.flatnonzero(used), (nx, ny, nz)

    def _kept(self, block: Block) -> tuple[Ints, Ints, Ints]:
        """Nodes of a block that are drawn along each axis."""
        counts = (block.x.stop - block.x.start, self._grid[1][1], block.z.stop - block.z.start)
        steps = (
            (1, 1, 1) if self.detail == "nodes" else (self.axes[0].degree, self.axes[1].degree, 1)
        )
        x, y, z = (np.arange(0, n, step) for n, step in zip(counts, steps, strict=True))
        return x, y, z

    @cached_property
    def mesh(self) -> Mesh:
        """The points shown, in m, with eight-cornered cells between them."""
        points, cells, regions = [], [], []
        outer: dict[str, list[Ints]] = {name: [] for name, _ in self._metal.values()}
        names = tuple(dict.fromkeys(block.region for block in self.blocks))
        x, y, z = (axis.nodes for axis in self.axes)
        count = 0
        electrode = [float(self.bricks.z.breaks[k]) for k in self.bricks.electrode]
        for block in self.blocks:
            kept = self._kept(block)
            whole = x[block.x], y, z[block.z]
            lines = [line[part] for line, part in zip(whole, kept, strict=True)]
            points.append(np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3))
            shape = tuple(line.size for line in lines)
            hexes, sides = _cells(shape)
            cells.append(count + hexes)
            regions.append(np.full(len(hexes), names.index(block.region)))
            if block.region in self._metal:
                name, side = self._metal[block.region]
                quads = sides[side]
                at = points[-1][quads, 2]
                under = ((at >= electrode[0] - 1e-12) & (at <= electrode[1] + 1e-12)).all(axis=1)
                outer[name].append(count + quads[under])
            count += len(points[-1])
        return Mesh(
            points=np.concatenate(points),
            cells=np.concatenate(cells),
            kind="hexahedron",
            region_of_cell=np.concatenate(regions).astype(np.int64),
            regions=names,
            faces={name: np.concatenate(quads) for name, quads in outer.items()},
        )

    @cached_property
    def _slopes(self) -> list[tuple[Floats, Floats, Floats]]:
        """Matrices (n, n) from values along each axis of a block to derivatives there."""
        x, y, z = self.axes
        along_y = _differentiation(y, slice(0, y.nodes.size))
        return [(_differentiation(x, b.x), along_y, _differentiation(z, b.z)) for b in self.blocks]

    def sample(self, values: Numbers) -> tuple[Numbers, Numbers]:
        """Values (n, k) and gradients (n, k, 3) at the points from those at all nodes.

        Parameters
        ----------
        values : (n_nodes, k) array
            In the order of the system's nodes.
        """
        at, shape = self._grid
        grid = np.zeros((*shape, values.shape[1]), dtype=values.dtype)
        grid.reshape(-1, values.shape[1])[at] = values
        sampled, gradients = [], []
        for block, (d_x, d_y, d_z) in zip(self.blocks, self._slopes, strict=True):
            part = grid[block.x, :, block.z]
            x, y, z = self._kept(block)
            gradient = np.stack(
                [
                    np.einsum("ai,ijkc->ajkc", d_x[x], part[:, y][:, :, z]),
                    np.einsum("bj,ijkc->ibkc", d_y[y], part[x][:, :, z]),
                    np.einsum("ek,ijkc->ijec", d_z[z], part[x][:, y]),
                ],
                axis=-1,
            )
            shown = part[np.ix_(x, y, z)]
            sampled.append(shown.reshape(-1, shown.shape[-1]))
            gradients.append(gradient.reshape(-1, *gradient.shape[-2:]))
        return np.concatenate(sampled), np.concatenate(gradients)


def _differentiation(axis: Axis, part: slice) -> Floats:
    """Matrix (n, n) that differentiates piecewise polynomials at a part's nodes."""
    degree = axis.degree
    reference = _reference_slopes(degree)
    first = part.start // degree
    count = (part.stop - 1 - part.start) // degree
    matrix, shares = np.zeros((part.stop - part.start,) * 2), np.zeros(part.stop - part.start)
    for k in range(count):
        at = slice(k * degree, (k + 1) * degree + 1)
        width = float(axis.breaks[first + k + 1] - axis.breaks[first + k])
        matrix[at, at] += reference * (2.0 / width)
        shares[at] += 1.0
    return matrix / shares[:, None]


def _reference_slopes(degree: int) -> Floats:
    """Derivatives (n, n) of the polynomials through Gauss–Lobatto points at these points."""
    points = lobatto_points(degree)
    powers = np.vander(points, increasing=True)
    slopes = np.zeros_like(powers)
    slopes[:, 1:] = powers[:, :-1] * np.arange(1, degree + 1)
    return np.asarray(slopes @ np.linalg.inv(powers))


def _cells(shape: tuple[int, ...]) -> tuple[Ints, tuple[Ints, Ints]]:
    """Hexahedra of a block of points, z fastest, and quads at its ends along x."""
    number = np.arange(int(np.prod(shape))).reshape(shape)
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    nx, ny, nz = shape

    def corner(a: int, b: int, c: int) -> Ints:
        return number[a : nx - 1 + a, b : ny - 1 + b, c : nz - 1 + c].ravel()

    hexes = np.stack([corner(a, b, c) for c in (0, 1) for a, b in around], axis=1)

    def quads(at: int) -> Ints:
        face = number[at]
        return np.stack(
            [face[:-1, :-1], face[1:, :-1], face[1:, 1:], face[:-1, 1:]], axis=-1
        ).reshape(-1, 4)

    return hexes, (quads(0), quads(-1))


#: Barycentric coordinates of the ten nodes.
_NODES = np.vstack([np.eye(4), 0.5 * (np.eye(4)[TET_EDGES[:, 0]] + np.eye(4)[TET_EDGES[:, 1]])])


@dataclass(frozen=True)
class TetSampler:
    """Points of the whole, each region with its own, and how fields come to them."""

    solved: Mesh  #: The mesh of the solution, ``tetra`` or ``tetra10``, whole or a quarter
    nodes: Floats  #: (n_nodes, 3) The system's nodes (m)

    @cached_property
    def _quadratic(self) -> tuple[Floats, Ints, Ints]:
        """Points, cells (m, 10) with points of their region, and the node of every point."""
        whole = whole_mesh(self.solved)
        corners = whole.points[whole.cells]
        if whole.kind == "tetra":
            middles = 0.5 * (corners[:, TET_EDGES[:, 0]] + corners[:, TET_EDGES[:, 1]])
            corners = np.concatenate([corners, middles], axis=1)
        node = cKDTree(self.nodes).query(corners.reshape(-1, 3))[1]
        keys = np.repeat(whole.region_of_cell, corners.shape[1]) * len(self.nodes) + node
        different, cells = np.unique(keys, return_inverse=True)
        of_node = different % len(self.nodes)
        return self.nodes[of_node], cells.reshape(-1, corners.shape[1]), of_node

    @cached_property
    def mesh(self) -> Mesh:
        """The points in m and their ten-node cells."""
        points, cells, _ = self._quadratic
        whole = whole_mesh(self.solved)
        return Mesh(points, cells, "tetra10", whole.region_of_cell, whole.regions, {})

    def sample(self, values: Numbers) -> tuple[Numbers, Numbers]:
        """Values (n, k) and gradients (n, k, 3) at the points; see BrickSampler.sample."""
        points, cells, of_node = self._quadratic
        shown = values[of_node]
        gradients = np.zeros((len(points), values.shape[1], 3), dtype=values.dtype)
        corners = points[cells]
        local = shown[cells]
        for k, slopes in enumerate(_shape_slopes()):
            jacobian = np.einsum("cni,nj->cij", corners, slopes)
            slope = np.einsum("cnv,nj->cvj", local, slopes) @ np.linalg.inv(jacobian)
            np.add.at(gradients, cells[:, k], slope)
        shares = np.bincount(cells.ravel(), minlength=len(points))
        return shown, gradients / shares[:, None, None]


def _shape_slopes() -> Floats:
    """(10, 10, 3): at each node, the slopes of the ten functions by ξ, η, ζ."""
    corners = (4.0 * _NODES - 1.0)[:, :, None] * SLOPES
    i, j = TET_EDGES.T
    middles = 4.0 * (_NODES[:, i, None] * SLOPES[j] + _NODES[:, j, None] * SLOPES[i])
    return np.concatenate([corners, middles], axis=1)


#: Fields, tip displacement (m) and charge (C) of one state.
Found = tuple[Mapping[str, Array], complex, complex]


class SolidFields:
    """The states of a solid model with all their fields, at points of one mesh."""

    def __init__(self, model: TwoMeshModel, detail: Detail) -> None:
        self._model = model
        solved = model.meshes()[0]
        self._system: SolidSystem = model.systems()[0]
        self._lossy: SolidSystem | None = None
        self._of_motion: dict[Motion, SolidSystem] = {}
        self._without_ports: dict[Motion, list[SolidState]] = {}
        self._sampler: BrickSampler | TetSampler = (
            BrickSampler(solved, detail)
            if isinstance(solved, Bricks)
            else TetSampler(solved, self._system.nodes)
        )

    @property
    def mesh(self) -> Mesh:
        """The points and cells."""
        return self._sampler.mesh

    def modes(self, count: int, *, open_circuit: bool) -> list[tuple[str, Found]]:
        """Class and fields of the lowest `count` modes, ascending."""
        model, system = self._model, self._system
        found: list[SolidState] = []
        for motion, number in model.motions(open_circuit=open_circuit).items():
            of = system if system.related is None else self._related(motion)
            if of.has_ports:
                found += natural_modes(of, model.scene.ends, number, open_circuit=open_circuit)
            else:
                found += self._apart(of, number)
        found.sort(key=lambda state: state.frequency)
        out: list[tuple[str, Found]] = []
        for state in found[:count]:
            size = float(np.linalg.norm(state.values[:, :3], axis=1).max())
            sign = -1.0 if state.tip.real < 0.0 else 1.0
            scaled = state.scaled(sign * MODE_SIZE / size)
            out.append((state.kind, self._fields(scaled, lossy=False)))
        return out

    def _related(self, motion: Motion) -> SolidSystem:
        """System of a class of motion, the same for every circuit."""
        assert self._system.related is not None
        if motion not in self._of_motion:
            own = motion == self._system.motion
            self._of_motion[motion] = self._system if own else self._system.related(motion)
        return self._of_motion[motion]

    def _apart(self, system: SolidSystem, number: int) -> list[SolidState]:
        """Modes that no circuit changes, of a class in which the ports take no part."""
        if len(self._without_ports.get(system.motion, ())) < number:
            ends = self._model.scene.ends
            self._without_ports[system.motion] = natural_modes(system, ends, number)
        return self._without_ports[system.motion][:number]

    def static(self, voltage: float) -> Found:
        """Lossless fields at rest under a voltage (V) across each layer."""
        ends = self._model.scene.ends.lossless
        state = driven_state(self._system, ends, 0.0, voltage)
        real = SolidState(0.0, state.values.real, state.tip.real, state.charge.real)
        return self._fields(real, lossy=False)

    def harmonic(self, frequency: float, voltage: float) -> Found:
        """Fields with losses at a frequency (Hz) and voltage (V) across each layer."""
        scene = self._model.scene
        if self._lossy is None:
            self._lossy = assemble(scene.device, self._model.meshes()[0], lossy=True)
        return self._fields(driven_state(self._lossy, scene.ends, frequency, voltage), lossy=True)

    def _fields(self, state: SolidState, *, lossy: bool) -> Found:
        scene, mesh = self._model.scene, self.mesh
        values, gradients = self._sampler.sample(state.values)
        slope = gradients[:, :3]
        strain = np.stack([slope[:, i, i] for i in range(3)], axis=1)
        pairs = ((1, 2), (0, 2), (0, 1))
        shear = np.stack([slope[:, i, j] + slope[:, j, i] for i, j in pairs], axis=1)
        strain = np.concatenate([strain, shear], axis=1)
        field = -gradients[:, 3]
        stress = np.zeros_like(strain)
        flux = np.zeros_like(field)
        ceramic, layers = scene.device.piezo.ceramic(), scene.bimorph.layers
        known = materials(scene.device, mesh.regions, ceramic, lossy=lossy)
        along = {layers.region(n): layer for n, layer in enumerate(layers) if layer.pitch}
        for region, at in points_of_regions(mesh).items():
            stress[at], flux[at] = _constitutive(known[region], strain[at], field[at])
            if known[region].piezo is None:
                field[at] = 0.0
                if along:  # the voltage of interdigitated fingers is not that of what they touch
                    values[at, 3] = 0.0
            if layer := along.get(region):
                # the field that stands for the one between the fingers is through the thickness
                share = layer.thickness / layer.pitch
                across = values[at, 3]
                values[at, 3] = 0.5 * across[np.abs(across).argmax()]  # fingers at 0 V and U
                field[at] = -share * field[at][:, ::-1]
                flux[at] = -flux[at][:, ::-1] / share
        fields = {
            "displacement": values[:, :3],
            "potential": values[:, 3],
            "strain": strain,
            "stress": stress,
            "electric_field": field,
            "electric_displacement": flux,
        }
        return fields, state.tip, state.charge


def _constitutive(material: Material, strain: Numbers, field: Numbers) -> tuple[Numbers, Numbers]:
    """T = c S − eᵀ E and D = e S + ε E of one material, (n, 6) and (n, 3)."""
    stress = strain @ material.c.T
    if material.piezo is None:
        return stress, np.zeros_like(field)
    e, eps = material.piezo.e, material.piezo.eps
    return stress - field @ e, strain @ e.T + field @ eps.T


def points_of_regions(mesh: Mesh) -> dict[str, Ints]:
    """Points of every region."""
    return {
        region: np.unique(mesh.cells[mesh.region_of_cell == number])
        for number, region in enumerate(mesh.regions)
    }
