"""A bimorph in three parts against the same bricks whole."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactgen.fem.piezo.bricks import assemble_bricks
from tactgen.fem.piezo.krylov import port_error
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.parts import joined
from tactgen.fem.piezo.parts.joined import joined_system
from tactgen.fem.piezo.ports import direct_multiport, static_multiport
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing, bimorph_bricks, in_parts
from tactgen.geometry.bimorph.bricks import Axis
from tactgen.geometry.bimorph.ends import Ends
from tactgen.geometry.device.parameters import Bimorph, Device, Shim
from tactgen.geometry.store.values import fingerprint
from tactgen.tmm.ports.multiport import passivity_margin, reciprocity_error

DEVICE = Device(bimorph=Bimorph(length=8e-3))
BRICKS = bimorph_bricks(
    DEVICE, BrickMeshing((2, 2, 3), smallest=0.8, tip=1.0, longest=1.0, pieces=(2.0, 30.0))
)
#: The break points next above two thicknesses, and next below two from the tip.
SECTIONS = tuple(
    int(np.searchsorted(BRICKS.z.breaks, at))
    for at in (2.0 * DEVICE.bimorph.thickness, 8e-3 - 2.0 * DEVICE.bimorph.thickness)
)
MOTIONS = ("bending_x", "bending_y", "torsion", "axial")


@pytest.fixture(autouse=True)
def _nothing_kept(monkeypatch):
    """Each part is reduced anew."""
    monkeypatch.setattr(joined, "kept", lambda kind, inputs, made_of, work: work())


@cache
def in_three(share, *, lossy=False):
    """The system joined of three parts."""
    return joined_system(DEVICE, in_parts(BRICKS, 0, SECTIONS, share), lossy=lossy)


@cache
def whole(*, lossy=False, motion="bending_x"):
    """The system of the same bricks, uncut."""
    return assemble_bricks(DEVICE, BRICKS, lossy=lossy, motion=motion)


def test_the_parts_are_the_whole_to_what_the_sections_leave_out():
    """Fields kept down to 1e-4: their squares count, and the fewer are kept the stiffer it is."""
    exact = static_multiport(whole())
    errors = [
        port_error(static_multiport(in_three(share)), exact)[0] for share in (1e-1, 1e-2, 1e-4)
    ]
    assert errors[2] < 1e-6
    assert errors[2] < 0.1 * errors[1] < 0.1 * errors[0]


@pytest.mark.parametrize("motion", MOTIONS)
def test_modes_of_every_class(motion):
    """The first of each: the fields kept are static ones to 1e-4 of amplitude, whose squares count.

    Fields of displacement left out make it stiffer, those of potential softer.
    """
    exact = natural_modes(whole(motion=motion), Ends(), 1)
    system = in_three(1e-4)
    found = natural_modes(system if motion == "bending_x" else system.related(motion), Ends(), 1)
    assert abs(found[0].frequency / exact[0].frequency - 1.0) < 1e-5
    assert found[0].kind == motion


def test_driven_with_losses():
    """D(Ω) with losses, up to the first mode, reciprocal and passive like the whole.

    What losses of 1 % do to the fields at the section is left out and counts by its square, too.
    """
    frequencies = np.array([100.0, 2.3e3])
    exact, found = (
        direct_multiport(system, frequencies)
        for system in (whole(lossy=True), in_three(1e-4, lossy=True))
    )
    assert port_error(found, exact).max() < 1e-5
    assert reciprocity_error(found).max() < 1e-9
    assert passivity_margin(found).min() > -1e-9


def test_as_many_pivots_are_negative_as_there_are_potentials():
    """Charges and displacements are what they say, in foot and tip and between them."""
    system = in_three(1e-2)
    assert factorise(system.stiffness.inner).negative_pivots == system.potentials


def test_a_small_system_tells_what_stands_behind_it():
    """Whoever solves several classes at once must know how large their ends are."""
    parts = in_parts(BRICKS, 0, SECTIONS, 1e-1)
    system = joined_system(DEVICE, parts, lossy=False)
    ends = parts.foot.used().sum() + parts.tip.used().sum()
    assert system.behind == 4 * ends > system.size
    assert whole().behind == 0


def test_a_translation_needs_no_force():
    """The section has the rigid motions to rounding."""
    assert in_three(1e-1).spurious_stiffness < 10.0 * whole().spurious_stiffness


def test_another_length_asks_for_the_same_parts_another_shim_for_others(monkeypatch):
    """By the inputs that foot, tip and section are kept under."""

    def asked(device, bricks):
        found = []

        def noted(kind, inputs, made_of, work):
            found.append((kind, fingerprint(inputs)))
            return work()

        monkeypatch.setattr(joined, "kept", noted)
        joined_system(device, in_parts(bricks, 0, SECTIONS, 1e-2), lossy=False)
        return found

    breaks = BRICKS.z.breaks.copy()
    breaks[SECTIONS[1] :] += 1e-3 / 3.0
    longer = replace(BRICKS, z=Axis(breaks, BRICKS.z.degree))
    stiffer = DEVICE.model_copy(update={"shim": Shim(youngs_modulus=150e9)})
    first = asked(DEVICE, BRICKS)
    assert sorted(kind for kind, _ in first) == ["end", "end", "section"]
    assert asked(DEVICE, longer) == first
    assert not set(asked(stiffer, BRICKS)) & set(first)


def test_losses_of_ends_are_refused_where_they_are_not_known():
    """Ends are reduced with losses for the motions that the ports drive alone."""
    parts = in_parts(BRICKS, 0, SECTIONS, 1e-2)
    with pytest.raises(ValueError, match="of the motions that ports drive only"):
        joined_system(DEVICE, parts, lossy=True, motion="torsion")
