# %% [markdown]
# # The chain in the open: cadquery, pytetwild, scikit-fem
#
# The bimorph of the scene `j1` from its three boxes to its deflection, capacitance and modes. Of
# this project only the material's tensors, the sparse solver and ten lines of assembly take part
# (`fem/weak_forms.py`); the models `cad` and `solid` then have to agree.

# %%
import time

import cadquery as cq
import numpy as np
from pytetwild.pytetwild import tetrahedralize
from scipy.sparse.linalg import LinearOperator, eigsh
from skfem import Basis, ElementTetP2, ElementVector, FacetBasis, LinearForm, MeshTet

import tactgen
from tactgen.fem.piezo.system import materials
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.fem.weak_forms import GIGAVOLT, assemble, piezo_strain, piezo_tensor

scene, _ = tactgen.load_scene("j1")
b = scene.device.bimorph
core, outer = b.shim_thickness / 2, b.thickness / 2
layers = {"piezo_bottom": (-outer, -core), "shim": (-core, core), "piezo_top": (core, outer)}

# %% [markdown]
# **Shape.** Three boxes in millimetres, triangulated. The mesher sees the beam three times as thick
# and a third as long, so that its cells come out slender. Its filter would drop layers that share
# faces, so the cells outside are dropped here, and vertices go back onto the faces.

# %%
low = np.array([-outer, -b.width / 2, 0.0]) * 1e3
high = np.array([outer, b.width / 2, b.length]) * 1e3
stretch, envelope, vertices, triangles = np.array([3.0, 1.0, 1.0 / 3.0]), 5e-3, [], []
for left, right in layers.values():
    box = cq.Workplane().box((right - left) * 1e3, high[1] - low[1], high[2], centered=False)
    corners, faces = box.translate((left * 1e3, low[1], 0.0)).val().tessellate(1e-3)
    triangles += (np.array(faces) + len(vertices)).tolist()
    vertices += [corner.toTuple() for corner in corners]
vertices = np.array(vertices) * stretch
points, cells = tetrahedralize(
    vertices, np.array(triangles, dtype=np.int32), edge_length_abs=0.4, num_threads=1,
    epsilon=envelope / np.linalg.norm(np.ptp(vertices, axis=0)), disable_filtering=True,
    vtk_ordering=True,
)  # fmt: skip
points /= stretch
planes = np.array([-outer, -core, core, outer]) * 1e3, [low[1], high[1]], [low[2], high[2]]
for axis, places in enumerate(planes):
    for place in places:
        near = np.abs(points[:, axis] - place) * stretch[axis] < 4 * envelope
        points[near, axis] = place
middle = points[cells].mean(axis=1)
cells = cells[((middle > low) & (middle < high)).all(axis=1)]
used, cells = np.unique(cells, return_inverse=True)
p, t = 1e-3 * points[used].T, cells.reshape(-1, 4).T
mesh = MeshTet(np.ascontiguousarray(p), np.ascontiguousarray(t))
for reach in (2.0, 1.0):  # stress and field are singular at the clamp
    mesh = mesh.refined(np.flatnonzero(mesh.p[2, mesh.t].mean(axis=0) < reach * b.thickness))
x = mesh.p[0, mesh.t].mean(axis=0)
regions = {name: np.flatnonzero((x > a) & (x < c)) for name, (a, c) in layers.items()}
volume = sum(Basis(mesh, ElementTetP2(), elements=r).dx.sum() for r in regions.values())
assert abs(volume / (b.thickness * b.width * b.length) - 1.0) < 1e-12

# %% [markdown]
# **Weak form.** For all (v, ψ), with S the symmetric gradient and the potential φ in gigavolts so
# that all entries are of like size:
#
# ∫ (S(v), grad ψ) · C (S(u), grad φ) dV = Ω² ∫ ρ v·u dV,  C = [[c, eᵀ], [e, −ε]]

# %%
known = materials(scene.device, tuple(layers), scene.device.piezo.ceramic(), lossy=False)
element = ElementVector(ElementTetP2()) * ElementTetP2()
basis = Basis(mesh, element, intorder=2)  # exact for gradients of quadratics
began = time.perf_counter()
stiffness = mass = 0.0
for name, cells in regions.items():
    material, finer = known[name], Basis(mesh, element, intorder=4, elements=cells)
    stiffness += assemble(basis.with_elements(cells), piezo_strain, piezo_tensor(material))
    mass += assemble(finer, lambda u, phi: np.asarray(u), material.density * np.eye(3))
assembly = time.perf_counter() - began

# %% [markdown]
# **Conditions.** The clamp holds u, the shim is grounded, both outer faces are at 1 V. Poled alike,
# the ceramics bend the tip towards −x.

# %%
displacements, voltage = ["u^1^1", "u^2^1", "u^3^1"], 1.0
clamped = basis.get_dofs(lambda p: p[2] < 1e-9).all(displacements)
ground = basis.get_dofs(elements=regions["shim"]).all("u^2")
electrodes = basis.get_dofs(lambda p: np.abs(p[0]) > (1.0 - 1e-9) * outer).all("u^2")
state = np.zeros(basis.N)
state[electrodes] = voltage / GIGAVOLT
free = np.setdiff1d(np.arange(basis.N), np.concatenate([clamped, ground, electrodes]))
began = time.perf_counter()
factor = factorise(stiffness[free][:, free])
state[free] = factor.solve(-(stiffness @ state)[free])
solution = time.perf_counter() - began
capacitance = -(stiffness @ state)[electrodes].sum() / GIGAVOLT / voltage
top = mesh.facets_satisfying(lambda p: p[2] > (1.0 - 1e-9) * b.length)
tip = FacetBasis(mesh, element, facets=top)
mean = LinearForm(lambda v, psi, w: v[0] / (b.thickness * b.width)).assemble(tip)
deflection = mean @ state

# %% [markdown]
# **Modes** with short-circuited electrodes: the same factor, as the shift is zero.

# %%
began = time.perf_counter()
inverse = LinearOperator((free.size, free.size), factor.solve, dtype=float)
held = stiffness[free][:, free], mass[free][:, free]
squares = eigsh(held[0], 3, held[1], sigma=0.0, OPinv=inverse, return_eigenvectors=False)
modes = np.sqrt(np.sort(squares)) / (2 * np.pi)
vibration = time.perf_counter() - began
print(f"{free.size} unknowns; seconds: {assembly:.2f} to assemble, {solution:.2f} to solve,")
print(f"{vibration:.2f} for three modes")
print(f"{1e9 * deflection:.2f} nm, {1e9 * capacitance:.4f} nF, {modes.round(1)} Hz")

# %% [markdown]
# **The product** on bricks (`solid`) and on tetrahedra that it refines itself (`cad`), with errors.
# This mesh is coarser than theirs: it is stiffer by some tenths of a percent.

# %%
ours = {
    "static_tip_displacement": (deflection, 4e-3),
    "capacitance_free": (capacitance, 4e-3),
    "short_circuit_frequencies": (modes[:2], 1.2e-2),
}
for quantity in tactgen.solve(scene, ["solid", "cad"], list(ours)).quantities:
    value, tolerance = ours[quantity.name]
    off = value / np.ravel(quantity.value)[: np.size(value)] - 1.0
    print(f"{quantity.name}, {quantity.model}: {100.0 * off} %")
    assert np.all(np.abs(off) < tolerance)

# %% [markdown]
# **The product's assembly** of the same mesh: on straight cells all 40 × 40 entries follow from one
# matrix of the reference element, since a gradient there is the cell's inverse times a fixed one.
# Equal to rounding, node by node over (u, φ), and faster by what is printed.

# %%
from tactgen.fem.piezo.tetrahedra import SkfemBody
from tactgen.geometry.meshing.mesh import Mesh

region_of_cell = np.zeros(mesh.nelements, dtype=int)
for number, cells in enumerate(regions.values()):
    region_of_cell[cells] = number
same = Mesh(mesh.p.T, mesh.t.T, "tetra", region_of_cell, tuple(regions), {})
body = SkfemBody(same, known, GIGAVOLT)
began = time.perf_counter()
own_stiffness, own_mass = body.matrices
own = time.perf_counter() - began
order = np.concatenate([basis.nodal_dofs.T.ravel(), basis.edge_dofs.T.ravel()])
print(f"{assembly:.2f} s in the open, {own:.2f} s by the product: {assembly / own:.1f} times")
for open_form, own_form in ((stiffness, own_stiffness), (mass, own_mass)):
    assert abs(open_form[order][:, order] - own_form).max() < 1e-13 * abs(own_form).max()
