"""The bimorph as a SfePy user would solve it: its own fields, terms and regions.

Bricks of the job's grid with complete Lagrange polynomials of the job's order for
displacement and, in the ceramic only, potential.  The terms are those of its piezoelectric
examples (lin_elastic, piezo_coupling, diffusion, dot); losses are assembled as a second set of real
tensors.  Factorisation: SuperLU, SfePy's own choice where no other solver is installed, in
symmetric mode.  Natural frequencies by Lanczos around 0 Hz with that same factorisation.
The sweep factorises once per frequency.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from tactgen.geometry.arrays import Floats, Ints, Sparse
from tactgen.geometry.errors import InputError
from tactgen.validation.evidence.peers.job import (
    Answer,
    Clock,
    Job,
    Material,
    answer,
    bricks,
    lowest_frequencies,
    potential_unit,
)

_SOLVER = "SuperLU"
_LAYERS: tuple[Literal["ceramic"], Literal["shim"]] = ("ceramic", "shim")
#: Voigt's order in SfePy: xx, yy, zz, xy, xz, yz.
_ORDER = [0, 1, 2, 5, 4, 3]
#: Distance (m) within which a vertex lies on a plane.
_NEAR = 1e-9


def run(job: Job) -> Answer:
    """Solve the job; called alone in a process."""
    if job["kind"] != "brick":
        raise InputError("SfePy makes no tetrahedra by itself; ask it for bricks")
    # imported before the clock starts: their time is the process's, not the mesh's
    import sfepy.discrete.fem
    import sfepy.terms  # noqa: F401
    from sfepy.base.base import output

    output.set_output(quiet=True)
    clock = Clock()
    domain = _domain(job)
    clock.stop("mesh")
    model = _Model(domain, job)
    clock.stop("assembly")
    if job["frequencies"]:
        values = [model.deflection_at(frequency) for frequency in job["frequencies"]]
        clock.stop("sweep")
        return answer(clock, model.unknowns, _SOLVER, sweep=values)
    inverse = _factorised(model.stiffness)
    clock.stop("factor")
    static = model.static(inverse)
    clock.stop("solve")
    natural = lowest_frequencies(inverse, lambda v: model.mass @ v, model.unknowns, job["modes"])
    clock.stop("eigen")
    return answer(clock, model.unknowns, _SOLVER, static=static, natural=natural)


def _domain(job: Job) -> Any:
    """Grid as a domain; cell groups 1 and 2 are the ceramic, 3 the shim."""
    from sfepy.discrete.fem import FEDomain, Mesh

    grid = bricks(job)
    groups = [(grid.layer + 1).astype(np.int32)]
    cells = [grid.cells.astype(np.int32)]
    return FEDomain("bimorph", Mesh.from_data("bimorph", grid.points, None, cells, groups, ["3_8"]))


class _Model:
    """Assembled matrices of the free unknowns; complex stiffness for a sweep.

    Attributes
    ----------
    stiffness, mass : (n, n) sparse
        Of the free displacements and potentials.
    unknowns : int
        n.
    """

    def __init__(self, domain: Any, job: Job) -> None:
        forms = _Forms(domain, job)
        whole: Sparse = forms.stiffness(loss=False)
        if job["frequencies"]:
            whole = whole + 1j * forms.stiffness(loss=True)
        mass, tip = forms.mass(), forms.tip()
        free, volt = forms.essential()
        self.stiffness, self.mass = whole[free][:, free], mass[free][:, free]
        self.unknowns = free.size
        self._area = job["width"] * (job["shim_thickness"] + 2.0 * job["piezo_thickness"])
        self._tip, self._free, self._volt, self._whole = tip, free, volt, whole
        self._force, self._inertia = (whole @ volt)[free], (mass @ volt)[free]

    def static(self, inverse: Any) -> tuple[float, float]:
        """Deflection and capacitance."""
        y = self._volt.copy()
        y[self._free] -= inverse(self._force)
        return float(self._tip @ y / self._area), float(-self._volt @ (self._whole @ y))

    def deflection_at(self, frequency: float) -> complex:
        """Complex deflection at a frequency (Hz) by a factorisation of its own."""
        o2 = (2.0 * np.pi * frequency) ** 2
        inverse = _factorised(self.stiffness - o2 * self.mass)
        moved = -inverse(self._force - o2 * self._inertia)
        return complex(self._tip[self._free] @ moved / self._area)


class _Forms:
    """Fields, terms and regions of a job; matrices over all unknowns, fixed ones included."""

    def __init__(self, domain: Any, job: Job) -> None:
        from sfepy.discrete import Equations, FieldVariable, Integral, Problem
        from sfepy.discrete.fem import Field

        order = job["order"]
        everything = domain.create_region("all", "all")
        self._piezo = domain.create_region("piezo", "cells of group 1 +c cells of group 2")
        self._shim = domain.create_region("shim", "cells of group 3")
        self._faces = _faces(domain, job)
        moved = Field.from_args("moved", np.float64, "vector", everything, approx_order=order)
        field = Field.from_args("field", np.float64, "scalar", self._piezo, approx_order=order)
        self._spaces = (moved, field)
        self._variables = {
            "u": FieldVariable("u", "unknown", moved),
            "v": FieldVariable("v", "test", moved, primary_var_name="u"),
            "phi": FieldVariable("phi", "unknown", field),
            "psi": FieldVariable("psi", "test", field, primary_var_name="phi"),
        }
        self._integral = Integral("i", order=2 * order)
        self._unit = potential_unit(job["ceramic"])
        self._equations = {"mass": self._inertia(job), "tip": self._mean_over_tip()}
        for loss in (False, True) if job["frequencies"] else (False,):
            self._equations |= self._constitutive(job, loss=loss)
        self._all = Equations(self._equations.values())
        self._problem = Problem("bimorph", equations=self._all)
        self._problem.time_update()
        self._problem.update_materials()

    def _sum(self, name: str, *terms: tuple[float, str, Any, Any]) -> Any:
        """Equation of (factor, term, region, material)."""
        from sfepy.discrete import Equation
        from sfepy.terms import Term

        made = []
        for factor, form, region, material in terms:
            named = {key: v for key, v in self._variables.items() if key in _arguments(form)}
            made.append(
                factor
                * Term.new(form, self._integral, region, **{material.name: material}, **named)
            )
        return Equation(name, sum(made[1:], made[0]))

    def _constitutive(self, job: Job, *, loss: bool) -> dict[str, Any]:
        """Two rows of the piezoelectric stiffness, or of its imaginary part."""
        from sfepy.discrete import Material as Constants

        at, (ceramic, shim) = f"{loss:d}", (_tensors(job[key], loss=loss) for key in _LAYERS)
        p = Constants(
            f"p{at}", D=ceramic[0], e=self._unit * ceramic[1], eps=self._unit**2 * ceramic[2]
        )
        s = Constants(f"s{at}", D=shim[0])
        return {
            f"u{at}": self._sum(
                f"u{at}",
                (1.0, f"dw_lin_elastic(p{at}.D, v, u)", self._piezo, p),
                (1.0, f"dw_lin_elastic(s{at}.D, v, u)", self._shim, s),
                (1.0, f"dw_piezo_coupling(p{at}.e, v, phi)", self._piezo, p),
            ),
            f"phi{at}": self._sum(
                f"phi{at}",
                (1.0, f"dw_piezo_coupling(p{at}.e, u, psi)", self._piezo, p),
                (-1.0, f"dw_diffusion(p{at}.eps, psi, phi)", self._piezo, p),
            ),
        }

    def _inertia(self, job: Job) -> Any:
        from sfepy.discrete import Material as Constants

        p, s = (Constants(f"rho_{key}", rho=job[key]["density"]) for key in _LAYERS)
        return self._sum(
            "mass",
            (1.0, f"dw_dot({p.name}.rho, v, u)", self._piezo, p),
            (1.0, f"dw_dot({s.name}.rho, v, u)", self._shim, s),
        )

    def _mean_over_tip(self) -> Any:
        from sfepy.discrete import Material as Constants

        pull = Constants("pull", x=[[1.0], [0.0], [0.0]])
        return self._sum("tip", (1.0, "dw_surface_ltr(pull.x, v)", self._faces["tip"], pull))

    def _assembled(self, *names: str) -> Sparse:
        matrix = self._problem.mtx_a.copy()
        matrix.data[:] = 0.0
        for name in names:
            matrix = self._equations[name].evaluate(mode="weak", dw_mode="matrix", asm_obj=matrix)
        return matrix

    def stiffness(self, *, loss: bool) -> Sparse:
        """Stiffness, or its imaginary part."""
        return self._assembled(f"u{loss:d}", f"phi{loss:d}")

    def mass(self) -> Sparse:
        """Mass matrix."""
        return self._assembled("mass")

    def tip(self) -> Floats:
        """Integral of u_x over the tip per unknown."""
        zero = np.zeros(self._problem.mtx_a.shape[0])
        found = self._equations["tip"].evaluate(mode="weak", dw_mode="vector", asm_obj=zero)
        return np.asarray(found)

    def essential(self) -> tuple[Ints, Floats]:
        """Free unknowns, and all unknowns at 1 V with nothing moved."""
        starts = self._all.variables.di.indx
        moved, field = self._spaces

        def on(space: Any, face: str) -> Ints:
            return np.asarray(space.get_dofs_in_region(self._faces[face], merge=True))

        volt = np.zeros(self._problem.mtx_a.shape[0])
        fixed = np.zeros(volt.size, dtype=bool)
        base = 3 * on(moved, "base")[:, None] + np.arange(3)
        fixed[starts["u"].start + base.ravel()] = True
        outer = starts["phi"].start + on(field, "outer")
        fixed[starts["phi"].start + on(field, "inner")] = fixed[outer] = True
        volt[outer] = 1.0 / self._unit
        return np.flatnonzero(~fixed), volt


def _arguments(form: str) -> list[str]:
    """Names between the brackets of a term."""
    return form.partition("(")[2].rstrip(")").split(", ")


def _tensors(material: Material, *, loss: bool) -> tuple[Floats, Floats, Floats]:
    """Stiffness, coupling and permittivity (or their losses) in SfePy's order."""
    part = (
        (material["stiffness_loss"], material["coupling_loss"], material["permittivity_loss"])
        if loss
        else (material["stiffness"], material["coupling"], material["permittivity"])
    )
    c, e, eps = (np.array(values) for values in part)
    return c[np.ix_(_ORDER, _ORDER)], e[..., _ORDER] if e.size else e, eps


def _faces(domain: Any, job: Job) -> dict[str, Any]:
    """Named faces as regions."""
    half = 0.5 * job["shim_thickness"]
    outer, upper = half + job["piezo_thickness"] - _NEAR, job["length"] - _NEAR
    where = {
        "base": f"vertices in z < {_NEAR}",
        "tip": f"vertices in z > {upper}",
        "outer": f"vertices in (x > {outer}) | (x < {-outer})",
        "inner": "r.piezo *v r.shim",
    }
    return {name: domain.create_region(name, at, "facet") for name, at in where.items()}


def _factorised(matrix: Sparse) -> Any:
    """V ↦ matrix⁻¹ v."""
    from scipy.sparse.linalg import splu

    return splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.01,
        options={"SymmetricMode": True},
    ).solve
