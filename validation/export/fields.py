"""Fields of a scene as files for ParaView: .vtu, .vtkhdf, and .pvd for what moves."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.files import NotWritten, writable_folder, write_text, written_whole
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.mesh_files import write_mesh
from tactgen.validation.fields.result import FIELDS, Array, FieldResult, State, at_phase

#: Steps of one period in a .pvd.
STEPS = 24
#: Of HDF's deflate, 0 to 9.
_COMPRESSION = 4
#: Where VTK's xx, yy, zz, xy, yz, xz are in Voigt's order.
_VTK_ORDER = [0, 1, 2, 5, 3, 4]
#: Number of VTK's cell of each kind.
_VTK_CELL = {"tetra": 10, "tetra10": 24, "hexahedron": 12}


def write_fields(path: Path, result: FieldResult, name: str | None = None) -> None:
    """Write the states of a result to a file, as its suffix says.

    A .vtu or .vtkhdf holds every field of every state at the mesh's points, named
    ``STATE: FIELD (UNIT)``; complex amplitudes (peak, e^{+jΩt}) are two fields, real and imaginary
    part.  Tensors have VTK's order xx, yy, zz, xy, yz, xz, strains as tensor components.  In a
    .vtkhdf names have _ for a decimal point.  A .pvd holds one period of the first harmonic
    state, else of the first mode, as time steps in s, in the folder ``NAME_steps`` beside it.

    Parameters
    ----------
    name : str, optional
        For that folder; that of the file by default.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    if path.suffix == ".pvd":
        _write_pvd(path, result, name or path.stem)
        return
    data: dict[str, Array] = {}
    for state in result.states:
        data |= _all_fields(state)
    if path.suffix == ".vtu":
        write_mesh(result.mesh, path, data)
        return
    grid = as_grid(result.mesh)
    for name, values in data.items():
        grid.point_data[name.replace(".", "_")] = values  # HDF knows no dots in names
    with written_whole(path) as temporary:
        if not _write_hdf(grid, temporary):
            remedy = "make room there, choose a folder on a local disk, or write .vtu"
            raise NotWritten(path, "VTK's HDF5 writer failed", remedy)


def as_grid(mesh: Mesh) -> Any:
    """Return a mesh as PyVista's grid in m, with the cell array ``region``."""
    import pyvista as pv

    count, corners = mesh.cells.shape
    cells = np.column_stack([np.full(count, corners), mesh.cells])
    grid = pv.UnstructuredGrid(cells.ravel(), np.full(count, _VTK_CELL[mesh.kind]), mesh.points)
    grid.cell_data["region"] = mesh.region_of_cell
    return grid


def field_name(state: str, field: str, part: str = "") -> str:
    """Return the name of an array: state, field, part of a complex amplitude, unit."""
    kind = FIELDS[field]
    of = f", {part} part" if part else ""
    return f"{state}: {kind.title}{of} ({kind.unit})"


def _all_fields(state: State) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for name, values in state.fields.items():
        values = _for_vtk(name, np.asarray(values))
        if state.kind == "harmonic":
            found[field_name(state.name, name, "real")] = np.real(values).copy()
            found[field_name(state.name, name, "imaginary")] = np.imag(values).copy()
        else:
            found[field_name(state.name, name)] = np.real(values).copy()
    return found


def _for_vtk(name: str, values: Array) -> Array:
    """Return a field with the components that ParaView's labels mean."""
    if name not in ("strain", "stress"):
        return values
    shear = 0.5 if name == "strain" else 1.0
    return np.asarray((values * np.array([1.0, 1.0, 1.0, shear, shear, shear]))[:, _VTK_ORDER])


def _write_hdf(grid: Any, path: Path) -> bool:
    from vtkmodules.vtkIOHDF import vtkHDFWriter

    writer = vtkHDFWriter()
    writer.SetInputData(grid)
    writer.SetFileName(str(path))
    writer.SetCompressionLevel(_COMPRESSION)
    return bool(writer.Write())


def moving_state(result: FieldResult) -> State:
    """Return the state that a film is of: the first harmonic one, else the first."""
    return next((s for s in result.states if s.kind == "harmonic"), result.states[0])


def _write_pvd(path: Path, result: FieldResult, name: str) -> None:
    state = moving_state(result)

    def at(step: int) -> tuple[float, dict[str, Array]]:
        phase = 2.0 * np.pi * step / STEPS
        return step / STEPS / state.frequency, {
            field_name(state.name, field): at_phase(_for_vtk(field, np.asarray(values)), phase)
            for field, values in state.fields.items()
        }

    write_steps(path, name, result.mesh, map(at, range(STEPS)))


def write_steps(
    path: Path, name: str, mesh: Mesh, steps: Iterable[tuple[float, dict[str, Array]]]
) -> None:
    """Write time steps as a .pvd, with each step in the folder ``NAME_steps`` beside it.

    Parameters
    ----------
    steps : iterable of (float, dict)
        Time (s), and data at the mesh's points by name.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    folder = writable_folder(path.parent / f"{name}_steps")
    lines = []
    for step, (time, data) in enumerate(steps):
        piece = folder / f"{step:03d}.vtu"
        write_mesh(mesh, piece, data)
        lines.append(
            f'    <DataSet timestep="{time:.9e}" part="0" file="{folder.name}/{piece.name}"/>'
        )
    write_text(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        + "\n".join(lines)
        + "\n  </Collection>\n</VTKFile>\n",
    )
