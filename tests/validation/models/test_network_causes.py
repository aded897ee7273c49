"""Why the network is not the field: what each telling is worth, and how little they leave."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.circuit import FULL, circuit
from tactgen.tmm.reluctance.flux_ladder import solve
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.engine.results import Estimate
from tactgen.validation.models.reluctance import network_causes as network_causes_module
from tactgen.validation.models.reluctance.field_reading import FieldReading
from tactgen.validation.models.reluctance.network_causes import network_causes, stroke_causes
from tactgen.validation.models.reluctance.open_circuit import Circuit
from tactgen.validation.models.reluctance.switching import SwitchingCurrents
from tactgen.validation.models.reluctance.told_by_field import ToldByField

GAP = 0.2e-3
STRONG, WEAK = 0.13, 0.05


@pytest.fixture(scope="module")
def causes():
    return {current: network_causes(Device(), current, GAP) for current in (WEAK, STRONG)}


def shares(found, quantity):
    return {cause.name: cause.of[quantity] for cause in found}


def left(found, current, gap):
    """What the causes leave of (network / the model's own field − 1), by quantity."""
    field = solve_point(Device(), current, gap)
    network = network_samples(Device(), np.array([current]), np.array([gap]))
    both = (
        ("magnetic_force", network.force, field.force),
        ("flux_linkage", network.flux_linkage, field.flux_linkage),
        ("coenergy", network.coenergy, field.coenergy),
        ("incremental_inductance", network.incremental_inductance, field.incremental_inductance),
    )
    return {
        name: float(ours[0, 0]) / exact - 1.0 - sum(shares(found, name).values())
        for name, ours, exact in both
    }


@pytest.mark.parametrize("current", [WEAK, STRONG])
def test_causes_leave_next_to_nothing(causes, current):
    """Network over the model's own field, less 1, is what the causes say, to 0.2 %.

    They are told permeances, lengths of iron and an inductance; all values come out.  What may be
    left is what a circuit is: the pole's faces and each section of iron have one potential.  Of the
    incremental inductance 0.3 %: across the coil and at the flange, changes of flux are not told.
    """
    found = left(causes[current], current, GAP)
    assert abs(found.pop("incremental_inductance")) < 3e-3
    assert abs(found.pop("flux_linkage")) < 1e-3
    assert max(map(abs, found.values())) < 2e-3


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("current", "gap", "most"),
    [
        (STRONG, 20e-6, (2e-3, 2e-3)),
        (WEAK, 20e-6, (2e-3, 5e-3)),
        (10e-3, GAP, (3e-3, 1e-3)),
        (10e-3, 20e-6, (4e-3, 4e-3)),
        (STRONG, 60e-6, (4e-3, 8e-3)),
    ],
)
def test_what_causes_leave_at_other_places(current, gap, most):
    """Of the pull and of the incremental inductance, told of flux's changes as well.

    Without these 2.6 % of that inductance are left at the lower stop and 130 mA.  At weak currents
    steel is least permeable: the mmf of a section is then not one number to 0.15 % of the gap's.
    """
    found = left(network_causes(Device(), current, gap), current, gap)
    for quantity, share in zip(("magnetic_force", "incremental_inductance"), most, strict=True):
        assert abs(found[quantity]) < share


@pytest.mark.heavy
def test_steel_makes_other_tubes_than_perfect_iron_at_the_narrow_gap():
    """At the lower stop and 130 mA that is 0.7 % of the pull."""
    found = shares(network_causes(Device(), STRONG, Device().spring.stop_gap), "magnetic_force")
    assert found["steel at the gap"] == pytest.approx(-0.0073, abs=1e-3)


def test_flux_outside_is_what_saturation_makes_of_the_shaft(causes):
    """Of the 12 % of pull at 130 mA nearly all; at 50 mA, where the shaft is not full, a fifth."""
    weak, strong = (shares(causes[i], "magnetic_force") for i in (WEAK, STRONG))
    assert strong["flux outside"] > 0.1
    assert strong["flux outside"] > 0.9 * sum(strong.values())
    assert 0.0 < weak["flux outside"] < 0.03


def test_causes_leave_next_to_nothing_of_switching_currents(monkeypatch):
    """Network's current for the field's pull, over the field's, less 1; a current that is none."""
    device, none = Device(), Estimate(np.nan, np.nan)
    stop, current = device.spring.stop_gap, 0.04
    gaps = SimpleNamespace(pull_in_gap=GAP, drop_out_gap=stop)
    monkeypatch.setattr(network_causes_module, "switching", lambda *_: gaps)
    held = Estimate(current, 0.0)
    currents = SwitchingCurrents(none, none, held, held, False, 0.0, 0.3)
    found = stroke_causes(device, None, currents)
    pull = solve_point(device, current, stop).force

    def miss(i):
        return float(network_samples(device, np.array([i]), np.array([stop])).force[0, 0]) - pull

    whole = brentq(miss, 0.5 * current, 1.5 * current) / current - 1.0
    assert abs(whole) > 1e-2
    for quantity in ("holding_current", "drop_out_current"):
        assert sum(shares(found, quantity).values()) == pytest.approx(whole, abs=2e-3)
    assert "pull_in_current" not in found[0].of


def test_foot_and_air_are_worth_less_than_a_percent_and_a_half(causes):
    """The flange's top is neither all of the rest nor nothing: half a percent of the pull."""
    for current in (WEAK, STRONG):
        found = shares(causes[current], "magnetic_force")
        assert 2e-3 < found["flange's foot"] < 8e-3
        assert -1e-2 < found["air at the flange"] < -2e-3
        assert abs(found["flux in the iron"]) < 1e-3
        assert found["flux in the winding"] == 0.0  # links turns, pulls nothing
    # steel that is not full yet is as good as perfect iron to the flux beside the gap
    weak, strong = (abs(shares(causes[i], "coenergy")["steel at the gap"]) for i in (WEAK, STRONG))
    assert weak < 5e-4
    assert strong > weak


@pytest.fixture(scope="module")
def plain():
    return Circuit.of(circuit(Device(), np.array([GAP]), FULL), STRONG)


@pytest.fixture(scope="module")
def reading():
    return FieldReading(Device(), GAP, solve_point(Device(), STRONG, GAP, order=3).solution)


@pytest.fixture(scope="module")
def told(plain, reading):
    telling = ToldByField(reading)
    spread = telling.flux_in_iron(telling.flange_foot(telling.flux_outside(plain)))
    return telling.flux_beside_shaft(spread)


def test_untold_circuit_is_the_network(plain):
    """The same minimum by two programs."""
    ladder = solve(circuit(Device(), np.array([GAP]), FULL), np.array([STRONG]))
    found = plain.solved()
    np.testing.assert_allclose(found.flux, ladder.flux[0, 0], rtol=1e-6)
    for name in ("coenergy", "flux_linkage", "force", "incremental_inductance"):
        assert getattr(found, name) == pytest.approx(float(getattr(ladder, name)[0, 0]), rel=1e-8)


def test_changes_of_a_field_are_a_field(reading):
    """As large as they would be from nothing: the incremental inductance times the current."""
    changes = reading.changes
    slope = float(reading.field.incremental_inductance[0, 0])
    assert changes.flux_linkage == pytest.approx(slope * STRONG, rel=1e-9)
    # all that the winding puts in is in the field, iron and air; what is held at 0 takes nothing
    d = reading.field.discretisation
    taken = (changes.field.field_strength * changes.field.flux_density).sum(axis=-1) * d.volumes
    assert float(taken.sum()) == pytest.approx(slope * STRONG**2, rel=1e-6)


def test_iron_of_one_permeability_is_read_back(reading):
    """And what a region takes below its own end is all that it takes."""
    even = dict.fromkeys(reading.permeabilities, 300.0)
    field = network_causes_module._field(Device(), WEAK, GAP, even)
    for name, found in FieldReading(Device(), GAP, field).permeabilities.items():
        assert found == pytest.approx(even[name], rel=1e-9)
    # a smooth curve through rows of points, beside a corner of iron
    assert float(reading.taken_below("rod")(1.0)) == pytest.approx(
        reading.taken_by("rod"), rel=1e-3
    )


def test_shares_of_more_quantities_are_put_together():
    """Cause by cause, in their order."""
    one, other = (
        [network_causes_module.NetworkCause(name, "", {key: n}) for n, name in enumerate("ab")]
        for key in "pq"
    )
    found = network_causes_module.together(one, other)
    assert [(cause.name, cause.of) for cause in found] == [
        ("a", {"p": 0, "q": 0}), ("b", {"p": 1, "q": 1}),
    ]  # fmt: skip
