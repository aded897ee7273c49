"""Contact, losses and coil fitted to curves that the machine itself made."""

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.quantities import measurable
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.scene.variation import value_of
from tactgen.validation.studies.curve_fit import curve_model
from tactgen.validation.studies.identify import identify
from tactgen.validation.studies.measured_data import MeasuredCurve

ON_CONTACT = ("support.kind=contact", "coil.current=0mA")
FREQUENCIES = np.linspace(10.0, 2000.0, 40)


def measured(scene, kind, frequencies=FREQUENCIES, level=0.02, seed=1):
    """Return the scene's own curve with complex noise, `level` of each value."""
    exact = curve_model(scene, measurable()[kind].name, frequencies, ())(np.zeros(0))
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal(exact.shape) + 1j * rng.standard_normal(exact.shape)
    values = exact * (1.0 + level * noise)
    return MeasuredCurve("the machine", kind, frequencies, values, None, np.ones(exact.shape))


def in_its_interval(found, scene, key):
    low, high = found.get(key).interval
    return low <= value_of(scene, key) <= high


@pytest.mark.parametrize(
    "keys",
    [
        ("contact.decay_length",),
        pytest.param(("contact.decay_length", "contact.relaxation_time"), marks=pytest.mark.heavy),
    ],
    ids="-".join,
)
def test_the_contacts_constants_come_back(keys):
    """From starts a factor 2 to 4 away; an interval of 95 % that is a few percent wide."""
    truth = {"contact.decay_length": "0.25um", "contact.relaxation_time": "30us"}
    start = {"contact.decay_length": "0.6um", "contact.relaxation_time": "8us"}
    made, _ = load_scene("prototype", [*ON_CONTACT, *(f"{k}={truth[k]}" for k in keys)])
    scene, _ = load_scene("prototype", ON_CONTACT)
    found = identify(scene, measured(made, "velocity"), [f"{k}={start[k]}" for k in keys])
    for key in keys:
        assert in_its_interval(found, made, key)
        assert found.get(key).half_width < 0.05
    assert not found.findings


@pytest.mark.heavy
def test_a_loss_factor_comes_back():
    """Of the shim; the curve is known to 0.2 %."""
    made, _ = load_scene("prototype", [*ON_CONTACT, "shim.loss_factor=0.05"])
    scene, _ = load_scene("prototype", ON_CONTACT)
    found = identify(scene, measured(made, "velocity", level=2e-3), ("shim.loss_factor=0.2",))
    assert in_its_interval(found, made, "shim.loss_factor")
    assert found.get("shim.loss_factor").half_width < 0.5


PAIR = ("contact.decay_length", "spring.preload")


def test_a_contact_is_as_stiff_as_its_load_over_its_decay_length():
    """So the curve turns the same way by the one as it turns back by the other: the guide's share
    of the stiffness apart, which is 4e-4."""
    scene, _ = load_scene("prototype", ON_CONTACT)
    model = curve_model(scene, measurable()["velocity"].name, FREQUENCIES, PAIR)
    one, other = model.sensitivities(np.array([value_of(scene, key) for key in PAIR])).T
    assert np.abs(one + other).max() < 1e-3 * np.abs(one).max()


@pytest.mark.heavy
def test_preload_and_decay_length_are_told_to_be_one():
    """What the curve knows is their quotient, and that is said."""
    scene, _ = load_scene("prototype", ON_CONTACT)
    found = identify(scene, measured(scene, "velocity"), PAIR)
    assert any(all(key in said for key in PAIR) for said in found.findings)


#: The rod held down, the tip free.
HELD = ("load.kind=none", "coil.current=50mA", "coil.history=falling")


def test_a_curve_of_the_machine_is_that_of_solve():
    """The coil's impedance to rounding, and it follows the lead's resistance."""
    scene, _ = load_scene("generator", [*HELD, "frequency=10,300,2000"])
    exact = solve(scene, ("tmm",), ("coil_impedance",)).get("coil_impedance", "tmm").value
    key = "coil.source_resistance"
    model = curve_model(scene, "coil_impedance", np.array(scene.frequency), (key,))
    here = model(np.array([value_of(scene, key)]))
    np.testing.assert_allclose(here, exact, rtol=1e-12)
    more = model(np.array([value_of(scene, key) + 20.0]))
    np.testing.assert_allclose(more - here, 20.0, rtol=1e-9)


@pytest.mark.heavy
def test_the_coils_circuit_comes_back_from_its_impedance():
    """The lead's resistance, at a rod held down."""
    made, _ = load_scene("generator", [*HELD, "coil.source_resistance=20ohm"])
    scene, _ = load_scene("generator", HELD)
    data = measured(made, "impedance", np.geomspace(10.0, 2000.0, 20))
    found = identify(scene, data, ("coil.source_resistance=5ohm",))
    assert in_its_interval(found, made, "coil.source_resistance")
    assert found.get("coil.source_resistance").half_width < 0.2


def test_an_impedance_wants_the_machine():
    """One sentence with the remedy, on the paper's springs."""
    scene, _ = load_scene("generator", ["load.kind=none", "frequency=100,200,300,400,500,600"])
    data = measured(scene, "impedance", np.array(scene.frequency))
    with pytest.raises(InputError, match=r"set support\.kind=contact"):
        identify(load_scene("prototype", [])[0], data, ("coil.turns",))
