"""Generators joined by name: each on its contact with the board, tips tied by the skin.

One generator is solved once: bimorph (by any model) and rigid rod, on the springs of its contact,
whose other side moves with the board.  It is then placed as often as there are units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.boundary_conditions import Law, TipLoad
from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.device.parameters import Device, Display, Skin
from tactgen.geometry.display.layout import axes, spacer_axes
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.contact import lateral_guide, moving_rod, stops_of, tilt_guide
from tactgen.tmm.generator.equilibrium import RestingPlace, pressed_support, resting_tilt
from tactgen.tmm.ports.multiport import (
    LATERAL,
    ROTATION,
    Multiport,
    Port,
    connect,
    reduce,
    respond,
    terminate,
)
from tactgen.tmm.ports.supports_and_loads import load_tip, spring
from tactgen.tmm.reluctance.flux_ladder import Ladder, solve
from tactgen.tmm.reluctance.magnetic_circuit import CELLS, FULL, circuit

#: What a unit shows to the others.
UNIT = ("w_tip", "voltage", "w_board", "psi_board")


def unit_ports(
    bimorph: Multiport, device: Device, place: RestingPlace, tip: TipLoad | Law
) -> Multiport:
    """One generator over its tip, its voltage and the board under its head.

    Rod and coil move with the base of the bimorph, a five-port wired as it is.  The stop where the
    rod rests carries the head, with the contact as springs; the guide holds it to the sleeve.
    """
    f, law = bimorph.frequencies, stops_of(device).holding(place.lift)
    held = pressed_support(device, law, place.contact_force, resting_tilt(device, place))
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
    return reduce(load_tip(stands, tip), UNIT)


def _rigid(frequencies: Floats, device: Device) -> Multiport:
    """Rod and coil as a rigid mass over the motion of the rod's top face."""
    d = -((2.0 * np.pi * frequencies)[:, None, None] ** 2) * moving_rod(device).mass_matrix + 0j
    return Multiport(frequencies, d, (Port("w_rod", LATERAL), Port("psi_rod", ROTATION)))


def joined(
    units: dict[str, Multiport], board: Multiport | None, sheet: Multiport | None
) -> Multiport:
    """All generators as one, over each one's tip and voltage.

    `units` are as :func:`unit_ports`, by name.  No :func:`board` holds every head's board still, no
    :func:`sheet` ties no tips.
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
    """Tips' motions (n, units) in m per volt at one unit, the others short-circuited."""
    drive = {f"voltage_{name}": float(name == driven) for name in units}
    found = respond(array, drive)
    return np.stack([found.motion[f"w_{name}"] for name in units], axis=1)


#: Poisson ratio of woven glass in epoxy, as the plate stiffness has it (D grows by 2 % from none).
_POISSON = 0.14
#: Waves kept, in k R: what is left out of a head's own tilt falls with the cube of it.
_SHORTEST = 15.0
#: Waves with a natural frequency below this many times the highest are given their inertia.
_DYNAMIC = 10.0


@dataclass(frozen=True)
class PlateWaves:
    """The board's waves as seen by the heads."""

    slopes: Floats  #: (waves, units) Tilt at each head per amplitude (1/m)
    stiffness: Floats  #: (waves,) Per amplitude (N/m)
    mass: float  #: Per amplitude, the same for all (kg)


def plate_waves(device: Device, display: Display) -> PlateWaves:
    """Waves of the upper board between its spacers."""
    from scipy.special import j1

    corner = spacer_axes(display.width, display.board_length, display)[-1]
    a, b = 2.0 * corner[0], 2.0 * corner[1]
    radius, thickness = device.rod.head_radius, display.board_thickness
    most = _SHORTEST / radius
    m, n = np.meshgrid(
        np.arange(1, int(most * a / np.pi) + 2), np.arange(1, int(most * b / np.pi) + 2)
    )
    along_x, along_y = (np.pi * m / a).ravel(), (np.pi * n / b).ravel()
    k = np.hypot(along_x, along_y)
    kept = k <= most
    along_x, along_y, k = along_x[kept], along_y[kept], k[kept]
    x, y = (np.array(c) for c in zip(*axes(display), strict=True))
    slopes = (
        (2.0 * j1(k * radius) / (k * radius) * along_x)[:, None]
        * np.cos(along_x[:, None] * (x + 0.5 * a))
        * np.sin(along_y[:, None] * (y + 0.5 * b))
    )
    bending = display.board_modulus * thickness**3 / (12.0 * (1.0 - _POISSON**2))
    share = 0.25 * a * b
    return PlateWaves(slopes, share * bending * k**4, share * display.board_density * thickness)


def tilt_compliance(waves: PlateWaves, frequencies: Floats, loss: float) -> Complex:
    """Tilts per moment (n, units, units) in rad/(N m), symmetric."""
    omega2 = (2.0 * np.pi * frequencies) ** 2
    slow = waves.stiffness / waves.mass < _DYNAMIC**2 * max(float(omega2.max()), 1.0)
    still, moving = waves.slopes[~slow], waves.slopes[slow]
    rest = (still.T / waves.stiffness[~slow]) @ still / (1.0 + 1j * loss)
    dynamic = waves.stiffness[slow] * (1.0 + 1j * loss) - omega2[:, None] * waves.mass
    return np.asarray(rest + np.einsum("wi,nw,wj->nij", moving, 1.0 / dynamic, moving))


def board(
    device: Device, display: Display, frequencies: Floats, units: tuple[str, ...], mass: float
) -> Multiport:
    """Upper board over ``w_board`` and a tilt ``psi_UNIT`` under each head.

    At frequencies (n,) in Hz; `units` are :func:`geometry.display.layout.unit_names`, `mass` is the
    board's (kg).
    """
    f = np.asarray(frequencies, dtype=float)
    compliance = tilt_compliance(plate_waves(device, display), f, display.board_loss)
    tilts = tuple(Port(f"psi_{unit}", ROTATION) for unit in units)
    inverse = np.linalg.inv(compliance)
    symmetric = np.asarray(0.5 * (inverse + inverse.transpose(0, 2, 1)), dtype=complex)
    bending = Multiport(f, symmetric, tilts)
    held = display.lateral_stiffness * (1.0 + 1j * display.board_loss)
    in_plane = np.asarray(held - (2.0 * np.pi * f) ** 2 * mass, dtype=complex)[:, None, None]
    return connect(Multiport(f, in_plane, (Port("w_board", LATERAL),)), bending, {})


def links(skin: Skin) -> tuple[float, float]:
    """Stiffness (N/m) between neighbours along x and along y."""
    plane = skin.youngs_modulus * skin.thickness / (1.0 - skin.poisson_ratio**2)
    shear = 0.5 * skin.youngs_modulus * skin.thickness / (1.0 + skin.poisson_ratio)
    return plane, shear


def sheet(skin: Skin, display: Display, frequencies: Floats, units: tuple[str, ...]) -> Multiport:
    """Sheet over the tips' lateral motions, ``w_UNIT``; frequencies (n,) in Hz."""
    ties, count = _ties(display, *links(skin)), len(units)
    f = np.asarray(frequencies, dtype=float)
    stiffness = np.broadcast_to(ties * (1.0 + 1j * skin.loss_factor), (f.size, count, count))
    return Multiport(f, stiffness.copy(), tuple(Port(f"w_{unit}", LATERAL) for unit in units))


def _ties(display: Display, along_x: float, along_y: float) -> Floats:
    """Matrix (units, units) of springs between all neighbours along x and along y."""
    ties = np.zeros((display.rows * display.columns,) * 2)
    at = np.arange(len(ties)).reshape(display.rows, display.columns)
    for i, j, tie in ((at[:, :-1], at[:, 1:], along_x), (at[:-1], at[1:], along_y)):
        for pair in zip(i.ravel(), j.ravel(), strict=True):
            ties[pair, pair] += tie
            ties[pair, pair[::-1]] -= tie
    return ties


#: Nearest neighbours in a square array.
NEIGHBOURS = 4
#: Share of the working gap's permeance with which its loss to a small further one is measured.
_SMALL = 1e-3


@dataclass(frozen=True)
class NetworkForces:
    """Pulls (N) at one current and gap, by the network."""

    #: Of one in an endless array, polarities equal or alternating
    same: float
    alternating: float
    #: Of one of the display's middle units, driven alone among others without current
    single: float


def between_heads(device: Device, pitch: float) -> float:
    """Permeance (H) between the heads of two neighbours.

    Raises InputError if the heads touch.
    """
    radius = device.rod.head_radius
    if pitch <= 2.0 * radius:
        raise InputError(
            f"display.pitch = {1e3 * pitch:g} mm lets heads of {2e3 * radius:g} mm touch; set "
            "display.pitch to more than that"
        )
    return float(MU0 * math.pi * device.rod.head_thickness / math.acosh(0.5 * pitch / radius))


def network_forces(
    device: Device, display: Display, current: float, gap: float, cells: int = CELLS
) -> NetworkForces:
    """Pulls of the display's units at a current (A) and gap (m).

    Raises InputError if the parts cannot form the circuit, or the heads touch.
    """
    over = between_heads(device, display.pitch)
    alone = circuit(device, np.array([gap]), FULL, cells)
    pull = _pull(alone, current)
    alternating = _pull(beside(alone, 2.0 * NEIGHBOURS * over), current)
    return NetworkForces(pull, alternating, _one_driven(alone, current, pull, display, over))


def beside(ladder: Ladder, permeance: float) -> Ladder:
    """Circuit with a permeance (H) parallel to its working gap, which pulls nothing."""
    top, slope = ladder.reluctance[:, -1], ladder.d_reluctance[:, -1]
    joined = 1.0 / (1.0 / top + permeance)
    reluctance, d_reluctance = ladder.reluctance.copy(), ladder.d_reluctance.copy()
    reluctance[:, -1] = joined
    d_reluctance[:, -1] = slope * (joined / top) ** 2
    return replace(ladder, reluctance=reluctance, d_reluctance=d_reluctance)


def _pull(ladder: Ladder, current: float) -> float:
    return float(solve(ladder, np.array([current])).force[0, 0])


def _one_driven(alone: Ladder, current: float, pull: float, display: Display, over: float) -> float:
    """Pull (N) of one driven unit among others without current, heads as nodes.

    A unit's permeance from head to sleeve, its iron and winding's path included, is what halves
    the head's magnetic voltage when as much is put beside it.
    """
    gap = 1.0 / float(alone.reluctance[0, -1])
    less = _pull(beside(alone, _SMALL * gap), current)
    if pull <= 0.0:
        return 0.0
    own = _SMALL * gap / (math.sqrt(pull / less) - 1.0)
    return pull * float(head_levels(display, over / own).max()) ** 2  # that of the driven one


def head_levels(display: Display, ratio: float) -> Floats:
    """All heads' magnetic voltages (units,) over that of the driven middle one if alone.

    `ratio` is the permeance between two heads over a unit's own.
    """
    ties = _ties(display, ratio, ratio)
    source = np.zeros(len(ties))
    source[(display.rows - 1) // 2 * display.columns + (display.columns - 1) // 2] = 1.0
    return np.asarray(np.linalg.solve(np.eye(len(ties)) + ties, source))
