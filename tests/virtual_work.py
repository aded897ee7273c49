"""Force on a body in a static magnetic field by virtual work, in 3D.

Moving the body by δ, and the nodes of its shell by g δ with the eggshell's weight g, changes the
co-energy at constant current by F δ.  That uses only the energies of two solutions, the eggshell
the fields of a third.  What separates them is discretisation error, but not all of it: on curved
cells, whose nodes follow g exactly, both are the same derivative of the vector potential's
co-energy, and only the other potential tells how far off it is.
"""

from dataclasses import replace

import numpy as np


def moved(problem, weight, shift):
    """Problem with the body displaced by `shift` (3,) in m, the shell deformed.

    The source stays where it is.  A jump of T0 on the mesh's planes would be torn off
    them, so in body and shell T0 must be smooth; zero is.
    """
    mesh = problem.mesh
    points = mesh.points + weight.nodal[:, None] * np.asarray(shift, dtype=float)
    return replace(problem, mesh=replace(mesh, points=points))


def virtual_work_force(problem, weight, direction, step, coenergy):
    """Force (N) along `direction` (3,) from two co-energies (J), by `coenergy` of a problem.

    The body is moved by `step` (m) either way: a small part of the narrowest gap.
    """
    shift = step * np.asarray(direction, dtype=float)
    ahead = coenergy(moved(problem, weight, shift))
    behind = coenergy(moved(problem, weight, -shift))
    return (ahead - behind) / (2.0 * step)
