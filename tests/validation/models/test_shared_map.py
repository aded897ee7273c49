"""One co-energy map of a field for all gaps, currents, springs and loads of one geometry."""

import numpy as np
import pytest

from tactgen.fem.magnetics import axisymmetric as actuator
from tactgen.fem.magnetics import axisymmetric as walk
from tactgen.fem.magnetics.axisymmetric import FieldErrors, FieldPoint
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import load_scene

SETS = ["models=axisymmetric", "accuracy=10%"]


def _point(current, gap):
    """A coil whose inductance is L = A/(g + g0): W' = L i²/2."""
    inductance = 4e-6 / (gap + 3e-4)
    force = 0.5 * inductance / (gap + 3e-4) * current**2
    return FieldPoint(
        current=current, gap=gap, flux_linkage=inductance * current,
        coenergy=0.5 * inductance * current**2, force=force, force_eggshell=force,
        incremental_inductance=inductance, errors=FieldErrors(0.0, 0.0, 1e-3 * force, 0.0),
        iterations=1, unknowns=1, beyond_table=0.0,
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
        walk.FieldContinuation, "at", lambda _self, _device, i, g, _place: _point(i, g)
    )
    return maps


def test_another_geometry_has_another_map(mapped):
    for length in ("1.5 mm", "1.6 mm"):
        scene, _ = load_scene("reluctance", [*SETS, f"coil.length={length}"])
        solve(scene, ("axisymmetric",), ("pull_in_current",))
    assert len(mapped) == 2


def test_currents_are_those_of_the_closed_form(mapped):
    """Pull-in where A i² / 2 (g + g0)² is the preload, at any stiffness that shares the map."""
    for stiffness in (0, 100):
        scene, _ = load_scene("reluctance", [*SETS, f"spring.stiffness={stiffness} N/m"])
        found = solve(scene, ("axisymmetric",), ("pull_in_current",)).quantities[0]
        exact = np.sqrt(2.0 * scene.spring.preload / 4e-6) * (scene.gap + 3e-4)
        assert abs(found.value - exact) <= found.error
    assert len(mapped) == 1


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
