# %% [markdown]
# # 6 The machine in motion
#
# Bimorph, rod, coil, spring and stops form one machine. Where is the rod in equilibrium, how does
# it respond to small voltages, to large voltages, and in time?

# %%
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np
from scipy import signal

import tactgen
from tactgen.tmm.generator.equilibrium import axial_forces, position_loop
from tactgen.tmm.generator.transient.waveform import Sine, Sources, Square
from tactgen.tmm.reluctance.map_range import network_map
from tactgen.validation.models.backbone import backbone, held_head
from tactgen.validation.models.transient import phases, run_scene
from tactgen.validation.show.export import export

scene, _ = tactgen.load_scene("generator", ["load.kind=none", "frequency=10:1000:150:log"])
device = scene.device

# %% [markdown]
# ## Position
#
# With rising current the rod stays up until the magnetic force exceeds the spring force, then snaps
# down. With falling current it stays down to a much lower current: between them there are two
# stable positions at one current.

# %%
currents = np.linspace(0.0, 0.14, 71)
loop = position_loop(axial_forces(device, network_map(device)), currents)
rising, falling = (np.array([p.lift for p in way]) for way in (loop.rising, loop.falling))
figure, axis = plt.subplots(figsize=(7.0, 3.2))
axis.plot(1e3 * currents, 1e6 * rising, label="current rising")
axis.plot(1e3 * currents, 1e6 * falling, "--", label="current falling")
axis.set(xlabel="coil current (mA)", ylabel="rod position (µm)")
_ = axis.legend()
at_50 = int(np.argmin(np.abs(currents - 0.05)))
assert rising[at_50] > -1e-6
assert falling[at_50] < -150e-6

# %% [markdown]
# ## Small motions
#
# The spring or the magnetic force presses the head on its stop and so sets the contact stiffness.
# Held down with 50 mA the contact force is three times as large, and the resonance rises.

# %%
asked = ["short_circuit_frequencies", "lateral_tip_per_voltage"]
up = tactgen.solve(scene, ["tmm"], asked)
held_scene, _ = tactgen.load_scene(
    "generator",
    ["load.kind=none", "frequency=10:1000:150:log", "coil.current=50mA", "coil.history=falling"],
)
down = tactgen.solve(held_scene, ["tmm"], asked)
figure, axis = plt.subplots(figsize=(7.0, 3.2))
for words, found in (("up, by the spring", up), ("down, by 50 mA", down)):
    curve = np.abs(found.get("lateral_tip_per_voltage", "tmm").value)
    axis.loglog(scene.frequency, 1e6 * curve, label=words)
axis.set(xlabel="frequency (Hz)", ylabel="lateral tip (µm/V)")
_ = axis.legend()
first = [float(f.get(asked[0], "tmm").value.flat[0]) for f in (up, down)]
print(f"f1 up {first[0]:.0f} Hz, held {first[1]:.0f} Hz")
assert first[1] > 1.2 * first[0]

# %% [markdown]
# The same for control engineers: `tactgen export generator --machine machine.npz` writes
# x' = a x + b u, y = c x + d u. An upright head keeps the axial motion to itself, so three of the
# states are a system of their own; in `scipy.signal` its poles are one line, and so is the Bode
# plot of what the coil's voltage does. With python-control the whole would read
#
#     saved = np.load("machine.npz")
#     control.bode_plot(control.ss(saved["a"], saved["b"], saved["c"], saved["d"]))

# %%
driven_scene, _ = tactgen.load_scene(
    "generator",
    [
        "load.kind=none", "frequency=10:20000:80:log", "coil.current=50mA", "coil.history=falling",
        "coil.supply=voltage",
    ],
)  # fmt: skip
with TemporaryDirectory() as folder:
    file = Path(folder) / "machine.npz"
    export(driven_scene, {"machine": file}, lambda _: None)
    with np.load(file) as opened:
        saved = dict(opened)
print(*saved["inputs"], "to", *saved["outputs"])

states = len(saved["a"])
axial = [2, (states - 1) // 2 + 2, states - 1]  # lift, its rate, flux linkage
a, b, c = saved["a"][np.ix_(axial, axial)], saved["b"][axial, 2:], saved["c"][1:2, axial]
plant = signal.StateSpace(a, b, c, [[0.0]])
# scipy warns of every system without feed-through
warnings.filterwarnings("ignore", category=signal.BadCoefficients)
frequencies = np.array(driven_scene.frequency)
_, decibels, degrees = plant.bode(2.0 * np.pi * frequencies)
figure, axes = plt.subplots(2, 1, figsize=(7.0, 4.2), sharex=True)
axes[0].semilogx(frequencies, decibels)
axes[0].set_ylabel("lift per coil voltage (dB, m/V)")
axes[1].semilogx(frequencies, degrees)
axes[1].set(ylabel="phase (°)", xlabel="frequency (Hz)")

known = tactgen.solve(driven_scene, ["tmm"], ["axial_poles", "axial_tip_per_coil_voltage"])
for pole in known.get("axial_poles", "tmm").value:
    assert np.abs(plant.poles - pole).min() < 1e-9 * abs(pole)
    assert np.abs(np.linalg.eigvals(saved["a"]) - pole).min() < 1e-9 * abs(pole)
# scipy draws by way of a transfer function, whose coefficients lose some digits
exact = np.abs(known.get("axial_tip_per_coil_voltage", "tmm").value)
assert np.allclose(10.0 ** (decibels / 20.0), exact, rtol=1e-6, atol=0.0)

# %% [markdown]
# ## Amplitude
#
# A head pressed with 110 mN tilts when the bimorph's moment grows. The peak then leans to lower
# frequencies, and one frequency has several amplitudes, as in the paper's Fig 14. No constant is
# fitted here.

# %%
(curve,) = backbone(held_head(scene), [1.0], (330.0, 500.0)).curves
small = np.abs(up.get("lateral_tip_per_voltage", "tmm").value)
figure, axis = plt.subplots(figsize=(7.0, 3.4))
for words, frequency, moved in (
    ("small motions", np.array(scene.frequency), small),
    ("1 V", curve.frequencies, np.abs(curve.displacement)),
):
    axis.plot(frequency, 1e3 * 2.0 * np.pi * frequency * moved, label=words)
axis.set(xlabel="frequency (Hz)", ylabel="tip velocity (mm/s per V)", xlim=(330.0, 500.0))
_ = axis.legend()
assert curve.peaks[0].frequency < 0.95 * first[0]
assert len(curve.folds) >= 2

# %% [markdown]
# ## Time
#
# The coil is on for 5 ms while the bimorph vibrates. The rod moves down, is held, and returns; the
# lateral motion of the tip depends on the contact meanwhile.

# %%
run = run_scene(
    scene, Sources(Sine(10.0, 200.0), Square(0.15, 100.0)), 8e-3, coil="current", accuracy=0.05
)
lift, tip = (run.answer.outputs[name] for name in ("rod_lift", "lateral_tip"))
time = 1e3 * run.answer.run.time
figure, axes = plt.subplots(2, 1, figsize=(7.0, 4.6), sharex=True)
axes[0].plot(time, 1e6 * lift)
axes[0].set_ylabel("rod (µm)")
axes[1].plot(time, 1e6 * tip)
axes[1].set(ylabel="tip, lateral (µm)", xlabel="time (ms)")
for phase in phases(run):
    print(f"{phase.name:8} from {1e3 * phase.start:5.2f} to {1e3 * phase.end:5.2f} ms")

# %%
# every step gives back what it was given, and the rod did go down and come up again
assert run.answer.run.worst_imbalance < 1e-10
assert lift.min() < -0.7 * run.stroke
assert lift[-1] > -0.3 * run.stroke
