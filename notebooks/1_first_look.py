# %% [markdown]
# # 1 First look
#
# A bimorph of 20 mm on the support that the paper fitted, a finger on its tip, 50 V. How far does
# the tip move, at which frequency does it ring, and can these numbers be trusted?

# %%
import matplotlib.pyplot as plt
import numpy as np

import tactgen

scene, _ = tactgen.load_scene("paper", ["frequency=10:1000:200:log", "mesh.level=2"])
asked = ["static_tip_displacement", "short_circuit_frequencies", "tip_displacement"]
found = tactgen.solve(scene, ["lumped", "tmm", "beam", "solid"], asked)

# %% [markdown]
# ## Four models, one answer?
#
# Each number comes with its own numerical error bar. The bars are far smaller than what separates
# the differences between models: their assumptions differ, not their arithmetic.

# %%
models = ("lumped", "tmm", "beam", "solid")
print(f"{'model':8}{'static tip (µm)':>18}{'bar':>10}{'f1 (Hz)':>12}{'bar':>10}")
for model in models:
    tip, f1 = (found.get(name, model) for name in asked[:2])
    values = float(tip.value.flat[0]), float(f1.value.flat[0])
    bars = tuple(
        f"{float(np.ravel(q.error)[0]) / v:.0e}" if q.error is not None else "-"
        for q, v in zip((tip, f1), values, strict=True)
    )
    print(f"{model:8}{values[0] * 1e6:18.3f}{bars[0]:>10}{values[1]:12.2f}{bars[1]:>10}")

# %% [markdown]
# `lumped` is one spring and one mass. `tmm` and `beam` solve the same beam equations by two
# independent methods. `solid` includes the bending across the width and the non-uniform field
# across a bending layer; the report quantifies both effects. The beam deflects a few percent more
# than the solid. The first frequencies agree better, since the support is the softest part.

# %%
tips = {m: float(found.get("static_tip_displacement", m).value.flat[0]) for m in models}
assert abs(tips["tmm"] / tips["beam"] - 1.0) < 1e-8
assert 0.02 < tips["tmm"] / tips["solid"] - 1.0 < 0.09

# %% [markdown]
# ## Over frequency
#
# With the finger there is no peak at the first natural frequency, because the finger damps it.
# The tip displacement falls with frequency and has a minimum near 940 Hz.

# %%
figure, axis = plt.subplots(figsize=(7.0, 3.6))
for model, style in (("lumped", ":"), ("tmm", "-"), ("solid", "--")):
    curve = np.abs(found.get("tip_displacement", model).value)
    axis.loglog(scene.frequency, 1e6 * curve, style, label=model)
axis.set(xlabel="frequency (Hz)", ylabel="tip displacement (µm)")
_ = axis.legend()

# %% [markdown]
# ## See it
#
# Natural modes, the static state and driven states, enlarged; choose a state, colour it by
# potential or stress, clip it, point at it to read a value. `tactgen view paper` writes the same
# page.

# %%
tactgen.show(scene, ["solid"])
