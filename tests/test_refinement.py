"""Error bars from refinement: the published fixture, and coverage where the answer is known."""

import pytest

from validation.refinement import three_mesh_gci, two_mesh_factor
from validation.scene import load_scene
from validation.solve import solve


def test_published_three_mesh_study():
    """NASA's tutorial on spatial convergence: order, extrapolation and both indices."""
    gci = three_mesh_gci(0.97050, 0.96854, 0.96178, 2.0)
    # the inputs are printed to 5e-6, their smallest difference is 2e-3: order to 4e-3 at worst;
    # the tutorial computed from more digits than it prints
    assert gci.order == pytest.approx(1.78618, abs=2e-5)
    assert gci.extrapolated == pytest.approx(0.971300, abs=1e-6)
    assert 100 * gci.fine == pytest.approx(0.10308, abs=1e-5)
    assert 100 * gci.coarse == pytest.approx(0.35624, abs=2e-5)


def test_oscillating_values_have_no_order():
    """Where no order exists, none is made up."""
    with pytest.raises(ValueError, match="monotonically"):
        three_mesh_gci(1.0, 1.1, 1.05, 2.0)


def test_two_mesh_factor_is_wide_for_close_meshes():
    """The closer two meshes, the more their difference must be magnified."""
    assert two_mesh_factor(1.2) > two_mesh_factor(2.0) > 0.0


def covered(level):
    """Quantities of job J1 at a mesh level, with the four-code consensus."""
    scene, _ = load_scene("j1", [f"mesh.level={level}"])
    names = ("static_tip_displacement", "short_circuit_frequencies")
    static, frequencies = solve(scene, ("solid",), names).quantities
    yield static.value, static.uncertainty, -6.7582e-7, 1e-5
    reference = (1065.96, 3329.10, 6642.85, 16267.0)
    for value, bar, known in zip(
        frequencies.value, frequencies.uncertainty, reference, strict=True
    ):
        yield value, bar, known, 3e-5


@pytest.mark.parametrize(
    "level", [2, 3, *(pytest.param(n, marks=pytest.mark.heavy) for n in (4, 5))]
)
def test_error_bars_cover_the_known_answer(level):
    """On job J1 the true error lies inside the bar (plus the reference's own uncertainty),
    and the bar is not more than 20 times the error."""
    ratios = []
    for value, bar, known, own in covered(level):
        error = abs(value - known)
        assert error <= bar + own * abs(known)
        ratios.append(bar / max(error, own * abs(known)))
    assert sorted(ratios)[len(ratios) // 2] < 20.0


@pytest.mark.parametrize("scene_name", ["paper", "j1"])
def test_wanted_accuracy_is_reached(scene_name):
    """The mesh chosen for the default accuracy of 1e-3 has bars within 1e-3."""
    scene, _ = load_scene(scene_name)
    names = ("static_tip_displacement", "capacitance_free", "short_circuit_frequencies")
    for q in solve(scene, ("solid",), names).quantities:
        relative = q.uncertainty / abs(q.value)
        first = relative if q.value.ndim == 0 else relative[0]
        assert first <= scene.accuracy


@pytest.mark.heavy
@pytest.mark.parametrize(
    "overrides",
    [
        ["bimorph.tab_length=1.6mm", "support.kind=clamped"],
        ["bimorph.width=8mm", "support.kind=clamped"],
        ["bimorph.piezo_thickness=0.1mm", "bimorph.length=10mm", "piezo.material=PZT-5A"],
    ],
    ids=["tab", "wide", "thin"],
)
def test_error_bars_cover_finer_meshes(overrides):
    """Away from job J1: the bar of the default mesh covers the finest mesh's value."""
    names = ("static_tip_displacement", "capacitance_free", "short_circuit_frequencies")
    default, finest = (
        solve(load_scene("prototype", [*overrides, *more])[0], ("solid",), names)
        for more in ([], ["mesh.level=5"])
    )
    for q, better in zip(default.quantities, finest.quantities, strict=True):
        # the finest mesh has an error of its own, which its bar bounds
        assert (abs(q.value - better.value) <= q.uncertainty + better.uncertainty).all()
