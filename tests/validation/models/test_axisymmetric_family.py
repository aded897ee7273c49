"""Many points of the axisymmetric model from one table, against points solved alone."""

import numpy as np
import pytest

from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.families import find_families
from tactgen.validation.models.reluctance import field
from tactgen.validation.models.reluctance.family import axisymmetric as family
from tactgen.validation.models.reluctance.family import field_tables
from tactgen.validation.scene.nearby import value_of, with_values
from tactgen.validation.scene.scene import load_scene

NAMES = ("magnetic_force", "flux_linkage", "coenergy", "inductance", "incremental_inductance")
SETS = ["models=axisymmetric", "accuracy=10%"]


@pytest.fixture(autouse=True)
def coarse(own_store, monkeypatch):
    """One coarse grid for both ways, in a store whose keys do not know how coarse."""
    for module in (field, field_tables):
        monkeypatch.setattr(module, "REFINEMENTS", ((0.0, 0.5),))
    monkeypatch.setattr(family, "_PLACES", (8, 3))  # nine points are enough for a table


def test_edges_that_pass_another_divide_the_range():
    """The head grows past the sleeve: two tables meet where both are as wide."""
    scene, _ = load_scene("reluctance", SETS)
    found = family.point_family(scene, {"rod.head_radius": (1.12e-3, 1.17e-3)})
    assert [t.ranges["rod.head_radius"] for t in found.tables] == [
        pytest.approx(ends) for ends in ((1.12e-3, 1.15e-3), (1.15e-3, 1.17e-3))
    ]
    sides = found.read({"rod.head_radius": 1.15e-3 + np.array([-1e-12, 1e-12])})
    for name, (value, bar) in sides.items():
        assert abs(value[1] - value[0]) <= bar.sum(), name
        assert value[0] != value[1], name  # they are two


def test_what_one_grid_does_not_reach_is_answered_alone():
    """A collar that comes; and numbers that are too many."""
    scene, _ = load_scene("reluctance", SETS)
    with pytest.raises(InputError, match="a part comes or goes"):
        family.reduce_family(scene, {"sleeve.inner_radius": (0.96e-3, 1e-3)}, NAMES, 9)
    ranges = dict.fromkeys(("gap", "rod.radius", "coil.current"), (1.0, 2.0))
    with pytest.raises(InputError, match="3 keys vary together"):
        family.reduce_family(scene, ranges, NAMES, 9)


@pytest.mark.parametrize(
    ("key", "own"),
    [("rod.flange_radius", True), ("sleeve.length", True), ("coil.turns", True), ("gap", True),
     ("coil.current", True), ("accuracy", False), ("rod.density", False),
     ("spring.stiffness", False), ("steel.curve", False)],
)  # fmt: skip
def test_numbers_that_a_point_reads_vary_within_a_family(key, own):
    scene, _ = load_scene("reluctance", SETS)
    assert family.is_family_key(scene, key) is own


def test_only_points_are_tabled():
    """Currents of the stroke are no smooth functions: another place of the stroke may decide."""
    scene, _ = load_scene("reluctance", SETS)
    assert find_families("axisymmetric", [scene] * 20, ("pull_in_current",)) == []


#: Sizes that may be a little larger or smaller without parts meeting.
SIZES = (
    "rod.head_radius", "rod.head_thickness", "rod.flange_radius", "rod.flange_thickness",
    "rod.flange_position", "rod.length", "coil.outer_radius", "coil.length", "coil.turns",
    "sleeve.length", "gap", "coil.current",
)  # fmt: skip


@pytest.mark.heavy
@pytest.mark.parametrize("seed", range(20))
def test_bars_hold_a_better_field_anywhere(seed, monkeypatch):
    """Size, range, current and gap by chance, against a field of one order more on finer grids."""
    rng = np.random.default_rng(seed)
    monkeypatch.setattr(field_tables, "REFINEMENTS", ((0.0, 1.0),))
    key = SIZES[int(rng.integers(len(SIZES)))]
    middle = {"gap": rng.uniform(0.05e-3, 0.22e-3), "coil.current": rng.uniform(0.02, 0.3)}
    there = [f"gap={middle['gap']!r} m", f"coil.current={middle['coil.current']!r} A"]
    scene, _ = load_scene("reluctance", [*SETS, *there])
    value = float(value_of(scene, key))
    low = value * (1.0 - rng.uniform(0.01, 0.08))
    # the coil has 40 um to the flange, the sleeve is as long as it must be
    high = value * (1.0 + rng.uniform(0.001, 0.008))
    found = family.point_family(scene, {key: (low, high)})
    for asked in rng.uniform(low, high, 2):
        given = found.read({key: np.array([asked])})
        exact = with_values(scene, {key: float(asked)})
        point = solve_point(exact.device, exact.coil.current, exact.gap, order=5, refinement=1.5)
        for name, (near, bar) in given.items():
            off = abs(float(near[0]) - getattr(point, name))
            assert off <= float(bar[0]) + getattr(point.errors, name), (key, asked, name)


def test_a_range_beyond_what_is_kept_is_tabled_together_with_it(monkeypatch):
    """So that the one kept entry serves both; a range within it is tabled no more."""
    made = []

    class Held:
        ranges = {"gap": (1e-4, 2e-4)}  # noqa: RUF012

        def covers(self, wanted):
            low, high = wanted["gap"]
            return self.ranges["gap"][0] <= low and high <= self.ranges["gap"][1]

    def kept(*given, serves, **_):
        held = Held()
        return held if serves(held) else given[3]()

    monkeypatch.setattr(family, "kept", kept)
    monkeypatch.setattr(family, "field_tables", lambda _, wanted, announce: made.append(wanted))
    scene, _ = load_scene("reluctance", SETS)
    found = family.point_family(scene, {"gap": (1.2e-4, 1.8e-4)})
    assert (found.ranges, made) == (Held.ranges, [])
    family.point_family(scene, {"gap": (1.5e-4, 2.5e-4)})
    assert made == [{"gap": (1e-4, 2.5e-4)}]
