"""Each kind of error bar holds the answer, and would not if it were three times narrower.

A bar is a promise: too narrow it is broken, absurdly wide it says nothing.  The cases are
those in which the bar is put to the test: the largest share of it that an error takes is
stated, with the reason why it is as large as that.
"""

from functools import cache

import numpy as np
import pytest

from tactgen.fem.magnetics import axisymmetric as actuator
from tactgen.fem.magnetics.actuator_3d import solve_solid
from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.fem.magnetics.axisymmetric_force import Eggshell, stress_size
from tactgen.geometry.device.parameters import Device, Steel
from tactgen.geometry.reluctance.sector_tets import Sector
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

DEVICE = Device()
MAGNETIC = ("force", "flux_linkage", "coenergy", "incremental_inductance")


def shares(found, exact):
    """Return the largest share of its bar that each quantity's error takes."""
    pairs = [(q, next(e for e in exact if e.name == q.name)) for q in found]
    return {
        q.name: float(np.max(np.abs(q.value - e.value) / (q.error + e.error))) for q, e in pairs
    }


def solved(model, quantities, *overrides, scene="paper"):
    return solve(load_scene(scene, overrides)[0], (model,), quantities).quantities


def test_beam_elements_bar_follows_their_order():
    """Elements of order five gain 2¹⁰ by halving, and no more than 2⁸ is counted with.

    So the error takes (2⁸ − 1) / (2¹⁰ − 1) / 1.25 = 0.2 of the bar, somewhat more where the gain
    is not yet that of the limit.
    """
    overrides = ("support.kind=clamped", "load.kind=none", "frequency=100 kHz")
    names = ("tip_displacement", "tip_rotation", "blocked_force")
    beam, exact = (solved(model, names, *overrides) for model in ("beam", "tmm"))
    for name, share in shares(beam, exact).items():
        assert 0.19 < share < 0.25, name


@pytest.mark.heavy
def test_beam_elements_rounding():
    """Where rounding is all, errors take a fifth to a half of the bar, seldom more than all of it.

    The bar is twice a mean of distances between evaluations that round differently.
    """
    names = ("short_circuit_frequencies", "open_circuit_frequencies", "static_tip_displacement")
    found = []
    for length in np.linspace(15.0, 30.0, 6):
        common = ("load.kind=none", "modes=1", f"bimorph.length={length} mm")
        beam, exact = (solved(model, names, *common) for model in ("beam", "tmm"))
        found += shares(beam, exact).values()
    assert 0.1 < np.median(found) < 0.6
    assert np.mean(np.array(found) <= 1.0) > 0.9


def test_beam_elements_bar_holds_the_tab():
    """A tab that ends on thin glue: the bar misses the error of what is never halved."""
    names = ("blocked_force", "tip_displacement")
    overrides = ("glue.thickness=1 um", "bimorph.tab_length=4 mm", "load.kind=none")
    high = (*overrides, "frequency=22 kHz")
    beam, exact = (solved(model, names, *high, scene="bimorph_on_rod") for model in ("beam", "tmm"))
    assert all(0.05 < share <= 1.0 for share in shares(beam, exact).values())


@pytest.mark.parametrize("material", ["M1876", "PZT-5A"])
def test_coupling_factor_has_what_two_frequencies_leave_of_it(material):
    """k² = 1 − (f_s/f_o)²: moving both frequencies by their bars moves k by its bar.

    It is taken for small k; the frequencies' own floor of 1e-13 counts once or twice.
    """
    names = ("short_circuit_frequencies", "open_circuit_frequencies", "coupling_factor")
    short, opened, k = solved(
        "tmm", names, f"piezo.material={material}", "load.kind=none", "modes=1"
    )
    share = float(short.error[0] / short.value[0] + opened.error[0] / opened.value[0])
    moved = (1.0 - k.value**2) * share / k.value**2
    assert 0.5 <= k.error / (k.value * moved) <= 1.2


@cache
def order_four(current, gap):
    return solve_point(DEVICE, current, gap, refinement=0.75)


def magnetic_shares(point, exact):
    return {
        name: abs(getattr(point, name) - getattr(exact, name))
        / (getattr(point.errors, name) + getattr(exact.errors, name))
        for name in MAGNETIC
    }


def test_axisymmetric_bars_on_a_coarse_grid():
    """Order 3 on half the lines against order 4: rated, nearly closed and saturated, wide open.

    The change from order 2 to 3 is at least as large as what order 3 leaves.
    """
    found = []
    for current, gap in ((0.13, 0.2e-3), (0.5, 20e-6), (0.02, 0.3e-3)):
        point = solve_point(DEVICE, current, gap, order=3, refinement=0.5)
        found.append(magnetic_shares(point, order_four(current, gap)))
    for name in MAGNETIC:
        assert 1.0 / 3.0 < max(share[name] for share in found) <= 1.0, name


def test_axisymmetric_force_bar_at_a_gap_narrower_than_any_cell():
    """2 µm: the order alone must resolve the corners, and its change is less than what is left.

    The force is that of order 6 on twice the lines, where orders 5 and 6 are 1.2e-4 apart.
    """
    point = solve_point(DEVICE, 0.13, 2e-6, order=3, refinement=0.5)
    assert 0.8 < abs(point.force - 1.43934) / point.errors.force <= 1.0


def test_axisymmetric_bars_where_the_air_ends_early():
    """5 mm of air instead of 60, in saturation: truncation is most of the error and of the bar.

    The force's is that of the co-energy times 8, hardly more than it takes here.
    """
    near, far = (
        solve_point(DEVICE, 0.3, 50e-6, outer_radius=radius, refinement=0.75, any_grid=True)
        for radius in (5e-3, 60e-3)
    )
    share = magnetic_shares(near, far)
    assert 1.0 / 3.0 < share["force"] <= 1.0
    assert 1.0 / 3.0 < share["coenergy"] <= 1.0
    assert max(share.values()) <= 1.0
    assert near.coenergy < far.coenergy


@pytest.mark.parametrize("radius", [None, 6e-3])
def test_axisymmetric_force_bar_where_the_force_cancels(radius):
    """Iron as permeable as air feels no force, whatever part of the grid or of the air is missing.

    The bar is below 1e-3 of the stress on the default air, which gets near to what is missing; the
    early end of the air is told by a bound.
    """
    steel = Steel(curve="linear", relative_permeability=1.0)
    point = solve_point(
        DEVICE.model_copy(update={"steel": steel}), order=3, refinement=2.0, outer_radius=radius
    )
    field = point.solution
    stress = stress_size(field, Eggshell(field.discretisation).weight(field.discretisation))
    assert abs(point.force_eggshell) <= point.errors.force
    assert abs(point.force) <= point.errors.force < (1e-3 if radius is None else 0.1) * stress


def test_axisymmetric_force_bar_has_the_two_routes():
    """The force is no better known than the co-energy, and than virtual work and stress agree."""
    point = order_four(0.02, 0.3e-3)
    assert point.errors.force >= point.errors.coenergy / point.coenergy * point.force
    values = {name: getattr(point, name) for name in (*MAGNETIC, "force_eggshell")}
    apart = values | {"force_eggshell": 1.5 * point.force}
    field = point.solution
    stress = stress_size(field, Eggshell(field.discretisation).weight(field.discretisation))
    routes = actuator._errors(field, apart, point.coarser, stress).force
    agreeing = actuator._errors(field, values, point.coarser, stress).force
    assert agreeing == pytest.approx(point.errors.force, rel=1e-12)
    assert 0.5 * point.force <= routes < 0.5 * point.force + agreeing


def test_solid_coenergy_bar_is_the_enclosure():
    """The vector potential's co-energy is below the exact one, the scalar's above: the bar
    reaches just from one to the other, and the axisymmetric field's lies between them."""
    point = solve_solid(DEVICE, 0.13, 0.2e-3, Sector(refinement=0.4))
    low, high = point.vector.coenergy, point.scalar.coenergy
    bar = point.errors.coenergy
    assert (point.coenergy - bar, point.coenergy + bar) == pytest.approx((low, high), rel=1e-12)
    exact = solve_point(DEVICE, 0.13, 0.2e-3, order=3)
    assert low < exact.coenergy < high
    shells = max(np.ptp(by.forces) for by in (point.vector, point.scalar))
    half = 0.5 * abs(point.vector.forces[0] - point.scalar.forces[0])
    of_energy = (high - low) / (high + low) * point.force
    estimated = max(of_energy, half - of_energy, shells)
    assert estimated <= point.errors.force <= 1.5 * estimated  # with a margin
    share = magnetic_shares(point, exact)
    assert 0.08 < share["force"] <= 0.8
    assert 0.1 < share["flux_linkage"] <= 1.0
