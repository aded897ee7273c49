"""Steps by layerwise theory: shear lag in closed form, its symmetry, and a solid."""

import numpy as np
import pytest

from tactgen.fem.piezo.ports import static_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks
from tactgen.geometry.bimorph.segments import beam_pieces
from tactgen.geometry.device.parameters import Support
from tactgen.tmm.beam import calibrated_row, calibrated_section
from tactgen.tmm.beam.layerwise_steps import layer_steps
from tactgen.validation.scene.load import load_scene


def scene(layers, *more):
    return load_scene("j1", [f"bimorph.layers={layers}", *more])[0]


def steps(device):
    return layer_steps(device, beam_pieces(device, Support()))


def test_thin_films_on_soft_glue_are_bars_in_shear_lag():
    """Volkersen's bonded bars on both faces of a beam: the films' force rises as 1 - exp(-κ z)."""
    film, glue, core, young, shear = 1e-6, 5e-6, 1e-3, 1e9, 1e7
    of = scene(
        "piezo 0.001 mm from 5 mm to 15 mm +x; glue 0.005 mm from 5 mm to 15 mm; shim 1 mm; "
        "glue 0.005 mm from 5 mm to 15 mm; piezo 0.001 mm from 5 mm to 15 mm +x",
        f"glue.youngs_modulus={2.6 * shear} Pa", "glue.poisson_ratio=0.3",
        f"shim.youngs_modulus={young} Pa", "shim.shear_modulus=1e12 Pa",
    )  # fmt: skip
    stretch, bending = film / of.piezo.s11, young * core**3 / 12.0  # per width
    apart = core + 2.0 * glue + film
    decay = np.sqrt(shear / glue * (1.0 / stretch + apart * core / (2.0 * bending)))
    share = stretch * apart**2 / 2.0 / bending
    below, above = steps(of.device)
    # the glue is 1/200 of the core's thickness, and stretches a little itself
    assert above.by_moment == pytest.approx(share / (1.0 + share) / decay, rel=0.02)
    assert above.by_voltage == pytest.approx(-1.0 / decay, rel=0.02)
    assert (below.softer, below.driven, above.softer, above.driven) == (0, 1, 2, 1)
    assert below[1::2] == pytest.approx(above[1::2], rel=1e-9)


def test_the_end_of_an_electrode_is_no_step():
    assert steps(load_scene("j1", ["bimorph.bare_below=2mm"])[0].device) == [None]


@pytest.mark.parametrize(
    ("layers", "more"),
    [
        ("brass 0.3 mm; PZT-5A 0.3 mm from 5 mm to 12 mm +x", ()),
        ("PZT-5A 0.3 mm +x; brass 0.15 mm; PZT-5A 0.3 mm +x", ("bimorph.tab_length=2mm",)),
    ],
)
def test_a_narrow_solid_turns_as_much(layers, more):
    """Tip per force and per voltage, within what the clamp and the section leave on plain ones."""
    of = scene(layers, "bimorph.width=0.5mm", *more)
    solid = moved(static_multiport(assemble(of.device, bimorph_bricks(of.device, LEVELS[1]),
                                            lossy=False)).stiffness[0].real)  # fmt: skip
    factors = calibrated_section.section_factors(of.device, of.beam)
    with pytest.MonkeyPatch.context() as patch:
        own = calibrated_tip(of, factors)
        patch.setattr(calibrated_row, "layer_steps", lambda _, row: [None] * (len(row) - 1))
        without = calibrated_tip(of, factors)
    with_steps, plain = (np.abs(found / solid - 1.0) for found in (own, without))
    assert (with_steps < 8e-3).all()
    assert plain.max() > 0.02


def calibrated_tip(of, factors):
    row = calibrated_row.sections(of.device, of.support, of.beam, factors, lossy=False)
    return moved(calibrated_row.multiport(row, factors, np.zeros(1)).stiffness[0].real)


def moved(stiffness):
    """Displacement of the tip per force and per voltage, from D(0)."""
    flexible = np.linalg.inv(stiffness[2:4, 2:4])
    return np.array([flexible[0, 0], (-flexible @ stiffness[2:4, 4])[0]])


def test_beside_a_ceramic_without_electrode_the_nearest_driven_piece_turns():
    """A tab and a short bare end, then the driven length: what the tab's step adds is not lost."""
    bare = load_scene("j1", ["bimorph.tab_length=2mm", "bimorph.bare_below=0.05mm"])[0]
    whole = load_scene("j1", ["bimorph.tab_length=2mm"])[0]
    (own, _), (plain,) = steps(bare.device), steps(whole.device)
    assert own.driven == 2
    assert own.by_voltage != 0.0
    # the bare end is a sixth of the ceramic's thickness
    assert own.by_voltage == pytest.approx(plain.by_voltage, abs=0.1 * bare.bimorph.piezo_thickness)
