"""A spring that presses off both planes: the head's turns in them are tied together."""

from math import pi

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device, Spring, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.sections import section_across
from tactgen.tmm.beam.transfer_matrix import chain, multiport, sections
from tactgen.tmm.generator.contact import stops_of
from tactgen.tmm.generator.equilibrium import axial_forces, resting_place, resting_tilt
from tactgen.tmm.generator.small_signal import _contact, _spring_and_guide, linearised, rod_ports
from tactgen.tmm.ports.multiport import hold, reduce
from tactgen.tmm.ports.supports_and_loads import load_tip
from tactgen.tmm.reluctance.map_range import network_map
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.backbone import held_head
from tactgen.validation.models.transient import scene_machine
from tactgen.validation.scene.load import load_scene

ANGLE = pi / 6.0
FREQUENCIES = np.array([0.0, 100.0, 400.0, 430.0, 900.0])


def scene_at(angle, *overrides, eccentricity=0.4, scene="generator"):
    return load_scene(scene, [
        f"spring.eccentricity={eccentricity} mm", f"spring.eccentricity_angle={angle} deg",
        "load.kind=none", "models=tmm", "drive.voltage=1V", "coil.current=0mA", *overrides,
    ])[0]  # fmt: skip


def answer(scene):
    return solve(scene, ["tmm"], ["tip_displacement"]).quantities[0].value


@pytest.mark.parametrize(("current", "side"), [(0.0, 1.0), (50e-3, -1.0)])
def test_the_contact_is_that_of_a_ring_of_rough_points(current, side):
    """Its stiffness over lift and both turns is the pressure's slope, summed round the ring."""
    device = Device(spring=Spring(eccentricity=0.4e-3, eccentricity_angle=ANGLE))
    pull = network_map(device)
    place = resting_place(axial_forces(device, pull), current, "falling")
    tilt, law = resting_tilt(device, place), stops_of(device).holding(place.lift)
    # where a point of the ring is, over the head's lift and turns
    round_it = np.linspace(0.0, 2.0 * pi, 720, endpoint=False)
    reach = device.rod.head_radius * np.stack([np.cos(round_it), np.sin(round_it)])
    towards = np.array([np.cos(ANGLE), np.sin(ANGLE)]) @ reach
    pressure = np.exp(tilt * towards / law.decay_length)
    pressure *= place.contact_force / pressure.sum()  # N a point
    moves = np.stack([np.full(720, side), *reach])
    ring = (moves * pressure / law.decay_length) @ moves.T
    found = _contact(device, place, tilt)[0][np.ix_([2, 1, 4], [2, 1, 4])]
    if side < 0.0:  # the lower stop holds the head's lower face sideways
        sideways = law.tangential_stiffness(place.contact_force) * device.rod.head_thickness**2
        found[[1, 2], [1, 2]] -= sideways
    np.testing.assert_allclose(found, ring, rtol=1e-9, atol=1e-9 * np.abs(ring).max())


def test_rod_and_bimorph_rock_as_one_body_with_five_motions():
    """The two planes put together motion by motion give what their condensation gives."""
    device = Device(spring=Spring(eccentricity=0.4e-3, eccentricity_angle=ANGLE))
    scene = scene_at(30.0)
    pull, beam, tip = network_map(device), scene.beam, scene.ends.tip
    place = resting_place(axial_forces(device, pull), 0.0, "rising")
    rod = linearised(device, beam, place, 0.0, pull, tip)
    # springs, contact and masses over (w, ψ, u, w, ψ), and the bimorph in both planes
    tilt = resting_tilt(device, place)
    stiffness, damping = _contact(device, place, tilt)
    stiffness = stiffness + _spring_and_guide(device, tilt)
    damping[2, 2] += device.guide.axial_damping
    stiffness[2, 2] = rod.stiffness[2, 2]
    mass = np.zeros((5, 5))
    mass[:3, :3], mass[3:, 3:] = rod.mass, rod.mass[:2, :2]
    omega = 2.0 * pi * FREQUENCIES[:, None, None]
    whole = stiffness + 1j * omega * damping - omega**2 * mass
    clamped = Support(kind="clamped")
    row = sections(device, clamped, beam, lossy=True, section_of=section_across)
    across = reduce(hold(load_tip(chain(row, FREQUENCIES), tip), "voltage"), ("w_base", "psi_base"))
    whole[:, 3:, 3:] += across.stiffness
    along = reduce(
        load_tip(multiport(device, clamped, beam, FREQUENCIES), tip),
        ("w_base", "psi_base", "voltage"),
    ).stiffness
    whole[:, :2, :2] += along[:, :2, :2]
    moved = np.linalg.solve(whole, -np.pad(along[:, :2, 2], ((0, 0), (0, 3)))[..., None])[:, :3, 0]
    condensed = rod_ports(rod, FREQUENCIES).stiffness[:, :3, :3].copy()
    condensed[:, :2, :2] += along[:, :2, :2]
    asked = np.linalg.solve(condensed, -np.pad(along[:, :2, 2], ((0, 0), (0, 1)))[..., None])
    np.testing.assert_allclose(asked[..., 0], moved, rtol=1e-9, atol=1e-12 * np.abs(moved).max())


def test_the_bimorph_on_its_springs_moves_as_the_machine_does():
    """Both take the other plane along; at right angles its only trace is a softer contact."""
    band = "frequency=10,200,350"
    both = solve(scene_at(45.0, band), ["tmm"], ["tip_displacement", "lateral_tip_per_voltage"])
    springs, machine = (quantity.value for quantity in both.quantities)
    # the machine has the rod's mass sideways, too, which moves the peak by a thousandth
    np.testing.assert_allclose(np.abs(machine), np.abs(springs), rtol=1e-2)
    aside, inside = (scene_at(angle, band).ends for angle in (90.0, 0.0))
    assert aside.base.rotational_stiffness == pytest.approx(inside.across.rotational_stiffness)
    assert aside.across.rotational_stiffness == pytest.approx(inside.base.rotational_stiffness)


@pytest.mark.parametrize(("scene", "purpose", "use"), [
    ("generator", "time simulation", lambda s: scene_machine(s, coil="current", volts=1.0)),
    ("generator", "harmonic balance", held_head),
    ("display", "display", lambda s: solve(s, ["tmm"], ["crosstalk_largest"])),
])  # fmt: skip
def test_what_knows_one_plane_only_says_so(scene, purpose, use):
    with pytest.raises(InputError, match=rf"eccentricity_angle = 45 deg has no {purpose} yet"):
        use(scene_at(45.0, scene=scene))
    # an angle of a centred spring is none
    upright = scene_at(45.0, eccentricity=0.0).ends
    assert upright.base == upright.across


def test_a_measured_load_is_not_asked_for_at_rest(tmp_path):
    """Statics and the springs at rest have a free tip, since a table need not reach 0 Hz."""
    table = tmp_path / "finger.csv"
    table.write_text(
        "frequency (Hz),impedance_re (N*s/m),impedance_im (N*s/m)\n"
        "50,0.7,-1.2\n100,0.7,-0.7\n200,0.7,-0.4\n400,0.7,-0.2\n700,0.7,-0.1\n1000,0.7,-0.1\n"
    )
    asked = ("load.kind=table", f"load.file={table}", "frequency=100,400")
    loaded, free = scene_at(45.0, *asked), scene_at(45.0, "frequency=100,400")
    assert loaded.ends.base.rotational_stiffness == free.ends.base.rotational_stiffness
    found = answer(loaded)
    assert np.isfinite(found).all()
    assert (np.abs(found) != np.abs(answer(free))).all()
