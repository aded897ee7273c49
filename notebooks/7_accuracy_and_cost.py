# %% [markdown]
# # 7 How accurate is it, and what does accuracy cost?
#
# A number without an error bar is an opinion. Each model says how far its own arithmetic can be
# trusted; whether its assumptions hold is another question, answered by a better model.

# %%
from time import process_time

import tactgen
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.comparison import choose

# %% [markdown]
# ## The solid converges, and its bars know
#
# A clamped PZT-5H bimorph on which four public finite-element codes agree to 3e-5. Two levels of
# bricks: the error against the four codes, and the bar that each level states without knowing them.

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
# ## The beam is exact, and wrong by five percent
#
# The transfer-matrix model solves its equations to thirteen digits in milliseconds. What its
# equations leave out is a thousand million times larger than its bar. So ask for what you need:
# with `accuracy` and no model, the cheapest model whose *known* error meets it answers.

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
# What no model can give is refused, with what each would:

# %%
impossible, _ = tactgen.load_scene("paper", ["support.kind=clamped", "accuracy=1e-9"])
try:
    choose((impossible,), asked)
except InputError as refusal:
    print(refusal)
else:
    raise AssertionError("no mesh is that fine")

# %% [markdown]
# `tactgen bench` draws run time against error for every kind of mesh, beside public finite-element
# codes; `tactgen stress` drives the models to where their digits end; `tactgen coverage` counts, on
# random devices, how often the truth lies inside the bars.
