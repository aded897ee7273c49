"""A device many times larger or smaller is the same device in other units."""

import pytest

from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.geometry.device.parameters import NOMINAL_GAP, Device
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

FACTOR = 1e-2
LENGTHS = ("length", "width", "piezo_thickness", "shim_thickness")


@pytest.mark.usefixtures("coarse_solid")
@pytest.mark.parametrize("model", ["tmm", "beam", "solid"])
def test_bimorph(model):
    """All lengths by a hundredth, s, at the same voltage: deflection as before, frequencies by 1/s,
    capacitance by s, and the coupling factor as before."""
    names = (
        "static_tip_displacement", "short_circuit_frequencies", "capacitance_free",
        "coupling_factor",
    )  # fmt: skip
    small, _ = load_scene("j1", ["mesh.level=2", "modes=2"])
    bimorph = small.bimorph
    larger = bimorph.model_copy(update={n: FACTOR * getattr(bimorph, n) for n in LENGTHS})
    large = small.model_copy(update={"bimorph": larger})
    one, other = (solve(scene, (model,), names).quantities for scene in (small, large))
    for before, after, power in zip(one, other, (0, -1, 1, 0), strict=True):
        # the rounding that the bars tell, which is the solid's at 1e-6
        expected = FACTOR**power * before.value
        assert after.value == pytest.approx(expected, rel=1e-6), before.name


def grown(device, factor):
    """Device with all lengths and the current times a factor; positions count from the head."""

    def group(values, lengths, positions=()):
        new = {name: factor * getattr(values, name) for name in lengths}
        new |= {n: factor * (getattr(values, n) + NOMINAL_GAP) - NOMINAL_GAP for n in positions}
        return values.model_copy(update=new)

    radii = ("inner_radius", "outer_radius", "length")
    rod = ("radius", "head_radius", "head_thickness", "flange_radius", "flange_thickness")
    return Device(
        gap=factor * device.gap,
        rod=group(device.rod, rod, ("flange_position", "length")),
        coil=group(device.coil, (*radii, "current"), ("position",)),
        sleeve=group(device.sleeve, (*radii, "collar_radius", "collar_thickness")),
    )


@pytest.mark.parametrize("factor", [0.1, 100.0])
def test_normal_actuator(factor):
    """The field strength stays, so the force grows as the square, and its bar as the force."""
    one = solve_point(Device(), order=2, any_grid=True)
    other = solve_point(grown(Device(), factor), order=2, any_grid=True)
    # edges are rounded to 1 pm, of the smaller device's clearances of 5 µm 2e-7
    assert other.force == pytest.approx(factor**2 * one.force, rel=1e-6)
    assert other.errors.force / other.force == pytest.approx(one.errors.force / one.force, rel=1e-6)
