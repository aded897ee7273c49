"""The jobs of the piezoelectric benchmark, and their solution on this program's own meshes.

Job J1: a clamped PZT-5H bimorph, static deflection, capacitance and four natural
frequencies.  Job J2: its damped sweep at 200 frequencies.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Unpack

import numpy as np
import scipy.sparse.linalg  # noqa: F401  (before a clock starts)
from scipy import sparse

from tactgen.fem.piezo.krylov import reduce_to_ports
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import static_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.system import materials
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.bricks import LEVELS, BrickMeshing, Bricks, bimorph_bricks
from tactgen.geometry.bimorph.tets import TetMeshing, tetrahedralise
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import CellKind, Mesh
from tactgen.geometry.meshing.structured_tets import box_tetrahedra
from tactgen.tmm.ports.multiport import respond
from tactgen.tmm.ports.supports_and_loads import attach
from tactgen.validation.evidence.peers.job import (
    LAYERS,
    SHIM,
    SIDES,
    Answer,
    Fineness,
    Job,
    Material,
    bricks,
    layers_across,
    planes,
    solved,
)
from tactgen.validation.models.bimorph.natural_modes import coarse_modes, fine_modes, lowest_modes
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene

#: Natural frequencies that are compared.
MODES = 4
#: Error asked of the reduction to ports, relative; far below the meshes' errors.
_REDUCTION = 1e-6

#: So few bricks that asking them which modes are the lowest costs next to nothing: two along the
#: length, of degree 5 (two percent off, where its modes lie tens apart), as the intervals at both
#: ends (thicknesses) are so long that nothing is left between them.
_SCOUT = BrickMeshing((2, 2, 5), smallest=1e3, tip=1e3)
#: The solid model's own family.
BRICKS = "bricks of high order"


def j1() -> Scene:
    """Scene of the job."""
    return load_scene("j1", [])[0]


#: What is not said of a fineness.
_USUAL = Fineness(
    kind="brick", order=2, through_piezo=1, through_shim=1, across=2, growth=4.0
)  # fmt: skip


def job(device: Device | None = None, **fineness: Unpack[Fineness]) -> Job:
    """Job J1, or another device's, as plain numbers; without frequencies."""
    device = device or j1().device
    known = materials(device, ("piezo_top", "shim"), device.piezo.ceramic(), lossy=True)
    bimorph = device.bimorph
    return {
        "piezo_thickness": bimorph.piezo_thickness, "shim_thickness": bimorph.shim_thickness,
        "width": bimorph.width, "length": bimorph.length, "ceramic": _plain(known["piezo_top"]),
        "shim": _plain(known["shim"]), "modes": MODES, "frequencies": [], **_USUAL, **fineness,
    }  # fmt: skip


def _plain(lossy: Any) -> list[Material]:
    """Region's tensors as lists: their real parts, and the imaginary ones."""
    piezo = lossy.piezo
    tensors = (lossy.c, piezo.e if piezo else np.array([]), piezo.eps if piezo else np.array([]))
    parts = ([t.real.tolist() for t in tensors], [t.imag.tolist() for t in tensors])
    return [
        Material(stiffness=c, coupling=e, permittivity=eps, density=lossy.density)
        for c, e, eps in parts
    ]


def solve_own(family: str, fineness: Any, frequencies: list[float]) -> Answer:
    """Solve the job (or, with frequencies, its sweep) on a mesh of one of our families."""
    # the solver's libraries come with its first call, before the clock starts: their time is the
    # process's, not the mesh's
    factorise(sparse.csr_matrix(np.eye(2)))
    device, make = j1().device, FAMILIES[family]
    return solved(
        frequencies, lambda: make(device, fineness),
        lambda mesh: _Own(device, mesh, lossy=bool(frequencies)),
    )  # fmt: skip


class _Own:
    """The job on a mesh of ours."""

    def __init__(self, device: Device, mesh: Mesh | Bricks, *, lossy: bool) -> None:
        self._device, self._mesh = device, mesh
        self._system = assemble(device, mesh, lossy=lossy)
        self.unknowns = self._system.size

    def sweep(self, frequencies: list[float]) -> list[complex]:
        """Complex deflection by reduction to ports."""
        f = np.array(frequencies)
        port = reduce_to_ports(self._system, f, tolerance=_REDUCTION).multiport(f)
        response = respond(attach(port, Ends()), {"voltage": 1.0})
        return [complex(w) for w in response.motion["w_tip"]]

    def factor(self) -> None:
        """Factorise the stiffness."""
        _ = self._system.held_factor

    def static(self) -> tuple[float, float]:
        """Deflection and capacitance of the clamped, free bimorph."""
        response = respond(attach(static_multiport(self._system), Ends()), {"voltage": 1.0})
        tip, charge = response.motion["w_tip"], response.effort["voltage"]
        return float(tip[0].real), float(charge[0].real)

    def natural(self) -> list[float]:
        """Natural frequencies; a coarse mesh says which classes of motion they are in."""
        if not isinstance(self._mesh, Bricks):
            return [mode.frequency for mode in natural_modes(self._system, Ends(), MODES)]
        scout = assemble(self._device, bimorph_bricks(self._device, _SCOUT), lossy=False)
        below = coarse_modes(scout, MODES)
        above = fine_modes(self._system, below, MODES)
        found, _ = lowest_modes(above, below, Ends(), MODES, open_circuit=False)
        return [mode.frequency for mode in found][:MODES]


def hexahedra(job: Job) -> Mesh:
    """Job's grid of bricks as hexahedra."""
    grid = bricks(job)
    sides = np.concatenate([grid.cells[:, side] for ends in SIDES for side in ends])
    return _named(grid.points, grid.cells, "hexahedron", grid.layer, sides)


def layered_tetrahedra(x: Floats, y: Floats, z: Floats, half: float) -> Mesh:
    """Boxes between planes (m) cut into six tetrahedra each; the shim is between x = ± `half`."""
    boxes = (y.size - 1) * (z.size - 1)
    region = np.repeat(layers_across(x, half), boxes).reshape(-1, y.size - 1, z.size - 1)
    mesh = box_tetrahedra(x, y, z, region, LAYERS)
    sides = np.concatenate([np.delete(mesh.cells, corner, axis=1) for corner in range(4)])
    return _named(mesh.points, mesh.cells, "tetra", mesh.region_of_cell, sides)


def _named(points: Floats, cells: Ints, kind: CellKind, layer: Ints, sides: Ints) -> Mesh:
    """Mesh of three layers with its named faces, from the `sides` of all cells."""
    half, outer = points[cells[layer == SHIM], 0].max(), points[:, 0].max()
    x, z, faces = points[sides, 0], points[sides, 2], {}
    for name, along, place in (
        ("base", z, 0.0), ("tip", z, z.max()),
        ("electrode_top_inner", x, half), ("electrode_top_outer", x, outer),
        ("electrode_bottom_inner", x, -half), ("electrode_bottom_outer", x, -outer),
    ):  # fmt: skip
        on = sides[(np.abs(along - place) < 1e-9 * outer).all(axis=1)]
        _, once = np.unique(np.sort(on, axis=1), axis=0, return_index=True)
        faces[name] = on[once]
    return Mesh(points, cells, kind, layer, LAYERS, faces)


#: Mesh of each of our families from a device and a fineness: of the first a level of the solid
#: model's own; of 27 nodes on the quarter (bricks of degree 2), how many through a ceramic layer,
#: and `side`, `smallest`, `longest` of a BrickMeshing; of tetwild's the edges (m) at the clamp and
#: elsewhere.  Another one is one line.
FAMILIES: dict[str, Callable[[Device, Any], Mesh | Bricks]] = {
    BRICKS: lambda device, level: bimorph_bricks(device, LEVELS[level]),
    "hexahedra of 27 nodes": lambda device, sizes: bimorph_bricks(device, BrickMeshing(
        (2, 2, 2), (1.0 / sizes[0],) * sizes[0], side=sizes[1], smallest=sizes[2], tip=sizes[2],
        longest=sizes[3], pieces=(10.0, 1e3), growth=3.0,
    )),
    "hexahedra of 20 nodes": lambda _, fineness: hexahedra(fineness),
    "structured P2 tetrahedra": lambda device, fineness: layered_tetrahedra(
        *planes(fineness), 0.5 * device.bimorph.shim_thickness
    ),
    "tetwild P2 tetrahedra": lambda device, edges: tetrahedralise(
        device, "alone", LAYERS, TetMeshing(root_edge_length=edges[0], edge_length=edges[1])
    ),
}  # fmt: skip
