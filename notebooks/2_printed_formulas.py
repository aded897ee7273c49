# %% [markdown]
# # 2 The paper's formulas audited
#
# The paper prints its model as 50 numbered formulas: springs below, finger above, the 25 entries
# of a transfer matrix A between them, and what these are made of. Which of them follow from the
# beam's equations? And how large is the error of the others for the 20 mm actuator under the
# finger?

# %%
import matplotlib.pyplot as plt
import numpy as np

from tactgen.tmm.beam.printed_formulas import MISPRINTS, from_dynamic_stiffness, matrix_a
from tactgen.tmm.beam.transfer_matrix import multiport, sections
from tactgen.validation.evidence.cases.audit import AT, audit
from tactgen.validation.scene.load import load_scene

scene, _ = load_scene("paper")
result = audit(scene)

# %% [markdown]
# ## Is each formula right?
#
# Each formula is evaluated as printed, with all others corrected, and compared with the 80-digit
# solution of the differential equations. A correct one differs by rounding only.

# %%
for row in result.rows:
    f = row.formula
    off = "" if row.deviation is None else f"{row.deviation:.0e}"
    verdict = f"SHOULD BE {f.correct}" if f.correct else "as printed"
    print(f"eq {f.equation:2}  {f.symbol:7} {f.printed:64} {off:>6}  {verdict}")

# %%
right = [r for r in result.rows if not r.formula.correct and r.deviation is not None]
wrong = [r for r in result.rows if r.formula.equation in MISPRINTS]
print(f"{len(right)} formulas are right to {max(r.deviation for r in right):.0e} or better")
print(f"{len(wrong)} are off by {min(r.deviation for r in wrong):.1e} or more")
# eight orders of magnitude lie between the worst of the right and the best of the wrong
assert max(r.deviation for r in right) < 1e-11
assert min(r.deviation for r in wrong) > 1e-4
# eq 9 names the current U and eq 12 equates what it means to multiply: both have no value
assert {r.formula.equation for r in result.rows if r.formula.correct} == {*MISPRINTS, 9, 12}

# %% [markdown]
# ## Does it matter?
#
# The change of tip velocity and current when only that formula is taken as printed.

# %%
print(f"{'':10} tip velocity at", *(f"{f:9.0f} Hz" for f in AT), "  current, at most")
for row in wrong:
    changes = " ".join(f"{100 * v:10.3g} %" for v in row.velocity)
    current = f"{100 * row.current.max():8.2g} %"
    print(f"eq {row.formula.equation:2} {row.formula.symbol:7}       {changes} {current}")
print("all together        ", " ".join(f"{100 * v:10.3g} %" for v in result.velocity))

# %%
figure, axis = plt.subplots(figsize=(7.0, 3.6))
for row in wrong:
    if row.velocity.min() > 0.0:
        axis.loglog(AT, 100.0 * row.velocity, "o-", label=f"eq {row.formula.equation}")
axis.axhline(10.0, color="grey", linewidth=0.8)
axis.set(xlabel="frequency (Hz)", ylabel="change of tip velocity (%)")
_ = axis.legend(fontsize=8)

# %%
effect = {row.formula.equation: row for row in wrong}
# eq 39 alone leaves nothing of the result, at any frequency
assert effect[39].velocity.min() > 0.99
# the sign in eq 36 is 0.1 % at 10 Hz, 11 % at 100 Hz and 54 times the velocity at 1 kHz
np.testing.assert_allclose(effect[36].velocity[[0, 1, 3]], [0.0011, 0.109, 53.8], rtol=0.03)
# the factor in eq 24 grows from 1.2 % to 345 %
assert 0.012 < effect[24].velocity[0] < 0.013
assert effect[24].velocity[-1] > 3.0
# eqs 41, 47 and 49 are easy to miss
assert max(effect[n].velocity.max() for n in (41, 49)) < 1e-3
assert effect[47].velocity.max() < 0.1
# eq 55 turns the capacitor into a source, and touches the current only
assert effect[55].velocity.max() < 1e-12
assert effect[55].current.max() > 0.05

# %% [markdown]
# ## With all corrected
#
# With the corrections the paper's chain of matrices is exact, and its matrix A is the five-port
# matrix of this project in other variables.

# %%
(section, length), *_ = sections(scene.device, scene.support, scene.beam, lossy=True)
port = multiport(scene.device, scene.support, scene.beam, AT)
difference = np.abs(matrix_a(section, length, AT) / from_dynamic_stiffness(port.stiffness, AT) - 1)
print(f"chain against the 80-digit solution: {result.residual:.1e}")
print(f"A against the five ports in other variables: {difference.max():.1e}")
assert result.residual < 1e-11
# the change of variables divides by Ω², which costs five digits at 10 Hz
assert difference.max() < 1e-10
