# %% [markdown]
# # 4 What the rod does to the bimorph
#
# A real support is not a rigid clamp. In the generator the bimorph's shim tab is glued into the
# slot of a rod, and the rod stands on a contact that the spring preloads. Each of these adds
# compliance. How much does each lower the first natural frequency?

# %%
import matplotlib.pyplot as plt
import numpy as np

import tactgen

FREE = ["load.kind=none", "modes=1"]


def first(name, *more):
    """Return the first natural frequency (Hz) by beam elements."""
    scene, _ = tactgen.load_scene(name, [*FREE, *more])
    (found,) = tactgen.solve(scene, ["beam"], ["short_circuit_frequencies"]).quantities
    return float(found.value.flat[0])


steps = {
    "all layers clamped": first("paper", "support.kind=clamped"),
    "on a free tab of 1.6 mm": first("paper", "support.kind=clamped", "bimorph.tab_length=1.6mm"),
    "tab glued into the rod": first("bimorph_on_rod"),
    "on the paper's springs": first("paper"),
    "on the contact's spring": first("generator"),
}
for words, frequency in steps.items():
    print(f"{words:26} {frequency:7.1f} Hz")

# %% [markdown]
# Tab and glue together are about as compliant as the springs that the paper fitted to its
# prototype, so one fitted curve cannot separate them. The contact has one calibrated constant and
# gives the same springs at the rated preload; in addition the rod and the coil move.

# %%
names = list(steps)
assert steps[names[0]] > steps[names[1]] > steps[names[2]]
assert abs(steps[names[4]] / steps[names[3]] - 1.0) < 0.05

# %% [markdown]
# ## The preload separates them
#
# The stiffness of a contact of rough surfaces is proportional to its load; that of glue is
# constant. The paper tunes its generators over about 300 Hz with the screw behind the spring.

# %%
preloads = np.array([40.0, 75.0, 110.0, 180.0, 330.0])
tuned = np.array([first("generator", f"spring.preload={p:g}mN") for p in preloads])
glued = np.array([first("bimorph_on_rod", f"spring.preload={p:g}mN") for p in preloads])

figure, axis = plt.subplots(figsize=(7.0, 3.4))
axis.plot(preloads, tuned, "o-", label="held by its contact")
axis.plot(preloads, glued, "s--", label="glued into a fixed rod")
axis.set(xlabel="preload (mN)", ylabel="first natural frequency (Hz)")
_ = axis.legend()

# %%
assert np.all(np.diff(tuned) > 0.0)
assert np.ptp(glued) < 1e-9 * glued[0]
assert 200.0 < np.ptp(tuned) < 400.0

# %% [markdown]
# ## Which tab has the stiffness that the paper fitted?
#
# A beam on a bare tab rotates by the tab's length over its bending stiffness. In the solid the
# lower end of the ceramic clamps the tab less, and glue and rod add compliance.

# %%
from tactgen.validation.models.bimorph import rod_joint

scene, _ = tactgen.load_scene("paper")
target = scene.support.rotational_stiffness
tabs = rod_joint.tab_by_bricks(scene, rod_joint.TAB_LENGTHS, lambda _: None, level=0)
joint = rod_joint.joint_by_beam(scene, scene.glue.youngs_modulus).matrix[1, 1]
lengths = {
    "beam, tab alone": rod_joint.tab_by_beam(scene, 1.0).rotational_stiffness / target,
    "solid, tab alone": rod_joint.tab_for(tabs, target),
    "solid, tab in glue and rod": rod_joint.tab_for(tabs, target, joint),
}
for words, length in lengths.items():
    print(f"{words:28} {1e3 * length:.2f} mm")

# %%
beam_alone, alone, in_rod = lengths.values()
assert in_rod < alone < beam_alone
