"""Section constants of the three layers, the bare shim and the rod."""

import math

import pytest

from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.bimorph import Dimensions
from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Glue, Rod, Shim
from tactgen.tmm.beam.sections import section

NAMES = ("EI", "GA", "m", "rhoI", "K", "C")
BIMORPH = Piece("bimorph", 20e-3)


def test_shim_and_rod_are_textbook_sections():
    """Rectangle b h³/12 with the beam's shear factor; disc π r⁴/4 with Cowper's."""
    device = Device(shim=Shim(youngs_modulus=100e9), rod=Rod(poisson_ratio=0.3))
    shim = section(Piece("shim", 1e-3), device, Beam(shear_correction=0.8), lossy=True)
    assert pytest.approx(100e9 * 2.1e-3 * 0.25e-3**3 / 12) == shim.EI
    assert pytest.approx(0.8 * 5e9 * 2.1e-3 * 0.25e-3) == shim.GA
    disc = section(Piece("cylinder", 1e-3, 0.62e-3), device, Beam(), lossy=True)
    assert pytest.approx(205e9 * math.pi * 0.62e-3**4 / 4) == disc.EI
    # Cowper (1966), solid circle, ν = 0.3: 0.886
    assert disc.GA / (205e9 / 2.6 * math.pi * 0.62e-3**2) == pytest.approx(0.8864, abs=5e-5)
    assert disc.rhoI / disc.m == pytest.approx(0.62e-3**2 / 4)


def test_glue_layer_by_hand():
    """Five layers as a textbook composite: E I about the middle, shears and masses added."""
    b, hs, tg, hp = 2e-3, 0.2e-3, 0.05e-3, 0.3e-3
    device = Device(
        bimorph=Bimorph(width=b, shim_thickness=hs, piezo_thickness=hp, glue_thickness=tg),
        glue=Glue(youngs_modulus=4e9, poisson_ratio=0.25, density=1100.0),
    )
    got = section(BIMORPH, device, Beam(shear_correction=0.8), lossy=False)
    p, s = device.piezo, device.shim

    def inertia(thickness, arm):  # parallel axes, both sides of the middle
        return 2 * (b * thickness**3 / 12 + b * thickness * arm**2)

    glue, piezo = inertia(tg, 0.125e-3), inertia(hp, 0.3e-3)
    core = b * hs**3 / 12
    stiffness = s.youngs_modulus * core + 4e9 * glue + piezo / p.s11
    assert pytest.approx(stiffness, rel=1e-14) == got.EI
    assert got.rhoI == pytest.approx(s.density * core + 1100 * glue + p.density * piezo, rel=1e-14)
    assert got.m == pytest.approx(
        b * (s.density * hs + 2 * (1100 * tg + p.density * hp)), rel=1e-14
    )
    shear = s.shear_modulus * hs + 2 * (1.6e9 * tg + hp / p.s55)
    assert pytest.approx(0.8 * b * shear, rel=1e-14) == got.GA
    # each layer's force per volt, d31/s11 b, on a lever from middle to middle
    assert abs(got.K) == pytest.approx(2 * abs(p.d31) / p.s11 * b * 0.3e-3, rel=1e-14)


def test_bare_ceramic_carries_no_charge():
    """Without electrodes: no coupling, each layer's mean strain stiffened by 1/(1 − k²)."""
    device = Device()
    b, p = device.bimorph, device.piezo
    active = section(BIMORPH, device, Beam(), lossy=True)
    bare = section(Piece("bimorph", 20e-3, electrode=False), device, Beam(), lossy=True)
    assert (bare.K, bare.C) == (0.0, 0.0)
    assert (bare.GA, bare.m, bare.rhoI) == (active.GA, active.m, active.rhoI)
    modulus = (1 + 1j / p.quality_factor) / p.s11
    k2 = p.d31**2 * modulus / (p.eps33 * EPS0 * (1 - 1j * p.loss_tangent))
    arm = 0.5 * (b.shim_thickness + b.piezo_thickness)
    layers = 2 * b.width * b.piezo_thickness * arm**2
    # C is a difference, ε (1 − k²): one more digit
    more = layers * modulus * k2 / (1 - k2)
    assert pytest.approx(more, rel=1e-13) == bare.EI - active.EI
    assert bare.EI.imag > 0.0


def test_sections_along_a_taper():
    """The section at a share of a tapered piece is that of a bimorph with those dimensions."""
    ends = Dimensions(2e-3, 0.3e-3, 0.2e-3), Dimensions(1e-3, 0.1e-3, 0.4e-3)
    tapered = Piece("bimorph", 20e-3, ends=ends)
    quarter = Bimorph(width=1.75e-3, piezo_thickness=0.25e-3, shim_thickness=0.25e-3)
    got = section(tapered, Device(), Beam(), lossy=True, share=0.25)
    exact = section(BIMORPH, Device(bimorph=quarter), Beam(), lossy=True)
    for name in NAMES:
        assert getattr(got, name) == pytest.approx(getattr(exact, name), rel=1e-14)
