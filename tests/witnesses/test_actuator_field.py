"""NGSolve solves the field of fresh normal actuators: both bars cover, at every current."""

import secrets

import numpy as np
import pytest

from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.errors import InputError
from tactgen.geometry.reluctance.section_grid import actuator_regions
from tactgen.validation.evidence.random_devices import ACTUATOR
from tactgen.validation.evidence.random_devices import overrides as random_overrides
from tactgen.validation.scene.load import load_scene

VALUES = ("flux_linkage", "coenergy", "force")
#: Triangles at the corners of iron (mm): between these lies what is left beyond the finer ones.
CORNERS = (0.02, 0.005)
#: Error of the witness's slope over a hundredth of the gap, relative: its square, at worst.
SLOPE = 1e-4
#: Ampere-turns: where iron is linear, about those of the paper's 130 mA, and deep in saturation.
TURNS_BY_CURRENT = (5.0, 70.0, 300.0)
#: Devices; each costs the witness a minute.
_COUNT = 2
#: Far end of a magnetisation curve's straight part (T).
_BEYOND = 50.0


def bezier(curve):
    """Return the breaks of H(B) and the control points of its cubics."""
    breaks = np.append(curve.flux_density, _BEYOND)
    low, high = breaks[:-1], breaks[1:]
    third = (high - low) / 3.0
    # the slope may jump at the table's end: that of each piece is taken from inside
    after = curve.field_strength(low) + third * curve.slope(low)
    before = curve.field_strength(high) - third * curve.slope(np.nextafter(high, 0.0))
    inner = np.stack([after, before, curve.field_strength(high)], axis=1)
    return breaks.tolist(), [0.0, *inner.ravel().tolist()]


def job(device, currents, corner):
    knots, controls = bezier(magnetisation_curve(device.steel))
    parts = [
        {"radii": [*r.radii], "heights": [*r.heights], "turns": r.turns, "moves": r.moves}
        for r in actuator_regions(device, device.gap)
    ]
    return {
        "parts": parts, "gap": device.gap, "currents": currents, "knots": knots,
        "controls": controls, "corner": corner,
    }  # fmt: skip


def drawn_device(rng):
    """Return the overrides of a device whose parts fit and whose iron saturates, and it."""
    while True:
        overrides = [*random_overrides(rng, ACTUATOR), "steel.curve=team20"]
        try:
            device = load_scene("reluctance", overrides)[0].device
            actuator_regions(device, device.gap)
        except InputError:
            continue
        return overrides, device


@pytest.mark.heavy
def test_fresh_actuators(witness):
    """Flux linkage, co-energy and pull at three currents; the seed is drawn anew and shown."""
    seed = secrets.randbits(32)
    print(f"seed {seed}")
    rng = np.random.default_rng(seed)
    for _ in range(_COUNT):
        drawn, device = drawn_device(rng)
        currents = [product / device.coil.turns for product in TURNS_BY_CURRENT]
        coarse, finer = (
            witness("ngsolve", "ngsolve_actuator", job(device, currents, corner))
            for corner in CORNERS
        )
        for at, current in enumerate(currents):
            own = solve_point(device, current)
            for name in VALUES:
                value, right = getattr(own, name), finer[name][at]
                bar = abs(right - coarse[name][at]) + SLOPE * abs(right) * (name == "force")
                apart, both = abs(value - right), getattr(own.errors, name) + bar
                print(f"{name} {current:.4g} A: {apart / right:.1e} of {both / right:.1e}")
                assert apart <= both, (name, current, drawn)


def test_the_curve_is_handed_over_whole():
    """Its cubics by their Bézier points are itself, beyond the table's end too."""
    from scipy.interpolate import BPoly

    curve = magnetisation_curve(load_scene("reluctance", [])[0].device.steel)
    breaks, controls = bezier(curve)
    pieces = np.array([controls[3 * i : 3 * i + 4] for i in range(len(breaks) - 1)])
    b = np.linspace(0.0, 4.0, 1000)
    np.testing.assert_allclose(
        BPoly(pieces.T, np.array(breaks))(b), curve.field_strength(b), rtol=1e-12
    )
