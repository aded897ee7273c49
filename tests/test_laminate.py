"""Laminate theory against a numerical through-thickness solution, and its place between models."""

import numpy as np
import pytest

from geometry.parameters import Bimorph, Device, Piezo, Shim
from tmm.laminate import static_response


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
    found = static_response(device)
    assert abs(found.tip_displacement) == pytest.approx(abs(deflection), rel=1e-10)
    assert found.capacitance == pytest.approx(charge, rel=1e-10)


def test_sign_follows_the_poling():
    """Poled along -x the tip moves towards +x, as in the beam models."""
    assert static_response(Device()).tip_displacement > 0.0
    turned = static_response(Device(bimorph=Bimorph(poling="+x")))
    assert turned.tip_displacement == -static_response(Device()).tip_displacement
