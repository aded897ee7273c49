"""The jobs of the piezoelectric benchmark, and their solution on this program's own meshes.

Job J1: a clamped PZT-5H bimorph, static deflection, capacitance and four natural
frequencies.  Job J2: its damped sweep at 200 frequencies.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import scipy.sparse.linalg  # noqa: F401  (before a clock starts)
from scipy import sparse

from tactgen.fem.piezo.krylov import reduce_to_ports
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import static_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.system import materials
from tactgen.fem.solvers.linear_solver import available_solver, factorise
from tactgen.geometry.arrays import Ints, Numbers
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.bricks import LEVELS, BrickMeshing, Bricks, bimorph_bricks
from tactgen.geometry.bimorph.tets import TetMeshing, tetrahedralise
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import respond
from tactgen.validation.evidence.peers.job import (
    LAYERS,
    Answer,
    Clock,
    Job,
    Material,
    answer,
    bricks,
)
from tactgen.validation.models.bimorph.natural_modes import coarse_modes, fine_modes, lowest_modes
from tactgen.validation.scene.scene import Scene, load_scene

#: Natural frequencies that are compared.
MODES = 4
#: Error asked of the reduction to ports, relative; far below the meshes' errors.
_REDUCTION = 1e-6

#: The solid model's own family.
BRICKS = "bricks of high order"


def j1() -> Scene:
    """Scene of the job."""
    return load_scene("j1", [])[0]


def job(
    *,
    kind: Literal["brick", "tetra"] = "brick",
    order: int = 2,
    through_piezo: int = 1,
    through_shim: int = 1,
    across: int = 2,
    longest: float,
    first: float,
    growth: float = 4.0,
    device: Device | None = None,
) -> Job:
    """Job J1, or another device's, as plain numbers; without frequencies."""
    device = device or j1().device
    regions = ("piezo_top", "shim")
    exact, lossy = (
        materials(device, regions, device.piezo.ceramic(), lossy=loss) for loss in (False, True)
    )
    bimorph = device.bimorph
    return Job(
        piezo_thickness=bimorph.piezo_thickness,
        shim_thickness=bimorph.shim_thickness,
        width=bimorph.width,
        length=bimorph.length,
        ceramic=_plain(exact["piezo_top"], lossy["piezo_top"]),
        shim=_plain(exact["shim"], lossy["shim"]),
        modes=MODES,
        frequencies=[],
        kind=kind,
        order=order,
        through_piezo=through_piezo,
        through_shim=through_shim,
        across=across,
        longest=longest,
        first=first,
        growth=growth,
    )


def _plain(exact: Any, lossy: Any) -> Material:
    """Region's tensors as lists: the lossy ones hold the imaginary parts."""

    def rows(values: Numbers) -> list[list[float]]:
        return [[float(v) for v in row] for row in values]

    empty: list[list[float]] = []
    piezo, damped = exact.piezo, lossy.piezo
    return Material(
        stiffness=rows(lossy.c.real),
        stiffness_loss=rows(lossy.c.imag),
        coupling=rows(damped.e.real) if piezo else empty,
        coupling_loss=rows(damped.e.imag) if piezo else empty,
        permittivity=rows(damped.eps.real) if piezo else empty,
        permittivity_loss=rows(damped.eps.imag) if piezo else empty,
        density=exact.density,
    )


def solve_own(family: str, fineness: Any, frequencies: list[float]) -> Answer:
    """Solve the job (or, with frequencies, its sweep) on a mesh of one of our families."""
    # the solver's libraries come with its first call, before the clock starts: their time is the
    # process's, not the mesh's
    factorise(sparse.csr_matrix(np.eye(2)))
    solver = available_solver()
    device, make = j1().device, FAMILIES[family]

    clock = Clock()
    mesh = make(device, fineness)
    clock.stop("mesh")
    system = assemble(device, mesh, lossy=bool(frequencies))
    clock.stop("assembly")
    if frequencies:
        values = _sweep(system, frequencies)
        clock.stop("sweep")
        return answer(clock, system.size, solver, sweep=values)
    _ = system.held_factor
    clock.stop("factor")
    static = _static(system)
    clock.stop("solve")
    natural = _natural(device, mesh, system)
    clock.stop("eigen")
    return answer(clock, system.size, solver, static=static, natural=natural)


def _static(system: Any) -> tuple[float, float]:
    """Deflection and capacitance of the clamped, free bimorph."""
    response = respond(attach(static_multiport(system), Ends()), {"voltage": 1.0})
    return float(response.motion["w_tip"][0].real), float(response.effort["voltage"][0].real)


def _natural(device: Device, mesh: Mesh | Bricks, system: Any) -> list[float]:
    """Natural frequencies; a coarse mesh says which classes of motion they are in."""
    if not isinstance(mesh, Bricks):
        return [mode.frequency for mode in natural_modes(system, Ends(), MODES)]
    below = coarse_modes(assemble(device, scout(device), lossy=False), MODES)
    above = fine_modes(system, below, MODES)
    found, _ = lowest_modes(above, below, Ends(), MODES, open_circuit=False)
    return [mode.frequency for mode in found][:MODES]


def _sweep(system: Any, frequencies: list[float]) -> list[complex]:
    """Complex deflection by reduction to ports."""
    f = np.array(frequencies)
    port = reduce_to_ports(system, f, tolerance=_REDUCTION).multiport(f)
    response = respond(attach(port, Ends()), {"voltage": 1.0})
    return [complex(w) for w in response.motion["w_tip"]]


#: Six tetrahedra of a brick, all around its diagonal from corner 0 to corner 6.
_TETS = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]


def second_order(
    device: Device, through: int, side: float, smallest: float, longest: float
) -> Bricks:
    """Bricks of degree 2, which are hexahedra of 27 nodes, on the quarter.

    `through` a ceramic layer; `side`, `smallest` and `longest` as of a BrickMeshing.
    """
    layers = (1.0 / through,) * through
    meshing = BrickMeshing(
        (2, 2, 2), layers, side=side, smallest=smallest, tip=smallest, longest=longest,
        pieces=(10.0, 1e3), growth=3.0,
    )  # fmt: skip
    return bimorph_bricks(device, meshing)


def scout(device: Device) -> Bricks:
    """So few bricks that asking them which modes are the lowest costs next to nothing.

    Two along the length, of degree 5: two percent off, where its modes lie tens apart.
    """
    whole = 1e3  # so long at both ends that nothing is left between them
    return bimorph_bricks(device, BrickMeshing((2, 2, 5), smallest=whole, tip=whole))


def hexahedra(job: Job) -> Mesh:
    """Job's grid of bricks as hexahedra."""
    grid = bricks(job)
    faces: dict[str, list[Ints]] = {}
    for face in grid.faces():
        if face.name != "side" and face.quads.size:
            name = face.name
            if name in ("outer", "inner"):
                name = f"electrode_{LAYERS[face.layer].removeprefix('piezo_')}_{name}"
            faces.setdefault(name, []).append(face.quads)
    return Mesh(
        points=grid.points,
        cells=grid.cells,
        kind="hexahedron",
        region_of_cell=grid.layer,
        regions=LAYERS,
        faces={name: np.concatenate(parts) for name, parts in faces.items()},
    )


def structured_tetrahedra(job: Job) -> Mesh:
    """Job's grid with every brick cut into six tetrahedra."""
    mesh = hexahedra(job)
    return Mesh(
        points=mesh.points,
        cells=mesh.cells[:, _TETS].reshape(-1, 4),
        kind="tetra",
        region_of_cell=np.repeat(mesh.region_of_cell, len(_TETS)),
        regions=mesh.regions,
        faces={name: _triangles(quads) for name, quads in mesh.faces.items()},
    )


def _triangles(quads: Ints) -> Ints:
    """Cut quadrilaterals as the tetrahedra do: along lowest to highest corner."""
    start = np.argmin(quads, axis=1)
    a, b, c, d = (quads[np.arange(len(quads)), (start + turn) % 4] for turn in range(4))
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def free_tetrahedra(device: Device, root: float, far: float) -> Mesh:
    """Tetwild mesh with edges of `root` at the clamp and `far` elsewhere (m)."""
    options = TetMeshing(edge_length=far, root_edge_length=root)
    return tetrahedralise(device, "alone", LAYERS, options)


#: Mesh of each of our families from a device and a fineness; that of the first a level of the
#: solid model's own.  Another one is one line.
FAMILIES: dict[str, Callable[[Device, Any], Mesh | Bricks]] = {
    BRICKS: lambda device, level: bimorph_bricks(device, LEVELS[level]),
    "hexahedra of 27 nodes": lambda device, sizes: second_order(device, *sizes),
    "hexahedra of 20 nodes": lambda _, fineness: hexahedra(fineness),
    "structured P2 tetrahedra": lambda _, fineness: structured_tetrahedra(fineness),
    "tetwild P2 tetrahedra": lambda device, edges: free_tetrahedra(device, *edges),
}
