"""The bimorph on its rod as an NGSolve user would solve it: Netgen's curved tetrahedra, order 3.

A quarter of rod, glue, shim and upper ceramic, for what bends it in x: on x = 0 it moves along x
only, on y = 0 not along y.  The rod's bottom face is clamped.  Netgen's geometry kernel makes the
round rod with its slot; tetrahedra are small in the bond and at the tab's and the ceramic's edges.
"""

from __future__ import annotations

from typing import Any, TypedDict

import numpy as np

from tactgen.validation.evidence.peers.job import Material, lowest_frequencies, potential_unit

_ORDER = 3
#: Largest tetrahedra of the rod and of the bimorph (mm).
_ROD, _BIMORPH = 0.6, 0.5
#: The mesh is curved in mm, so all is in N, mm, t, V: these are MPa, N/(V mm), N/V² and t/mm³ of
#: a material's tensors and its density.
_STIFFNESS, _COUPLING, _PERMITTIVITY, _DENSITY = 1e-6, 1e-3, 1.0, 1e-12
_MM = 1e3


class Solid(TypedDict):
    """A box between two corners or a turned outline (r, z), less a box (mm); others are empty."""

    box: list[list[float]]
    outline: list[list[float]]
    cut: list[list[float]]
    material: Material


class Job(TypedDict):
    """Solids by name: rod, glue, shim, piezo; tetrahedra in the bond and at the edges (mm)."""

    solids: dict[str, Solid]
    bond: float
    edge: float


class Answer(TypedDict):
    """Mean of u_x over the tip per volt (m/V), and the first frequency (Hz), short-circuited."""

    deflection: float
    frequency: float
    unknowns: int


def run(job: Job) -> Answer:
    """Solve the job; called alone in a process."""
    import ngsolve as ngs

    mesh = _mesh(job)
    moved = ngs.VectorH1(
        mesh, order=_ORDER, dirichletx="base", dirichlety="base|middle_x|middle_y",
        dirichletz="base|middle_x",
    )  # fmt: skip
    field = ngs.H1(mesh, order=_ORDER, definedon="piezo", dirichlet="inner|outer")
    space = moved * field
    free = space.FreeDofs(True)
    (u, phi), (v, psi) = space.TnT()
    known = {name: solid["material"] for name, solid in job["solids"].items()}
    unit = potential_unit(known["piezo"]) / _MM
    hard = mesh.MaterialCF(
        {name: _constant(ngs, _STIFFNESS, m["stiffness"]) for name, m in known.items()}
    )
    coupling = _constant(ngs, unit * _COUPLING, known["piezo"]["coupling"])
    permittivity = _constant(ngs, unit**2 * _PERMITTIVITY, known["piezo"]["permittivity"])
    s, t = _strain(ngs, u), _strain(ngs, v)
    stiffness = ngs.BilinearForm(space, symmetric=True, condense=True)
    stiffness += (hard * s) * t * ngs.dx
    stiffness += (
        (coupling * t) * ngs.grad(phi)
        + (coupling * s) * ngs.grad(psi)
        - (permittivity * ngs.grad(phi)) * ngs.grad(psi)
    ) * ngs.dx("piezo")
    stiffness.Assemble()
    density = mesh.MaterialCF({name: _DENSITY * m["density"] for name, m in known.items()})
    mass = ngs.BilinearForm(density * (u * v) * ngs.dx).Assemble().mat
    inverse = _inverse(ngs, stiffness, free)
    volt = ngs.GridFunction(space)
    volt.components[1].Set(1.0 / unit, definedon=mesh.Boundaries("outer"))
    force = volt.vec.CreateVector()
    stiffness.Apply(volt.vec, force)
    volt.vec.data -= inverse * force
    tip = mesh.Boundaries("tip")
    area = ngs.Integrate(ngs.CF(1.0) * ngs.ds(definedon=tip), mesh)
    bent = ngs.Integrate(volt.components[0][0] * ngs.ds(definedon=tip), mesh)
    x, y = force.CreateVector(), force.CreateVector()

    def times(operator: Any, values: Any) -> Any:
        x.FV().NumPy()[:] = np.ravel(values)
        y.data = operator * x
        return np.array(y.FV().NumPy())

    first = lowest_frequencies(lambda w: times(inverse, w), lambda w: times(mass, w), len(x), 1)
    unknowns = sum(space.FreeDofs())
    return Answer(deflection=bent / area / _MM, frequency=first[0], unknowns=unknowns)


def _constant(ngs: Any, unit: float, values: Any) -> Any:
    array = unit * np.array(values)
    return ngs.CoefficientFunction(tuple(array.ravel().tolist()), dims=array.shape)


def _strain(ngs: Any, u: Any) -> Any:
    """Return the strain of a displacement in Voigt's order."""
    g = ngs.Grad(u)
    shear = (g[1, 2] + g[2, 1], g[0, 2] + g[2, 0], g[0, 1] + g[1, 0])
    return ngs.CoefficientFunction((g[0, 0], g[1, 1], g[2, 2], *shear))


def _inverse(ngs: Any, form: Any, free: Any) -> Any:
    """Factorise what is left without the interior unknowns; return the inverse of all."""
    one = ngs.IdentityMatrix()
    inner = form.mat.Inverse(free, "sparsecholesky")
    to, back = one + form.harmonic_extension_trans, one + form.harmonic_extension
    return back @ inner @ to + form.inner_solve


def _mesh(job: Job) -> Any:
    """Return Netgen's tetrahedra of the quarter."""
    import netgen.occ as occ
    import ngsolve as ngs

    far = 100.0
    quarter = occ.Box(occ.Pnt(0.0, 0.0, -far), occ.Pnt(far, far, far))

    def box(corners: Any) -> Any:
        return occ.Box(*(occ.Pnt(*corner) for corner in corners))

    def made(solid: Solid) -> Any:
        if solid["outline"]:
            plane = occ.WorkPlane(occ.Axes((0, 0, 0), n=-occ.Y, h=occ.X))
            plane.MoveTo(*solid["outline"][0])
            for point in solid["outline"][1:]:
                plane.LineTo(*point)
            axis = occ.Axis(occ.Pnt(0.0, 0.0, 0.0), occ.Z)
            shape = plane.Close().Face().Revolve(axis, 360.0)
        else:
            shape = box(solid["box"])
        return (shape - box(solid["cut"]) if solid["cut"] else shape) * quarter

    shapes = []
    for name, solid in job["solids"].items():
        shape = made(solid).mat(name)
        shape.solids.maxh = {"rod": _ROD, "glue": job["bond"]}.get(name, _BIMORPH)
        shapes.append(shape)
    whole = occ.Glue(shapes)
    _name_faces(whole, job)
    mesh = occ.OCCGeometry(whole).GenerateMesh(grading=0.4)
    return ngs.Mesh(mesh).Curve(_ORDER)


def _name_faces(whole: Any, job: Job) -> None:
    """Name the faces, and make tetrahedra small along the bond's and the ceramic's lower edges."""
    low, high = job["solids"]["piezo"]["box"]
    bottom = min(z for _, z in job["solids"]["rod"]["outline"])
    tab = job["solids"]["shim"]["box"][0][2]
    near = 1e-6

    def flat(part: Any, axis: int, value: float) -> bool:
        ends = (corner[axis] for corner in part.bounding_box)
        return all(abs(end - value) < near for end in ends)

    planes = (
        ("middle_x", 0, 0.0), ("middle_y", 1, 0.0), ("base", 2, bottom), ("tip", 2, high[2]),
        ("outer", 0, high[0]), ("inner", 0, low[0]),
    )  # fmt: skip
    for face in whole.faces:
        above = face.bounding_box[0][2] > low[2] - near
        for name, axis, value in planes:
            if flat(face, axis, value) and (above or name not in ("inner", "outer")):
                face.name = name
    for edge in whole.edges:
        if any(flat(edge, 2, value) for value in (tab, 0.0, low[2])) and (
            edge.bounding_box[1][0] <= high[0] + near
        ):
            edge.maxh = job["edge"]
