"""The rod rocks in both planes together, where its spring presses off both of them.

The head tilts towards where the spring presses.  In that direction the contact is softer, ∂M/∂ψ,
than beside it, M/ψ.  Between the axes a turn in the plane of bending then needs a moment in the
other one as well, where rod and bimorph, which hardly bends across its width, rock on the same
contact.  Seen from the plane of bending they are a resonator on the head.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends, Law, TipLoad
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.tmm.beam.sections import section_across
from tactgen.tmm.beam.transfer_matrix import chain, sections
from tactgen.tmm.generator.contact import stops_of
from tactgen.tmm.generator.equilibrium import RestingPlace, resting_tilt, rocking_stiffness
from tactgen.tmm.ports.elements import base_stiffness, load_tip
from tactgen.tmm.ports.multiport import hold, reduce


def turn_across(
    device: Device, beam: Beam, tip: TipLoad | Law, base: Complex, frequencies: Floats
) -> Complex:
    """Turn of the head per moment (n,) in rad/(N m) in the plane across the width.

    At frequencies (n,) in Hz, the load being alike in all lateral directions.  `base` (n, 2, 2) is
    the dynamic stiffness of rod, contact and guide over motion and turn of the head.
    """
    row = sections(device, Support(kind="clamped"), beam, lossy=True, section_of=section_across)
    loaded = hold(load_tip(chain(row, frequencies), tip), "voltage")
    bimorph = reduce(loaded, ("w_base", "psi_base"))
    return np.asarray(np.linalg.inv(bimorph.stiffness + base)[:, 1, 1])


def coupled(ends: Ends, device: Device, beam: Beam, place: RestingPlace) -> Ends:
    """Ends on the contact of a tilted head, which holds both planes and ties them together.

    `ends` has the contact in the plane of bending.  Statics and undamped modes take the other
    plane at rest.
    """
    base, law, tilt = ends.base, stops_of(device).holding(place.lift), resting_tilt(device, place)
    if base is None or not tilt:
        return ends
    contact, guide = rocking_stiffness(device, law, place.contact_force, tilt)
    across = replace(
        base,
        rotational_stiffness=float(contact[1, 1] + guide[1, 1]),
        rotational_damping=law.relaxation_time * float(contact[1, 1]),
        law=None,
    )
    if not device.spring.tilts_both_planes:
        return replace(ends, across=across)

    def both(frequencies: Floats, tip: TipLoad | Law = ends.tip) -> tuple[Complex, Complex]:
        omega = 2.0 * np.pi * np.asarray(frequencies, dtype=float)
        lateral, rotational = base_stiffness(base, frequencies)
        turning = guide + contact * (1.0 + 1j * omega * law.relaxation_time)[:, None, None]
        other = np.zeros((omega.size, 2, 2), dtype=complex)
        other[:, 0, 0] = lateral
        other[:, 1, 1] = turning[:, 1, 1] - omega**2 * base.rotational_inertia
        turn = turn_across(device, beam, tip, other, frequencies)
        return lateral, rotational - turning[:, 0, 1] ** 2 * turn

    at_rest = float(both(np.zeros(1), ends.conservative_tip)[1][0].real)
    return Ends(replace(base, rotational_stiffness=at_rest, law=both), ends.tip, across)
