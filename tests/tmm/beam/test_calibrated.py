"""Calibrated sections: limits, scaling, and what a port matrix must keep."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.fem.piezo.ports import direct_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import calibrated_row, calibrated_section, calibration_fit, transfer_matrix
from tactgen.tmm.beam.laminate import laminate_section
from tactgen.tmm.ports.multiport import BIMORPH
from tactgen.validation.scene.load import load_scene


def scene(*overrides):
    return load_scene("prototype", ["support.kind=clamped", "load.kind=none", *overrides])[0]


def solved(of, frequencies):
    factors = calibrated_section.section_factors(of.device, of.beam)
    row = calibrated_row.sections(of.device, of.support, of.beam, factors, lossy=False)
    return calibrated_row.multiport(row, factors, frequencies), factors


def sized(scale, *more):
    """Return the bimorph of the scene in another size."""
    sizes = {"length": 14.0, "width": 2.1, "piezo_thickness": 0.26, "shim_thickness": 0.25}
    return scene(*(f"bimorph.{name}={scale * v}mm" for name, v in sizes.items()), *more)


UNIMORPH = "brass 0.2 mm; glue 0.02 mm; PZT-5A 0.26 mm +x"


def listed(layers, scale=1.0):
    """Return a bimorph of such layers in another size."""
    return sized(scale, f"bimorph.layers={layers}")


@pytest.mark.parametrize(
    ("one", "other", "scale"),
    [
        (sized(1.0), sized(10.0), 10.0),
        (listed(UNIMORPH), listed("brass 2 mm; glue 0.2 mm; PZT-5A 2.6 mm +x", 10), 10.0),
        (listed(UNIMORPH), listed("PZT-5A 0.26 mm -x; glue 0.02 mm; brass 0.2 mm"), 1.0),
    ],
    ids=["by keys", "listed", "upside down"],
)
def test_only_ratios_matter_and_no_side(one, other, scale):
    """Ten times as large, and upside down: the same factors and errors."""
    one, other = (calibrated_section.section_factors(s.device, s.beam) for s in (one, other))
    for name in ("stiffness", "shear", "coupling", "capacitance", "root", "root_coupling"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-9)
    np.testing.assert_allclose(other.errors, one.errors, rtol=1e-9)
    np.testing.assert_allclose(other.knots, one.knots / scale, rtol=1e-9)


def test_keys_that_listed_layers_replace_change_no_error():
    """Glue and thickness profiles of the three layers."""
    listed = f"bimorph.layers={UNIMORPH}"
    replaced = (
        "bimorph.glue_thickness=0.03mm",
        "bimorph.piezo_thickness_profile=0 mm: 0.2 mm, 14 mm: 0.1 mm",
    )
    one, *others = (
        calibrated_section.section_factors(s.device, s.beam)
        for s in (sized(1.0, listed), *(sized(1.0, listed, key) for key in replaced))
    )
    for other in others:
        np.testing.assert_array_equal(other.errors, one.errors)


def test_two_calibrations_of_one_bimorph_agree():
    """Of three layers by their keys and by a list: two fits to two sets of solids."""
    answers, errors = [], []
    layers = "bimorph.layers=piezo 0.26 mm -x; shim 0.25 mm; piezo 0.26 mm -x"
    for s in (sized(1.0), sized(1.0, layers)):
        port, factors = solved(s, np.zeros(1))
        d = port.stiffness[0].real
        flexible = np.linalg.inv(d[2:4, 2:4])  # of the tip, the base being held
        moved = -flexible @ d[2:4, 4]
        answers.append([flexible[0, 0], moved[0], d[4, 4] + d[4, 2:4] @ moved])
        errors.append(factors.errors[:3])
    apart = np.abs(np.divide(*answers) - 1.0)
    assert (apart < np.add(*errors)).all()
    assert (np.add(*errors) < 0.05).all()  # or to agree would say nothing


@pytest.mark.parametrize(
    ("of", "words"),
    [
        (listed("PZT-5A 0.26 mm +x; brass 0.2 mm; PZT-5A 0.26 mm -x"), "hardly bend it"),
        (
            sized(
                1.0,
                "bimorph.layers=shim 0.2 mm; piezo 0.3 mm +x; shim 0.1 mm",
                "bimorph.tab_length=2mm",
            ),
            "lie apart where others end",
        ),
        (load_scene("bimorph_on_rod")[0], "--model cad, which takes both"),
    ],
)
def test_what_no_fit_has_seen_is_refused(of, words):
    with pytest.raises(InputError, match=words):
        calibrated_section.check_known(of.device, of.support)


def test_a_slender_plate_is_its_laminate():
    """Far from ends and edges laminate theory is right."""
    of = scene("bimorph.length=60mm", "bimorph.width=12mm", "bimorph.piezo_thickness=0.2mm")
    factors = calibrated_section.section_factors(of.device, of.beam)
    plate, beam = laminate_section(of.device, of.beam), laminate_section(
        of.device, of.beam, poisson=False, d32=False, varying_field=False
    )  # fmt: skip
    assert factors.stiffness == pytest.approx(plate.EI / beam.EI, rel=0.01)
    assert factors.coupling == pytest.approx(plate.K / beam.K, rel=0.02)


def test_the_port_matrix_is_reciprocal_and_carries_the_mass():
    """Symmetric but for the sign of the charge; slow translation meets the mass, no more."""
    of = sized(1.0)
    port, _ = solved(of, np.array([1.0, 500.0, 3000.0]))
    d = port.stiffness.real
    moving = [BIMORPH.index(p) for p in port.ports if p.name != "voltage"]
    block = d[:, moving][:, :, moving]
    np.testing.assert_allclose(block, block.transpose(0, 2, 1), rtol=1e-8, atol=1e-8)
    section = laminate_section(of.device, of.beam)
    shift = np.array([1.0, 0.0, 1.0, 0.0])
    force = shift @ block[0] @ shift
    assert force == pytest.approx(-section.m * 14e-3 * (2.0 * np.pi) ** 2, rel=1e-4)


def test_beyond_the_range_is_named_and_widened():
    """Stout; glued; a tab of three times the ceramic's length beside the longest one; a taper.

    The higher modes of the long tab are those of a beam of its own, with smaller errors.
    """
    usual, stout, glued, tab, longer, taper = (
        calibrated_section.section_factors(of.device, of.beam)
        for of in (
            sized(1.0), scene("bimorph.length=2.2mm"), sized(1.0, "bimorph.glue_thickness=10um"),
            *(sized(1.0, f"bimorph.tab_length={mm}mm") for mm in (14, 42)),
            sized(1.0, "bimorph.width_profile=0 mm: 2.1 mm, 14 mm: 1 mm"),
        )
    )  # fmt: skip
    assert usual.beyond == tab.beyond == ()
    assert stout.beyond
    assert longer.beyond == ("proportions of the pieces",)
    assert (glued.errors > usual.errors).all()
    at_rest_and_first = [0, 1, 2, 3, 6]
    assert (longer.errors > tab.errors)[at_rest_and_first].all()
    assert np.isnan(taper.errors).all()


def test_a_width_that_no_layer_has_says_nothing():
    """Where all layers state their own."""
    layers = "bimorph.layers=PZT-5A 0.3 mm wide 4 mm +x; brass 0.2 mm wide 6 mm"
    one, other = (
        calibrated_section.section_factors(of.device, of.beam).errors
        for of in (scene(layers, "bimorph.length=20mm", f"bimorph.width={mm}mm") for mm in (2, 9))
    )
    np.testing.assert_allclose(one, other, rtol=1e-9)


@pytest.mark.parametrize(
    ("more", "unknown"),
    [
        (["bimorph.layers=PVDF 0.1 mm +x; shim 0.2 mm"], [0, 1, 2, 3, 6]),
        (["bimorph.layers=PZT-5A 0.3 mm +x; brass 0.3 mm wide 60 mm"], [0, 1, 2, 3, 6]),
        (["bimorph.glue_thickness=20um", "glue.youngs_modulus=50MPa"], [0, 1, 2, 3, 6]),
        (["bimorph.layers=brass 0.2 mm; PZT-5A 0.26 mm from 2 mm to 2.8 mm +x"], [1, 6]),
    ],
    ids=["film", "wide", "soft glue", "short patch"],
)
def test_what_no_fit_has_seen_has_no_error(more, unknown):
    of = sized(1.0, *more)
    errors = calibrated_section.section_factors(of.device, of.beam).errors
    assert np.isnan(errors[unknown]).all()
    assert np.isfinite(errors[0]) == (0 not in unknown)


def patched(end, *more):
    """Brass of 0.2 mm with a ceramic up to a height."""
    layers = f"brass 0.2 mm; PZT-5A 0.2 mm to {end:.9g} mm +x"
    return scene("bimorph.length=20mm", f"bimorph.layers={layers}", "piezo.material=PZT-5A", *more)


def test_a_short_patch_is_known_less_well_than_a_long_one():
    """How far force and voltage move it, its first frequency and its coupling."""
    long, short = (
        calibrated_section.section_factors(of.device, of.beam)
        for of in (patched(16.0), patched(4.0))
    )
    assert short.beyond == long.beyond == ()
    for name in ("compliance", "deflection", "f1", "coupling_factor"):
        place = calibration_fit.ERRORS.index(name)
        assert short.errors[place] > long.errors[place], name


def test_sizes_of_a_row_of_pieces():
    """A patch and a tab by hand; the same of a bimorph twice as large; nothing of a plain one."""
    of = patched(5.0, "bimorph.tab_length=5mm", "bimorph.width=4mm")
    found = np.exp(calibrated_section.step_sizes(of.device, of.beam))
    # driven are 5 of 25 mm above the tab; glue there is none, so the brass is half as thick
    assert found[[0, 1, 2, 4, 5]] == pytest.approx([0.08, 0.8, 0.5, 0.22, 0.2])
    larger = sized(2.0, "bimorph.tab_length=4mm")
    np.testing.assert_allclose(
        calibrated_section.step_sizes(larger.device, larger.beam),
        calibrated_section.step_sizes(sized(1.0, "bimorph.tab_length=2mm").device, larger.beam),
        atol=1e-12,
    )
    plain = calibrated_section.step_sizes(sized(1.0).device, larger.beam)
    assert plain[[2, 3, 5]] == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("width", "young", "shear"), [("6mm", "60GPa", "25GPa"), ("2mm", "30MPa", "10MPa")]
)
def test_losses_are_those_of_the_solid(width, young, shear):
    """Held across at the clamp, and on a soft core that loses most."""
    s = scene(
        "bimorph.length=20mm", f"bimorph.width={width}", "bimorph.piezo_thickness=0.22mm",
        "bimorph.shim_thickness=0.04mm", "piezo.d31=-3.5e-10m/V", "piezo.quality_factor=80",
        "piezo.loss_tangent=0.03", "shim.loss_factor=0.05",
        f"shim.youngs_modulus={young}", f"shim.shear_modulus={shear}",
    )  # fmt: skip
    factors = calibrated_section.section_factors(s.device, s.beam)
    row = calibrated_row.sections(s.device, s.support, s.beam, factors, lossy=True)
    plain = transfer_matrix.multiport(s.device, s.support, s.beam, np.zeros(1), lossy=True)
    mesh = bimorph_bricks(s.device, LEVELS[0])
    solid = direct_multiport(assemble(s.device, mesh, lossy=True), np.zeros(1))
    flexible = [
        np.linalg.inv(port.stiffness[0][2:4, 2:4])[0, 0]
        for port in (calibrated_row.multiport(row, factors, np.zeros(1)), plain, solid)
    ]
    own, beam, right = (-one.imag / one.real for one in flexible)
    # which 19 of 20 bimorphs are within, and all but a few within its double
    assert own == pytest.approx(right, rel=2.0 * factors.damping_error)
    assert beam < 0.9 * right


@pytest.mark.parametrize("layers", ["none", "shim 0.2 mm; piezo 0.26 mm +x"])
def test_materials_of_one_loss_factor_lose_just_that(layers):
    """Bending and shear of all parts alike, without piezoelectricity."""
    s = scene(
        f"bimorph.layers={layers}", "piezo.quality_factor=50", "piezo.d31=0m/V",
        "shim.loss_factor=0.02", "shim.youngs_modulus=50MPa", "shim.shear_modulus=20MPa",
    )  # fmt: skip
    factors = calibrated_section.section_factors(s.device, s.beam)
    for own, _ in calibrated_row.sections(s.device, s.support, s.beam, factors, lossy=True):
        for value in (own.EI, own.GA):
            # a difference, of the third order in a step of 2e-4; rounding of the fit's polynomials
            assert value.imag / value.real == pytest.approx(0.02, rel=1e-5)


def test_the_error_of_losses_is_what_a_softer_piece_makes_of_them():
    """By so much of the whole's compliance as its error is; of one loss factor all over nothing."""
    patch = "shim 0.2 mm; piezo 0.26 mm from 1 mm to 6 mm +x"
    s = scene(f"bimorph.layers={patch}", "shim.loss_factor=0.001", "piezo.quality_factor=20")
    factors = calibrated_section.section_factors(s.device, s.beam)
    row = calibrated_row.sections(s.device, s.support, s.beam, factors, lossy=True)
    beyond = calibrated_row.loss_error(row, factors) - factors.damping_error

    def mean(added=None, share=0.0):
        """Loss factor of the tip's compliance by ∫ (L − x)² / EI dx, one piece's being raised."""
        z = np.cumsum([0.0, *(length for _, length in row)])
        arm = [z[-1] - np.linspace(z[n], z[n + 1], 2001) for n in range(len(row))]
        soft = [-np.trapezoid(a**2, a) / of.EI for a, (of, _) in zip(arm, row, strict=True)]
        if added is not None:
            whole = sum(part.real for part in soft)
            soft[added] *= 1.0 + share * whole / soft[added].real
        return -sum(soft).imag / sum(soft).real

    error, step = factors.errors[0], 1e-6
    moved = [abs(mean(n, step) / mean() - 1.0) / step for n in range(len(row))]
    assert len({round(of.EI.imag / of.EI.real, 9) for of, _ in row}) > 1
    assert beyond == pytest.approx(error * max(moved), rel=1e-4)  # of the step and the integral
    alike = [(replace(of, EI=of.EI.real * (1.0 + 0.02j)), length) for of, length in row]
    assert calibrated_row.loss_error(alike, factors) == pytest.approx(
        factors.damping_error, rel=1e-9
    )
