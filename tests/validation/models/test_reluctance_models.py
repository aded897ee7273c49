"""The models of the normal actuator: fineness by what the bar came to, and what is said of bars."""

from types import SimpleNamespace

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import make_plan
from tactgen.validation.models.reluctance.field import _fine_enough
from tactgen.validation.scene.load import load_scene

GRIDS = ((2e-3, 1.0), (5e-4, 1.5), (0.0, 2.0))


@pytest.mark.parametrize(
    ("accuracy", "bar", "tried"),
    [
        (1e-3, 5e-4, [1.5]),  # the first grid is the one that usually suffices
        (1e-3, 3e-3, [1.5, 2.0]),  # it did not here: on to the next
        (1e-2, 1.0, [1.0, 1.5, 2.0]),  # up to the finest, whose bar stands
        (1e-5, 1.0, [2.0]),
    ],
)
def test_the_grid_is_refined_until_the_bar_is_met(accuracy, bar, tried):
    """From the usual grid of an accuracy on, by the bar that a grid really has there."""
    asked = []

    def solve(fineness):
        asked.append(fineness)
        return SimpleNamespace(force=-2.0, errors=SimpleNamespace(force=2.0 * bar / fineness**0.5))

    _fine_enough(GRIDS, accuracy, solve)
    assert asked == tried


def test_what_makes_no_circuit_is_refused_before_anything_is_solved():
    """The network says so at once; the field takes the same device."""
    scene, _ = load_scene("reluctance", ["sleeve.collar_thickness=2mm"])
    with pytest.raises(InputError, match=r"brings sleeve\.collar_thickness = 2 mm to"):
        make_plan(scene, ("network", "axisymmetric"), ("magnetic_force",))
    make_plan(scene, ("axisymmetric",), ("magnetic_force",))
