"""Surrogates: fresh points lie inside the stated error, modes keep their class, errors grow."""

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.engine.surrogate import (
    Box,
    build_surrogate,
    design_points,
    design_size,
    fit_surrogate,
)
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.variation import with_values

FREQUENCIES = "short_circuit_frequencies"
STATICS = ("static_tip_displacement", "capacitance_free")


def fresh(ranges, count, seed=1):
    """Return `count` points of the ranges, evenly by ratio."""
    rng = np.random.default_rng(seed)
    return {key: low * (high / low) ** rng.random(count) for key, (low, high) in ranges.items()}


def inside(scene, model, names, ranges, count):
    """Return which of all values at fresh points are inside their stated errors."""
    surrogate = build_surrogate(scene, model, names, ranges)
    values = fresh(ranges, count)
    found = []
    for n, answers in enumerate(surrogate.answers(values)):
        at = with_values(scene, {key: float(of[n]) for key, of in values.items()})
        single = solve(at, (model,), names)
        for q in answers:
            other = single.get(q.name, model)
            assert (q.classes, q.value.shape) == (other.classes, other.value.shape)
            found += list(np.ravel(np.abs(q.value - other.value) <= q.error))
    return np.array(found)


@pytest.mark.parametrize(
    ("model", "names", "ranges"),
    [
        pytest.param("beam", (*STATICS, FREQUENCIES, "coupling_factor"),
                     {"bimorph.length": (14e-3, 40e-3)}, marks=pytest.mark.heavy),
        ("lumped", STATICS, {"bimorph.length": (14e-3, 20e-3), "bimorph.width": (1.5e-3, 3e-3)}),
    ],
)  # fmt: skip
def test_fresh_points_are_inside_the_error(model, names, ranges):
    scene, _ = load_scene("paper", [f"models={model}"])
    assert inside(scene, model, names, ranges, 12).mean() >= 0.95


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("scene", "model", "names", "ranges", "count"),
    [
        ("paper", "beam", (*STATICS, FREQUENCIES),
         {"bimorph.length": (14e-3, 40e-3), "bimorph.piezo_thickness": (2e-4, 3e-4),
          "bimorph.width": (1.5e-3, 3e-3)}, 200),
        ("paper", "solid", (*STATICS, FREQUENCIES), {"bimorph.length": (14e-3, 40e-3)}, 200),
        ("reluctance", "network", ("magnetic_force", "flux_linkage", "pull_in_current"),
         {"gap": (1e-4, 3e-4)}, 200),
    ],
)  # fmt: skip
def test_two_hundred_fresh_points_are_inside_the_error(scene, model, names, ranges, count):
    at, _ = load_scene(scene, [f"models={model}"])
    assert inside(at, model, names, ranges, count).mean() >= 0.95


def test_modes_that_cross_are_told_apart_by_class():
    """Bending across a narrow bimorph falls below the second bending in x as it grows wider."""
    ranges = {"bimorph.width": (1e-3, 3e-3)}
    scene, _ = load_scene("paper", ["modes=2"])

    def answer(width):
        across, along = 5e5 * width, 1000.0 + 0.0 * width  # they cross at 2 mm
        pairs = sorted([(along, "bending_x"), (across, "bending_y"), (4000.0, "torsion")])
        value = np.array([f for f, _ in pairs])
        return (Quantity(
            name=FREQUENCIES, model="solid", unit="Hz", value=value, error=1e-6 * value,
            classes=tuple(kind for _, kind in pairs),
        ),)  # fmt: skip

    answers = [answer(point["bimorph.width"]) for point in design_points(ranges)]
    surrogate = fit_surrogate(scene, ranges, answers)
    (narrow,), (wide,) = surrogate.answers({"bimorph.width": np.array([1.99e-3, 2.01e-3])})
    assert narrow.classes == wide.classes[::-1] == ("bending_y", "bending_x")
    np.testing.assert_allclose(narrow.value, [995.0, 1000.0], rtol=1e-9)
    np.testing.assert_allclose(wide.value, [1000.0, 1005.0], rtol=1e-9)


def smooth(ranges, of):
    """Return a surrogate of one number that a function of the values gives."""
    answers = [
        (Quantity(name=STATICS[0], model="solid", unit="m", value=np.asarray(of(point)),
                  error=np.asarray(1e-9)),)
        for point in design_points(ranges)
    ]  # fmt: skip
    return fit_surrogate(load_scene("paper")[0], ranges, answers)


def estimate(surrogate, values):
    """Return values and errors of the one quantity at points."""
    found = [q for (q,) in surrogate.answers(values)]
    return np.array([q.value for q in found]), np.array([q.error for q in found])


def test_outside_the_range_the_error_grows_and_a_jump_is_seen():
    surrogate = smooth({"gap": (1.0, 2.0)}, lambda p: np.exp(3.0 * p["gap"]))
    at = np.array([1.0, 2.0, 2.2, 2.6])
    value, error = estimate(surrogate, {"gap": at})
    assert (np.abs(value - np.exp(3.0 * at)) <= error).all()
    assert error[1] < error[2] < error[3]
    jump = smooth({"gap": (1.0, 2.0)}, lambda p: 1.0 + (p["gap"] > 1.4))
    assert jump.interpolation_error(STATICS[0]) > 0.2


def test_numbers_that_may_be_zero_are_spaced_evenly():
    ranges = {"gap": (-1.0, 1.0), "coil.current": (0.0, 2.0)}
    surrogate = smooth(ranges, lambda p: p["gap"] * p["coil.current"] - 0.5)
    values = {"gap": np.array([-0.3, 0.9]), "coil.current": np.array([0.0, 1.7])}
    value, _ = estimate(surrogate, values)
    np.testing.assert_allclose(value, [-0.5, 1.03], atol=1e-12)


def test_a_resonance_is_interpolated_as_its_reciprocal():
    """Lightly damped: the response has a pole next to the range, its reciprocal has none."""
    surrogate = smooth({"gap": (0.9, 1.1)}, lambda p: 1.0 / (1.0 - p["gap"] ** 2 + 0.02j))
    at = np.linspace(0.9, 1.1, 50)
    value, _ = estimate(surrogate, {"gap": at})
    np.testing.assert_allclose(value, 1.0 / (1.0 - at**2 + 0.02j), rtol=1e-9)


def test_values_at_some_points_only_are_refused():
    with pytest.raises(InputError, match="has no value"):
        smooth({"gap": (1.0, 2.0)}, lambda p: np.nan if p["gap"] > 1.5 else 1.0)
    with pytest.raises(InputError, match="have no answer"):
        fit_surrogate(load_scene("paper")[0], {"a": (1.0, 2.0)}, [None] * design_size(1))


@pytest.mark.parametrize("keys", [1, 8])
def test_the_design_is_inside_and_overdetermines(keys):
    box = Box({str(n): (1.0, 2.0) for n in range(keys)})
    place = box.design()
    assert (np.abs(place) <= 1.0).all()
    assert len(np.unique(place, axis=0)) == len(place) == design_size(keys) <= 128
    basis = box.basis(place, box.degree)
    assert np.linalg.matrix_rank(basis) == basis.shape[1]
