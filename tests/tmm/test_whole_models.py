"""All that beam, lumped and network models say of a few devices, as approved."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.bimorph.ends import Ends, Springs, TipLoad
from tactgen.geometry.device.parameters import (
    Beam,
    Bimorph,
    Device,
    Display,
    Limits,
    Load,
    Skin,
    Support,
)
from tactgen.tmm.beam import lumped
from tactgen.tmm.beam.modes import natural_frequencies
from tactgen.tmm.beam.section.shear_correction import energy_shear_correction
from tactgen.tmm.beam.shapes import driven_line, mode_lines
from tactgen.tmm.beam.transfer import transfer_matrix
from tactgen.tmm.display.board import board, plate_waves
from tactgen.tmm.display.field import between_heads, head_levels, network_forces
from tactgen.tmm.display.skin import links, sheet
from tactgen.tmm.generator.guide import lateral_guide, tilt_guide
from tactgen.tmm.generator.held_base import held_support
from tactgen.tmm.generator.moving_mass import moving_rod
from tactgen.tmm.generator.network_pull import network_pull
from tactgen.tmm.generator.positions import axial_forces, position_loop, resting_place
from tactgen.tmm.generator.small_signal import axial_poles, linearised
from tactgen.tmm.generator.stops import stops_of
from tactgen.tmm.ports.loads.finger import finger_impedance, finger_stiffness
from tactgen.tmm.ports.springs_dampers_masses import finger_chain
from tactgen.tmm.ports.terminations import attach, ends_of
from tactgen.tmm.reluctance.circuit import FULL, ONE_GAP, circuit
from tactgen.tmm.reluctance.coil_heat import (
    largest_rms_current,
    steady_temperature_rise,
    thermal_statement,
)
from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.tmm.reluctance.network import network_bridge, network_samples
from tactgen.tmm.reluctance.switching import equilibria, resting_gaps, switching
from tests.approved import by_ports, described

FREQUENCIES = np.array([0.0, 120.0, 600.0, 2.5e3, 1.1e4])
BEAM = Beam()
ROWS = {
    "paper": (Device(), Support(kind="clamped")),
    "bare ends and glue": (
        Device(bimorph=Bimorph(bare_below=1e-3, bare_above=0.5e-3, glue_thickness=10e-6)),
        Support(kind="clamped"),
    ),
    "on its rod": (Device(bimorph=Bimorph(tab_length=0.9e-3)), Support(kind="rod")),
}
HELD = {
    "clamped": Ends(),
    "sprung": Ends(Springs(3e6, 0.24, 1e-4, 1e-12), TipLoad(40.0, 0.02, 1e-6)),
}


@pytest.mark.parametrize("name", ROWS)
def test_a_row_of_beams(name, approved):
    """Its sections, its ports over frequency, and how it vibrates and is driven on two supports."""
    device, support = ROWS[name]
    row = transfer_matrix.sections(device, support, BEAM, lossy=False)
    losing = transfer_matrix.sections(device, support, BEAM, lossy=True)
    said = {
        "row": row, "shear correction": energy_shear_correction(device), "with losses": losing,
        "ports": by_ports(transfer_matrix.multiport(device, support, BEAM, FREQUENCIES)),
        "lumped": by_ports(lumped.multiport(device, support, BEAM, FREQUENCIES[:2])),
        "lumped model": lumped.lumped_model(row),
    }  # fmt: skip
    for held, ends in HELD.items():
        said[held] = {
            "frequencies": natural_frequencies(row, ends, 5, open_circuit=False).frequencies,
            "open": natural_frequencies(row, ends, 2, open_circuit=True).frequencies,
            "circuit": lumped.equivalent_circuit(row, ends),
            "modes": [(m.w, m.psi, m.charge) for m in mode_lines(row, ends, 2, open_circuit=True)],
            "driven": driven_line(losing, ends, 300.0, 5.0 + 0.0j),
            "attached": by_ports(attach(transfer_matrix.chain(losing, FREQUENCIES), ends)),
        }
    approved(described(said))


def test_what_the_tip_touches(approved):
    """The finger as an impedance, as springs and masses, and as the end of a row."""
    above = FREQUENCIES[1:]
    approved(
        described({
            "impedance": finger_impedance(above), "stiffness": finger_stiffness(above),
            "chain": finger_chain(),
            "ends": [ends_of(Support(kind=kind), Load()) for kind in ("clamped", "spring")],
        })
    )  # fmt: skip


def test_the_network(approved):
    """Flux and pull over currents and gaps, what each refinement adds, switching and heat."""
    device = Device()
    currents, gaps = np.array([0.0, 0.05, 0.13, 0.6]), np.array([0.02e-3, 0.2e-3, 0.5e-3])
    pull, between = network_pull(device), np.array([0.02e-3, 0.07e-3, 0.2e-3])
    approved(
        described({
            "ladders": [circuit(device, gaps, which) for which in (FULL, ONE_GAP)],
            "samples": network_samples(device, currents, gaps),
            "without leakage": network_samples(
                device, currents, gaps, replace(FULL, leakage=False, iron="linear")
            ),
            "bridge": network_bridge(device, 0.13, 0.2e-3),
            "range": [map_grid(device), map_grid(device, shared=True)],
            "map": [pull.force(0.13, between), pull.flux_linkage(0.13, between),
                    pull.force_gradient(0.13, between)],
            "switching": switching(device, pull),
            "resting": [resting_gaps(device, pull, currents, rising=up) for up in (True, False)],
            "equilibria": equilibria(device, pull, 0.1),
            "heat": [steady_temperature_rise(device, 0.2), largest_rms_current(device, Limits()),
                     thermal_statement(device, 0.2)],
        })
    )  # fmt: skip


def test_the_networks_map_reaches_as_far_as_the_device_opens():
    """It is made for the device's own gap, not for the paper's."""
    wide = Device(gap=0.3e-3)
    low, high = network_pull(wide).gap_limits
    assert low < wide.spring.stop_gap
    assert high > wide.gap


def test_the_machine_about_its_places(approved):
    """Where the rod rests, and what holds, guides and moves it there."""
    device = Device(bimorph=Bimorph(tab_length=0.9e-3))
    pull = network_pull(device)
    forces = axial_forces(device, pull)
    currents = np.array([0.0, 0.05, 0.1, 0.2])
    said = {
        "places": position_loop(forces, currents).places, "rod": moving_rod(device),
        "stops": stops_of(device), "guides": [lateral_guide(device), tilt_guide(device)],
        "held": [held_support(device, pull, 0.05, came, 0.02) for came in ("rising", "falling")],
    }  # fmt: skip
    for current in (0.05, 0.2):
        place = resting_place(forces, current, "rising")
        linear = linearised(device, BEAM, place, current, pull)
        said[f"about {current} A"] = [
            linear,
            *(axial_poles(linear, voltage=v) for v in (True, False)),
        ]
    approved(described(said))


def test_a_display(approved):
    """Board, skin and stray field between units."""
    device, display, skin = Device(), Display(rows=2, columns=2), Skin()
    units = ("1,1", "1,2", "2,1", "2,2")
    approved(
        described({
            "board": by_ports(board(device, display, FREQUENCIES[:3], units, 0.01)),
            "waves": plate_waves(device, display), "links": links(skin),
            "sheet": by_ports(sheet(skin, display, FREQUENCIES[:3], units)),
            "between heads": between_heads(device, 2.4e-3),
            "forces": network_forces(device, display, 0.13, 0.2e-3),
            "levels": head_levels(display, 0.1),
        })
    )  # fmt: skip
