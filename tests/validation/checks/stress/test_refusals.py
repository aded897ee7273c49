"""What a row of the stress run makes of a model that says why it has no answer."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.checks.stress import (
    beam_modes,
    magnetics_circuit,
    magnetics_device,
    magnetics_solid,
    solid_answers,
    solid_exact,
)
from tactgen.validation.checks.stress.driven import lateral, sweep


def refuse(*_, **__):
    raise InputError("come nearer")


#: By family, what it takes for its answers, and what stands in the place of that.
REFUSED = {
    "scales": (solid_exact.scaling_row, {"_three": [(1.0, 1.0, 1.0)]}),
    "layers": (solid_exact.uniform_section_row, {"assemble": []}),
    "slender": (solid_exact.slender_row, {"assemble": []}),
    "slivers": (solid_exact.distorted_row, {"assemble": []}),
    "thickness": (solid_answers.thickness_row, {"_answers": []}),
    "glue": (solid_answers.glue_row, {"_answers": 2 * [np.ones(4)]}),
    "fields": (magnetics_device.device_rows, {"solve_map": []}),
    "coarse fields": (
        magnetics_device.device_rows,
        {"solve_map": 9 * [3 * [[None] * 3]], "solve_point": []},
    ),
    "built": (magnetics_device.as_built_row, {"solve_point": []}),
    "built coarse": (magnetics_device.as_built_row, {"solve_point": ["the finer one"]}),
    "boxes": (magnetics_solid.sliver_row, {"VectorPotential": []}),
    "potentials": (
        magnetics_solid.team20_rows,
        {"_solvers": 4 * [2 * [SimpleNamespace(solve=refuse)]]},
    ),
    "network": (magnetics_circuit.network_rows, {"network_samples": []}),
    "modes": (beam_modes.row, {"natural_frequencies": []}),
    "driven": (lambda quick: lateral._BEAM.row(lateral._SHIM, quick), {"solve": []}),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused_is_quoted(monkeypatch, case, approved_line):
    """Each refusal counts, wherever it is met, and the points beside it go on."""
    row, taken = REFUSED[case]
    module = sweep if case == "driven" else importlib.import_module(row.__module__)
    for name, answers in taken.items():
        left = iter(answers)

        def stand_in(*_, left=left, **__):
            for answer in left:
                return answer
            return refuse()

        monkeypatch.setattr(module, name, stand_in)
    found = row(True)
    rows = found if isinstance(found, list) else [found]
    assert "come nearer" in {words for row in rows for words in row.refusals}
    approved_line("; ".join(f"{r.family} {r.points} {len(r.refusals)} {r.verdict}" for r in rows))
