"""Fields of the 3D piezoelectric solid, on bricks or on tetrahedra."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from tactgen.fem.elements.skfem_mesh import SLOPES
from tactgen.fem.piezo.modal_model import Motion
from tactgen.fem.piezo.modes import SolidState, driven_state, natural_modes
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.system import Material, SolidSystem, materials
from tactgen.geometry.arrays import Floats, Ints, Numbers
from tactgen.geometry.bimorph.bricks import Bricks, lobatto_points
from tactgen.geometry.bimorph.segments import block_cells
from tactgen.geometry.meshing.mesh import TET_EDGES, CellKind, Mesh
from tactgen.geometry.meshing.structured_tets import whole_mesh
from tactgen.tmm.ports.excitation_and_circuit import PortState
from tactgen.validation.models.bimorph.mesh_pair import TwoMeshModel
from tactgen.validation.show.field import MODE_SIZE, Array

#: Every node, or those on bricks' edges across and all along z: what a picture needs.
Detail = Literal["nodes", "edges"]


@dataclass(frozen=True)
class Element:
    """One kind of cells with polynomials through their nodes."""

    weights: Floats  #: (n, c) Places of the nodes from those of a cell's corners
    slopes: Floats  #: (n, n, 3) At each node the slopes of all functions by ξ, η, ζ
    drawn: Ints  #: (d, 8 | 10) Nodes of the cells that are drawn of each


def _tetrahedron(corners: int) -> Element:
    """Quadratic functions; cells are given by four corners, or by all ten nodes."""
    i, j = TET_EDGES.T
    nodes = np.vstack([np.eye(4), 0.5 * (np.eye(4)[i] + np.eye(4)[j])])  # barycentric
    first = (4.0 * nodes - 1.0)[:, :, None] * SLOPES
    middles = 4.0 * (nodes[:, i, None] * SLOPES[j] + nodes[:, j, None] * SLOPES[i])
    weights = nodes if corners == 4 else np.eye(10)
    return Element(weights, np.concatenate([first, middles], axis=1), np.arange(10)[None])


def _brick(degree: tuple[int, int, int], detail: Detail) -> Element:
    """Products of polynomials through Gauss–Lobatto points, those along y fastest, z slowest."""

    def products(x: Floats, y: Floats, z: Floats) -> Floats:
        return np.kron(z, np.kron(x, y))

    ends = [0.5 * (1.0 + np.outer(lobatto_points(d), [-1.0, 1.0])) for d in degree]
    (x, dx), (y, dy), (z, dz) = ((np.eye(d + 1), _line_slopes(d)) for d in degree)
    slopes = products(dx, y, z), products(x, dy, z), products(x, y, dz)
    nx, ny, nz = (d + 1 for d in degree)
    kept = np.arange(nz * nx * ny).reshape(nz, nx, ny)
    if detail == "edges":
        kept = kept[:, :: degree[0], :: degree[1]]
    return Element(
        products(*ends)[:, block_cells(2, 2, 2)[0]],
        np.stack(slopes, axis=-1),
        kept.ravel()[block_cells(*kept.shape)],
    )


def _line_slopes(degree: int) -> Floats:
    """Derivatives (n, n) of the polynomials through Gauss–Lobatto points at these points."""
    points = lobatto_points(degree)
    powers = np.vander(points, increasing=True)
    slopes = np.zeros_like(powers)
    slopes[:, 1:] = powers[:, :-1] * np.arange(1, degree + 1)
    return np.asarray(slopes @ np.linalg.inv(powers))


class Sampler:
    """Points of the whole bimorph, each region with its own, and how fields come to them.

    Parameters
    ----------
    solved : Mesh or Bricks
        The mesh of the solution; tetrahedra whole or a quarter.
    nodes : (n_nodes, 3) array
        The system's nodes (m).
    """

    def __init__(self, solved: Mesh | Bricks, nodes: Floats, detail: Detail = "nodes") -> None:
        if isinstance(solved, Bricks):
            whole, element = solved.corner_mesh(), _brick(solved.degree, detail)
            regions, region = whole.regions, whole.region_of_cell
            if solved.mirrored_x:  # the ceramic, which is in front there, is named last
                regions, region = regions[2:] + regions[:2], (region - 2) % len(regions)
        else:
            whole = whole_mesh(solved)
            element = _tetrahedron(whole.cells.shape[1])
            regions, region = whole.regions, whole.region_of_cell
        places = element.weights @ whole.points[whole.cells]
        found = cKDTree(nodes).query(places.reshape(-1, 3))[1].reshape(places.shape[:2])
        keys = region[:, None] * len(nodes) + found
        own, cells = np.unique(keys[:, element.drawn], return_inverse=True)
        cells = cells.reshape(-1, element.drawn.shape[1])
        #: System's nodes: of the points, and of the cells (m, n) that carry polynomials
        self._node, self._nodes_of_cells = own % len(nodes), found
        self._corners, self._slopes = nodes[found], element.slopes
        #: Nodes of a cell that are drawn, and their points (m, k)
        self._shown = np.unique(element.drawn)
        self._points_of_cells = np.searchsorted(own, keys[:, self._shown])
        kind: CellKind = "hexahedron" if isinstance(solved, Bricks) else "tetra10"
        drawn = np.repeat(region, len(element.drawn))
        #: The points shown (m) and cells between them.
        self.mesh = Mesh(nodes[self._node], cells, kind, drawn, regions, {})
        if isinstance(solved, Bricks):
            self.mesh.faces.update(_driven_faces(solved, self.mesh))

    def sample(self, values: Numbers) -> tuple[Numbers, Numbers]:
        """Values (n, k) and gradients (n, k, 3) at the points from values at all nodes.

        A gradient is the mean of those in the cells of one region around its point.
        """
        local = values[self._nodes_of_cells].swapaxes(1, 2)
        corners = self._corners.swapaxes(1, 2)
        gradients = np.zeros((len(self._node), values.shape[1], 3), dtype=values.dtype)
        for points, node in zip(self._points_of_cells.T, self._shown, strict=True):
            slopes = self._slopes[node]
            np.add.at(gradients, points, local @ slopes @ np.linalg.inv(corners @ slopes))
        shares = np.bincount(self._points_of_cells.ravel(), minlength=len(self._node))
        return values[self._node], gradients / shares[:, None, None]


def _driven_faces(bricks: Bricks, mesh: Mesh) -> dict[str, Ints]:
    """Quadrilaterals under the electrodes at the voltage, by the electrodes' names."""
    if bricks.mirrored_x:
        hot = {f"piezo_{s}": (f"electrode_{s}_outer", s == "top") for s in ("bottom", "top")}
    else:
        slabs = (slab for slab in bricks.ceramics if slab.hot)
        hot = {s.region: (f"electrode_{s.region}", s.hot > 0) for s in slabs}
    low, high = (bricks.z.breaks[k] for k in bricks.electrode)
    found = {}
    for region, (name, above) in hot.items():
        sides = mesh.cells[mesh.cells_of(region)][:, [1, 2, 6, 5] if above else [0, 3, 7, 4]]
        x, z = mesh.points[sides, 0], mesh.points[sides, 2]
        on = np.abs(x - (x.max() if above else x.min())) < 1e-12
        found[name] = sides[(on & (z >= low - 1e-12) & (z <= high + 1e-12)).all(axis=1)]
    return found


#: Fields, tip displacement (m) and charge (C) of one state.
Found = tuple[Mapping[str, Array], complex, complex]


class SolidFields:
    """The states of a solid model with all their fields, at points of one mesh."""

    def __init__(self, model: TwoMeshModel, detail: Detail) -> None:
        self._model = model
        solved = model.meshes()[0]
        self._system: SolidSystem = model.systems()[0]
        self._lossy: SolidSystem | None = None
        related = self._system.related
        own = self._system.motion
        #: System of a class of motion, the same for every circuit
        self._system_of = cache(
            lambda motion: self._system if related is None or motion == own else related(motion)
        )
        self._without_ports: dict[Motion, list[SolidState]] = {}
        self._sampler = Sampler(solved, self._system.nodes, detail)
        self.mesh = self._sampler.mesh  #: The points and cells

    def modes(self, count: int, *, open_circuit: bool) -> list[Found]:
        """Fields of the lowest `count` modes, ascending."""
        model = self._model
        found: list[SolidState] = []
        for motion, number in model.motions(open_circuit=open_circuit).items():
            of = self._system_of(motion)
            if of.has_ports:
                found += natural_modes(of, model.scene.ends, number, open_circuit=open_circuit)
            else:
                found += self._apart(of, number)
        found.sort(key=lambda state: state.frequency)
        out: list[Found] = []
        for state in found[:count]:
            size = float(np.linalg.norm(state.values[:, :3], axis=1).max())
            sign = -1.0 if state.tip.real < 0.0 else 1.0
            scaled = state.scaled(sign * MODE_SIZE / size)
            out.append(self._fields(scaled, lossy=False))
        return out

    def _apart(self, system: SolidSystem, number: int) -> list[SolidState]:
        """Modes that no circuit changes, of a class in which the ports take no part."""
        if len(self._without_ports.get(system.motion, ())) < number:
            ends = self._model.scene.ends
            self._without_ports[system.motion] = natural_modes(system, ends, number)
        return self._without_ports[system.motion][:number]

    def driven(self, state: PortState) -> Found:
        """Fields under ports that move so, at rest lossless."""
        if not state.frequency:
            return self._fields(driven_state(self._system, state), lossy=False)
        if self._lossy is None:
            self._lossy = assemble(self._model.scene.device, self._model.meshes()[0], lossy=True)
        return self._fields(driven_state(self._lossy, state), lossy=True)

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
