"""Fields of the normal actuator as models: how fine, and one map of all gaps and currents.

The map serves all springs and loads of one geometry; in 3D it is solved row by row, each kept.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.magnetics import actuator_3d
from tactgen.fem.magnetics import axisymmetric as actuator
from tactgen.fem.magnetics.actuator_3d import SolidPoint, SolidValues
from tactgen.fem.magnetics.axisymmetric import FieldErrors, FieldPoint
from tactgen.geometry.errors import CoarseGridError, InputError
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models.classes import make_model
from tactgen.validation.models.model import Stages
from tactgen.validation.models.reluctance.field import MAP_ORDER, _fine_enough
from tactgen.validation.scene.load import load_scene

SETS = ["models=axisymmetric", "accuracy=10%"]


@pytest.mark.parametrize(
    ("accuracy", "bar", "tried"),
    [
        (1e-3, 5e-4, [1.5]),  # the first grid is the one that usually suffices
        (1e-3, 3e-3, [1.5, 2.0]),  # it did not here: on to the next
        (1e-2, 1.0, [1.0, 1.5, 2.0]),  # up to the finest, whose bar stands
    ],
)
def test_the_grid_is_refined_until_the_bar_is_met(accuracy, bar, tried):
    """From the usual grid of an accuracy on, by the bar that a grid really has there."""
    asked = []

    def solve(fineness):
        asked.append(fineness)
        return SimpleNamespace(force=-2.0, errors=SimpleNamespace(force=2.0 * bar / fineness**0.5))

    _fine_enough(((2e-3, 1.0), (5e-4, 1.5), (0.0, 2.0)), accuracy, solve)
    assert asked == tried


def test_what_makes_no_circuit_is_refused_before_anything_is_solved():
    """The network says so at once; the field takes the same device."""
    scene, _ = load_scene("reluctance", ["sleeve.collar_thickness=2mm"])
    with pytest.raises(InputError, match=r"brings sleeve\.collar_thickness = 2 mm to"):
        make_plan(scene, ("network", "axisymmetric"), ("magnetic_force",))
    make_plan(scene, ("axisymmetric",), ("magnetic_force",))


def coil(current, gap):
    """Flux linkage, co-energy, force and inductance of L = A/(g + g0): W' = L i²/2."""
    inductance = 4e-6 / (gap + 3e-4)
    coenergy = 0.5 * inductance * current**2
    return inductance * current, coenergy, coenergy / (gap + 3e-4), inductance


def _point(current, gap):
    flux, coenergy, force, inductance = coil(current, gap)
    return FieldPoint(
        current=current, gap=gap, flux_linkage=flux, coenergy=coenergy, force=force,
        force_eggshell=force, incremental_inductance=inductance,
        errors=FieldErrors(0.0, 0.0, 1e-3 * force, 0.0), iterations=1, unknowns=1, beyond_table=0.0,
    )  # fmt: skip


@pytest.fixture
def mapped(own_store, monkeypatch):
    """Replace the field by a closed form; return the maps that were solved."""
    maps = []

    def solve_map(_device, gaps, currents, **_):
        maps.append((gaps, currents))
        return tuple(tuple(_point(i, g) for i in currents) for g in gaps)

    monkeypatch.setattr(actuator, "solve_map", solve_map)
    monkeypatch.setattr(actuator, "solve_point", lambda _device, i, g, **_: _point(i, g))
    monkeypatch.setattr(
        actuator.FieldContinuation, "at", lambda _self, _device, i, g, _place: _point(i, g)
    )
    return maps


def test_currents_are_those_of_the_closed_form(mapped):
    """Pull-in where A i² / 2 (g + g0)² is the preload, at any stiffness that shares the map."""
    for stiffness in (0, 100):
        scene, _ = load_scene("reluctance", [*SETS, f"spring.stiffness={stiffness} N/m"])
        found = solve(scene, ("axisymmetric",), ("pull_in_current",)).quantities[0]
        exact = np.sqrt(2.0 * scene.spring.preload / 4e-6) * (scene.gap + 3e-4)
        assert abs(found.value - exact) <= found.error
    assert len(mapped) == 1


@pytest.mark.parametrize("coarse", [(MAP_ORDER,), (MAP_ORDER, actuator.ORDER)])
def test_a_map_that_is_too_coarse(mapped, monkeypatch, coarse):
    """A narrow clearance alone needs the order of points, all others are served by the lower one.

    Without an answer by either, what needs the map is left out with one warning and one attempt,
    alone it is refused.
    """
    solve_map, orders = actuator.solve_map, []

    def demanding(*args, order=actuator.ORDER):
        orders.append(order)
        if order in coarse:
            raise CoarseGridError("too coarse")
        return solve_map(*args)

    monkeypatch.setattr(actuator, "solve_map", demanding)
    scene, _ = load_scene("reluctance", ["models=axisymmetric,network", SETS[1]])
    asked = ("magnetic_force", "pull_in_current", "rod_position")
    found = solve(scene, quantities=asked)
    assert orders == [MAP_ORDER, actuator.ORDER]
    missing = {(name, "axisymmetric") for name in asked[1:]} if len(coarse) > 1 else set()
    both = {(name, model) for name in asked for model in ("network", "axisymmetric")}
    assert {(q.name, q.model) for q in found.quantities} == both - missing
    said = [text for text in found.warnings if "too coarse" in text]
    assert ["pull_in_current, rod_position" in text for text in said] == [True] * bool(missing)
    if missing:
        with pytest.raises(CoarseGridError, match="too coarse"):
            solve(scene, ("axisymmetric",), asked[1:])


@pytest.mark.heavy
def test_the_shared_map_holds_points_solved_alone(own_store):
    """Held out, at currents and gaps between its samples, of a scene that did not ask for it."""
    from tactgen.validation.models.classes import map_of

    scene, _ = load_scene("reluctance", [*SETS, "spring.stiffness=90 N/m"])
    found = map_of(scene)
    rng = np.random.default_rng(7)
    limit, (low, high) = found.current_limit, found.gap_limits
    for share, place in rng.uniform(0.1, 0.95, (6, 2)):
        current, gap = share * limit, float(low * (high / low) ** place)
        point = actuator.solve_point(scene.device, current, gap, order=5)
        error = found.interpolation_error
        most = found.samples.force_error.max() / found.samples.force.max()
        assert abs(found.force(current, gap) - point.force) <= (
            (error.force + most) * point.force + point.errors.force
        )
        assert abs(found.flux_linkage(current, gap) - point.flux_linkage) <= (
            (error.flux_linkage + most) * point.flux_linkage + point.errors.flux_linkage
        )


def test_an_interrupted_map_goes_on_where_it_was(tmp_path, monkeypatch):
    """Rows that were solved before the interruption are read, the others solved."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path))
    solved, ends = [], iter([False, False, True])

    def row(_device, gap, currents, _sector):
        if next(ends, False):
            raise KeyboardInterrupt
        solved.append(gap)
        found = []
        for current in map(float, currents):
            flux, coenergy, force, inductance = coil(current, gap)
            values = SolidValues(flux, coenergy, (force,) * 2, inductance, 1, 1, 0.0)
            found.append(SolidPoint(current, gap, values, values))
        return tuple(found)

    monkeypatch.setattr(actuator_3d, "solve_row", row)
    scene, _ = load_scene("reluctance", ["models=magnetic3d"])
    plan = make_plan(scene, ("magnetic3d",), ("pull_in_current",))
    with pytest.raises(KeyboardInterrupt):
        make_model("magnetic3d", scene, Stages(plan.keys)).map()
    found, again = (make_model("magnetic3d", scene, Stages(plan.keys)).map() for _ in range(2))
    assert solved == found.samples.gap.tolist()  # each once
    assert np.array_equal(again.coefficients, found.coefficients)


@pytest.mark.heavy
def test_the_3d_map_switches_like_the_half_sections(tmp_path, monkeypatch):
    """Map, pull-in and holding current in 3D, by rows that are kept, within the error bars of
    the axisymmetric field's; the map itself to what it says of its interpolation."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path))
    scene, _ = load_scene("reluctance", ["models=magnetic3d,axisymmetric", "accuracy=5%"])
    names = ("pull_in_current", "holding_current")
    solution = solve(scene, None, names)
    for name in names:
        solid, half = (solution.get(name, model) for model in ("magnetic3d", "axisymmetric"))
        bar = float(solid.error) + float(half.error)
        assert abs(float(solid.value) - float(half.value)) <= bar
        assert bar < 0.06 * float(half.value)
    maps = [solution.models[m].map() for m in ("magnetic3d", "axisymmetric")]
    for current, gap in ((0.05, 0.1e-3), (0.13, 0.2e-3), (0.02, 0.03e-3)):
        forces = [float(found.force(current, gap)) for found in maps]
        allowed = sum(found.interpolation_error.force for found in maps) + 0.03
        assert abs(forces[0] / forces[1] - 1.0) < allowed
    assert len(list(tmp_path.glob("magnetic3d.row-*"))) == 6
