"""Parameters: the paper's values by default, a source for each, no silent mistakes; the wire."""

import math

import pytest
from pydantic import ValidationError

from tactgen.geometry.bimorph.segments import Piece, beam_pieces
from tactgen.geometry.device import parameters as p
from tactgen.geometry.device.checks import check_fit
from tactgen.geometry.device.parameters import Coil
from tactgen.geometry.device.winding import winding
from tactgen.geometry.errors import InputError

GROUPS = (
    p.Bimorph, p.Piezo, p.Shim, p.Glue, p.Rod, p.Coil, p.Sleeve, p.Spring, p.Contact, p.Guide,
    p.Steel, p.Support, p.Load, p.Drive, p.Beam, p.Display, p.Skin, p.Scatter,
)  # fmt: skip


def test_defaults_are_the_papers():
    """Table 2 and section 4 of the paper, in SI."""
    b, s = p.Bimorph(), p.Support()
    assert (b.length, b.width, b.piezo_thickness, b.shim_thickness) == (
        20e-3, 2.1e-3, 0.26e-3, 0.25e-3,
    )  # fmt: skip
    assert (p.Shim().youngs_modulus, p.Shim().density) == (140e9, 1500.0)
    assert (s.rotational_stiffness, s.lateral_stiffness) == (0.24, 3e6)
    assert (s.rotational_damping, s.rotational_inertia) == (4.46e-6, 1e-12)
    assert (p.Drive().voltage, p.Device().gap) == (50.0, 0.2e-3)


@pytest.mark.parametrize("group", GROUPS)
def test_groups_state_their_sources_are_frozen_and_closed(group):
    """Each value is the paper's or assumed; none changes after the fact, no unknown key passes."""
    made = group()
    found = p.sources(made)
    assert set(found) == set(group.model_fields)
    assert all(text.startswith(("paper", "assumed", "not in the paper")) for text in found.values())
    with pytest.raises(ValidationError):
        setattr(made, next(iter(group.model_fields)), 1.0)
    with pytest.raises(ValidationError):
        group(lenght=1.0)


ROD = p.Support(kind="rod")
#: With a collar that the flange does not pass, nor the coil reaches.
COLLAR = p.Sleeve(collar_radius=0.905e-3)


def with_tab(**bimorph):
    return p.Bimorph(**{"tab_length": 2e-3, **bimorph})


@pytest.mark.parametrize(
    ("device", "support", "words"),
    [
        (p.Device(bimorph=with_tab(width=2.5e-3)), ROD, ("2.5 mm", "2.3 mm", "narrower")),
        (p.Device(bimorph=p.Bimorph()), ROD, ("tab_length = 0 mm", "at least 0.4 mm")),
        (p.Device(bimorph=with_tab(), rod=p.Rod(slot_depth=0.5e-3)), ROD, ("slot_depth", "head")),
        (
            p.Device(
                bimorph=with_tab(width=1e-3), rod=p.Rod(slot_depth=0.1e-3),
                glue=p.Glue(thickness=0.1e-3),
            ),
            ROD, ("glue.thickness", "thinner"),
        ),
        (p.Device(coil=p.Coil(inner_radius=0.5e-3)), p.Support(), ("rod.radius = 0.64 mm",)),
        (p.Device(sleeve=p.Sleeve(outer_radius=0.9e-3)), p.Support(), ("sleeve.outer_radius",)),
        (p.Device(rod=p.Rod(flange_radius=0.96e-3)), p.Support(), ("rod.flange_radius",)),
        (p.Device(rod=p.Rod(length=4.6e-3)), p.Support(), ("rod.length = 4.6 mm", "longer")),
        (p.Device(coil=p.Coil(length=2.2e-3)), p.Support(), ("runs into the flange", "shorten")),
        (
            p.Device(coil=p.Coil(position=-1e-3)), p.Support(),
            ("coil.position = -1 mm", "rod's head", "move the coil down"),
        ),
        (
            p.Device(gap=1.75e-3, sleeve=COLLAR), p.Support(),
            ("gap = 1.75 mm", "pass the collar", "at a gap of 1.7"),
        ),
    ],
)  # fmt: skip
def test_parts_that_do_not_fit_are_refused(device, support, words):
    """A device that cannot be put together is refused in one sentence with values and remedy."""
    with pytest.raises(InputError) as caught:
        check_fit(device, support)
    assert all(word in str(caught.value) for word in words), caught.value


def test_parts_that_fit_pass():
    """The paper's device fits, and a wide bimorph may be studied alone."""
    check_fit(p.Device(), p.Support())
    check_fit(p.Device(bimorph=with_tab()), ROD)
    check_fit(p.Device(bimorph=p.Bimorph(width=5e-3)), p.Support(kind="clamped"))
    # the flange goes through a wide collar, and the coil may touch the head that carries it
    check_fit(p.Device(gap=5e-3, sleeve=p.Sleeve(collar_radius=0.95e-3)), p.Support())
    check_fit(p.Device(coil=p.Coil(position=-p.NOMINAL_GAP)), p.Support())


def test_pieces_from_base_to_tip():
    """The row of beams is the ceramic, the free part of the tab below it, the rod below that."""
    assert beam_pieces(p.Device(), p.Support()) == (Piece("bimorph", 20e-3),)
    device = p.Device(bimorph=with_tab())
    assert beam_pieces(device, p.Support())[0] == Piece("shim", 2e-3)
    on_rod = beam_pieces(device, ROD)
    assert [piece.section for piece in on_rod] == ["cylinder"] * 3 + ["bond", "shim", "bimorph"]
    # the shaft below the sleeve's top, the gap above it, and the head; this rod ends at its flange
    height = device.rod.length + p.NOMINAL_GAP + device.rod.head_thickness
    assert sum(piece.length for piece in on_rod[:3]) == pytest.approx(height)
    # the glued part of the tab lies beside the head, the free part above it
    assert on_rod[3].length == pytest.approx(device.rod.slot_depth - device.glue.thickness)
    assert on_rod[4].length == pytest.approx(device.ceramic_base)
    longer = p.Device(bimorph=with_tab(), rod=p.Rod(length=5.4e-3))
    assert beam_pieces(longer, ROD)[0].length == pytest.approx(0.7e-3)


def test_a_group_that_is_none_and_a_constant_that_cannot_be_read_are_refused_as_such():
    """A metal's shear modulus follows from two others: the sentence is about the one given."""
    with pytest.raises(ValidationError, match="valid dictionary"):
        p.Piezo.model_validate(3)
    for wrong in ("stiff", [1.0]):
        with pytest.raises(ValidationError, match="youngs_modulus") as said:
            p.Shim(material="brass", youngs_modulus=wrong)
        assert "shear_modulus" not in str(said.value)


def test_wire_fills_its_share_of_the_window():
    """Turns times the bare wire's area is the fill factor's share of the window."""
    wound = winding(Coil())
    assert wound.window == pytest.approx(0.26e-3 * 1.6e-3)
    assert 560.0 * wound.wire_area == pytest.approx(0.5 * wound.window)
    assert math.pi / 4.0 * wound.wire_diameter**2 == pytest.approx(wound.wire_area)


def test_resistance():
    """R = ρ N · 2π r_mean / a; half the fill doubles it, and copper gains 39.3 % in 100 K."""
    cold, thin, warm = (
        winding(Coil(**change)).resistance
        for change in ({}, {"fill_factor": 0.25}, {"temperature": 393.15})
    )
    length = 560.0 * 2.0 * math.pi * 0.77e-3
    assert cold == pytest.approx(1.7241e-8 * length / (0.5 * 0.416e-6 / 560.0))
    assert thin == pytest.approx(2.0 * cold)
    assert warm == pytest.approx(1.393 * cold)


def test_heating_rate_is_power_over_heat_capacity():
    """Uncooled, all heat stays in the copper: 385 J/(kg K), 8960 kg/m³."""
    wound = winding(Coil())
    copper = 385.0 * 8960.0 * wound.wire_area * wound.wire_length
    assert wound.heating_rate(0.13) == pytest.approx(wound.power(0.13) / copper)
