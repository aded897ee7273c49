# %% [markdown]
# # The printed formulas of Appendix A
#
# The paper prints the transfer matrix of a piezoelectric Timoshenko beam entry by entry. Held
# against the beam's own equations, some entries cannot be right. How much does each matter for
# the 20 mm actuator under the finger?

# %%
import numpy as np

from tmm.appendix_a import from_dynamic_stiffness, matrix_a
from tmm.transfer_matrix import multiport, sections
from validation.audit import AT, audit
from validation.scene import load_scene

scene, _ = load_scene("paper")

# %% [markdown]
# First the corrected matrix: it is the dynamic stiffness in other variables.

# %%
(section, length), *_ = sections(scene.device, scene.support, scene.beam, lossy=True)
closed_form = matrix_a(section, length, AT)
port = multiport(scene.device, scene.support, scene.beam, AT)
from_ports = from_dynamic_stiffness(port.stiffness, AT)
worst = np.max(np.abs(closed_form / from_ports - 1.0))
print(f"largest relative difference over 25 entries: {worst:.1e}")
# the closed form divides by jΩ and cancels below 100 Hz, where it keeps nine digits
assert worst < 1e-8

# %% [markdown]
# Then each printed entry alone.

# %%
rows = audit(scene)
for row in rows:
    change = ", ".join(f"{100 * v:.3g} %" for v in row["velocity"])
    print(f"eq {row['misprint'].equation:7} tip velocity at {AT.tolist()} Hz: {change}")

# %%
by_equation = {row["misprint"].equation: row for row in rows}
# eqs 24 and 36 spoil the loaded response by far more than any material uncertainty
assert by_equation["24"]["velocity"].max() > 1.0
assert by_equation["36"]["velocity"].max() > 1.0
# eq 47 is easy to miss, eq 55 touches the current only
assert by_equation["47"]["velocity"].max() < 0.1
assert by_equation["55"]["velocity"].max() < 1e-12
assert by_equation["55"]["current"].max() > 0.05
