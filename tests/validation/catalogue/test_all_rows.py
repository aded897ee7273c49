"""The catalogue as it is read: every quantity, and what every model's stages read."""

from dataclasses import replace

import pytest
from approved import described

from tactgen.validation.catalogue import detection
from tactgen.validation.catalogue.bimorph import coupling_factor, coupling_rounding
from tactgen.validation.catalogue.models import MODELS, map_model, models_of, ranked
from tactgen.validation.catalogue.needs import NEEDS
from tactgen.validation.catalogue.quantities import QUANTITIES, measurable

#: What is said of a row beside its words.
ASKED = (
    "headline", "varied", "by_frequency", "static", "loaded", "held_by_support", "has_level",
    "is_transduced",
)  # fmt: skip


def test_quantities(approved):
    lines = [
        f"{row.name} ({row.unit}): {row.label}. {row.meaning}; {row.actuator}, "
        f"needs {', '.join(row.needs)}; {', '.join(a for a in ASKED if getattr(row, a))}"
        for row in QUANTITIES.values()
    ]
    lines += [f"{name}: {row.curve}" for name, row in measurable().items()]
    approved("\n".join([*lines, described({n: tuple(row) for n, row in NEEDS.items()})]))


def test_models(approved):
    lines = []
    for row in MODELS.values():
        rest = replace(row, stages={})
        lines.append(described(rest, row.name))
        lines += [f"  {stage}: {' '.join(sorted(reads))}" for stage, reads in row.stages.items()]
    lines.append(described([ranked(reversed(MODELS)), models_of("bimorph"), map_model(MODELS)]))
    approved("\n".join(lines))


def test_thresholds(approved):
    curve = detection.DISPLAY_THRESHOLD
    at = (9.0, 10.0, 50.0, 250.0, 600.0, 1000.0, 1001.0)
    approved(described([curve, detection.LITERATURE_BOUND, curve.at(at), curve.weights(50.0)]))


@pytest.mark.parametrize("ratio", [0.5, 0.95, 1.0 - 1e-9])
def test_rounding_of_frequencies_in_a_coupling_factor(ratio):
    """What both of them off by a part does at most; also where k is itself of rounding's size."""
    part = 1e-8
    value = coupling_factor(ratio, 1.0)
    apart = [abs(coupling_factor(ratio * (1.0 + s * part), 1.0) - value) for s in (-1.0, 1.0)]
    # second order in the part
    assert coupling_rounding(value, part) == pytest.approx(max(apart), rel=1e-5)
