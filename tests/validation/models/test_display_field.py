"""Pulls among driven units whose fields only add up: what is made of them, and of their bars."""

from types import SimpleNamespace

import pytest

from tactgen.fem.magnetics import array_3d as array
from tactgen.fem.magnetics import array_3d as nine
from tactgen.fem.magnetics.array_3d import NineForces
from tactgen.validation.models import display as field
from tactgen.validation.scene.load import load_scene

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
