"""Generators joined by name: each on its contact with the board, tips tied by the skin.

One generator is solved once: bimorph (by any model) and rigid rod, on the springs of its contact,
whose other side moves with the board.  It is then placed as often as there are units.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.ends import Law, TipLoad
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.generator.guide import lateral_guide, tilt_guide
from tactgen.tmm.generator.held_base import pressed_support
from tactgen.tmm.generator.moving_mass import moving_rod
from tactgen.tmm.generator.positions import RestingPlace
from tactgen.tmm.generator.stops import stops_of
from tactgen.tmm.ports.elements import spring
from tactgen.tmm.ports.multiport import Multiport, connect, reduce, respond, terminate
from tactgen.tmm.ports.port import LATERAL, ROTATION, Port
from tactgen.tmm.ports.terminations import tip_stiffness

#: What a unit shows to the others.
UNIT = ("w_tip", "voltage", "w_board", "psi_board")


def unit_ports(
    bimorph: Multiport, device: Device, place: RestingPlace, tip: TipLoad | Law
) -> Multiport:
    """Return one generator over its tip, its voltage and the board under its head.

    Parameters
    ----------
    bimorph : Multiport
        The five-port, wired as it is.
    device : Device
        Rod and coil are read for what moves with the base; the guide holds it to the sleeve.
    place : RestingPlace
        Where the rod rests: the stop there carries the head, with contact and guide as springs.
    tip : TipLoad or Law
        What loads the tip by itself.
    """
    f, law = bimorph.frequencies, stops_of(device).holding(place.lift)
    held = pressed_support(device, law, place.contact_force)
    guided = {"w_rod": lateral_guide(device).at_rest, "psi_rod": tilt_guide(device).at_rest}
    along = held.lateral_stiffness - guided["w_rod"]
    across = spring(
        f, LATERAL, stiffness=along, damping=law.relaxation_time * along,
        ends=("w_rod", "w_board"),
    )  # fmt: skip
    rocking = spring(
        f, ROTATION, stiffness=held.rotational_stiffness - guided["psi_rod"],
        damping=held.rotational_damping, ends=("psi_rod", "psi_board"),
    )  # fmt: skip
    rod = terminate(_rigid(f, device), guided)
    on_rod = connect(bimorph, rod, {"w_base": "w_rod", "psi_base": "psi_rod"})
    stands = connect(
        on_rod, connect(across, rocking, {}), {"w_base": "w_rod", "psi_base": "psi_rod"}
    )
    return reduce(terminate(stands, {"w_tip": tip_stiffness(tip, f)}), UNIT)


def _rigid(frequencies: Floats, device: Device) -> Multiport:
    """Return rod and coil as a rigid mass over the motion of the rod's top face."""
    body = moving_rod(device)
    coupling = -body.mass * body.centre
    mass = np.array([[body.mass, coupling], [coupling, body.inertia_about(0.0)]])
    omega2 = (2.0 * np.pi * frequencies)[:, None, None] ** 2
    return Multiport(
        frequencies, -omega2 * mass + 0j, (Port("w_rod", LATERAL), Port("psi_rod", ROTATION))
    )


def joined(
    units: dict[str, Multiport], board: Multiport | None, sheet: Multiport | None
) -> Multiport:
    """Return all generators as one, over each one's tip and voltage.

    Parameters
    ----------
    units : dict of str to Multiport
        As :func:`unit_ports`, by name.
    board : Multiport or None
        As :func:`tmm.display.board.board`; None holds every head's board still.
    sheet : Multiport or None
        As :func:`tmm.display.skin.sheet`; None ties no tips.
    """
    whole: Multiport | None = board
    for name, unit in units.items():
        renamed = unit.renamed(
            {"w_tip": f"w_{name}", "voltage": f"voltage_{name}", "psi_board": f"psi_{name}"}
        )
        if board is None:
            renamed = renamed.block(f"w_{name}", f"voltage_{name}")
        if whole is None:
            whole = renamed
            continue
        shared = ("w_board", f"psi_{name}") if board is not None else ()
        whole = connect(whole, renamed, {port: port for port in shared})
    assert whole is not None, "a display has at least one unit"
    kept = [f"{kind}_{name}" for name in units for kind in ("w", "voltage")]
    seen = reduce(whole, kept)
    if sheet is None:
        return seen
    return connect(seen, sheet, {port: port for port in sheet.names})


def tip_motions(array: Multiport, driven: str, units: tuple[str, ...]) -> Complex:
    """Return the tips' motions (n, units) in m per volt at one unit, the others short-circuited."""
    drive = {f"voltage_{name}": float(name == driven) for name in units}
    found = respond(array, drive)
    return np.stack([found.motion[f"w_{name}"] for name in units], axis=1)
