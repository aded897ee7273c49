# %% [markdown]
# # 5 The reluctance actuator's map
#
# The coil pulls the rod down and a spring pushes it up. One co-energy map gives the magnetic
# force, the flux linkage and the currents at which the rod switches. Here the reluctance network
# computes the map in a moment; the field models give the same kind of map.

# %%
import matplotlib.pyplot as plt
import numpy as np

import tactgen
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import closed_loop_work
from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.tmm.reluctance.network import network_refinements, network_samples, thermal_statement
from tactgen.tmm.reluctance.switching import finger_force, switching

scene, _ = tactgen.load_scene("reluctance")
device = scene.device
pull = fit(network_samples(device, *map_grid(device)))

# %% [markdown]
# The magnetic force is the map's slope along the gap. Where the spring force is larger the rod
# moves up, where it is smaller down. At a current whose curve is tangent to the spring's line it
# snaps.

# %%
gaps = np.linspace(20e-6, device.gap, 200)
figure, axis = plt.subplots(figsize=(7.0, 3.8))
for current in (0.03, 0.05, 0.09, 0.13):
    force = np.array([float(pull.force(current, g)) for g in gaps])
    axis.semilogy(1e6 * gaps, 1e3 * force, label=f"{1e3 * current:.0f} mA")
spring = device.spring.preload + device.spring.stiffness * (device.gap - gaps)
axis.semilogy(1e6 * gaps, 1e3 * spring, "k--", label="spring")
axis.set(xlabel="gap (µm)", ylabel="force (mN)")
_ = axis.legend(fontsize=8)

# %% [markdown]
# Effect of each refinement of the textbook formula at the upper stop:

# %%
bridge = network_refinements(device, device.coil.current, device.gap)
for row in bridge:
    print(f"{row.step:35} {row.force * 1e3:6.1f} mN  {row.force_change:+.1%}")

# %%
currents = switching(device, pull)
print(f"pulls in at {currents.pull_in * 1e3:.0f} mA, holds down to {currents.holding * 1e3:.0f} mA")
print(f"finger force at rest: {float(finger_force(device, pull, 0.0, device.gap)) * 1e3:.0f} mN")
print(thermal_statement(device, device.coil.current))

# %% [markdown]
# ## The field behind it
#
# The revolved half section with a quarter removed: |B| in the parts, and flux lines. The shaft is
# the bottleneck; the leakage flux along the coil does not reach the gap.

# %%
tactgen.show(scene)

# %%
(field,) = tactgen.solve(scene, ["axisymmetric"], ["magnetic_force"]).quantities
network = float(pull.force(device.coil.current, device.gap))
print(f"pull by the network {1e3 * network:.1f} mN, by the field {1e3 * float(field.value):.1f} mN")
assert 0.7 < network / float(field.value) < 1.3

# %%
assert currents.holding < 0.5 * currents.pull_in
# around a closed loop of current and gap the map does no net work
net, side = closed_loop_work(pull.sampled, (0.02, 0.12), (30e-6, 180e-6))
assert abs(net) < 1e-6 * side
# the textbook formula comes out about right by accident: what it leaves out cancels in part
changes = {row.step: row.force_change for row in bridge}
assert changes["fringing beside the pole faces"] > 0.4
assert changes["saturation"] < -0.1
