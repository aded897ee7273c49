# %% [markdown]
# # What if the bimorph were longer?
#
# The paper chose 20 mm: long enough to move the finger, short enough to keep the minimum of
# the response out of the range that the finger feels. The transfer-matrix model answers in
# milliseconds, so we can simply ask for every length.

# %%
import numpy as np

from validation.scene import load_scene
from validation.solve import solve

lengths = np.arange(16, 42, 2)
frequencies = np.geomspace(10.0, 1000.0, 600)
sweep = "10:1000:600:log"

# %%
deflection = np.array(
    [
        np.abs(
            solve(
                load_scene("paper", [f"bimorph.length={mm}mm", f"frequency={sweep}"])[0],
                ["tmm"],
                ["tip_displacement"],
            )
            .quantities[0]
            .value
        )
        for mm in lengths
    ]
)

# %% [markdown]
# Deflection at 10 Hz grows with length; the minimum moves down.

# %%
at_start = deflection[:, 0]
minimum_at = frequencies[np.argmin(deflection, axis=1)]
for mm, start, minimum in zip(lengths, at_start, minimum_at, strict=True):
    print(f"{mm:3d} mm: {start * 1e6:6.1f} µm at 10 Hz, minimum at {minimum:5.0f} Hz")

# %%
assert np.all(np.diff(at_start) > 0.0)
inside = minimum_at < 0.99 * frequencies[-1]
assert np.all(np.diff(minimum_at[inside]) < 0.0)
# 20 mm is the longest of these whose minimum stays above 900 Hz
assert lengths[minimum_at > 900.0].max() == 20
