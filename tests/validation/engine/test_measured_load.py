"""A measured load in a scene: every model takes it, the bar has it, its key is its content."""

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.inputs import values_read
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.warnings import scene_warnings

SPRING = ("load.kind=spring_damper", "load.stiffness=300N/m", "load.damping=0.5N*s/m")


def write(path, impedance, frequencies):
    points = zip(frequencies, impedance(frequencies), strict=True)
    rows = [f"{f:.17g}, {z.real:.17g}, {z.imag:.17g}" for f, z in points]
    head = "frequency (Hz), impedance_re (N s/m), impedance_im (N s/m)"
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def spring_damper(f):
    return 0.5 + 300.0 / (2j * np.pi * f)


@pytest.fixture
def measured(tmp_path):
    """A table of a spring with a damper, and what a scene says to be loaded by it."""
    path = write(tmp_path / "load.csv", spring_damper, np.geomspace(10.0, 1000.0, 50))
    return ("load.kind=table", f"load.file={path}")


def solved(scene, models, quantity, *overrides):
    return solve(load_scene(scene, overrides)[0], models, (quantity,))


@pytest.mark.usefixtures("coarse_bricks", "own_store")
@pytest.mark.parametrize(
    ("scene", "models", "quantities"),
    [
        ("paper", ("lumped", "tmm", "beam"), ("tip_velocity", "ceramic_stress")),
        ("j1", ("solid",), ("tip_displacement",)),
    ],
)
def test_every_model_takes_it(measured, scene, models, quantities):
    """As the same spring and damper by constants, within bars that say what the table lacks."""
    common = ("frequency=20,130,900", "mesh.level=2")
    by_table, by_constants = (
        solve(load_scene(scene, (*common, *load))[0], models, quantities)
        for load in (measured, SPRING)
    )
    for found, exact in zip(by_table.quantities, by_constants.quantities, strict=True):
        assert (np.abs(found.value - exact.value) <= found.error).all()
        assert (found.error >= exact.error).all()
        assert (found.error <= 0.02 * np.abs(found.value) + exact.error).all()
        assert "load's table" in found.method


def test_the_machine_takes_it(measured):
    common = ("support.kind=contact", "frequency=20,130", "models=tmm")
    name = "lateral_tip_per_voltage"
    found = solved("paper", ("tmm",), name, *common, *measured).get(name, "tmm")
    exact = solved("paper", ("tmm",), name, *common, *SPRING).get(name, "tmm")
    assert (np.abs(found.value - exact.value) <= found.error).all()
    assert (found.error > exact.error).all()


def test_beyond_the_table_only_its_fit_answers_and_says_so(measured):
    common = ("frequency=20,2000", "models=tmm", *measured)
    with pytest.raises(InputError, match=r"2000 Hz is outside .*passive_fit"):
        solved("paper", None, "tip_displacement", *common)
    fitted = (*common, "load.extrapolation=passive_fit")
    found = solved("paper", None, "tip_displacement", *fitted)
    (said,) = (text for text in found.warnings if "is replaced by" in text)
    assert "1 of 2 frequencies are outside the table" in said
    assert "misfit of at most" in said
    q = found.get("tip_displacement", "tmm")
    exact = solved("paper", ("tmm",), "tip_displacement", "frequency=20,2000", *SPRING)
    apart = np.abs(q.value - exact.get("tip_displacement", "tmm").value)
    assert (apart <= q.error).all()


#: Columns of the tables that a scene may name, each constant over the frequency.
TABLES = {
    "load": "impedance_re (N s/m),impedance_im (N s/m)",
    "support": "rotational_stiffness_re (N m/rad),rotational_stiffness_im (N m/rad)",
    "threshold": "threshold (um)",
}


@pytest.mark.parametrize("group", TABLES)
def test_a_tables_key_is_what_is_in_the_file(tmp_path, group):
    """Another name for the same numbers is the same; other numbers under that name are not."""

    def scene(name, value):
        cells = ",".join([value] * (1 + TABLES[group].count(",")))
        rows = (f"{f},{cells}" for f in (1, 2, 5, 20, 100, 1000))
        (tmp_path / name).write_text("\n".join([f"frequency (Hz),{TABLES[group]}", *rows]))
        return load_scene("paper", (f"{group}.kind=table", f"{group}.file={tmp_path / name}"))[0]

    one, other = (values_read(scene(name, "1"), (group,)) for name in ("one.csv", "other.csv"))
    assert other == one
    assert values_read(scene("other.csv", "2"), (group,)) != one


@pytest.mark.parametrize("group", TABLES)
def test_a_table_that_is_missing_or_idle_is_said(group):
    with pytest.raises(InputError, match=f"needs {group}.file"):
        solved("paper", ("tmm",), "threshold_voltage", f"{group}.kind=table")
    scene, origins = load_scene("paper", [f"{group}.file=nowhere.csv"])
    assert any(f'set {group}.kind = "table"' in text for text in scene_warnings(scene, origins))
