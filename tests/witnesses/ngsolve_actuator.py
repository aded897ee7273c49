"""The normal actuator as an NGSolve user would solve it: its own mesh, elements and Newton.

Triangles by Netgen in the half section, small at all corners of iron, where the field is singular.
Unknown A_φ/r of order 4; the field minimises ∫ w(|B|) dV − i λ.  The force is the co-energy's
slope: the moving parts are carried a little up and down, the mesh with them, and solved anew.
"""

from __future__ import annotations

from typing import Any, TypedDict

#: How far the air reaches (m).
_REACH = 0.12
#: Polynomial order.
_ORDER = 4
#: Largest triangles (mm), of the air far away and of iron, winding and the air near them.
_FAR, _NEAR = 12.0, 0.15
#: What the moving parts are carried for the slope, as a share of the gap: its square is the error.
_STEP = 5e-3
#: Flux density (T) below which iron is linear, where its magnitude has no derivative.
_WEAK = 1e-7
_MM = 1e3


class Part(TypedDict):
    """A rectangle of the half section: radii, heights (m), turns (0 is iron), whether it moves."""

    radii: list[float]
    heights: list[float]
    turns: float
    moves: bool


class Job(TypedDict):
    """What is solved: parts, gap (m), currents (A), and the iron's curve.

    `knots` are the breaks of H(B) in T, the last one beyond all that is met, and `controls` the
    Bézier points of its cubics (A/m), each break once.  `corner` is the length of the triangles at
    the corners of iron (mm).
    """

    parts: list[Part]
    gap: float
    currents: list[float]
    knots: list[float]
    controls: list[float]
    corner: float


class Answer(TypedDict):
    """Flux linkage (Wb), co-energy (J) and pull (N) for each current."""

    flux_linkage: list[float]
    coenergy: list[float]
    force: list[float]
    unknowns: int


def run(job: Job) -> Answer:
    """Solve the job; called alone in a process."""
    model = _Model(job)
    step = _STEP * job["gap"]
    found = Answer(flux_linkage=[], coenergy=[], force=[], unknowns=model.unknowns)
    for current in job["currents"]:
        linked, coenergy = model.solved(current, 0.0)
        up, down = (model.solved(current, moved)[1] for moved in (step, -step))
        found["flux_linkage"].append(linked)
        found["coenergy"].append(coenergy)
        # the moving parts are above the gap: a pull that closes it points down
        found["force"].append(-(up - down) / (2.0 * step))
    return found


class _Model:
    """The half section on its mesh."""

    def __init__(self, job: Job) -> None:
        import ngsolve as ngs

        self._ngs, self._job = ngs, job
        self._mesh = _mesh(job)
        space = ngs.H1(self._mesh, order=_ORDER, dirichlet="wall")
        self.unknowns = sum(space.FreeDofs())
        self._potential = ngs.GridFunction(space)
        self._rise = self._carried()
        radius, weight = ngs.x, 2.0 * ngs.pi * ngs.x
        (coil,) = (part for part in job["parts"] if part["turns"])
        (inner, outer), (low, high) = coil["radii"], coil["heights"]
        self._turns = coil["turns"] / ((outer - inner) * (high - low))
        self._current = ngs.Parameter(0.0)
        u = space.TrialFunction()
        self._linked = self._turns * radius * weight
        self._energy = self._density()
        self._form = ngs.BilinearForm(space, symmetric=True)
        self._form += ngs.Variation(weight * self._energy(u, ngs.grad(u)) * ngs.dx)
        self._form += ngs.Variation(
            -self._current * self._linked * u * ngs.dx(definedon=self._mesh.Materials("coil"))
        )

    def _density(self) -> Any:
        """Return the energy density (J/m³) of a potential and its gradient."""
        ngs, job = self._ngs, self._job
        stored = _spline(ngs, job).Integrate()

        def density(u: Any, slope: Any) -> Any:
            across, along = -ngs.x * slope[1], 2.0 * u + ngs.x * slope[0]
            square = across**2 + along**2
            air = square / (2.0 * _MU0)
            iron = stored(ngs.sqrt(square + _WEAK**2))
            return self._mesh.MaterialCF({"iron.*": iron}, default=air)

        return density

    def _carried(self) -> Any:
        """Return each point's share of the motion: harmonic between moving and fixed parts."""
        ngs = self._ngs
        space = ngs.H1(self._mesh, order=1, dirichlet="wall")
        rise = ngs.GridFunction(space)
        moving = self._mesh.Materials("iron_moving|coil")
        rise.Set(1.0, definedon=moving)
        free = space.FreeDofs()
        for region in (moving, self._mesh.Materials("iron_fixed")):
            free &= ~space.GetDofs(region)
        u, v = space.TnT()
        form = ngs.BilinearForm(ngs.grad(u) * ngs.grad(v) * ngs.dx).Assemble()
        rise.vec.data -= form.mat.Inverse(free, "sparsecholesky") * (form.mat * rise.vec)
        return rise

    def solved(self, current: float, moved: float) -> tuple[float, float]:
        """Return flux linkage and co-energy with the moving parts `moved` (m) higher."""
        ngs = self._ngs
        from ngsolve.solvers import NewtonMinimization

        shift = ngs.GridFunction(ngs.VectorH1(self._mesh, order=1))
        shift.Set(ngs.CF((0.0, moved * self._rise)))
        self._mesh.SetDeformation(shift)
        self._current.Set(current)
        _, steps = NewtonMinimization(
            self._form, self._potential, maxit=60, maxerr=1e-12, inverse="sparsecholesky",
            linesearch=True, printing=False,
        )  # fmt: skip
        if steps >= 60:
            raise RuntimeError(f"Newton's method does not arrive at {current} A")
        coil = self._mesh.Materials("coil")
        linked = ngs.Integrate(self._linked * self._potential * ngs.dx(definedon=coil), self._mesh)
        u = self._potential
        weight = 2.0 * ngs.pi * ngs.x
        stored = ngs.Integrate(
            weight * self._energy(u, ngs.grad(u)), self._mesh, order=2 * _ORDER + 2
        )
        self._mesh.UnsetDeformation()
        return float(linked), float(current * linked - stored)


#: Permeability of vacuum (H/m), CODATA 2018.
_MU0 = 1.25663706212e-6


def _spline(ngs: Any, job: Job) -> Any:
    """Return H(B) as NGSolve's B-spline: with triple knots its coefficients are the controls."""
    first, *inside, last = job["knots"]
    knots = [first] * 4 + [knot for knot in inside for _ in range(3)] + [last] * 4
    return ngs.BSpline(4, knots, job["controls"])


def _mesh(job: Job) -> Any:
    """Return Netgen's triangles."""
    import netgen.occ as occ
    import ngsolve as ngs

    def face(radii: Any, heights: Any) -> Any:
        (inner, outer), (low, high) = ([_MM * v for v in pair] for pair in (radii, heights))
        return occ.MoveTo(inner, low).Rectangle(outer - inner, high - low).Face()

    def together(moves: bool) -> Any:
        faces = [
            face(p["radii"], p["heights"])
            for p in job["parts"] if not p["turns"] and p["moves"] == moves
        ]  # fmt: skip
        whole = faces[0]
        for other in faces[1:]:
            whole = whole + other
        return whole

    solids = {"iron_moving": together(True), "iron_fixed": together(False)}
    (coil,) = (p for p in job["parts"] if p["turns"])
    winding = face(coil["radii"], coil["heights"])
    winding.faces.name, winding.faces.maxh = "coil", _NEAR
    for name, solid in solids.items():
        solid.faces.name, solid.faces.maxh = name, _NEAR
        solid.vertices.maxh = job["corner"]
    air = face((0.0, _REACH), (-_REACH, _REACH))
    air.faces.name = "air"
    air.edges.Max(occ.X).name = air.edges.Max(occ.Y).name = air.edges.Min(occ.Y).name = "wall"
    air = air - winding - solids["iron_moving"] - solids["iron_fixed"]
    whole = occ.Glue([air, winding, *solids.values()])
    mesh = occ.OCCGeometry(whole, dim=2).GenerateMesh(maxh=_FAR, grading=0.25)
    mesh.Scale(1.0 / _MM)
    return ngs.Mesh(mesh)
