"""All that small field models say of a few devices, as approved: coarse, so that they are quick."""

import numpy as np
import pytest

from tactgen.fem.beam import beam as elements
from tactgen.fem.beam.shapes import driven_line
from tactgen.fem.bimorph.modes import natural_modes
from tactgen.fem.bimorph.ports import static_multiport
from tactgen.fem.bimorph.reduction.krylov import reduce_to_ports
from tactgen.fem.bimorph.reduction.state_space import state_space
from tactgen.fem.bimorph.solid import assemble
from tactgen.fem.bimorph.states import driven_state, mode_states
from tactgen.fem.reluctance.axisymmetric.actuator import solve_map
from tactgen.fem.reluctance.three_d.actuator import solve_solid
from tactgen.geometry.bimorph.bimorph_bricks import bimorph_bricks
from tactgen.geometry.bimorph.ends import Ends, Springs, TipLoad
from tactgen.geometry.bimorph.rod_bricks import ROD_LEVELS, rod_bricks
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Support
from tactgen.geometry.reluctance.sector_tets import Sector
from tests.approved import by_ports, described

SPRUNG = Ends(Springs(3e6, 0.24, 1e-4, 1e-12), TipLoad(40.0, 0.02, 1e-6))
#: Short, so that rounding stays far below what counts as the same number.
DEVICES = {
    "plain": Device(bimorph=Bimorph(length=5e-3)),
    "glued": Device(bimorph=Bimorph(length=5e-3, glue_thickness=20e-6, bare_above=0.7e-3)),
    "on its rod": Device(bimorph=Bimorph(length=5e-3, tab_length=0.9e-3)),
}
#: Values of a field's point; bars are differences of close values, and not shown.
FIELD = (
    "current", "gap", "flux_linkage", "coenergy", "force", "force_eggshell",
    "incremental_inductance", "unknowns", "beyond_table",
)  # fmt: skip


@pytest.mark.parametrize("name", DEVICES)
def test_beam_elements(name, approved):
    """How many are taken, their ports over frequency, and modes on two supports."""
    device = DEVICES[name]
    support = Support(kind="rod" if name == "on its rod" else "clamped")
    made = elements.assemble(device, support, Beam(), elements=2, lossy=False)
    approved(
        described({
            "elements": [elements.elements_for(device, f) for f in (1e3, 3e4, 1e6)],
            "stations": made.stations, "unit": made.unit, "ports": made.ports,
            "over frequency": by_ports(elements.multiport(
                device, support, Beam(), np.array([0.0, 2e3, 3e4]), elements=2
            )),
            "modes": [elements.bending_frequencies(made, ends, 4, open_circuit=opened)
                      for ends in (Ends(), SPRUNG) for opened in (False, True)],
            "driven": driven_line(made, SPRUNG, 900.0, 3.0),
        })
    )  # fmt: skip


@pytest.mark.parametrize("name", DEVICES)
def test_the_solid_on_few_bricks(name, approved, few_bricks):
    """Statics, modes, and what of it is left in reduced models."""
    device = DEVICES[name]
    on_rod = name == "on its rod"
    bricks = rod_bricks(device, ROD_LEVELS[0]) if on_rod else bimorph_bricks(device, few_bricks[0])
    system = assemble(device, bricks, lossy=not on_rod)
    said = {
        "unknowns": system.size, "unit": system.volts_per_unit,
        "at rest": by_ports(static_multiport(system)),
    }  # fmt: skip
    if on_rod:
        modes = natural_modes(system, Ends(), 4)
        said["modes"] = [(m.frequency, m.kind, m.share) for m in modes]
        # a mode has no sign, and with the circuit open no charge
        said["states"] = [
            (state.frequency, state.kind, abs(state.tip), opened or abs(state.charge))
            for opened in (False, True)
            for state in mode_states(system, SPRUNG, 2, open_circuit=opened)
        ]
    else:
        reduced = reduce_to_ports(system, np.array([0.0, 2e4]), tolerance=1e-4)
        state = driven_state(system, SPRUNG, 900.0, 3.0)
        small = state_space(reduced.fine, SPRUNG.base, (10.0, 2e4))
        said["driven"] = [state.tip, state.charge]
        said["reduced"] = [reduced.unknowns, reduced.range, reduced.fine.stiffness.shape,
                           reduced.coarse.stiffness.shape]  # fmt: skip
        said["state space"] = [small.a.shape, small.inputs, small.outputs]
        said["its response"] = small.frequency_response(np.array([100.0, 5e3]))
    approved(described(said))


def test_magnetic_fields(approved):
    """Values in the half section and in a sector."""
    plane = [p for row in solve_map(Device(), (0.05e-3, 0.3e-3), (0.05, 0.6), refinement=0.4,
                                    any_grid=True) for p in row]  # fmt: skip
    solid = solve_solid(Device(), 0.13, 0.2e-3, Sector(refinement=0.4, copies=8))
    approved(
        described({
            "half section": [{name: getattr(p, name) for name in FIELD} for p in plane],
            "sector": [
                (v.flux_linkage, v.coenergy, v.forces, v.incremental_inductance, v.unknowns)
                for v in (solid.vector, solid.scalar)
            ],
        })
    )  # fmt: skip
