"""Derivatives of the axisymmetric field on grids that move: identities, bars, and how narrow."""

import pytest

from tactgen.fem.magnetics import two_orders
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.derivatives import by_differences, derivatives
from tactgen.validation.models.reluctance import field, field_derivatives
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.sensitivity import changed_scenes

SETS = ["models=axisymmetric", "accuracy=10%"]
NAMES = ("coenergy", "flux_linkage", "magnetic_force", "inductance")
COARSE, FINER = ((0.0, 0.5),), ((0.0, 0.75),)


@pytest.fixture
def on_grids(own_store, monkeypatch):
    """Return what asks for derivatives on grids of a fineness, whose values are not kept."""

    def asked(keys, refinements, names=NAMES, way=derivatives):
        for module in (field, field_derivatives):
            monkeypatch.setattr(module, "REFINEMENTS", refinements)
        monkeypatch.setenv("TACTGEN_CACHE", str(own_store / str(refinements[0][1])))
        scene, _ = load_scene("reluctance", SETS)
        return way(scene, changed_scenes("reluctance", SETS), "axisymmetric", names, keys, print)

    return asked


def test_force_and_flux_linkage_are_slopes_of_the_co_energy(on_grids):
    """∂W'/∂g is minus the pull, ∂W'/∂i the flux linkage: of one grid, so much better than bars."""
    energy, linkage, force, _ = on_grids(["gap", "coil.current"], COARSE)
    for key, of, sign in (("gap", force, -1.0), ("coil.current", linkage, 1.0)):
        exact = sign * float(of.quantity.value)
        # truncation at 1 %, and of the pull that windings slip through the grid in one of the two
        assert float(energy.slopes[key]) == pytest.approx(exact, rel=1e-3)
        assert abs(float(energy.slopes[key]) - exact) <= energy.bars[key]


def test_where_the_lower_order_stops_hardly_moves_a_bar(on_grids, monkeypatch):
    """Its rounding is no part of the bar, though it stops at 1e-6 of the field."""
    found = on_grids(["gap"], COARSE)
    monkeypatch.setattr(two_orders, "_COARSE", 1e-12)
    again = on_grids(["gap"], ((0.0, 0.501),))  # in another store
    for a, b in zip(found, again, strict=True):
        assert a.bars["gap"] == pytest.approx(float(b.bars["gap"]), rel=0.01), a.quantity.name


#: The edges of head and sleeve are one line.  The flange ends where the rod does, so neither its
#: thickness nor the rod's length can be varied to both sides.
TWO_GRIDS = ("sleeve.outer_radius", "rod.head_radius")
KEYS = (
    "rod.head_thickness",
    *(
        pytest.param(key, marks=pytest.mark.heavy)
        for key in ("sleeve.outer_radius", "coil.length", "rod.head_radius", "gap")
    ),
)


@pytest.mark.parametrize("key", KEYS)
def test_bars_hold_a_finer_grid_and_are_narrow(key, on_grids):
    """A quarter, at most, of what values on separate grids leave open; by one grid a tenth."""
    rough, fine = on_grids([key], COARSE), on_grids([key], FINER)
    wide = on_grids([key], COARSE, way=by_differences)
    share = 0.25 if key in TWO_GRIDS else 0.1
    for a, b, other in zip(rough, fine, wide, strict=True):
        assert abs(a.slopes[key] - b.slopes[key]) <= a.bars[key] + b.bars[key], a.quantity.name
        assert 0.0 < a.bars[key] <= share * other.bars[key], a.quantity.name


def test_bars_of_two_grids_hold_values_on_separate_ones(on_grids):
    """From either side on a grid of its own, where one grid cannot be moved to both."""
    key = TWO_GRIDS[0]
    found, wide = on_grids([key], COARSE), on_grids([key], COARSE, way=by_differences)
    for a, other in zip(found, wide, strict=True):
        apart = abs(a.slopes[key] - other.slopes[key])
        assert apart <= a.bars[key] + other.bars[key], a.quantity.name
        assert 0.0 < a.bars[key] <= 0.25 * other.bars[key], a.quantity.name


@pytest.mark.parametrize(
    ("name", "given"),
    [("magnetic_force", True), ("incremental_inductance", False), ("pull_in_current", False)],
)
def test_what_is_smooth_has_derivatives(name, given):
    scene, _ = load_scene("reluctance", SETS)
    assert field_derivatives.gives_derivatives(scene, name) is given


def test_what_has_no_room_on_one_side_is_refused():
    """The built-in flange ends with its rod: a shorter rod is no device, and the key is named."""
    scene, _ = load_scene("reluctance", SETS)
    with pytest.raises(InputError, match=r"rod.length = 4.69\d* mm ends above the flange's lower"):
        derivatives(
            scene, changed_scenes("reluctance", SETS), "axisymmetric", NAMES, ["rod.length"], print
        )
