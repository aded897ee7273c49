"""The bimorph as an NGSolve user would solve it: its own forms, elements and factorisation.

Bricks of the job's grid, or tetrahedra that Netgen makes from three glued boxes, graded
towards the clamp.  Displacement and potential are H1 functions of the job's order (complete
tensor products on bricks); the potential lives in the ceramic only.  From order 3 on,
interior unknowns are condensed.  Factorisation: NGSolve's own sparse Cholesky (L D Lᵀ),
which here is faster than its Pardiso and UMFPACK.  Natural frequencies by Lanczos around
0 Hz with that same factorisation.  The sweep factorises once per frequency.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.evidence.peers.job import (
    LAYERS,
    Answer,
    Bricks,
    Job,
    Material,
    bricks,
    lowest_frequencies,
    potential_unit,
    solved,
    tensor,
)

_SOLVER = "sparsecholesky"
#: Netgen's geometry kernel has a fixed tolerance, so lengths go through it in mm.
_MM = 1e3


def run(job: Job) -> Answer:
    """Solve the job; called alone in a process."""
    # imported before the clock starts: its time is the process's, not the mesh's
    import ngsolve  # noqa: F401

    return solved(
        job["frequencies"],
        lambda: _tetrahedra(job) if job["kind"] == "tetra" else _brick_mesh(bricks(job)),
        lambda mesh: _Model(mesh, job),
    )  # fmt: skip


class _Model:
    """The forms of a job on a mesh, assembled; complex for a sweep."""

    def __init__(self, mesh: Any, job: Job) -> None:
        import ngsolve as ngs

        self._ngs, self._modes = ngs, job["modes"]
        order, lossy = job["order"], bool(job["frequencies"])
        self._condense = order >= 3 and not lossy
        moved = ngs.VectorH1(mesh, order=order, dirichlet="base", complex=lossy)
        field = ngs.H1(
            mesh, order=order, definedon="piezo.*", dirichlet="inner|outer", complex=lossy
        )
        self._space = moved * field
        self._free = self._space.FreeDofs(self._condense)
        self.unknowns = sum(self._space.FreeDofs())
        (u, phi), (v, psi) = self._space.TnT()
        unit = potential_unit(job["ceramic"][0])
        c, e, eps, density = _coefficients(ngs, mesh, job, unit, lossy=lossy)
        s, t = _strain(ngs, u), _strain(ngs, v)
        self._stiffness = ngs.BilinearForm(self._space, symmetric=True, condense=self._condense)
        self._stiffness += (c * s) * t * ngs.dx
        self._stiffness += (
            (e * t) * ngs.grad(phi) + (e * s) * ngs.grad(psi)
            - (eps * ngs.grad(phi)) * ngs.grad(psi)
        ) * ngs.dx("piezo.*")  # fmt: skip
        self._stiffness.Assemble()
        mass = ngs.BilinearForm(self._space, symmetric=True)
        mass += density * (u * v) * ngs.dx
        mass.Assemble()
        self._mass = mass.mat
        tip = ngs.LinearForm(self._space)
        tip += v[0] * ngs.ds("tip")
        tip.Assemble()
        self._tip = tip.vec
        self._area = job["width"] * (job["shim_thickness"] + 2.0 * job["piezo_thickness"])
        volt = ngs.GridFunction(self._space)
        volt.components[1].Set(1.0 / unit, definedon=mesh.Boundaries("outer"))
        self._volt = volt.vec

    def factor(self) -> None:
        """Factorise; what is kept is the inverse stiffness as an operator."""
        a = self._stiffness
        self._inverse = a.mat.Inverse(self._free, _SOLVER)
        if self._condense:
            one = self._ngs.IdentityMatrix()
            to, back = one + a.harmonic_extension_trans, one + a.harmonic_extension
            self._inverse = back @ self._inverse @ to + a.inner_solve

    def static(self) -> tuple[float, float]:
        """Deflection and capacitance."""
        force, moved = self._volt.CreateVector(), self._volt.CreateVector()
        self._stiffness.Apply(self._volt, force)
        moved.data = self._volt - self._inverse * force
        self._stiffness.Apply(moved, force)
        charge = -self._ngs.InnerProduct(self._volt, force)
        return self._ngs.InnerProduct(self._tip, moved) / self._area, charge

    def natural(self) -> list[float]:
        """Lowest natural frequencies (Hz)."""
        x, y = self._volt.CreateVector(), self._volt.CreateVector()

        def times(operator: Any, v: Floats) -> Floats:
            x.FV().NumPy()[:] = np.ravel(v)
            y.data = operator * x
            return np.array(y.FV().NumPy())

        return lowest_frequencies(
            lambda v: times(self._inverse, v), lambda v: times(self._mass, v), len(x), self._modes
        )

    def sweep(self, frequencies: list[float]) -> list[complex]:
        """Complex deflection at frequencies (Hz), each by a factorisation of its own."""
        return [self._deflection_at(frequency) for frequency in frequencies]

    def _deflection_at(self, frequency: float) -> complex:
        k = self._stiffness.mat
        dynamic = k.CreateMatrix()
        omega = 2.0 * np.pi * frequency
        dynamic.AsVector().data = k.AsVector() - omega**2 * self._mass.AsVector()
        force, moved = self._volt.CreateVector(), self._volt.CreateVector()
        force.data = dynamic * self._volt
        moved.data = self._volt - dynamic.Inverse(self._free, _SOLVER) * force
        deflection = self._ngs.InnerProduct(self._tip, moved, conjugate=False)
        return complex(deflection) / float(self._area)


def _strain(ngs: Any, u: Any) -> Any:
    """Strain of a displacement in Voigt's order."""
    g = ngs.Grad(u)
    shear = (g[1, 2] + g[2, 1], g[0, 2] + g[2, 0], g[0, 1] + g[1, 0])
    return ngs.CoefficientFunction((g[0, 0], g[1, 1], g[2, 2], *shear))


def _coefficients(ngs: Any, mesh: Any, job: Job, unit: float, *, lossy: bool) -> list[Any]:
    """Stiffness, coupling, permittivity and density, the potential in its unit."""

    def constant(material: list[Material], name: str, scale: float = 1.0) -> Any:
        values = scale * tensor(material, name, lossy=lossy)
        return ngs.CoefficientFunction(tuple(values.ravel().tolist()), dims=values.shape)

    ceramic, shim = job["ceramic"], job["shim"]
    hard = {"piezo.*": constant(ceramic, "stiffness"), "shim": constant(shim, "stiffness")}
    heavy = {"piezo.*": ceramic[0]["density"], "shim": shim[0]["density"]}
    return [
        mesh.MaterialCF(hard), constant(ceramic, "coupling", unit),
        constant(ceramic, "permittivity", unit**2), mesh.MaterialCF(heavy),
    ]  # fmt: skip


def _brick_mesh(grid: Bricks) -> Any:
    """Grid as a mesh with named layers and faces."""
    import netgen.meshing as netgen
    import ngsolve as ngs

    mesh = netgen.Mesh(3)
    mesh.AddPoints(grid.points)
    for number, layer in enumerate(LAYERS):
        cells = grid.cells[grid.layer == number].astype(np.int32)
        mesh.AddElements(dim=3, index=number + 1, data=cells, base=0)
        mesh.SetMaterial(number + 1, layer)
    for index, face in enumerate(grid.faces(), 1):
        outside = 0 if face.behind is None else face.behind + 1
        mesh.Add(
            netgen.FaceDescriptor(surfnr=index, domin=face.layer + 1, domout=outside, bc=index)
        )
        mesh.SetBCName(index - 1, face.name)
        mesh.AddElements(dim=2, index=index, data=face.quads.astype(np.int32), base=0)
    return ngs.Mesh(mesh)


def _tetrahedra(job: Job) -> Any:
    """Netgen's mesh of three glued boxes, finest at the clamped face."""
    import netgen.occ as occ
    import ngsolve as ngs

    half = 0.5 * job["shim_thickness"] * _MM
    outer, side = half + job["piezo_thickness"] * _MM, 0.5 * job["width"] * _MM
    boxes = []
    for layer, low, high in zip(LAYERS, (half, -outer, -half), (outer, -half, half), strict=True):
        box = occ.Box(occ.Pnt(low, -side, 0.0), occ.Pnt(high, side, job["length"] * _MM))
        box.mat(layer)
        box.faces.name = "side"
        if layer != "shim":
            box.faces.Max(occ.X).name = "outer" if low > 0.0 else "inner"
            box.faces.Min(occ.X).name = "inner" if low > 0.0 else "outer"
        box.faces.Min(occ.Z).name, box.faces.Max(occ.Z).name = "base", "tip"
        box.faces.Min(occ.Z).maxh = job["first"] * _MM
        boxes.append(box)
    geometry = occ.OCCGeometry(occ.Glue(boxes))
    mesh = geometry.GenerateMesh(maxh=job["longest"] * _MM, grading=0.3)
    mesh.Scale(1.0 / _MM)
    return ngs.Mesh(mesh)
