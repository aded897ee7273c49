"""How far beam theory is from the solid, as told without a solid: it holds what the solid says."""

import random

import pytest

from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.sections import laminate_section
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph.beam_theory_error import (
    end_share,
    expected_differences,
    stubby_warning,
)
from tactgen.validation.models.bimorph.beam_values import beam_values
from tactgen.validation.models.bimorph.bridge.causes import BRIDGED
from tactgen.validation.models.bimorph.bridge.solid_values import SolidCase, solve_solid
from tactgen.validation.scene.scene import load_scene

CLAMPED = ["support.kind=clamped", "load.kind=none"]
BRASS = [
    "shim.youngs_modulus=105GPa", "shim.shear_modulus=39GPa", "shim.poisson_ratio=0.34",
    "shim.density=8500kg/m^3",
]  # fmt: skip


def sized(layers, thicknesses, widths, more=()):
    """Return a clamped bimorph of layers (piezo, shim, in mm), its sizes in thicknesses."""
    piezo, shim = layers
    thickness = 2 * piezo + shim
    sizes = [
        f"bimorph.piezo_thickness={piezo}mm", f"bimorph.shim_thickness={shim}mm",
        f"bimorph.length={thicknesses * thickness}mm", f"bimorph.width={widths * thickness}mm",
    ]  # fmt: skip
    return load_scene("paper", [*CLAMPED, *sizes, *more])[0]


def assert_within(scene):
    beam, solid = beam_values(scene), solve_solid(SolidCase(scene)).values
    bands = expected_differences(scene)
    assert len(bands) == 3
    for name, band in bands.items():
        difference = getattr(beam, BRIDGED[name]) / getattr(solid, BRIDGED[name]) - 1.0
        # the divisions of this level are right to 3e-3 on such bimorphs
        assert band.low - 3e-3 <= difference <= band.high + 3e-3, (name, scene.bimorph)


@pytest.mark.parametrize(
    ("thicknesses", "widths", "more"),
    [(26, 2.7, []), (5, 0.5, []), (10, 6, ["piezo.material=PZT-5H", *BRASS])],
)
def test_the_band_holds_what_the_solid_says(thicknesses, widths, more):
    """The paper's section, a stubby strip, a plate of other layers."""
    assert_within(sized((0.26, 0.25), thicknesses, widths, more))


@pytest.mark.heavy
def test_the_band_holds_over_many_bimorphs():
    """Sixty at random, others than it was found by, of three ceramics and two shims."""
    chance = random.Random(4)
    for _ in range(60):
        more = [f"piezo.material={chance.choice(['M1876', 'PZT-5H', 'PZT-5A'])}"]
        more += BRASS if chance.random() < 0.5 else []
        layers = chance.uniform(0.1, 0.5), chance.uniform(0.05, 0.5)
        long, wide = 2 * 20 ** chance.random(), 0.5 * 20 ** chance.random()
        assert_within(sized(layers, long, wide, more))


def test_a_bimorph_shorter_than_thick_is_no_beam():
    """No one-dimensional model answers; a little longer, each does, and says how far it is off."""
    scene, _ = load_scene("paper", [*CLAMPED, "bimorph.length=1um"])
    for model in ("lumped", "tmm", "beam"):
        with pytest.raises(InputError, match=r"length = 0.001 mm .*0.77 mm: that is no beam"):
            solve(scene, (model,), ("static_tip_displacement",))
    scene, _ = load_scene("paper", [*CLAMPED, "bimorph.length=2mm"])
    found = solve(scene, ("lumped", "tmm"), ("static_tip_displacement",))
    (warning,) = (w for w in found.warnings if "thicknesses" in w)  # said once, not by each model
    assert "2.6 thicknesses" in warning
    assert f"{100 * end_share(scene.bimorph):.0f} % off" in warning


@pytest.mark.parametrize("name", ["paper", "prototype", "j1", "bimorph_on_rod"])
def test_slender_ones_are_not_warned_of(name):
    """The built-in bimorphs."""
    assert stubby_warning(load_scene(name)[0]) == ""


def test_layers_of_a_taper_or_with_glue_count_as_plain_ones():
    """The band is about the layers; on a rod, where the joint decides, there is none."""
    plain, _ = load_scene("paper", CLAMPED)
    taper = "bimorph.width_profile=0 mm: 2.1 mm, 20 mm: 1 mm"
    for more in ([taper], ["bimorph.glue_thickness=20 um"]):
        other, _ = load_scene("paper", [*CLAMPED, *more])
        for name, band in expected_differences(other).items():
            near = expected_differences(plain)[name]
            assert (band.low, band.high) == pytest.approx((near.low, near.high), abs=2e-3)
    assert expected_differences(load_scene("bimorph_on_rod")[0]) == {}


def test_a_band_holds_no_difference_and_that_of_the_plate():
    """From the strip to the plate, whichever is larger, with what the ends may do besides."""
    scene, _ = load_scene("j1")
    ends = end_share(scene.bimorph)
    strip = beam_values(scene)
    plate = beam_values(scene, laminate_section(scene.device, scene.beam))
    found = expected_differences(scene)
    for name, narrow, wide in (
        ("static_tip_displacement", strip.deflection, plate.deflection),
        ("short_circuit_frequencies", strip.first_frequency, plate.first_frequency),
        ("capacitance_free", strip.capacitance, plate.capacitance),
    ):
        both = sorted((0.0, narrow / wide - 1.0))
        assert (found[name].low, found[name].high) == pytest.approx(
            (both[0] - ends, both[1] + ends)
        )
