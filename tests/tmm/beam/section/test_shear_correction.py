"""The shear correction factor by the section's own shear energy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactgen.geometry.device.parameters import Bimorph, Device, Piezo, Shim
from tactgen.tmm.beam.layerwise import layerwise_beam


def by_quadrature(device, points=20001):
    """Jourawski's shear stress by cumulative sums over the thickness, its energy by a sum."""
    b, piezo, shim, glue = device.bimorph, device.piezo, device.shim, device.glue
    edges = np.cumsum([0.5 * b.shim_thickness, b.glue_thickness, b.piezo_thickness])
    x = (np.arange(points) + 0.5) * edges[-1] / points
    layer = np.searchsorted(edges, x)
    young = np.array([shim.youngs_modulus, glue.youngs_modulus, 1 / piezo.s11])[layer]
    soft = glue.youngs_modulus / (2 * (1 + glue.poisson_ratio))
    shear = np.array([shim.shear_modulus, soft, 1 / piezo.s55])[layer]
    dx = edges[-1] / points
    moment = np.cumsum((young * x * dx)[::-1])[::-1] - 0.5 * young * x * dx
    stiffness = (young * x**2).sum() * dx
    return stiffness**2 / ((moment**2 / shear).sum() * dx) / (shear.sum() * dx)


def test_papers_soft_core():
    """The paper's section, its shim of fibres along z much softer in shear, is near 0.425."""
    assert layerwise_beam(Device()).shear_correction == pytest.approx(0.425, abs=5e-4)  # as printed


@given(
    st.floats(0.02e-3, 1e-3), st.floats(0.02e-3, 1e-3), st.floats(0.0, 0.1e-3),
    st.floats(1e9, 4e11), st.floats(1e8, 2e11),
)  # fmt: skip
def test_closed_form_equals_quadrature(piezo, shim, bond, young, shear):
    """The closed form is the energy of the stress that equilibrium asks for, glue included."""
    device = Device(
        bimorph=Bimorph(piezo_thickness=piezo, shim_thickness=shim, glue_thickness=bond),
        shim=Shim(youngs_modulus=young, shear_modulus=shear),
    )
    found = layerwise_beam(device).shear_correction
    # layers' edges fall inside the sum's intervals, of which the thinnest layer has 300
    assert found == pytest.approx(by_quadrature(device), rel=1e-2)
    # Cauchy-Schwarz: no distribution of stress stores less than the uniform strain
    assert 0.0 < found <= 1.0


def test_layers_have_it_from_either_side():
    """A list of unequal layers upside down; two of one material, and three, have Reissner's 5/6."""
    there, back = (
        layerwise_beam(Device(bimorph=Bimorph(layers=layers))).shear_correction
        for layers in (
            "brass 0.2 mm; glue 0.02 mm; PZT-5A 0.3 mm +x",
            "PZT-5A 0.3 mm +x; glue 0.02 mm; brass 0.2 mm",
        )
    )
    assert there == pytest.approx(back, rel=1e-12)
    two = Device(bimorph=Bimorph(layers="PZT-5A 0.1 mm +x; PZT-5A 0.3 mm +x"))
    three = Device(shim=Shim(youngs_modulus=1 / Piezo().s11, shear_modulus=1 / Piezo().s55))
    for device in (two, three):
        assert layerwise_beam(device).shear_correction == pytest.approx(5.0 / 6.0, rel=1e-14)
