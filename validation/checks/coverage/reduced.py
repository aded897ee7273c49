"""Bars of the reduced basis: members of random families against bricks two levels finer."""

from __future__ import annotations

import numpy as np

from tactgen.validation.checks.coverage.result import Judged
from tactgen.validation.checks.coverage.scenes import between
from tactgen.validation.checks.coverage.solid import Case, reference
from tactgen.validation.models.bimorph.family.solid_family import solid_family
from tactgen.validation.models.bimorph.family.values import family_values
from tactgen.validation.scene.scene import load_scene

_NAMES = (
    "static_tip_displacement", "capacitance_free", "capacitance_blocked",
    "short_circuit_frequencies", "coupling_factor", "tip_displacement", "admittance",
)  # fmt: skip
#: Where the response is judged, per first resonance.
_AT = 0.9
#: Of which there is one, of whichever class of motion is the lowest.
_MODE = "short_circuit_frequencies"
#: How far a family's lengths reach to either side.
_REACH = 1.2


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one member of one family, drawn by `rng`."""
    layer = between(rng, 0.1, 0.4)
    length = between(rng, 15.0, 40.0) * 3.0 * layer
    drawn = (
        f"bimorph.width={layer * between(rng, 2.0, 10.0):.4g}mm",
        f"bimorph.piezo_thickness={layer:.4g}mm",
        f"bimorph.shim_thickness={layer * between(rng, 0.3, 2.0):.4g}mm",
        f"piezo.material={rng.choice(['M1876', 'PZT-5H', 'PZT-5A'])}",
        "support.kind=clamped", "accuracy=0.1", "modes=1",
    )  # fmt: skip
    ends = 1e-3 * length / _REACH, 1e-3 * length * _REACH
    member = between(rng, *ends)
    case = Case((*drawn, f"bimorph.length={1e3 * member:.12g}mm"), at=(_AT,))
    frequency = case.scene().frequency[0]
    scene, _ = load_scene("prototype", [*drawn, f"frequency={frequency:.12g} Hz"])
    basis = solid_family(scene, {"bimorph.length": ends}, _NAMES)
    found = family_values(scene, basis, {"bimorph.length": np.array([member])}, _NAMES)
    kinds = dict.fromkeys(_NAMES, "") | {_MODE: str(found[_MODE].classes[0, 0])}
    right, where = reference(case, kinds.values()), " ".join(case.overrides)
    judged = []
    for name, kind in kinds.items():
        known = right[name, kind][0]
        value, bar = (np.ravel(of)[0] for of in (found[name].value, found[name].error))
        judged.append(Judged(where, name, abs(value / known - 1.0), float(bar) / abs(known)))
    return judged
