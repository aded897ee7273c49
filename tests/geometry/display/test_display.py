"""The display's parts: where they stand, that they fit, what they weigh, room for leads."""

import itertools
import json
import math
import struct

import pytest

from tactgen.geometry.cad.display import display_assembly, display_solids
from tactgen.geometry.cad.solids import write_glb, write_step
from tactgen.geometry.device.parameters import Bimorph, Device, Display, Scatter, Spring
from tactgen.geometry.display.bill import bill_of_parts, coplanar_capacitance, total_mass, wiring
from tactgen.geometry.display.clearances import check_display, clearances, footprint, spring_turns
from tactgen.geometry.display.layout import (
    axes,
    display_parts,
    drawn_units,
    levels,
    spacer_axes,
    support_spacer_axes,
    unit_names,
)
from tactgen.geometry.errors import InputError

DEVICE, DISPLAY = Device(), Display()


def test_the_papers_sizes():
    """Section 5.2: 16 generators, 50 x 70 mm, 45 mm high, footprint at most 2.3 mm; 41 mm each."""
    level = levels(DEVICE, DISPLAY)
    assert len(axes(DISPLAY)) == 16
    assert (DISPLAY.width, DISPLAY.length) == (50e-3, 70e-3)
    assert level.total == pytest.approx(45e-3, abs=1e-9)
    assert level.tip - level.sleeve_bottom == pytest.approx(41e-3, abs=1e-9)
    assert max(footprint(DEVICE)) == pytest.approx(2.3e-3, abs=1e-12)


def test_axes_are_the_pitch_apart_and_centred():
    """Rows along y, columns along x, names in the same order; spacers stand in four corners."""
    display = Display(rows=2, columns=3)
    found = axes(display)
    assert len(found) == len(set(unit_names(display))) == 6
    assert unit_names(display)[-1] == "r2c3"
    assert [sum(along) for along in zip(*found, strict=True)] == pytest.approx([0, 0], abs=1e-12)
    nearest = min(math.dist(a, b) for a, b in itertools.combinations(found, 2))
    assert nearest == pytest.approx(display.pitch)
    for four in (spacer_axes(40e-3, 60e-3, DISPLAY), support_spacer_axes(DISPLAY)):
        x, y = four[-1]
        assert sorted(four) == [(-x, -y), (-x, y), (x, -y), (x, y)]


def test_the_narrowest_clearances():
    """Worked out by hand from the sizes."""
    gaps = {(c.between, c.where): c.gap for c in clearances(DEVICE, DISPLAY)}
    assert gaps["sleeve - sleeve", "x or y"] == pytest.approx(0.1e-3)
    assert gaps["bimorph - bimorph", "y"] == pytest.approx(0.3e-3)
    assert gaps["bimorph - bimorph", "x"] == pytest.approx(1.63e-3)
    assert gaps["grub screw - sleeve", "radial"] == pytest.approx(0.16e-3)
    assert gaps["head - sleeve", "z, working gap"] == pytest.approx(0.2e-3)
    assert list(gaps.values()) == sorted(gaps.values())


@pytest.mark.parametrize(
    ("device", "display", "words"),
    [
        (Device(bimorph=Bimorph(width=2.6e-3)), DISPLAY, ["display.pitch = 2.4 mm", "2.6 mm"]),
        (DEVICE, Display(slot_clearance=0.2e-3), ["upper board's web", "display.pitch larger"]),
        (DEVICE, Display(rows=32, columns=32), ["display.width", "larger"]),
        (Device(spring=Spring(stiffness=0.0)), DISPLAY, ["spring.stiffness = 0 N/m"]),
    ],
)
def test_what_does_not_fit_is_refused(device, display, words):
    """In one sentence with the sizes and the key to change."""
    with pytest.raises(InputError) as refused:
        check_display(device, display)
    assert all(word in str(refused.value) for word in words), str(refused.value)
    # where there is no neighbour, nothing is too close to one
    check_display(Device(bimorph=Bimorph(width=2.6e-3)), Display(rows=1, columns=1))


def test_bill_of_parts():
    """Counts, and masses against the sum worked out another way."""
    lines = {line.name: line for line in bill_of_parts(DEVICE, DISPLAY)}
    assert {line.count for line in lines.values()} == {1, 4, 16}
    assert lines["rod"].count == lines["grub_screw"].count == 16
    assert lines["board_spacer"].volume == pytest.approx(math.pi * 2e-3**2 * 19.4e-3)
    board = 50e-3 * 56e-3 - 16 * (0.97e-3 * 2.3e-3)
    assert lines["upper_board"].mass == pytest.approx(1850.0 * 1e-3 * board)
    inner, outer = 0.64e-3, 0.9e-3
    assert lines["coil"].mass == pytest.approx(
        8890.0 * 0.5 * math.pi * (outer**2 - inner**2) * 1.6e-3
    )
    assert total_mass(tuple(lines.values())) == pytest.approx(
        sum(line.count * line.mass for line in lines.values())
    )
    assert {p.name for p in display_parts(DEVICE, DISPLAY)} == lines.keys()


def test_a_springs_turns_give_its_rate():
    """EN 13906-1 the other way round: R = G d⁴ / (8 D³ n)."""
    turns = spring_turns(DEVICE, DISPLAY)
    assert 81.5e9 * 0.15e-3**4 / (8.0 * 1.5e-3**3 * turns) == pytest.approx(100.0)


def test_room_for_the_leads():
    """Counted by hand: (1.43 - 0.1)/0.2 traces a layer; 2 rows leave by either end, one return."""
    found = wiring(DEVICE, DISPLAY)
    assert (found.traces_fit, found.traces_needed, found.most_rows) == (12, 3, 22)
    assert found.fits
    crowded = wiring(DEVICE, Display(trace_width=0.8e-3, trace_spacing=0.2e-3, layers=1))
    assert (crowded.traces_fit, crowded.fits) == (1, False)
    # between equal strips of width s the elliptic integrals' moduli are 1/3 and sqrt(8)/3
    assert coplanar_capacitance(DISPLAY) == pytest.approx(8.8541878e-12 * 2.7 * 1.5632, rel=1e-3)


def test_units_are_drawn_anew_only_with_another_seed():
    """The same seed, the same units; a larger display keeps the first ones; 0 draws none apart."""
    one = drawn_units(DEVICE, Display(rows=1, columns=3), Scatter())
    again = drawn_units(DEVICE, Display(rows=2, columns=3), Scatter())
    assert again[:3] == one
    assert drawn_units(DEVICE, Display(rows=1, columns=3), Scatter(seed=2)) != one
    exact = Scatter(length=0.0, thickness=0.0, roughness=0.0, preload=0.0)
    assert set(drawn_units(DEVICE, DISPLAY, exact)) == {DEVICE}


def test_units_are_as_far_apart_as_stated():
    """Standard deviations of 1024 units; clipping at 2.5 takes 4.4 % off a normal one's."""
    many = drawn_units(DEVICE, Display(rows=32, columns=32), Scatter(length=0.01))
    lengths = [unit.bimorph.length / DEVICE.bimorph.length for unit in many]
    mean = sum(lengths) / len(lengths)
    deviation = math.sqrt(sum((x - mean) ** 2 for x in lengths) / len(lengths))
    # the deviation of 1024 draws scatters by 1/sqrt(2 * 1024) = 2.2 %
    assert deviation == pytest.approx(0.956 * 0.01, rel=4 * 0.022)
    assert mean == pytest.approx(1.0, abs=4 * 0.01 / 32)


def test_files_hold_each_part_once(tmp_path):
    """Each distinct solid is one set of triangles, however often it is placed."""
    display = Display(rows=1, columns=2)
    step, glb = tmp_path / "d.step", tmp_path / "d.glb"
    assembly = display_assembly(DEVICE, display)
    write_step(assembly, step)
    write_glb(assembly, glb)
    content = glb.read_bytes()
    (size,) = struct.unpack("<I", content[12:16])
    document = json.loads(content[20 : 20 + size])
    placed = sum(len(p.places) for p in display_parts(DEVICE, display))
    parts = len(display_parts(DEVICE, display))
    shapes = {
        tuple(primitive["attributes"]["POSITION"] for primitive in mesh["primitives"])
        for mesh in document["meshes"]
    }
    assert len(shapes) == parts
    assert sum("mesh" in node for node in document["nodes"]) == placed
    assert step.read_text(errors="replace").count("MANIFOLD_SOLID_BREP(") == parts


@pytest.mark.heavy
def test_no_two_solids_overlap_and_gaps_are_as_stated():
    """The CAD kernel's own distances of every pair in a display of two by one."""
    import cadquery as cq

    display = Display(rows=1, columns=2)
    solids = display_solids(DEVICE, display)
    stood = [
        (placed.name, solids[placed.name].moved(cq.Location(cq.Vector(*place))))
        for placed in display_parts(DEVICE, display)
        for place in placed.places
    ]
    nearest = {}
    for (a, one), (b, other) in itertools.combinations(stood, 2):
        box, wall = one.BoundingBox(), other.BoundingBox()
        apart = max(box.xmin - wall.xmax, wall.xmin - box.xmax, box.ymin - wall.ymax,
                    wall.ymin - box.ymax, box.zmin - wall.zmax, wall.zmin - box.zmax)  # fmt: skip
        if apart > 1.0:
            continue
        common = sum(s.Volume() for s in one.intersect(other).Solids())
        assert common < 1e-6, (a, b, common)
        key = tuple(sorted((a, b)))
        nearest[key] = min(nearest.get(key, math.inf), one.distance(other))
    assert nearest["sleeve", "sleeve"] == pytest.approx(0.1, abs=1e-6)
    assert nearest["coil", "sleeve"] == pytest.approx(0.06, abs=1e-6)
    assert nearest["grub_screw", "sleeve"] == pytest.approx(0.0, abs=1e-6)  # both on the plate
    # the slot's corner beside the shim: half of both thicknesses' difference and the clearance
    assert nearest["piezo_top", "upper_board"] == pytest.approx(math.hypot(0.1, 0.6), abs=1e-3)
