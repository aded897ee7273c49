"""Golden values: what every built-in scene gave by every model, to full precision.

A change that is meant to keep the numbers keeps these.  ``python tests/test_golden_values.py``
writes them anew; the difference is reviewed like code.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

import tactgen

FILE = Path(__file__).parent / "data" / "golden_values.csv"
#: Each scene with the models that cost little and those that solve fields.
LATERAL = (("lumped", "tmm", "beam"), ("solid", "cad"))
NORMAL = (("network",), ("axisymmetric", "magnetic3d"))
MACHINE = (("tmm", "network"), ("beam", "solid", "network"))
SCENES = {
    "j1": LATERAL, "prototype": LATERAL, "paper": LATERAL,
    "bimorph_on_rod": (("lumped", "tmm", "beam"), ("cad",)),

    "reluctance": NORMAL, "generator": MACHINE, "display": MACHINE,
}  # fmt: skip
#: Below, at and above the first resonance of most scenes (Hz).
FREQUENCIES = "frequency=100,376,1000"
#: What rounding on another processor, and the tolerance of an eigenvalue solver, may change.
ROUNDING = 1e-9
#: What may change besides, as a share of the estimated error: fTetWild meshes a solid differently
#: from run to run; the error of the beam models is rounding, large where numbers cancel.
SHARE = dict.fromkeys(("cad", "lumped", "tmm", "beam"), 1.0)


def quantities_of(scene):
    """Return the scene's own quantities; of a single actuator all that need not be named."""
    from tactgen.validation.catalogue.quantities import QUANTITIES

    actuators = {QUANTITIES[name].actuator for name in scene.quantities}
    if not actuators <= {"bimorph", "reluctance"}:
        return scene.quantities
    able = (row for row in QUANTITIES.values() if row.actuator in actuators)
    return [row.name for row in able if not row.by_name]


def rows(name, models):
    """Yield scene, model, quantity, place, value (re, im) and error of each number."""
    scene, _ = tactgen.load_scene(name, [FREQUENCIES])
    for q in tactgen.solve(scene, models, quantities_of(scene)).quantities:
        errors = np.broadcast_to(q.error, np.shape(q.value))
        for place, value in np.ndenumerate(q.value):
            if q.name != "dynamic_stiffness" or place[1] == place[2]:
                at = ".".join(map(str, place))
                yield (name, q.model, q.name, at, value.real, value.imag, errors[place])


@pytest.fixture(scope="module")
def golden():
    with FILE.open(encoding="utf-8", newline="") as file:
        return {tuple(row[:4]): tuple(map(float, row[4:])) for row in csv.reader(file)}


def check(golden, name, models):
    """Compare every number with its golden value."""
    computed = {row[:4]: row[4:] for row in rows(name, models)}
    assert set(computed) == {key for key in golden if key[0] == name and key[1] in models}
    for key, (re, im, error) in computed.items():
        value, (re0, im0, error0) = complex(re, im), golden[key]
        reach = ROUNDING * abs(complex(re0, im0)) + SHARE.get(key[1], 0.0) * np.nan_to_num(error0)
        same = value == complex(re0, im0) or (np.isnan(re) and np.isnan(re0))
        assert same or abs(value - complex(re0, im0)) <= reach, key
        assert np.isnan(error) == np.isnan(error0), key


@pytest.mark.parametrize("name", SCENES)
def test_models_that_cost_little(name, golden):
    check(golden, name, SCENES[name][0])


@pytest.mark.heavy
@pytest.mark.parametrize("name", SCENES)
def test_field_models(name, golden):
    check(golden, name, SCENES[name][1])


if __name__ == "__main__":
    found = [r for n, both in SCENES.items() for group in both for r in rows(n, group)]
    with FILE.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(dict.fromkeys(found))
