"""The piezoelectric solid far beyond the device: right to its bar, or a clear refusal.

Held against exact answers (scaling laws, fields that the elements contain, beams so slender
that beam theory is exact), else against a much finer division.
"""

from __future__ import annotations

import time

from tactgen.validation.checks.stress import Asked, Families
from tactgen.validation.checks.stress.result import Stress
from tactgen.validation.checks.stress.solid_answers import (
    glue_row,
    resonance_row,
    short_electrode_row,
    thickness_row,
)
from tactgen.validation.checks.stress.solid_exact import (
    distorted_row,
    one_element_row,
    scaling_row,
    slender_row,
    uniform_section_row,
)

_FAMILIES: Families = {
    "scales": scaling_row,
    "thickness ratios, exact": uniform_section_row,
    "thickness ratios": thickness_row,
    "slender": slender_row,
    "one element per layer": one_element_row,
    "distorted meshes": distorted_row,
    "electrodes": short_electrode_row,
    "glue": glue_row,
    "resonance": resonance_row,
}
_STATEMENT = (
    "Each answer is within what was promised of it: its own error bar, held against a finer "
    "division, or, where the exact answer is known, the bound that follows from the method. "
    "A point counts as refused if the model says in one sentence why it has no answer."
)


def run(asked: Asked) -> Stress:
    """Run all families; half a minute if quick, else some minutes."""
    started = time.perf_counter()
    rows = asked.rows("solid", _FAMILIES)
    return Stress("solid", _STATEMENT, rows, (), (), time.perf_counter() - started)
