# %% [markdown]
# # 7 How accurate is it, and what does accuracy cost?
#
# Each model states the numerical error of its own solution. Whether its assumptions hold is another
# question: the modelling error, found by comparison with a more detailed model.

# %%
from time import process_time

import tactgen
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.comparison import choose

# %% [markdown]
# ## The solid converges, and its error bars cover the error
#
# A clamped PZT-5H bimorph on which four public finite-element codes agree to 3e-5. Two levels of
# bricks: the error against the four codes, and the error bar that each level states by itself.

# %%
FOUR_CODES = {"static_tip_displacement": 6.7582e-7, "short_circuit_frequencies": 1065.96}
THEIR_BAR = 3e-5
print("level  quantity                       error    its bar   processor time")
errors, bars = {}, {}
for level in (2, 3):
    scene, _ = tactgen.load_scene("j1", [f"mesh.level={level}", "modes=1", "drive.voltage=1V"])
    start = process_time()
    solved = tactgen.solve(scene, ["solid"], list(FOUR_CODES))
    spent = process_time() - start
    for name, reference in FOUR_CODES.items():
        found = solved.get(name, "solid")
        errors[name, level] = abs(abs(float(found.value.flat[0])) / reference - 1.0)
        bars[name, level] = abs(float(found.error.flat[0] / found.value.flat[0]))
        row = f"{level:5d}  {name:26} {errors[name, level]:9.1e} {bars[name, level]:10.1e}"
        print(f"{row} {spent:10.1f} s")

# %%
for key, error in errors.items():
    assert error <= bars[key] + THEIR_BAR
for name in FOUR_CODES:
    assert bars[name, 3] < 0.5 * bars[name, 2]

# %% [markdown]
# ## The beam: a small numerical error and a modelling error of five percent
#
# The transfer-matrix model solves its equations to thirteen digits in milliseconds. What its
# equations neglect is a thousand million times larger. With `accuracy` and no model named, the
# cheapest model whose total error meets the accuracy is used.

# %%
asked = ["static_tip_displacement", "short_circuit_frequencies"]
chosen = {}
for accuracy in ("10 %", "5 %", "0.1 %"):
    free = ["support.kind=clamped", "load.kind=none", f"accuracy={accuracy}"]
    scene, _ = tactgen.load_scene("paper", free)
    chosen[accuracy] = choose((scene,), asked)
    print(f"{accuracy:>6}: {', '.join(chosen[accuracy].models)}")
for rung in chosen["5 %"].ladders[0]:
    print(" ", rung.sentence)

# %%
assert chosen["0.1 %"].models == ("solid",)
assert chosen["10 %"].models != ("solid",)
costs = {rung.model: rung for rung in chosen["5 %"].ladders[0]}
assert costs["tmm"].numerical < 1e-9 < costs["tmm"].form

# %% [markdown]
# An accuracy that no model reaches is refused, with the errors of each model:

# %%
impossible, _ = tactgen.load_scene("paper", ["support.kind=clamped", "accuracy=1e-9"])
try:
    choose((impossible,), asked)
except InputError as refusal:
    print(refusal)
else:
    raise AssertionError("no mesh is that fine")

# %% [markdown]
# `tactgen bench` draws run time against error for every kind of mesh, beside public
# finite-element codes; `tactgen stress` finds the numerical limits of each model; `tactgen
# coverage` counts, on random devices, how often the exact value lies within the error bars.
