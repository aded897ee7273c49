"""Imitation skin: its limits, its law of frequency, and that it only takes energy."""

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Load, Support, spreads
from tactgen.tmm.ports.elements import ends_of
from tactgen.tmm.ports.loads import REFERENCE, SkinPad, passive_fit

BAND = np.geomspace(1.0, 1e4, 400)


def pad(**changed):
    numbers = {
        "shear_modulus": 0.25e6, "loss_factor": 0.3, "thickness": 5e-3, "contact_radius": 0.6e-3,
        "weight": 50e-3, "backing_stiffness": 5e3,
    }  # fmt: skip
    return SkinPad(**{**numbers, **changed})


def test_on_rigid_backing_it_is_mindlins_disc():
    """Thick and held: 32 (1 − ν) G R / (7 − 8ν) with ν = 1/2, at the reference."""
    held = pad(thickness=10.0, backing_stiffness=1e15)
    expected = 32.0 * 0.5 * 0.25e6 * 0.6e-3 / (7.0 - 4.0) * (1.0 + 0.3j)
    assert held(np.array([REFERENCE]))[0] == pytest.approx(expected, rel=1e-4)  # R/2H = 3e-5
    thin = pad(thickness=0.3e-3, backing_stiffness=1e15)
    assert thin(np.array([REFERENCE]))[0] == pytest.approx(2.0 * expected, rel=1e-9)


def test_with_nothing_behind_it_is_the_weight():
    """A sheet much stiffer than the weight's inertia moves with it."""
    stiff = pad(shear_modulus=1e13, backing_stiffness=0.0, loss_factor=0.0)
    expected = -((2.0 * np.pi * BAND[:100]) ** 2) * 0.05
    np.testing.assert_allclose(stiff(BAND[:100]), expected, rtol=1e-4)


@pytest.mark.parametrize("loss", [0.0, 0.1, 0.6])
@pytest.mark.parametrize("backing", [0.0, 1e3, 5e4])
def test_it_only_takes_energy(loss, backing):
    found = pad(loss_factor=loss, backing_stiffness=backing)(BAND)
    assert (found.imag >= -1e-12 * np.abs(found)).all()


def test_the_rubber_is_causal():
    """Springs and dampers can follow it, so that it has a past and no future."""
    band = np.geomspace(1.0, 1e4, 120)
    found = pad(backing_stiffness=1e15)(band)
    fit = passive_fit(band, found / (2j * np.pi * band))
    # the dictionary's poles stand at tenths of a decade
    np.testing.assert_allclose(fit.stiffness_at(band), found, rtol=1e-3)


def test_its_modulus_rises_as_its_loss_says():
    """A constant loss factor η goes with f^α, α = 2/π arctan η: a spring-pot."""
    held = pad(backing_stiffness=1e15)
    low, high = held(np.array([10.0, 1000.0]))
    assert np.log(high.real / low.real) / np.log(100.0) == pytest.approx(
        2.0 / np.pi * np.arctan(0.3), rel=1e-6
    )
    assert low.imag / low.real == pytest.approx(0.3, rel=1e-6)


def test_at_rest_it_holds_nothing():
    assert pad()(np.array([0.0]))[0] == 0.0


def test_a_scene_states_it_with_sources_and_ranges():
    """All of its numbers that the paper does not give are marked as assumed, with a range."""
    load = Load(kind="pad")
    assert isinstance(ends_of(Support(), load).tip, SkinPad)
    ranges = {key for key in spreads(load) if key.startswith("pad_")}
    assert ranges == {key for key in Load.model_fields if key.startswith("pad_")}
