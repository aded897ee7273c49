"""The section over width and thickness, the clamped plate beside a beam: limits, convergence."""

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Piezo, Shim
from tactgen.tmm.beam import cross_section, plate
from tactgen.tmm.beam.cross_section import section_constants
from tactgen.tmm.beam.laminate import laminate_section
from tactgen.tmm.beam.layerwise import frequencies_with_root
from tactgen.tmm.beam.plate import plate_change

LISTED = (
    "none",
    "brass 0.2 mm; PZT-5A 0.26 mm +x",
    "PZT-5A 0.2 mm +x bare; piezo 0.1 mm +x; shim 0.2 mm; PZT-5H 0.1 mm +x shorted",
    "glue 20 um; PZT-5A 0.2 mm +z pitch 0.5 mm; brass 0.1 mm; PZT-5A 0.1 mm -x",
)


def bimorph(layers, width):
    """Of a width (m)."""
    return Device(bimorph=Bimorph(layers=layers, width=width))


def by_laminate(device, **simplified):
    """EI, K and C of laminate theory."""
    own = laminate_section(device, Beam(), **simplified)
    return np.array([own.EI, own.K, own.C])


def test_a_narrow_strip_is_free_across():
    """No stress across in any layer: laminate theory without what happens across, but for a zone
    of the width at each face of a layer, where one keeps the other from contracting."""
    layers = "brass 0.2 mm; PZT-5A 0.26 mm +x"
    one, other = (
        np.array(section_constants(of)) / by_laminate(of, poisson=False, d32=False) - 1.0
        for of in (bimorph(layers, width) for width in (100e-6, 50e-6))
    )
    of = bimorph(layers, 100e-6)
    wide = by_laminate(of) / by_laminate(of, poisson=False, d32=False) - 1.0
    assert (np.abs(one) < 0.25 * np.abs(wide)).all()
    np.testing.assert_allclose(other, 0.5 * one, atol=2e-3)


@pytest.mark.parametrize("layers", LISTED)
def test_a_wide_plate_differs_from_its_laminate_by_its_edges(layers):
    """By a zone of about a thickness at each edge: half as much of twice the width."""
    wide, twice = (bimorph(layers, width) for width in (20e-3, 40e-3))
    one, other = (np.array(section_constants(of)) / by_laminate(of) - 1.0 for of in (wide, twice))
    assert np.abs(one).max() < 0.04
    np.testing.assert_allclose(other, 0.5 * one, atol=2e-4)


@pytest.mark.parametrize("layers", LISTED)
@pytest.mark.parametrize("width", [0.3e-3, 5e-3])
def test_finer_polynomials_change_little(layers, width, monkeypatch):
    """Not by more than a calibration of listed layers leaves; singular edges converge slowly."""
    found = section_constants(bimorph(layers, width))
    monkeypatch.setattr(cross_section, "_THROUGH", 8)
    monkeypatch.setattr(cross_section, "_ACROSS", 10)
    cross_section._constants.cache_clear()
    np.testing.assert_allclose(found, section_constants(bimorph(layers, width)), rtol=4e-3)


def test_layers_of_one_material_are_one_layer():
    """Cut in two, and seen from the other side, which only turns the sign of the coupling."""
    one = section_constants(bimorph("shim 0.2 mm; PZT-5A 0.2 mm +x", 1e-3))
    cut = section_constants(bimorph("shim 0.1 mm; shim 0.1 mm; PZT-5A 0.2 mm +x", 1e-3))
    turned = section_constants(bimorph("PZT-5A 0.2 mm -x; shim 0.2 mm", 1e-3))
    np.testing.assert_allclose(cut, one, rtol=2e-4)
    np.testing.assert_allclose(turned, np.array(one) * [1.0, -1.0, 1.0], rtol=1e-9)


def test_without_coupling_and_without_a_difference_it_is_a_plain_beam():
    """Of one isotropic material it curves across as it likes, whatever the width."""
    steel = Shim(material="spring steel")
    for width in (0.1e-3, 1e-3, 10e-3):
        thin = Bimorph(piezo_thickness=1e-9, shim_thickness=0.5e-3, width=width)
        device = Device(bimorph=thin, shim=steel, piezo=Piezo(d31=0.0))
        plain = steel.youngs_modulus * width * 0.5e-3**3 / 12.0
        found = section_constants(device)
        assert found[0] == pytest.approx(plain, rel=1e-4)
        assert found[1] == pytest.approx(0.0, abs=1e-12)


def metal(width):
    """Plate 20 mm long of one isotropic metal with ν = 0.3 and hardly any ceramic."""
    shim = Shim(material="brass", poisson_ratio=0.3)
    sizes = Bimorph(width=width, length=20e-3, piezo_thickness=1e-9, shim_thickness=0.1e-3)
    return Device(bimorph=sizes, shim=shim, piezo=Piezo(d31=0.0))


def test_frequencies_of_a_square_are_just_below_published_bounds():
    """ω a² √(ρ/D) of a square cantilever plate: M. Barton (J. Appl. Mech. 18, 1951) has upper
    bounds 3.492 and 21.43, of a few terms (torsion, 8.525 there, is in the other class)."""
    near, (factors, ratios) = 0.2, plate_change(metal(20e-3), 0.2 * 20e-3, 2)
    beam = frequencies_with_root(near, np.exp(factors[1]))
    found = (beam * np.exp(-ratios))[:2] * np.sqrt(1.0 - 0.3**2)
    assert (found < [3.492, 21.43]).all()
    np.testing.assert_allclose(found, [3.492, 21.43], rtol=1e-2)


def test_a_narrow_plate_is_a_beam_but_for_its_root():
    """What the clamp does is of the order of the width over the length; the fifth mode of so
    narrow a strip is known to half a percent."""
    wide, narrow = (
        plate_change(Device(bimorph=Bimorph(width=width, length=20e-3)), 2e-3, 5)
        for width in (0.4e-3, 0.2e-3)
    )
    assert np.abs(wide.factors).max() > 1e-2
    np.testing.assert_allclose(narrow.factors, 0.5 * wide.factors, rtol=0.05, atol=1e-4)
    np.testing.assert_allclose(narrow.ratios, 0.0, atol=5e-3)


@pytest.mark.parametrize("width", [0.5e-3, 4e-3, 25e-3])
def test_finer_polynomials_along_change_little(width, monkeypatch):
    """The root's factors and the ratios by less than 2e-3, of which statics have a part."""
    device, root = Device(bimorph=Bimorph(width=width, length=20e-3)), 4e-3
    found = plate_change(device, root, 3)
    for name in ("_across", "_points"):
        getattr(plate, name).cache_clear()
    monkeypatch.setattr(plate, "_ALONG", 22)
    monkeypatch.setattr(plate, "_ACROSS", 7)
    finer = plate_change(device, root, 3)
    for name in ("_across", "_points"):
        getattr(plate, name).cache_clear()
    np.testing.assert_allclose(found.factors, finer.factors, atol=2e-3)
    np.testing.assert_allclose(found.ratios, finer.ratios, atol=2e-3)
