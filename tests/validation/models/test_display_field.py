"""Pulls among driven units whose fields only add up: what is made of them, and of their bars."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.magnetics import array_3d as array
from tactgen.fem.magnetics import array_3d as nine
from tactgen.fem.magnetics.array_3d import NineForces
from tactgen.validation.evidence.cases import display
from tactgen.validation.models.classes import make_model
from tactgen.validation.models.display import field
from tactgen.validation.models.model import Stages
from tactgen.validation.models.reluctance import field as field_model
from tactgen.validation.scene.scene import load_scene

#: Pull per square of current, of the unit's own and of one neighbour's beside and on the diagonal.
OWN, BESIDE, DIAGONAL = 5.0, -0.3, -0.06
#: Vector and scalar potential err the one way and the other.
OFF = (1.02, 0.98)


def pull(unit, currents):
    """Return Q i² + Σ 2 q i j of a unit among nine, the currents by kind of unit."""
    i = {kind: currents.get(kind, 0.0) for kind in ("middle", "beside", "diagonal")}
    near = {"middle": 4.0 * i["beside"], "beside": i["middle"] + 2.0 * i["diagonal"],
            "diagonal": 2.0 * i["beside"]}[unit]  # fmt: skip
    far = {"middle": 4.0 * i["diagonal"], "beside": 2.0 * i["beside"], "diagonal": i["middle"]}[
        unit
    ]
    return i[unit] * (OWN * i[unit] + 2.0 * BESIDE * near + 2.0 * DIAGONAL * far)


def nine_forces(device, currents, gap, pitch):
    def forces(at):
        both = {unit: tuple(off * pull(unit, at) for off in OFF)
                for unit in ("middle", "beside", "diagonal")}  # fmt: skip
        return NineForces(**both, unbalanced=(0.03, 0.01))

    assert (gap, pitch) == (0.2e-3, 2.4e-3)
    return [forces(at) for at in currents]


def array_forces(device, current, gap, pitch):
    assert (gap, pitch) == (0.2e-3, 2.4e-3)
    same, alternating = (current**2 * (OWN + sign * 8.0 * BESIDE) for sign in (1.0, -1.0))
    return SimpleNamespace(
        same=tuple(off * same for off in OFF), alternating=tuple(off * alternating for off in OFF)
    )


@pytest.fixture
def rows(monkeypatch):
    """Return the rows of the display by id, on such fields."""
    monkeypatch.setattr(display, "nine_forces", nine_forces)
    monkeypatch.setattr(display, "array_forces", array_forces)
    for cached in (display._nine, display._all_four):
        cached.cache_clear()
    yield {row.id: row.measure for each in display.CASES for row in each.rows}
    for cached in (display._nine, display._all_four):
        cached.cache_clear()


def test_reversals_count_pairs_of_neighbours(rows):
    """Four neighbours reversed, or one: as many pairs change sign."""
    assert rows["NEI-3"]() == pytest.approx(1.0)
    assert rows["NEI-4"]() == pytest.approx(1.0)
    assert rows["NEI-5"]() == pytest.approx(DIAGONAL / BESIDE)
    alone = OWN * display._CURRENT**2
    assert rows["NEI-6"]() == pytest.approx(0.02 / alone)


def test_the_network_is_held_against_the_one_driven_unit(rows, monkeypatch):
    asked = []

    def network(device, shown, current, gap):
        asked.append((shown.rows, shown.columns, current, gap))
        return SimpleNamespace(single=0.7 * OWN * current**2)

    monkeypatch.setattr(display, "network_forces", network)
    assert rows["NEI-2"]() == pytest.approx(0.7)
    assert asked == [(3, 3, 0.05, 0.2e-3)]


def test_the_field_of_an_array_is_the_mean_of_both_potentials(monkeypatch):
    """Bars: the distance of the potentials as a share, and of nine units what is out of balance."""
    monkeypatch.setattr(array, "array_forces", array_forces)
    monkeypatch.setattr(nine, "nine_forces", nine_forces)
    scene = load_scene("display", ["display.coil_current=50 mA"])[0]
    found = field.by_field(scene)
    square = 0.05**2
    assert found.current == 0.05
    for one, expected in (
        (found.same, square * (OWN + 8.0 * BESIDE)),
        (found.alternating, square * (OWN - 8.0 * BESIDE)),
        (found.difference, square * 16.0 * BESIDE),
    ):
        assert one.value == pytest.approx(expected)
        assert one.error == pytest.approx(0.02 * abs(expected), rel=1e-6)
    assert found.single.value == pytest.approx(OWN * square)
    assert found.single.error == pytest.approx(0.02)
    assert (found.passive.value, found.passive.error) == (0.0, pytest.approx(0.02 / 4.0))
    # what one neighbour's current changes: 2 q i
    per = found.per_neighbour
    assert per.value == pytest.approx(2.0 * BESIDE * 0.05)
    assert per.error == pytest.approx(0.02 * abs(per.value))


@pytest.mark.parametrize("wider", [0, 1])
def test_both_polarities_have_the_share_of_the_one_whose_potentials_are_farther_apart(
    monkeypatch, wider
):
    """Whichever it is; the difference has the larger of what its own potentials say and that."""
    pairs = [(1.02, 0.98), (0.33, 0.27)][:: -1 if wider else 1]
    found = SimpleNamespace(same=pairs[0], alternating=pairs[1])
    monkeypatch.setattr(array, "array_forces", lambda *_: found)
    monkeypatch.setattr(nine, "nine_forces", nine_forces)
    told = field.by_field(load_scene("display")[0])
    assert told.same.error == pytest.approx(0.1 * told.same.value)
    assert told.alternating.error == pytest.approx(0.1 * told.alternating.value)
    assert told.difference.error == pytest.approx(0.1 * 0.7)


def test_potentials_farther_apart_than_what_is_out_of_balance_are_the_bar():
    one = field._of_nine((1.0, 1.4), (0.02, -0.06), 4)
    assert (one.value, one.error) == (pytest.approx(1.2), pytest.approx(0.2))
    assert field._of_nine((1.0, 1.0), (0.2, 0.6)).error == pytest.approx(0.4)
    assert np.isfinite(one.error)


def test_what_a_new_process_knows_to_read():
    """The field between units is kept: a process that never solved it must know its class."""
    code = (
        "import tactgen.validation.models.reluctance.field; "
        "from tactgen.geometry.store import values; print(*values._STORABLE)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "NeighbourField" in done.stdout.split()


@pytest.mark.usefixtures("own_store")
@pytest.mark.parametrize("model", ["network", "magnetic3d"])
def test_a_model_of_the_display_says_what_neighbours_do(monkeypatch, model):
    """By the field or by the network; one that knows one actuator has nothing to say."""
    way = "by_network" if model == "network" else "by_field"
    monkeypatch.setattr(field_model, "by_field", lambda scene: ("by_field", 1.0))
    monkeypatch.setattr(field, "by_network", lambda scene: ("by_network", 1.0))
    scene = load_scene("display")[0]

    def made(name):
        return make_model(name, scene, Stages({f"{name}.neighbours": ""}))

    assert made(model).answer("neighbours") == (way, 1.0)
    with pytest.raises(NotImplementedError, match="axisymmetric knows one actuator"):
        made("axisymmetric").answer("neighbours")
