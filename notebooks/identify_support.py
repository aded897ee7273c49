# %% [markdown]
# # What a velocity curve tells about the support
#
# The paper fitted its support springs by hand to the measured velocity of a 14 mm prototype
# (its Fig 8). Here the same fit is made on a curve that we make ourselves, with 2 % noise, so
# that the correct result is known; then we vary what the fit assumes.

# %%
import numpy as np

from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies.identify import identify
from tactgen.validation.studies.measured_data import MeasuredCurve

scene, _ = load_scene("prototype", ["frequency=10:2000:80:log"])
exact = np.abs(solve(scene, ["tmm"], ["tip_velocity"]).quantities[0].value)
rng = np.random.default_rng(1)
measured = MeasuredCurve(
    source="made up",
    kind="velocity",
    frequencies=np.array(scene.frequency),
    values=exact * (1.0 + 0.02 * rng.standard_normal(exact.size)),
    error=None,
    weight=np.ones(exact.size),
)

# %% [markdown]
# Start from a support twice as stiff, with a third of the damping.

# %%
start, origins = load_scene(
    "prototype",
    ["support.rotational_stiffness=0.48 N*m/rad", "support.rotational_damping=1.5e-6 N*m*s/rad"],
)
found = identify(start, measured, ("c_s", "d_s"), origins=origins)
for name in ("c_s", "d_s"):
    estimate = found.get(name)
    low, high = estimate.interval
    print(f"{name}: {estimate.value:.4g}, 95 % interval {low:.4g} to {high:.4g}")

# %% [markdown]
# The interval is narrow, but it assumes that the mass of the ceramic is known. The paper does not
# give the density: 1 % more would change c_s by 1 %.

# %%
density = next(a for a in found.assumptions if a.row.key == "piezo.density")
print(f"{density.row.key} = {density.row.text}: d ln c_s / d ln density = {density.slopes[0]:.2f}")

# %%
truth = scene.support
assert abs(found.get("c_s").value / truth.rotational_stiffness - 1.0) < 0.01
assert abs(found.get("d_s").value / truth.rotational_damping - 1.0) < 0.05
assert found.get("c_s").interval[0] < truth.rotational_stiffness < found.get("c_s").interval[1]
assert abs(density.slopes[0] - 1.0) < 0.05
