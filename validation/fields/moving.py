"""The generator that moves: bimorph, rod and coil as one mesh, displaced by a run's coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.fem.beam import BeamMatrices
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.pieces import beam_pieces
from tactgen.geometry.bimorph.row_shape import block_cells, row_shape
from tactgen.geometry.device.layout import MM, Ring, moving_rings
from tactgen.geometry.device.parameters import Device, Support
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.tmm.generator.transient.machine import BimorphModes

#: Points around a ring.
_AROUND = 33


@dataclass(frozen=True)
class MovingBody:
    """A mesh, and how its points follow the coordinates of a run.

    Attributes
    ----------
    mesh : Mesh
        z = 0 at the rod's top face (m).
    lateral, axial : (n_points, c) float
        Displacement along x and z per coordinate; a run may have more coordinates behind these.
    """

    mesh: Mesh
    lateral: Floats
    axial: Floats

    def displacement(self, position: Floats) -> Floats:
        """Return (n_points, 3) in m at coordinates (n,)."""
        own = position[: self.lateral.shape[1]]
        along = self.lateral @ own
        return np.stack([along, np.zeros_like(along), self.axial @ own], axis=1)


def moving_body(device: Device, beam: BeamMatrices, modes: BimorphModes) -> MovingBody:
    """Return what moves of a generator: coordinates lift, w and ψ of the head, the modes.

    Parameters
    ----------
    device : Device
        Its row of pieces begins at the rod's head.
    beam, modes : BeamMatrices, BimorphModes
        Of that row.
    """
    z, w, psi = (np.array(column) for column in zip(*beam.stations, strict=True))
    top = device.bimorph.tab_length + device.bimorph.length
    row = row_shape(beam_pieces(device, Support()), device.bimorph, z, top)
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
    """Return rows with a first column for the lift."""
    return np.hstack([np.full((len(rows), 1), lift), rows])


def ring_mesh(name: str, ring: Ring) -> Mesh:
    """Return a turned ring (m) as hexahedra of one region."""
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
    """Return meshes of hexahedra side by side in one, without their named faces."""
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
