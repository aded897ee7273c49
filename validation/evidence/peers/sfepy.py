"""The bimorph as a SfePy user would solve it: its own fields, terms and regions.

Bricks of the job's grid with complete Lagrange polynomials of the job's order for
displacement and, in the ceramic only, potential.  The terms are those of its piezoelectric
examples (lin_elastic, piezo_coupling, diffusion, dot); losses are assembled as a second set of real
tensors.  Factorisation: SuperLU, SfePy's own choice where no other solver is installed, in
symmetric mode.  Natural frequencies by Lanczos around 0 Hz with that same factorisation.
The sweep factorises once per frequency.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats, Ints, Sparse
from tactgen.validation.evidence.peers.job import (
    Answer,
    Job,
    Material,
    bricks,
    lowest_frequencies,
    potential_unit,
    solved,
)

#: Voigt's order in SfePy: xx, yy, zz, xy, xz, yz.
_ORDER = [0, 1, 2, 5, 4, 3]
#: Distance (m) within which a vertex lies on a plane.
_NEAR = 1e-9
#: Parts of the piezoelectric stiffness, or of its imaginary part, by materials p and s; masses; and
#: the integral of u_x over the tip.
_STIFFNESS = (
    "dw_lin_elastic.i.piezo(p{part}.D, v, u) + dw_lin_elastic.i.shim(s{part}.D, v, u)",
    "dw_piezo_coupling.i.piezo(p{part}.e, v, phi)",
    "dw_piezo_coupling.i.piezo(p{part}.e, u, psi) - dw_diffusion.i.piezo(p{part}.eps, psi, phi)",
)
_MASS = "dw_dot.i.piezo(p0.rho, v, u) + dw_dot.i.shim(s0.rho, v, u)"
_TIP = "dw_surface_ltr.i.tip(pull.x, v)"


def run(job: Job) -> Answer:
    """Solve the job; called alone in a process."""
    # imported before the clock starts: their time is the process's, not the mesh's
    import sfepy.discrete.fem
    import sfepy.terms  # noqa: F401
    from sfepy.base.base import output

    output.set_output(quiet=True)
    return solved(job["frequencies"], lambda: _domain(job), lambda domain: _Model(domain, job))


def _domain(job: Job) -> Any:
    """Grid as a domain; cell groups 1 and 2 are the ceramic, 3 the shim."""
    from sfepy.discrete.fem import FEDomain, Mesh

    grid = bricks(job)
    groups = [(grid.layer + 1).astype(np.int32)]
    cells = [grid.cells.astype(np.int32)]
    return FEDomain("bimorph", Mesh.from_data("bimorph", grid.points, None, cells, groups, ["3_8"]))


class _Model:
    """Fields, terms and regions of a job; assembled matrices, complex for a sweep."""

    def __init__(self, domain: Any, job: Job) -> None:
        from sfepy.discrete import Problem

        self._unit, self._modes = potential_unit(job["ceramic"][0]), job["modes"]
        self._faces = _faces(domain, job)
        self._spaces, self._equations = _equations(domain, job, self._unit)
        problem = Problem("bimorph", equations=self._equations)
        problem.time_update()
        problem.update_materials()
        self._empty = problem.mtx_a
        self._area = job["width"] * (job["shim_thickness"] + 2.0 * job["piezo_thickness"])
        self._tip = self._equations["tip"].evaluate(
            mode="weak", dw_mode="vector", asm_obj=np.zeros(self._empty.shape[0])
        )
        stiffness = [[f"{i} of {part}" for i in range(len(_STIFFNESS))] for part in (0, 1)]
        self._whole, mass = self._assembled(*stiffness[0]), self._assembled("mass")
        if job["frequencies"]:
            self._whole = self._whole + 1j * self._assembled(*stiffness[1])
        self._free, self._volt = self._essential()
        self.unknowns = self._free.size
        self._stiffness, self._mass = (m[self._free][:, self._free] for m in (self._whole, mass))
        self._force = (self._whole @ self._volt)[self._free]
        self._inertia = (mass @ self._volt)[self._free]

    def _assembled(self, *names: str) -> Sparse:
        """Sum of equations' matrices over all unknowns, fixed ones included."""
        matrix = self._empty.copy()
        matrix.data[:] = 0.0
        for name in names:
            matrix = self._equations[name].evaluate(mode="weak", dw_mode="matrix", asm_obj=matrix)
        return matrix

    def _essential(self) -> tuple[Ints, Floats]:
        """Free unknowns, and all unknowns at 1 V with nothing moved."""
        starts = self._equations.variables.di.indx

        def on(name: str, face: str) -> Ints:
            return np.asarray(self._spaces[name].get_dofs_in_region(self._faces[face], merge=True))

        volt = np.zeros(self._empty.shape[0])
        fixed = np.zeros(volt.size, dtype=bool)
        base = 3 * on("u", "base")[:, None] + np.arange(3)
        fixed[starts["u"].start + base.ravel()] = True
        outer = starts["phi"].start + on("phi", "outer")
        fixed[starts["phi"].start + on("phi", "inner")] = fixed[outer] = True
        volt[outer] = 1.0 / self._unit
        return np.flatnonzero(~fixed), volt

    def factor(self) -> None:
        """Factorise."""
        self._inverse = _factorised(self._stiffness)

    def static(self) -> tuple[float, float]:
        """Deflection and capacitance."""
        y = self._volt.copy()
        y[self._free] -= self._inverse(self._force)
        return float(self._tip @ y / self._area), float(-self._volt @ (self._whole @ y))

    def natural(self) -> list[float]:
        """Lowest natural frequencies (Hz)."""
        return lowest_frequencies(
            self._inverse, lambda v: self._mass @ v, self.unknowns, self._modes
        )

    def sweep(self, frequencies: list[float]) -> list[complex]:
        """Complex deflection at frequencies (Hz), each by a factorisation of its own."""
        found = []
        for o2 in ((2.0 * np.pi * frequency) ** 2 for frequency in frequencies):
            inverse = _factorised(self._stiffness - o2 * self._mass)
            moved = -inverse(self._force - o2 * self._inertia)
            found.append(complex(self._tip[self._free] @ moved / self._area))
        return found


def _equations(domain: Any, job: Job, unit: float) -> tuple[dict[str, Any], Any]:
    """Fields of displacement u and potential phi, and the equations of all matrices."""
    from sfepy.discrete import Equations, FieldVariable, Integral, Integrals, Materials, Variables
    from sfepy.discrete import Material as Constants
    from sfepy.discrete.fem import Field

    order = job["order"]
    moved = Field.from_args(
        "moved", np.float64, "vector", domain.regions["all"], approx_order=order
    )  # fmt: skip
    field = Field.from_args(
        "field", np.float64, "scalar", domain.regions["piezo"], approx_order=order
    )  # fmt: skip
    variables = Variables([
        FieldVariable("u", "unknown", moved),
        FieldVariable("v", "test", moved, primary_var_name="u"),
        FieldVariable("phi", "unknown", field),
        FieldVariable("psi", "test", field, primary_var_name="phi"),
    ])  # fmt: skip
    materials = [Constants("pull", x=[[1.0], [0.0], [0.0]])]
    texts = {"mass": _MASS, "tip": _TIP}
    for part in (0, 1) if job["frequencies"] else (0,):
        materials += [
            Constants(f"p{part}", **_tensors(job["ceramic"][part], unit)),
            Constants(f"s{part}", **_tensors(job["shim"][part], unit)),
        ]
        texts |= {f"{i} of {part}": text.format(part=part) for i, text in enumerate(_STIFFNESS)}
    integrals = Integrals([Integral("i", order=2 * order)])
    return {"u": moved, "phi": field}, Equations.from_conf(
        texts, variables, domain.regions, Materials(materials), integrals
    )


def _tensors(material: Material, unit: float) -> dict[str, Any]:
    """Constants by their names in the equations, in SfePy's order and the potential's unit."""
    c, e, eps = (np.array(material[n]) for n in ("stiffness", "coupling", "permittivity"))
    known = {"D": c[np.ix_(_ORDER, _ORDER)], "rho": material["density"]}
    return known | ({"e": unit * e[:, _ORDER], "eps": unit**2 * eps} if e.size else {})


def _faces(domain: Any, job: Job) -> dict[str, Any]:
    """Named faces as regions, and those of all cells, of the ceramic and of the shim."""
    domain.create_region("all", "all")
    domain.create_region("piezo", "cells of group 1 +c cells of group 2")
    domain.create_region("shim", "cells of group 3")
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
