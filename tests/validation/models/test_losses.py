"""Structural losses of shim, glue and rod: in every model the same."""

import numpy as np
import pytest

from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

#: A bimorph with a bare tab and glue between its layers, which every model of the solid on
#: bricks takes, too; little loss in the ceramic, so that that of the others shows.
LAYERED = ("bimorph.tab_length=2mm", "bimorph.glue_thickness=20um", "support.kind=clamped",
           "load.kind=none", "piezo.quality_factor=1e4", "piezo.loss_tangent=1e-4")  # fmt: skip
LOSSY = ("shim.loss_factor=0.05", "glue.loss_factor=0.3")


def answered(name, model, *overrides, frequencies="10,200,1500"):
    scene, _ = load_scene(name, [*overrides, f"models={model}", f"frequency={frequencies}"])
    return solve(scene, (model,), ("tip_displacement",), modelling=False)


@pytest.mark.parametrize("key", ["shim", "glue", "rod"])
def test_each_part_takes_energy_by_both_beam_models(key):
    """Closed form and elements agree on what each part's loss alone does in the real joint."""
    none = ("shim.loss_factor=0", "glue.loss_factor=0", "rod.loss_factor=0", "load.kind=none")
    some = (*none, f"{key}.loss_factor=0.2")
    lossless, tmm, beam = (
        answered("bimorph_on_rod", model, *overrides)
        for model, overrides in (("tmm", none), ("tmm", some), ("beam", some))
    )
    values = [s.quantities[0].value for s in (lossless, tmm, beam)]
    # elements of order five at 1500 Hz
    np.testing.assert_allclose(values[2], values[1], rtol=1e-7)
    assert abs(values[1][1] / values[0][1] - 1.0) > 1e-6


def compliance(model, *overrides):
    """Tip compliance at 10 Hz, far below resonance, base and voltage held (m/N)."""
    found = answered("paper", model, *LAYERED, "accuracy=0.05", *overrides, frequencies="10")
    stiffness = found.models[model].answer("harmonic").fine.stiffness[0]
    return np.linalg.inv(stiffness[np.ix_([2, 3], [2, 3])])[0, 0]


def lag(model, *overrides):
    """Share of the energy that a loss takes (rad): the part in quadrature, without the rest's."""
    lossy, rest = (compliance(model, *more) for more in (overrides, ()))
    return rest.imag / rest.real - lossy.imag / lossy.real


@pytest.mark.heavy
def test_the_solid_loses_in_the_shim_what_the_beam_loses():
    """Its share of the bending energy: that of beam theory to what the width and ends change."""
    assert lag("solid", LOSSY[0]) == pytest.approx(lag("tmm", LOSSY[0]), rel=0.1)


@pytest.mark.heavy
def test_the_solid_loses_in_the_glue_its_share_of_the_energy():
    """Loss factor times the share that a stiffer glue says, without losses: dC/C per dE/E.

    In the solid the layers shear the glue, of which plane sections know nothing.
    """
    soft, stiff = (
        compliance("solid", f"glue.youngs_modulus={modulus}GPa").real for modulus in (2.97, 3.03)
    )
    share = np.log(soft / stiff) / np.log(3.03 / 2.97)
    # of first order in the loss factor; the next is its square
    assert lag("solid", "glue.loss_factor=0.05") == pytest.approx(0.05 * share, rel=0.01)
    assert lag("solid", "glue.loss_factor=0.05") > 10.0 * lag("tmm", "glue.loss_factor=0.05")


def test_the_generators_own_resonance_is_damped():
    """On the rod with the scene's losses Q is near the 22 of the paper's 20 mm actuator."""
    found = answered("bimorph_on_rod", "tmm", "load.kind=none", frequencies="340:410:281")
    size = np.abs(found.quantities[0].value)
    frequencies = np.asarray(found.scene.frequency)
    half = frequencies[size > size.max() / np.sqrt(2.0)]
    q = frequencies[size.argmax()] / (half[-1] - half[0])
    # a loss factor of 0.044 in tab and glue, which hold nearly all the energy, is Q = 23
    assert q == pytest.approx(22.0, rel=0.2)
