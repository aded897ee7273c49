"""What the tip touches: impedance, force and power; measured loads and other tables of a scene."""

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.finger_and_pad import finger_impedance
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.scene.inputs import values_read
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.warnings import scene_warnings

F = np.array([10.0, 300.0, 900.0])
SPRING = ("load.kind=spring_damper", "load.stiffness=300N/m", "load.damping=0.5N*s/m")


def spring_damper(f):
    return 0.5 + 300.0 / (2j * np.pi * f)


def solved(*overrides, scene="paper", models=("tmm",), quantities=("load_impedance",)):
    return solve(load_scene(scene, ("frequency=10,300,900", *overrides))[0], models, quantities)


def one(*overrides, **asked):
    """Return the first quantity of an answer."""
    return solved(*overrides, **asked).quantities[0]


@pytest.mark.parametrize(
    ("overrides", "impedance"),
    [
        ((), finger_impedance(F)),
        (("load.kind=none",), 0.0 * F),
        (("load.kind=mass", "load.mass=2mg"), 2j * np.pi * F * 2e-6),
        (SPRING, spring_damper(F)),
    ],
)
def test_the_impedance_is_that_of_what_is_stated(overrides, impedance):
    """By the formulas of a finger (eqs 1-3), a mass, a spring and a damper, to rounding.

    It is of the load alone: no stage runs for it.
    """
    found = solved(*overrides)
    np.testing.assert_allclose(found.quantities[0].value, impedance, rtol=1e-13)
    assert make_plan(found.scene, ("tmm",), ("load_impedance",)).run == ()


@pytest.mark.parametrize("overrides", [(), ("bimorph.wiring=series",)])
def test_force_and_power_follow_from_the_velocity(overrides):
    """F = Z v and P = Re(F v*)/2, by a model with a closed form and by one with ports only."""
    names = ("load_impedance", "tip_velocity", "load_force", "load_power")
    found = solved(*overrides, models=("lumped", "tmm", "beam"), quantities=names)
    z = found.get("load_impedance", "tmm").value
    for model in ("lumped", "tmm", "beam"):
        v, force, power = (found.get(name, model) for name in names[1:])
        np.testing.assert_allclose(force.value, z * v.value, rtol=1e-9)
        expected = 0.5 * (force.value * v.value.conj()).real
        np.testing.assert_allclose(power.value, expected, rtol=1e-9)
        assert (power.value > 0.0).all()
        # the power goes with the square of the motion; elements' bars are read off each alone
        relative = power.error / power.value, v.error / np.abs(v.value)
        assert model == "beam" or (relative[0] >= 1.5 * relative[1]).all()


def test_every_model_takes_imitation_skin():
    """The same load on the same theory by two ways of solving it."""
    found = solved("load.kind=pad", models=("tmm", "beam"), quantities=("load_force",))
    exact, elements = (found.get("load_force", model) for model in ("tmm", "beam"))
    apart = np.abs(exact.value - elements.value)
    assert (apart <= exact.error + elements.error).all()
    assert found.warnings == ()


@pytest.fixture
def measured(tmp_path):
    """A table of a spring with a damper, and what a scene says to be loaded by it."""
    path, frequencies = tmp_path / "load.csv", np.geomspace(10.0, 1000.0, 50)
    points = zip(frequencies, spring_damper(frequencies), strict=True)
    rows = [f"{f:.17g}, {z.real:.17g}, {z.imag:.17g}" for f, z in points]
    head = "frequency (Hz), impedance_re (N s/m), impedance_im (N s/m)"
    path.write_text("\n".join([head, *rows]) + "\n")
    return ("load.kind=table", f"load.file={path}")


@pytest.mark.usefixtures("coarse_bricks", "own_store")
@pytest.mark.parametrize(
    ("scene", "models", "quantities"),
    [
        ("paper", ("lumped", "tmm", "beam"), ("tip_velocity", "ceramic_stress")),
        ("j1", ("solid",), ("tip_displacement",)),
    ],
)
def test_every_model_takes_a_table(measured, scene, models, quantities):
    """As the same spring and damper by constants, within bars that say what the table lacks."""
    common = {"scene": scene, "models": models, "quantities": quantities}
    by_table, by_constants = (
        solved("frequency=20,130,900", "mesh.level=2", *load, **common).quantities
        for load in (measured, SPRING)
    )
    for found, exact in zip(by_table, by_constants, strict=True):
        assert (np.abs(found.value - exact.value) <= found.error).all()
        assert (found.error >= exact.error).all()
        assert (found.error <= 0.02 * np.abs(found.value) + exact.error).all()
        assert "load's table" in found.method


def test_the_machine_takes_a_table(measured):
    found, exact = (
        one("support.kind=contact", "frequency=20,130", *load,
            quantities=("lateral_tip_per_voltage",))
        for load in (measured, SPRING)
    )  # fmt: skip
    assert (np.abs(found.value - exact.value) <= found.error).all()
    assert (found.error > exact.error).all()


def test_beyond_the_table_only_its_fit_answers_and_says_so(measured):
    asked = ("frequency=20,2000", *measured)
    with pytest.raises(InputError, match=r"2000 Hz is outside .*passive_fit"):
        solved(*asked, quantities=("tip_displacement",))
    fitted = (*asked, "load.extrapolation=passive_fit")
    found = solved(*fitted, quantities=("tip_displacement",))
    (said,) = (text for text in found.warnings if "is replaced by" in text)
    assert "1 of 2 frequencies are outside the table" in said
    q = found.quantities[0]
    exact = one("frequency=20,2000", *SPRING, quantities=("tip_displacement",))
    assert (np.abs(q.value - exact.value) <= q.error).all()


#: Columns of the tables that a scene may name, each constant over the frequency.
TABLES = {
    "load": "impedance_re (N s/m),impedance_im (N s/m)",
    "support": "rotational_stiffness_re (N m/rad),rotational_stiffness_im (N m/rad)",
    "threshold": "threshold (um)",
}


@pytest.mark.parametrize("group", TABLES)
def test_a_tables_key_is_what_is_in_the_file(tmp_path, group):
    """Another name for the same numbers is the same; other numbers under that name are not.

    A table that is missing is refused, one that is idle is said.
    """

    def scene(name, value):
        cells = ",".join([value] * (1 + TABLES[group].count(",")))
        rows = (f"{f},{cells}" for f in (1, 2, 5, 20, 100, 1000))
        (tmp_path / name).write_text("\n".join([f"frequency (Hz),{TABLES[group]}", *rows]))
        return load_scene("paper", (f"{group}.kind=table", f"{group}.file={tmp_path / name}"))[0]

    first, other = (values_read(scene(name, "1"), (group,)) for name in ("one.csv", "other.csv"))
    assert other == first
    assert values_read(scene("other.csv", "2"), (group,)) != first
    with pytest.raises(InputError, match=f"needs {group}.file"):
        solved(f"{group}.kind=table", quantities=("threshold_voltage",))
    idle, origins = load_scene("paper", [f"{group}.file=nowhere.csv"])
    assert any(f'set {group}.kind = "table"' in text for text in scene_warnings(idle, origins))
