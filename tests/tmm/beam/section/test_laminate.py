"""Laminate theory against a numerical through-thickness solution, and its place between models."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.segments import Piece, stack
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Piezo, Shim
from tactgen.tmm.beam.laminate import laminate_section
from tactgen.tmm.beam.sections import section


def by_quadrature(device):
    """Curvature along the length and charge per area of the layered plate from its energy, at 1 V.

    Unknowns: both strains, both curvatures and the electric displacement of each ceramic with
    electrodes; the energy is integrated by Gauss points and made stationary.
    """
    layers = stack(Piece("bimorph", device.bimorph.length), device)
    charged = [layer for layer in layers if isinstance(layer.material, Piezo) and layer.electrodes]
    points, weights = np.polynomial.legendre.leggauss(4)
    right = np.zeros(4 + len(charged))
    matrix = np.zeros((right.size, right.size))
    for layer in layers:
        of, t = layer.material, layer.thickness
        compliance = of.ceramic().s[:2, :2] if isinstance(of, Piezo) else across(of)
        plane = np.linalg.inv(compliance)
        for x, w in zip(points, weights, strict=True):
            at, weight = layer.low + 0.5 * t * (1.0 + x), 0.5 * t * w
            strain = np.zeros((2, right.size))
            strain[:, :2], strain[:, 2:4] = np.eye(2), at * np.eye(2)
            matrix += weight * strain.T @ plane @ strain
            if not isinstance(of, Piezo):
                continue
            # E = (D - e S)/eps; internal energy 1/2 S c S + 1/2 eps E^2
            d = of.ceramic().d[2, :2]
            e, eps = layer.poling * d @ plane, of.ceramic().eps_t[2, 2] - d @ plane @ d
            row = -e @ strain / eps
            if layer in charged:
                row[4 + charged.index(layer)] = 1.0 / eps
            matrix += weight * eps * np.outer(row, row)
    for number, layer in enumerate(charged):
        right[4 + number] = -layer.hot
    solution = np.linalg.solve(matrix, right)
    return solution[2], solution[4:] @ right[4:]


def across(of):
    """In-plane compliance (2, 2) of what is not piezoelectric."""
    young, nu = of.youngs_modulus, of.poisson_ratio
    other = getattr(of, "transverse_modulus", None)
    other = other or (2 * (1 + nu) * of.shear_modulus if isinstance(of, Shim) else young)
    return np.array([[1 / young, -nu / young], [-nu / young, 1 / other]])


@pytest.mark.parametrize(
    "device",
    [
        Device(),
        Device(shim=Shim(transverse_modulus=140e9), bimorph=Bimorph(shim_thickness=0.1e-3)),
        Device(bimorph=Bimorph(glue_thickness=20e-6)),
        Device(bimorph=Bimorph(layers="brass 0.2 mm; PZT-5A 0.26 mm +x")),
        Device(bimorph=Bimorph(
            layers="PZT-5H 0.1 mm -x; titanium 0.1 mm; glue 0.02 mm; PZT-5A 0.2 mm -x bare; "
            "glue 0.01 mm; PZT-5A 0.1 mm +x; PZT-5H 0.1 mm +x shorted"
        )),
    ],
    ids=["paper", "thin stiff shim", "glued", "unimorph", "seven layers"],
)  # fmt: skip
def test_closed_form_equals_quadrature(device):
    """The closed form is the stationary point of the layered plate's energy."""
    curvature, charge = by_quadrature(device)
    plate, width = laminate_section(device, Beam()), device.bimorph.width
    assert pytest.approx(curvature, rel=1e-10) == plate.K / plate.EI
    assert (plate.C + plate.K**2 / plate.EI) / width == pytest.approx(charge, rel=1e-10)


def test_without_its_additions_it_is_the_beam():
    """Uniform field, no Poisson effect, no d32: the constants of the beam models."""
    device = Device(bimorph=Bimorph(poling="+x"))
    beam = section(Piece("bimorph", 20e-3), device, Beam(), lossy=False)
    plain = laminate_section(device, Beam(), poisson=False, d32=False, varying_field=False)
    for name in ("EI", "GA", "K", "C", "m", "rhoI"):
        assert getattr(plain, name) == pytest.approx(getattr(beam, name), rel=1e-14)
