"""The search for the normal actuator's unknown sizes, whose result is the device built in."""

import math

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Coil, Device
from tactgen.geometry.device.parts import total_height
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies import reconstruction as stated
from tactgen.validation.studies.reconstruction import (
    _crossing,
    actuator,
    ampere_turns_needed,
    field_pull,
    network_map,
    weighed,
)

#: Shaft radius, bore radius and coil length (m) of the device built in.
BUILT_IN = 0.64e-3, 0.96e-3, 1.6e-3


def test_the_device_built_in_follows_the_rules_of_the_search():
    """All sizes of rod, coil and sleeve but those it does not set are the built-in ones."""
    found, device = actuator(*BUILT_IN), Device()
    assert found.gap == device.gap
    for group in ("rod", "coil", "sleeve"):
        one, other = (getattr(built, group).model_dump() for built in (found, device))
        sizes = [key for key, value in one.items() if isinstance(value, float)]
        assert [one[key] for key in sizes] == pytest.approx([other[key] for key in sizes])


def test_the_generator_has_the_stated_height():
    """41 mm from tip to the sleeve's end: the last printed digit is half a millimetre."""
    device = load_scene("bimorph_on_rod")[0].device
    assert total_height(device) == pytest.approx(stated.TOTAL_HEIGHT, abs=0.5e-3)
    assert 2.0 * device.sleeve.outer_radius == pytest.approx(stated.OUTER_DIAMETER)


def test_the_needed_current_of_a_power_law_is_exact():
    """Pull ∝ i²: the crossing between samples is exact, beyond them only where asked for."""
    currents = np.array([0.5, 1.0, 3.0])
    forces = stated.FORCE * (currents / 2.0) ** 2
    assert _crossing(currents, forces) == pytest.approx(2.0, rel=1e-12)
    assert math.isinf(_crossing(currents[:2], forces[:2]))
    assert _crossing(currents[:2], forces[:2], beyond=True) == pytest.approx(2.0, rel=1e-12)


@pytest.mark.parametrize("pull", [network_map, field_pull])
def test_needed_ampere_turns_pull_with_the_stated_force(pull):
    """Asked again at what it said, the model pulls with 110 mN: 1 % of interpolation."""
    device = Device()
    needed = ampere_turns_needed(device, pull)
    force = pull(device, np.array([needed / device.coil.turns]))[0]
    assert force == pytest.approx(stated.FORCE, rel=0.01)


def test_heat_does_not_depend_on_the_turns_of_the_start():
    """Ampere-turns and window decide; whole turns round by 1e-3."""
    device = Device()
    other = device.model_copy(update={"coil": Coil(turns=300.0)})
    one, two = weighed(device, network_map), weighed(other, network_map)
    assert one.ampere_turns == pytest.approx(two.ampere_turns, rel=1e-2)  # samples lie elsewhere
    assert one.held_power == pytest.approx(two.held_power, rel=2e-2)


def test_a_coil_that_cannot_is_infinitely_hot():
    """A shaft too thin for the flux: no ampere-turns do it, and no heat is named."""
    found = weighed(actuator(0.3e-3, 0.96e-3, 1.6e-3), network_map)
    assert math.isinf(found.ampere_turns)
    assert math.isinf(found.held_power)


def test_a_long_coil_and_the_stated_force_exclude_each_other():
    """12 mm of coil on the same radii need many times the ampere-turns, as leakage saturates the
    shaft, and so stay hotter in spite of their larger window."""
    short, long = (weighed(actuator(*BUILT_IN[:2], l), network_map) for l in (1.6e-3, 12e-3))
    assert long.ampere_turns > 4.0 * short.ampere_turns
    assert long.held_power > 3.0 * short.held_power


@pytest.mark.heavy
@pytest.mark.parametrize("step", [(0.03, 0, 0), (-0.03, 0, 0), (0, 0.02, 0), (0, -0.02, 0),
                                  (0, 0, 0.6), (0, 0, -0.5)])  # fmt: skip
def test_no_neighbour_is_cooler_by_the_field(step):
    """The device built in is the coolest by the field, up to 2 % of search and rounding."""
    moved = (size + 1e-3 * change for size, change in zip(BUILT_IN, step, strict=True))
    neighbour = weighed(actuator(*moved), field_pull).held_power
    assert neighbour > 0.98 * weighed(Device(), field_pull).held_power
