"""Layerwise theory of a cantilever: its limits, a sandwich in closed form, a solid, and the
shear correction factor by the section's own shear energy.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import static_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks
from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Piezo, Shim
from tactgen.tmm.beam.dimensionless_groups import laminate
from tactgen.tmm.beam.layerwise import layerwise_beam, layerwise_change
from tactgen.tmm.beam.sections import section
from tactgen.validation.scene.load import load_scene

LISTS = (
    "none",
    "brass 0.2 mm; glue 0.02 mm; PZT-5A 0.3 mm +x",
    "PZT-5A 0.1 mm +x; PZT-5A 0.3 mm -x",
)


@pytest.mark.parametrize("layers", LISTS)
def test_without_modes_that_decay_it_is_beam_theory(layers):
    """Of the section that the beam models have, of any layers."""
    device = Device(bimorph=Bimorph(layers=layers))
    own = layerwise_beam(device)
    length = device.bimorph.length
    beam = section(Piece("bimorph", length), device, Beam(), lossy=False)
    slide = 1.0 / (own.shear_correction * own.rigidity)
    expected = [
        length**3 / 3.0 / beam.EI + length * slide, length**2 / 2.0 / beam.EI, length / beam.EI,
        length**2 / 2.0 * beam.K / beam.EI, length * beam.K / beam.EI,
    ]  # fmt: skip
    # rounding of an eigenproblem of ten unknowns whose entries span six decades
    np.testing.assert_allclose(np.abs(own.beam_statics(length)), np.abs(expected), rtol=1e-10)


def test_long_beams_and_waves_are_beam_theory():
    """What decays from the ends and varies slowly along z counts for nothing."""
    own = layerwise_beam(Device())
    # the loaded face turns a little more than the section: 3e-6 of what two metres turn
    np.testing.assert_allclose(own.statics(2.0) / own.beam_statics(2.0), 1.0, atol=1e-5)
    k = np.array([1.0])
    assert own.flexibility(k) == pytest.approx(own.bending / k**2 + own.shear, rel=1e-9)


@pytest.mark.parametrize("shear", [1e5, 1e7, 1e9])
def test_allens_sandwich(shear):
    """Thick faces that do not shear, on a core that does nothing else (Allen 1969)."""
    face, core, length, width = 0.3e-3, 0.4e-3, 20e-3, 2e-3
    device = Device(
        bimorph=Bimorph(piezo_thickness=face, shim_thickness=core, length=length, width=width),
        shim=Shim(youngs_modulus=1e2, shear_modulus=shear), piezo=Piezo(s55=1e-15),
    )  # fmt: skip
    young = width / device.piezo.s11
    apart = face + core
    of_faces, whole = young * face**3 / 6.0, young * face * (face**2 / 6.0 + apart**2 / 2.0)
    rigid = shear * width * apart**2 / core
    b = np.sqrt(rigid * whole / of_faces / (whole - of_faces))
    slip = (1.0 - of_faces / whole) ** 2 / rigid * (length - np.tanh(b * length) / b)
    found = layerwise_beam(device).statics(length)[0]
    # rounding: the moduli in shear are up to ten decades apart
    assert found == pytest.approx(length**3 / 3.0 / whole + slip, rel=1e-6)


def test_a_soft_core_is_that_of_the_solid():
    """Narrow, on a core of 20 MPa between ceramics of 60 GPa, where beam theory is a fifth off."""
    soft = ["shim.youngs_modulus=20MPa", "shim.shear_modulus=7.6923MPa", "bimorph.width=0.5mm"]
    scene = load_scene("j1", soft)[0]
    device = scene.device
    solid = assemble(device, bimorph_bricks(device, LEVELS[0]), lossy=False)
    compliance = np.linalg.inv(static_multiport(solid).stiffness[0].real[2:4, 2:4])[0, 0]
    own, length = layerwise_beam(device, varying_field=True), device.bimorph.length
    # within what a width of 0.65 thicknesses and a clamp that holds it across are worth
    assert own.statics(length)[0] == pytest.approx(compliance, rel=5e-3)
    assert own.beam_statics(length)[0] > 1.15 * compliance
    frequencies = [mode.frequency for mode in natural_modes(solid, scene.ends, 2)]
    found = layerwise_change(device, laminate(device), 1e-3).frequencies
    np.testing.assert_allclose(found[:2], frequencies, rtol=5e-3)


def test_factors_give_a_beam_the_tips_compliance():
    """A section with a zone at its clamp moves as far as layerwise theory says."""
    device = Device(shim=Shim(youngs_modulus=50e6, shear_modulus=20e6))
    plate, length, root = laminate(device), device.bimorph.length, 2e-3
    _, less, shear, coupling, *_ = np.exp(layerwise_change(device, plate, root).factors)
    far = (length - root) ** 3
    bend = (less * (length**3 - far) + far) / 3.0 / plate.EI
    beam = length**3 / 3.0 / plate.EI + length / plate.GA
    own = layerwise_beam(device, varying_field=True)
    ratio = own.statics(length) / own.beam_statics(length)
    assert (bend + shear * length / plate.GA) / beam == pytest.approx(ratio[0], rel=1e-12)
    assert coupling == pytest.approx(ratio[3], rel=1e-12)


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
