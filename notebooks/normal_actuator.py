# %% [markdown]
# # How the normal actuator switches
#
# The rod is drawn down by the coil and pushed up by a spring. From one co-energy map follow
# the pull, the flux linkage and the currents at which the rod moves. Here the map comes from
# the reluctance network, which takes a moment; the field gives the same kind of map.

# %%
from tactgen.tmm.reluctance.coenergy.fit import fit
from tactgen.tmm.reluctance.coenergy.map import closed_loop_work
from tactgen.tmm.reluctance.coil_heat import thermal_statement
from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.tmm.reluctance.network import network_bridge, network_samples
from tactgen.tmm.reluctance.switching import finger_force, switching
from tactgen.validation.scene.scene import load_scene

device = load_scene("reluctance")[0].device
pull = fit(network_samples(device, *map_grid(device)))

# %% [markdown]
# What each refinement of the textbook formula is worth at the upper stop:

# %%
bridge = network_bridge(device, device.coil.current, device.gap)
for row in bridge:
    print(f"{row.step:35} {row.force * 1e3:6.1f} mN  {row.force_change:+.1%}")

# %%
currents = switching(device, pull)
print(f"pulls in at {currents.pull_in * 1e3:.0f} mA, holds down to {currents.holding * 1e3:.0f} mA")
print(f"finger force at rest: {float(finger_force(device, pull, 0.0, device.gap)) * 1e3:.0f} mN")
print(thermal_statement(device, device.coil.current))

# %%
assert currents.holding < 0.5 * currents.pull_in
# around a closed loop of current and gap the map does no net work
net, side = closed_loop_work(pull.sampled, (0.02, 0.12), (30e-6, 180e-6))
assert abs(net) < 1e-6 * side
# the textbook formula comes out about right by accident: what it leaves out cancels in part
changes = {row.step: row.force_change for row in bridge}
assert changes["fringing beside the pole faces"] > 0.4
assert changes["saturation"] < -0.1
