"""The piezoelectric solid: displacement and potential on a 3D mesh, seen at five ports.

Strong form: div T = ρ ü, div D = 0 with T = c S − eᵀ E, D = e S + ε E, E = −grad φ.
Weak form, for all (v, ψ):

    ∫ S(v)ᵀ c S(u) + S(v)ᵀ eᵀ grad φ − Ω² ρ v·u dV   = port forces
    ∫ grad ψ · e S(u) − grad ψ · ε grad φ dV          = −charge

Electrodes are equipotential: both outer faces at U, both shim faces at 0.  The base
face moves as a rigid section (w, ψ; no motion along y or z); tip displacement and
rotation are the means over the tip face that are work-conjugate to a uniform and a
linear traction.  The potential is carried in units that give it the size of a
displacement, so that all entries of the system are alike.
"""

from __future__ import annotations

from tactgen.fem.piezo.bricks import assemble_bricks
from tactgen.fem.piezo.system import SolidSystem, materials, volts_per_unit
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.structured_tets import mirror_axes


def assemble(
    device: Device, mesh: Mesh | Bricks, *, lossy: bool, ceramic: Piezoceramic | None = None
) -> SolidSystem:
    """Assemble the solid model of `device` on `mesh`, all that its ports can move.

    Bricks are the business of :mod:`fem.piezo.bricks`; other cells that of
    :mod:`fem.piezo.tetrahedra`.  Regions are among piezo_top, piezo_bottom, shim, glue, rod, faces
    as named there.  A mesh with the faces `MIRRORS` is a quarter, with the second of them half of
    it: the system is then that of the bending in x that the ports move, the others are ``related``
    to it.

    A `lossy` one takes the ceramic's Q and tan δ into account (complex matrices).  A full material
    stands for the device's own ceramic, if given, for studies of the tensor.
    """
    if isinstance(mesh, Bricks):
        return assemble_bricks(device, mesh, lossy=lossy, ceramic=ceramic)
    from tactgen.fem.piezo.tetrahedra import SkfemBody  # of scikit-fem, which bricks do without

    known = materials(device, mesh.regions, ceramic or device.piezo.ceramic(), lossy=lossy)
    unit = volts_per_unit(known)
    body = SkfemBody(mesh, known, unit, device.measurement.below_tip)
    return body.system("bending_x" if mirror_axes(mesh) else "all")
