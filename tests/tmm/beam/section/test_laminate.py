"""Laminate theory against a numerical through-thickness solution, and its place between models."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Piezo, Shim
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.sections import laminate_section, section


def by_quadrature(device):
    """Curvatures and charge of the layered plate from its energy, field unknown per layer.

    Unknowns: both curvatures and the electric displacement of each ceramic layer; the
    enthalpy is integrated by Gauss points and made stationary at 1 V.
    """
    b, c = device.bimorph, device.piezo.ceramic()
    plane = np.linalg.inv(c.s[:2, :2])
    e = c.d[2, :2] @ plane * b.poling_sign
    eps = c.eps_t[2, 2] - c.d[2, :2] @ plane @ c.d[2, :2]
    shim = device.shim
    across = shim.transverse_modulus or 2 * (1 + shim.poisson_ratio) * shim.shear_modulus
    shim_s = np.array(
        [
            [1 / shim.youngs_modulus, -shim.poisson_ratio / shim.youngs_modulus],
            [-shim.poisson_ratio / shim.youngs_modulus, 1 / across],
        ]
    )
    points, weights = np.polynomial.legendre.leggauss(4)
    h, hp = b.shim_thickness, b.piezo_thickness
    matrix, right = np.zeros((4, 4)), np.zeros(4)
    layers = [(-h / 2, h / 2, None), (h / 2, h / 2 + hp, 2), (-h / 2 - hp, -h / 2, 3)]
    for low, high, unknown in layers:
        for x, w in zip(points, weights, strict=True):
            at, weight = (low + high) / 2 + x * (high - low) / 2, w * (high - low) / 2
            if unknown is None:
                matrix[:2, :2] += weight * at**2 * np.linalg.inv(shim_s)
                continue
            # E = (D - e·x κ)/eps; internal energy ½ S c S + ½ eps E²
            row = np.zeros(4)
            row[:2], row[unknown] = -e * at / eps, 1.0 / eps
            matrix[:2, :2] += weight * at**2 * plane
            matrix += weight * eps * np.outer(row, row)
        if unknown is not None:
            # the layer's voltage drop against D: outer face at +1 V, shim at 0
            right[unknown] = -1.0 if low > 0 else 1.0
    solution = np.linalg.solve(matrix, right)
    area = b.width * b.length
    charge = area * (-solution[2] + solution[3])
    return 0.5 * solution[0] * b.length**2, charge


@pytest.mark.parametrize(
    "device",
    [
        Device(),
        Device(piezo=Piezo(material="PZT-5H"), bimorph=Bimorph(poling="+x")),
        Device(shim=Shim(transverse_modulus=140e9), bimorph=Bimorph(shim_thickness=0.1e-3)),
    ],
    ids=["paper", "PZT-5H", "thin stiff shim"],
)
def test_closed_form_equals_quadrature(device):
    """The closed form is the stationary point of the layered plate's energy."""
    deflection, charge = by_quadrature(device)
    plate, length = laminate_section(device, Beam()), device.bimorph.length
    curvature = -plate.K / plate.EI
    assert abs(0.5 * curvature * length**2) == pytest.approx(abs(deflection), rel=1e-10)
    capacitance = (plate.C + plate.K**2 / plate.EI) * length
    assert capacitance == pytest.approx(charge, rel=1e-10)


def test_sign_follows_the_poling():
    """Poled along -x the tip moves towards +x, as in the beam models."""
    plain = laminate_section(Device(), Beam())
    turned = laminate_section(Device(bimorph=Bimorph(poling="+x")), Beam())
    assert -plain.K / plain.EI > 0.0
    assert turned.K == -plain.K


def test_without_its_additions_it_is_the_beam():
    """Uniform field, no Poisson effect, no d32: the constants of the beam models."""
    device = Device(bimorph=Bimorph(poling="+x"))
    beam = section(Piece("bimorph", 20e-3), device, Beam(), lossy=False)
    plain = laminate_section(device, Beam(), poisson=False, d32=False, varying_field=False)
    for name in ("EI", "GA", "K", "C", "m", "rhoI"):
        assert getattr(plain, name) == pytest.approx(getattr(beam, name), rel=1e-14)


def test_field_variation_stiffens_each_layer_about_its_middle():
    """With d31 alone the layers' own bending is stiffened by 1/(1 - k31^2), nothing else."""
    device = Device()
    plain, varying = (
        laminate_section(device, Beam(), poisson=False, d32=False, varying_field=on)
        for on in (False, True)
    )
    piezo, b = device.piezo, device.bimorph
    k2 = piezo.d31**2 / (piezo.s11 * piezo.eps33 * EPS0)
    own = 2.0 * b.width * b.piezo_thickness**3 / (12.0 * piezo.s11)
    stiffer = varying.EI - plain.EI
    assert stiffer == pytest.approx(own * k2 / (1.0 - k2), rel=1e-11)
    assert pytest.approx([plain.K, plain.C], rel=1e-14) == [varying.K, varying.C]


def test_glue_between_the_layers_is_refused():
    """Laminate theory has three layers here; glue is named with the remedy."""
    with pytest.raises(InputError, match=r"bimorph\.glue_thickness.*set it to 0 m"):
        laminate_section(Device(bimorph=Bimorph(glue_thickness=10e-6)), Beam())
