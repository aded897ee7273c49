"""The rod below a bimorph that stands on its contact: a rigid body that follows the bimorph's base.

No model divides it, so of its fields only the displacement is known.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.layout import moving_rings
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.fields.moving import joined, ring_mesh
from tactgen.validation.fields.result import MODE_SIZE, Array, FieldResult, State
from tactgen.validation.scene.scene import Scene

#: Points this near the lowest (m) are the base.
_NEAR = 1e-9


def standing(scene: Scene, result: FieldResult) -> FieldResult:
    """Return a result with the rod and its coil below the bimorph, if it stands on their contact.

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
    """Return a state with its fields at the rod's points too, where all but the motion are 0."""
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
    """Return how points (n, 3) move that are rigidly joined to the base: u_x = w − z ψ, u_z = x ψ.

    Motions that the contact does not let through have none at the base.
    """
    base = at[:, 2] < at[:, 2].min() + _NEAR
    x, moved = at[base, 0], displacement[base]
    turned = (x @ moved[:, 2]) / (x @ x)
    shifted = moved.mean(axis=0)
    out = np.tile(shifted, (len(points), 1))
    out[:, 0] -= turned * points[:, 2]
    out[:, 2] += turned * points[:, 0]
    return np.asarray(out)
