# %% [markdown]
# # The chain in the open: the reluctance actuator
#
# The half section of the actuator in the scene `reluctance`, from its rings to flux linkage and
# force, with nonlinear steel. Of this project only dimensions, steel, graded lines, Newton's method
# and ten lines of assembly take part (`fem/weak_forms.py`); the model `axisymmetric` then has to
# agree.

# %%
import time

import numpy as np
from skfem import Basis, ElementQuadP, LinearForm, MeshQuad

import tactgen
from tactgen.fem.magnetics.axisymmetric_space import (
    energy_density,
    field_from_flux,
    reluctivity_tensor,
)
from tactgen.fem.solvers.newton import Factors, minimise
from tactgen.fem.weak_forms import assemble, section_flux
from tactgen.geometry.reluctance.section_grid import actuator_regions, graded_grid

scene, _ = tactgen.load_scene("reluctance")
device = scene.device
current, gap = device.coil.current, device.gap

# %% [markdown]
# **Weak form.** With u = A_φ / r the flux density is B(u) = (−r ∂u/∂z, 2u + r ∂u/∂r), smooth at the
# axis. The field minimises
#
# Π(u) = ∫ w(|B(u)|) dV − i λ(u),  λ(u) = N/S ∫ r u dV over the winding,
#
# w = ∫ H dB of the steel's curve: ∫ B(v)·H(B(u)) dV = i λ(v) for all v, and in Newton's method
# ∫ B(v)·(dH/dB) B(δu) dV. At the minimum −Π is the co-energy.


# %%
class Section:
    """Π, its gradient and its Hessian over the free unknowns, at one gap (m) and current (A)."""

    def __init__(self, gap, current):
        grid = graded_grid(actuator_regions(device, gap))
        mesh = MeshQuad.init_tensor(grid.r, grid.z)
        self.basis = Basis(mesh, ElementQuadP(4), intorder=8)
        r, z = np.asarray(self.basis.global_coordinates())
        self.flux, self.volume = section_flux(r), 2.0 * np.pi * r
        column, row = (np.searchsorted(x, y.mean(axis=1)) for x, y in ((grid.r, r), (grid.z, z)))
        region = grid.labels[column - 1, row - 1]
        curves = [(i, part.curve) for i, part in enumerate(grid.regions) if part.curve]
        self.iron = [(np.flatnonzero(region == i), curve) for i, curve in curves]
        turns = sum((region == i) * p.turns / p.section for i, p in enumerate(grid.regions))
        turns = turns[:, None] * r * self.volume
        self.linkage = LinearForm(lambda v, _: turns * v).assemble(self.basis)
        wall = mesh.facets_satisfying(lambda x: x[0] > 1e-12, boundaries_only=True)
        self.free = self.basis.complement_dofs(self.basis.get_dofs(wall))
        self.current = current

    def field(self, x):
        """B (cells, points, 2) of the free unknowns."""
        u = self.basis.zeros()
        u[self.free] = x
        return np.moveaxis(self.flux(self.basis.interpolate(u)), 0, -1)

    def scale(self, x):
        energy = energy_density(self.iron, self.field(x))
        return float((energy * self.volume * self.basis.dx).sum())

    def value(self, x):
        return self.scale(x) - self.current * float(self.linkage[self.free] @ x)

    def gradient(self, x):
        h = np.moveaxis(field_from_flux(self.iron, self.field(x)), -1, 0) * self.volume
        force = LinearForm(lambda v, _: (self.flux(v) * h).sum(axis=0)).assemble(self.basis)
        return (force - self.current * self.linkage)[self.free]

    def hessian(self, x):
        tensor = np.moveaxis(reluctivity_tensor(self.iron, self.field(x)), (2, 3), (0, 1))
        matrix = assemble(self.basis, self.flux, tensor * self.volume)
        return matrix[self.free][:, self.free]


def solve(gap, current):
    """Flux linkage (Wb) and co-energy (J)."""
    section = Section(gap, current)
    x = minimise(section, np.zeros(section.free.size), Factors()).x
    return float(section.linkage[section.free] @ x), -section.value(x)


# %% [markdown]
# **Force** is the slope of the co-energy over the gap, here by a central difference of 1 µm.

# %%
began = time.perf_counter()
flux_linkage, coenergy = solve(gap, current)
step = 1e-6
force = (solve(gap - step, current)[1] - solve(gap + step, current)[1]) / (2.0 * step)
print(f"three fields in {time.perf_counter() - began:.1f} s")

# %% [markdown]
# **The product** has the same field from tables of the reference cell, its force from the field
# itself, and an error of each.

# %%
ours = {"flux_linkage": flux_linkage, "coenergy": coenergy, "magnetic_force": force}
began = time.perf_counter()
found = tactgen.solve(scene, ["axisymmetric"], list(ours)).quantities
print(f"with errors in {time.perf_counter() - began:.1f} s (or from the store)")
for quantity in found:
    ratio = ours[quantity.name] / float(quantity.value)
    error = float(quantity.error / abs(quantity.value))
    print(
        f"{quantity.name}: {100.0 * (ratio - 1.0):.4f} %, the product's error {100 * error:.4f} %"
    )
    assert abs(ratio - 1.0) < 2.0 * error + 1e-4
assert len(found) == len(ours)
