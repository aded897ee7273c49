# %% [markdown]
# # My own device in ten minutes
#
# The device: an 18 mm bimorph of PZT-5H on a brass shim. Four conditions of the test belong to
# every scene of your own: the support (here clamped), the load (free tip), the wiring (parallel)
# and the drive voltage (40 V). What the scene does not state is taken from the paper's device, or,
# with `start_from = "neutral"`, from neutral conditions. `tactgen init mine.toml` writes a scene
# with every key.

# %%
import tempfile
from pathlib import Path

import numpy as np

import tactgen

SCENE = """
description = "data sheet: 18 x 3 mm, PZT-5H 2 x 0.2 mm on 0.1 mm brass"
start_from = "neutral"
[bimorph]
wiring = "parallel"
length = "18 mm"
width = "3 mm"
piezo_thickness = "0.2 mm"
shim_thickness = "0.1 mm"
[piezo]
material = "PZT-5H"
[shim]
youngs_modulus = "105 GPa"
shear_modulus = "39 GPa"
poisson_ratio = "0.34"
density = "8500 kg/m^3"
[support]
kind = "clamped"
[load]
kind = "none"
[drive]
voltage = "40 V"
"""
folder = tempfile.TemporaryDirectory()
file = Path(folder.name) / "mine.toml"
file.write_text(SCENE, encoding="utf-8")
scene, _ = tactgen.load_scene(str(file), ["mesh.level=2"])

# %% [markdown]
# **Two models.** The transfer matrix answers in milliseconds, the solid in a second. The first
# states its modelling error: what the solid is expected to give, and how far that may be off.

# %%
asked = ["static_tip_displacement", "short_circuit_frequencies", "capacitance_free"]
found = tactgen.solve(scene, ["tmm", "solid"], asked)
for name in asked:
    beam, solid = (found.get(name, model) for model in ("tmm", "solid"))
    of_solid, error = (
        float(np.ravel(v)[0]) for v in (beam.modelling.expected, beam.modelling.error)
    )
    a, b = float(beam.value.flat[0]), float(solid.value.flat[0])
    print(f"{name:28s} tmm {a:.4g}, solid {of_solid:.4g} +/- {error:.2g} expected, {b:.4g} found")
    assert abs(of_solid - b) <= error + float(np.ravel(solid.error)[0])

# %% [markdown]
# **What if** it were 22 mm long? The deflection of a clamped slender bimorph is proportional to the
# square of its length. `tactgen report mine.toml` writes the full report.

# %%
longer, _ = tactgen.load_scene(str(file), ["bimorph.length=22mm"])
moved = [tactgen.solve(s, ["tmm"], asked[:1]).quantities[0].value for s in (scene, longer)]
print(f"18 mm: {1e6 * moved[0]:.1f} µm, 22 mm: {1e6 * moved[1]:.1f} µm")
assert abs(moved[1] / moved[0] / (22 / 18) ** 2 - 1.0) < 1e-6
folder.cleanup()
