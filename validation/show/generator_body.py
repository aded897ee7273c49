"""The generator that moves: bimorph, rod and coil as one mesh, displaced by a run's coordinates."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactgen.fem.beam import BeamMatrices
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import (
    CentreLine,
    RowShape,
    beam_pieces,
    block_cells,
    row_shape,
)
from tactgen.geometry.device.parameters import Device, Support
from tactgen.geometry.device.parts import MM, Ring, moving_rings
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.tmm.generator.transient.machine import BimorphModes
from tactgen.tmm.ports.excitation_and_circuit import PortState
from tactgen.validation.models.bimorph.model import BeamTheoryModel
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.field import MODE_SIZE, Array, FieldResult, State
from tactgen.validation.show.solid_fields import Found

#: Points around a ring.
_AROUND = 33


@dataclass(frozen=True)
class MovingBody:
    """A mesh, and how its points follow the coordinates of a run."""

    mesh: Mesh  #: z = 0 at the rod's top face (m)
    #: (n_points, c) Displacement along x and z per coordinate; a run may have more coordinates
    #: behind these
    lateral: Floats
    axial: Floats

    def displacement(self, position: Floats) -> Floats:
        """(n_points, 3) in m at coordinates (n,)."""
        own = position[: self.lateral.shape[1]]
        along = self.lateral @ own
        return np.stack([along, np.zeros_like(along), self.axial @ own], axis=1)


def moving_body(device: Device, beam: BeamMatrices, modes: BimorphModes) -> MovingBody:
    """Moving body of a generator: lift, w and ψ of the head, modes.

    Parameters
    ----------
    device : Device
        Its row of pieces begins at the rod's head.
    beam, modes : BeamMatrices, BimorphModes
        Of that row.
    """
    z, w, psi = (np.array(column) for column in zip(*beam.stations, strict=True))
    top = device.bimorph.height
    row = row_shape(beam_pieces(device, Support()), device, z, top)
    upright = row.mesh.points[:, :1]
    meshes = [row.mesh]
    lateral, turned = modes.shapes[w][row.station], modes.shapes[psi][row.station]
    along, up = [_lifted(lateral, 0.0)], [_lifted(upright * turned, 1.0)]
    for name, rings in moving_rings(device).items():
        for ring in rings:
            mesh = ring_mesh(name, ring)
            x, height = mesh.points[:, :1], mesh.points[:, 2:]
            ones, none = np.ones_like(x), np.zeros((len(x), modes.omega.size))
            meshes.append(mesh)
            along.append(_lifted(np.hstack([ones, -height, none]), 0.0))
            up.append(_lifted(np.hstack([0.0 * x, x, none]), 1.0))
    return MovingBody(joined(meshes), np.vstack(along), np.vstack(up))


def _lifted(rows: Floats, lift: float) -> Floats:
    """Rows with a first column for the lift."""
    return np.hstack([np.full((len(rows), 1), lift), rows])


def ring_mesh(name: str, ring: Ring) -> Mesh:
    """Turned ring (m) as hexahedra of one region."""
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND)
    height, radius, angle = np.meshgrid(
        np.array([ring.low, ring.high]) / MM, np.array([ring.inner, ring.outer]) / MM, angle,
        indexing="ij",
    )  # fmt: skip
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1)
    cells = block_cells(2, 2, _AROUND)
    return Mesh(
        points.reshape(-1, 3),
        cells,
        "hexahedron",
        np.zeros(len(cells), dtype=np.int64),
        (name,),
        {},
    )


def joined(meshes: list[Mesh]) -> Mesh:
    """Meshes of hexahedra side by side in one, without their named faces."""
    names = tuple(dict.fromkeys(name for mesh in meshes for name in mesh.regions))
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes)])
    numbers = [np.array([names.index(name) for name in mesh.regions]) for mesh in meshes]
    return Mesh(
        points=np.concatenate([mesh.points for mesh in meshes]),
        cells=np.concatenate([m.cells + s for m, s in zip(meshes, starts[:-1], strict=True)]),
        kind="hexahedron",
        region_of_cell=np.concatenate(
            [own[m.region_of_cell] for m, own in zip(meshes, numbers, strict=True)]
        ),
        regions=names,
        faces={},
    )


#: Points this near the lowest (m) are the base.
_NEAR = 1e-9


def standing(scene: Scene, result: FieldResult) -> FieldResult:
    """Result with the rod and its coil below the bimorph, if it stands on their contact.

    What tetrahedra show stays alone.

    Parameters
    ----------
    result : FieldResult
        The bimorph's base lies in the plane z = 0, the rod's top face, and moves as a rigid body.
    """
    lateral = result.theory in ("beam", "solid") and result.mesh.kind == "hexahedron"
    if scene.support.kind != "contact" or not lateral:
        return result
    bodies = moving_rings(scene.device).items()
    rings = [ring_mesh(name, ring) for name, rings in bodies for ring in rings]
    mesh = joined([result.mesh, *rings])
    points = mesh.points[len(result.mesh.points) :]
    states = tuple(_with_rod(state, result.mesh, points) for state in result.states)
    rigid = tuple(dict.fromkeys(name for ring in rings for name in ring.regions))
    return replace(result, mesh=mesh, states=states, rigid=rigid)


def _with_rod(state: State, mesh: Mesh, points: Floats) -> State:
    """State with its fields at the rod's points too, where all but the motion are 0."""
    fields = {
        name: np.concatenate([values, np.zeros((len(points), *values.shape[1:]), values.dtype)])
        for name, values in ((name, np.asarray(of)) for name, of in state.fields.items())
    }
    moved = fields["displacement"]
    moved[len(mesh.points) :] = _carried(mesh.points, moved[: len(mesh.points)], points)
    if state.kind != "mode":
        return replace(state, fields=fields)
    factor = MODE_SIZE / float(np.linalg.norm(np.abs(moved), axis=1).max())
    fields = {name: factor * values for name, values in fields.items()}
    return replace(state, fields=fields, tip=factor * state.tip, charge=factor * state.charge)


def _carried(at: Floats, displacement: Array, points: Floats) -> Array:
    """Rigid motion of points (n, 3) with the base: u_x = w − z ψ, u_z = x ψ, and alike about x.

    Motions that the contact does not let through have none at the base.
    """
    base = at[:, 2] < at[:, 2].min() + _NEAR
    moved = displacement[base]
    out = np.tile(moved.mean(axis=0), (len(points), 1))
    for axis in (0, 1):
        side = at[base, axis]
        turned = (side @ moved[:, 2]) / (side @ side)
        out[:, axis] -= turned * points[:, 2]
        out[:, 2] += turned * points[:, axis]
    return np.asarray(out)


class RowFields:
    """The states of a beam theory: displacement and potential, at points of one mesh."""

    def __init__(self, model: BeamTheoryModel) -> None:
        self._model = model
        scene = model.scene
        rod = scene.support.kind == "rod"
        base = scene.device.ceramic_base if rod else scene.bimorph.tab_length
        lines = model.mode_lines(open_circuit=False)
        pieces = beam_pieces(scene.device, scene.support)
        top = base + scene.bimorph.length + scene.bimorph.tip_extension
        self._shape: RowShape = row_shape(pieces, scene.device, lines[0].z, top)
        self._short = lines

    @property
    def mesh(self) -> Mesh:
        """The points and cells."""
        return self._shape.mesh

    def modes(self, count: int, *, open_circuit: bool) -> list[Found]:
        """Fields of the lowest `count` modes, ascending."""
        lines = self._model.mode_lines(open_circuit=True) if open_circuit else self._short
        out = []
        for line in lines[:count]:
            values = self._shape.values(line)
            size = float(np.linalg.norm(values[:, :3], axis=1).max())
            out.append(self._found(line, MODE_SIZE / size))
        return out

    def driven(self, state: PortState) -> Found:
        """Fields under ports that move so, at rest lossless."""
        return self._found(self._model.driven_line(state))

    def _found(self, line: CentreLine, factor: float = 1.0) -> Found:
        values = factor * self._shape.values(line)
        fields = {"displacement": values[:, :3], "potential": values[:, 3]}
        measured = line.measured(self._model.scene.measurement.below_tip)
        return fields, factor * measured, factor * line.charge
