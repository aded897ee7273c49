"""Two scenes that differ in one key: exactly the stages that read it run again, and what is taken
over is to the last bit what a cold run gives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tactgen.geometry.device.parameters import Parameters
from tactgen.validation.catalogue.models import MODELS, stage_reads
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.inputs import keys_read
from tactgen.validation.scene.load import load_scene

#: A change of one key by text, as a user writes it, for each model and quantity.
LATERAL = (
    "bimorph.length=19mm", "bimorph.width=2mm", "piezo.density=7800 kg/m^3", "piezo.d31=-380 pC/N",
    "shim.youngs_modulus=150GPa", "support.rotational_stiffness=0.2 N*m/rad",
    "support.rotational_damping=5e-6 N*m*s/rad", "load.kind=finger", "drive.voltage=3V", "modes=3",
    "frequency=200", "bimorph.wiring=series", "beam.shear_correction=0.8", "accuracy=1e-2",
    "coil.current=20mA", "spring.stiffness=90N/m", "glue.thickness=20um", "mesh.level=3",
)  # fmt: skip
MAGNETIC = (
    "coil.current=20mA", "coil.turns=700", "gap=0.15mm", "spring.stiffness=90N/m",
    "rod.youngs_modulus=190GPa", "sleeve.length=5mm", "bimorph.length=19mm", "accuracy=1e-2",
    "drive.voltage=3V", "steel.curve=linear",
)  # fmt: skip
CASES = (
    ("prototype", "beam", ("tip_displacement", "static_tip_displacement"), LATERAL),
    ("prototype", "tmm", ("short_circuit_frequencies", "admittance"), LATERAL),
    ("reluctance", "network", ("magnetic_force",), MAGNETIC),
)


def values_of(scene, path):
    value = scene
    for part in path.split("."):
        value = getattr(value, part)
    return value.model_dump() if isinstance(value, Parameters) else value


def numbers(solution):
    return [(q.name, q.value.tobytes(), q.error.tobytes()) for q in solution.quantities]


@pytest.mark.heavy
@settings(max_examples=40)
@given(data=st.data())
@pytest.mark.parametrize(("name", "model", "quantities", "changes"), CASES)
def test_exactly_what_reads_the_key_runs_again(
    name, model, quantities, changes, data, tmp_path_factory
):
    """Random pairs; the first is solved, then the second with what the first left in the store."""
    first, second = (data.draw(st.sampled_from(changes)) for _ in range(2))
    base = load_scene(name, ["frequency=100,500", first])[0]
    key = second.partition("=")[0]
    changed = load_scene(name, ["frequency=100,500", first, second])[0]
    differing = {
        stage
        for stage, entries in stage_reads().items()
        if key in keys_read(base, entries) | keys_read(changed, entries)
        and values_of(base, key) != values_of(changed, key)
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("warm")))
        solve(base, (model,), quantities)
        warm = solve(changed, (model,), quantities)
        patch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("cold")))
        cold = solve(changed, (model,), quantities)
    stored = {f"{model}.{stage}" for stage in MODELS[model].kept} & set(warm.plan.keys)
    assert warm.stages.computed & stored == differing & stored
    assert cold.stages.computed == set(cold.stages.seconds)
    assert numbers(warm) == numbers(cold)
    assert warm.warnings == cold.warnings
    assert np.isfinite(warm.quantities[0].error).all()
