"""The clamped plate beside a beam: published frequencies, limits, convergence."""

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Bimorph, Device, Piezo, Shim
from tactgen.tmm.beam import plate
from tactgen.tmm.beam.layerwise import frequencies_with_root
from tactgen.tmm.beam.plate import plate_change


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


def test_a_narrow_strip_is_a_beam_but_for_its_root():
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
def test_finer_polynomials_change_little(width, monkeypatch):
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
