"""Drawings of cases: every page has one, and it shows what the case solves."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.validation.checks.drawings import machines
from tactgen.validation.checks.drawings.sections import _Section
from tactgen.validation.checks.known import beams, elastic, resonators, seven_layers
from tactgen.validation.checks.known.magnetics import coils
from tactgen.validation.scene.scene import load_scene


def drawn(cases, name):
    """Return the drawing of the case of that name."""
    return next(case for case in cases if case.id == name).setup()


def spans(areas):
    """Return the size (across, up) of each area."""
    return [tuple(np.ptp(np.array(area.outline), axis=0)) for area in areas]


def test_a_section_shows_supports_and_loads():
    """A plate held at four edges; a strip on a line, pushed down in the middle, of two plies."""
    plate = drawn(elastic.CASES, "P13H")
    held = [line.points for line in plate.lines if line.kind == "held"]
    assert len(set(held)) == 4
    assert plate.labels == ("z (m)", "y (m)")
    strip = drawn(seven_layers.CASES, "R0031")
    assert {area.material for area in strip.areas} == {"fibres along z", "fibres along y"}
    hinge, push = strip.marks
    assert (hinge.kind, hinge.at) == ("hinge", (pytest.approx(15.0), 0.0))
    assert (push.kind, push.direction) == ("force", 270.0)
    assert push.at == (0.0, pytest.approx(1.0))


def test_a_load_points_where_it_acts():
    """VM231's stress changes sign over the height: it bends, and its middle is free of it."""
    arrows = drawn(resonators.CASES, "VM231").marks
    up = {round(mark.at[1], 3): mark.direction for mark in arrows if mark.kind == "force"}
    assert up == {-0.5: 0.0, -0.25: 0.0, 0.25: 180.0, 0.5: 180.0}


def test_a_load_on_part_of_a_face_has_its_arrows_there():
    """From one end of the part to the other, in the drawing's unit; on the whole face from edge
    to edge; on a line where that is."""
    axis = SimpleNamespace(breaks=np.array([0.0, 5.0]))
    seen = _Section(SimpleNamespace(y=axis, z=axis), "mm", ("z", "y"))
    for where, ends in (((1.0, 3.0), (1e3, 3e3)), (None, (0.0, 5e3)), (2.0, (2e3, 2e3))):
        found = seen._along(where, 0)
        assert (found[0], found[-1]) == ends
        assert found == pytest.approx(np.linspace(*ends, len(found)))


def test_a_potential_is_not_a_support():
    """A block's faces carry a potential; what holds it against rigid motion is a point."""
    block = drawn(resonators.CASES, "BLOCK")
    assert {line.kind for line in block.lines} == {"division", "potential"}
    faces = {line.points[0][1] for line in block.lines if line.kind == "potential"}
    assert faces == {0.0, 1.0}


def test_a_strip_has_its_layers():
    """Smits' bimorph is two layers of 0.26 mm over 20 mm, held at its root."""
    strip = drawn(beams.CASES, "SMITS")
    assert spans(strip.areas) == [(20.0, 0.26), (20.0, 0.26)]
    (held,) = strip.lines
    assert held.points == ((0.0, 0.0), (0.0, 0.52))


def test_a_taper_follows_its_law():
    """VM148's height is 2 in at the root, half of it squared at three quarters of the length."""
    outline = np.array(drawn(beams.CASES, "VM148").areas[0].outline)
    upper = outline[outline[:, 1] >= 0.0]
    assert np.interp([0.0, 3.0], upper[:33, 0], upper[:33, 1]) == pytest.approx(
        [1.0, 0.5], rel=1e-3
    )


def test_the_actuator_is_the_scene():
    """Its gap is the scene's, between what moves and the sleeve; a long one lies on its side."""
    device = load_scene("reluctance")[0].device
    drawing = machines.actuator()
    assert drawing.labels == ("z (mm)", "r (mm)")
    assert not drawing.equal
    heads = [area for area in drawing.areas if area.material == "iron, moves"]
    above = min(z for area in heads for z, _ in area.outline if z > 0.0)
    assert above == pytest.approx(1e3 * device.gap)


def test_small_windings_have_a_mark():
    """Wire of 1 mm on a loop of 200 mm is not seen else."""
    radii = [mark.at[0] for mark in drawn(coils.CASES, "LOOPS").marks]
    assert radii == pytest.approx([200.0, 250.0])


def test_the_display_has_its_pitch():
    """Three heads in a row stand at the display's pitch, one of nine is driven."""
    display = load_scene("display")[0].display
    drawing = machines.display(3, 3, driven=True)
    heads = [area for area in drawing.areas if area.material.startswith("head")]
    assert len(heads) == 9
    assert sum(area.material == "head, driven" for area in heads) == 1
    middles = sorted({round(float(np.mean(np.array(a.outline)[:-1, 0])), 6) for a in heads})
    assert np.diff(middles) == pytest.approx(1e3 * display.pitch)
