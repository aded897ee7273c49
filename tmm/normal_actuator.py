"""What the normal actuator does with its return spring: switching, finger force, heat.

Plain functions of a co-energy map, whichever model it came from.  Static and without
friction: the rod moves as soon as a force difference lets it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats
from geometry.errors import InputError
from geometry.parameters import Device
from geometry.winding import Winding, winding
from tmm.coenergy import CoenergyMap

#: Positions between the stops at which forces are compared, before refinement.
_POSITIONS = 401

#: Halvings of a bracket: down to rounding.
_HALVINGS = 60

#: Heat transfer to still air (W/(m² K)), the most that free convection gives (Incropera and
#: DeWitt, Fundamentals of Heat and Mass Transfer, table 1.1: 2 to 25).
_TO_AIR = 25.0


@dataclass(frozen=True)
class Equilibrium:
    """Where the rod can rest.

    Attributes
    ----------
    gap : float
        Working gap there (m).
    kind : str
        ``upper stop``, ``lower stop``, ``stable`` or ``unstable``, the last two floating
        between the stops.
    """

    gap: float
    kind: str


@dataclass(frozen=True)
class Switching:
    """Currents at which the rod moves, when the current changes slowly (A).

    Attributes
    ----------
    lift_off : float
        The rod leaves the upper stop: the pull there equals the preload.
    pull_in : float
        The last stable place before the lower stop vanishes: the rod arrives there.
        Equal to `lift_off` if the pull outgrows the spring from the start.
    holding : float
        Pull and spring balance at the lower stop: below it the rod leaves the stop.
    drop_out : float
        The last stable place before the upper stop vanishes: the rod is back there.
    """

    lift_off: float
    pull_in: float
    holding: float
    drop_out: float


@dataclass(frozen=True)
class Electrical:
    """The coil at one current and gap.

    Attributes
    ----------
    resistance : float
        Ω, at the wire's temperature.
    power : float
        Heat of the current as direct current (W).
    current_density : float
        In the bare wire (A/m²).
    heating_rate : float
        Of the wire if it gives off no heat (K/s).
    apparent_inductance, incremental_inductance : float
        λ/i and ∂λ/∂i (H).
    time_constant : float
        ∂λ/∂i over the resistance (s), the gap held.
    """

    resistance: float
    power: float
    current_density: float
    heating_rate: float
    apparent_inductance: float
    incremental_inductance: float
    time_constant: float


def map_grid(device: Device, currents: int = 13, gaps: int = 12) -> tuple[Floats, Floats]:
    """Return currents (A) and gaps (m) at which a model is sampled for the device's map.

    Half as much again as the device's current, and from the lower stop to a quarter beyond
    the upper; denser where the map bends: at small currents and small gaps.

    Raises
    ------
    InputError
        If the device's current is 0.
    """
    if device.coil.current == 0.0:
        raise InputError(
            "coil.current = 0 mA spans no map of currents; set the largest current of interest, "
            "such as coil.current=130mA"
        )
    share = np.linspace(0.0, 1.0, currents)
    largest = 1.25 * device.gap
    return (
        1.5 * abs(device.coil.current) * share**1.5,
        np.geomspace(min(device.spring.stop_gap, 0.5 * device.gap), largest, gaps),
    )


def spring_force(device: Device, gap: Floats | float) -> Floats:
    """Return the spring's force (N), which opens the gap."""
    return np.asarray(
        device.spring.preload + device.spring.stiffness * (device.gap - np.asarray(gap))
    )


def finger_force(
    device: Device, pull: CoenergyMap, current: Floats | float, gap: Floats | float
) -> Floats:
    """Return the force on a finger that holds the rod at `gap`: spring less pull (N).

    Positive when the rod pushes against the finger.
    """
    return spring_force(device, gap) - pull.force(current, gap)


def balance_current(device: Device, pull: CoenergyMap, gap: Floats) -> Floats:
    """Return the current (A) at which pull and spring balance at each `gap`; inf if none does."""
    gap = np.asarray(gap, dtype=float)
    against = spring_force(device, gap)
    low, high = np.zeros_like(gap), np.full_like(gap, pull.current_limit)
    within = pull.force(high, gap) >= against
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        enough = pull.force(middle, gap) >= against
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    return np.where(within, high, np.inf)


def switching(device: Device, pull: CoenergyMap) -> Switching:
    """Return the currents at which the rod moves between its stops.

    The balance current i_b(g) tells all: rising, the rod gets past every gap whose i_b it
    exceeds, so it arrives at the largest; falling, it is back at the smallest.

    Raises
    ------
    InputError
        If the stops do not fit the gap or the map, or no current of the map pulls in.
    """
    gaps = _between_stops(device)
    needed = balance_current(device, pull, gaps)
    if not np.isfinite(needed).all():
        raise InputError(
            f"spring.preload = {device.spring.preload * 1e3:g} mN is more than the coil can pull "
            f"with up to {pull.current_limit * 1e3:g} mA; use a softer spring or a larger map"
        )
    return Switching(
        lift_off=float(needed[-1]),
        pull_in=-_least(device, pull, gaps, -needed, -1.0),
        holding=float(needed[0]),
        drop_out=_least(device, pull, gaps, needed, 1.0),
    )


def equilibria(device: Device, pull: CoenergyMap, current: float) -> tuple[Equilibrium, ...]:
    """Return all places where the rod can rest at a constant current, from the top down.

    Floating is stable if the spring stiffens faster than the pull: ∂F/∂g + k > 0.
    """
    gaps = _between_stops(device)
    opening = finger_force(device, pull, current, gaps)
    found = []
    if opening[-1] >= 0.0:
        found.append(Equilibrium(float(gaps[-1]), "upper stop"))
    for k in np.flatnonzero(np.sign(opening[1:]) * np.sign(opening[:-1]) < 0.0)[::-1]:
        gap = _root(device, pull, current, float(gaps[k]), float(gaps[k + 1]))
        slope = float(pull.force_gradient(current, gap)) + device.spring.stiffness
        found.append(Equilibrium(gap, "stable" if slope > 0.0 else "unstable"))
    if opening[0] <= 0.0:
        found.append(Equilibrium(float(gaps[0]), "lower stop"))
    return tuple(found)


def electrical(
    device: Device, pull: CoenergyMap, current: float | None = None, gap: float | None = None
) -> Electrical:
    """Return the coil's electrical values, by default at the device's current and gap."""
    current = device.coil.current if current is None else current
    gap = device.gap if gap is None else gap
    wound = winding(device.coil)
    incremental = float(pull.incremental_inductance(current, gap))
    return Electrical(
        resistance=wound.resistance,
        power=wound.power(current),
        current_density=wound.current_density(current),
        heating_rate=wound.heating_rate(current),
        apparent_inductance=float(pull.apparent_inductance(current, gap)),
        incremental_inductance=incremental,
        time_constant=incremental / wound.resistance,
    )


def steady_temperature_rise(device: Device, current: float) -> float:
    """Return how much warmer (K) than still air the actuator would stay, at the least.

    Free convection at its best from the sleeve's outside and the head's top; what the
    circuit board and the finger lead away is left out, and so is the wire's own rise.
    """
    sleeve, head = device.sleeve, device.rod.head_radius
    surface = 2.0 * math.pi * sleeve.outer_radius * sleeve.length + math.pi * head**2
    return float(winding(device.coil).power(current) / (_TO_AIR * surface))


def thermal_statement(device: Device, current: float) -> str:
    """Return in plain words what the current means for the wire."""
    wound: Winding = winding(device.coil)
    rise = steady_temperature_rise(device, current)
    seconds = 100.0 / wound.heating_rate(current) if current else math.inf
    verdict = (
        "not plausible as a direct current unless the circuit board leads the heat away"
        if rise > 100.0
        else "plausible as a direct current"
    )
    return (
        f"{abs(current) * 1e3:.3g} mA in {wound.wire_diameter * 1e6:.3g} um wire is "
        f"{wound.current_density(current) * 1e-6:.3g} A/mm^2 and {wound.power(current):.3g} W; "
        f"uncooled, the wire would warm by 100 K in {seconds:.2g} s, and still air alone would "
        f"leave the actuator {rise:,.0f} K warmer: {verdict}"
    )


def _between_stops(device: Device) -> Floats:
    """Return gaps from the lower stop to the upper (m)."""
    stop = device.spring.stop_gap
    if not stop < device.gap:
        raise InputError(
            f"spring.stop_gap = {stop * 1e3:g} mm leaves no stroke below gap = "
            f"{device.gap * 1e3:g} mm; use a smaller one"
        )
    return np.linspace(stop, device.gap, _POSITIONS)


def _least(device: Device, pull: CoenergyMap, gaps: Floats, values: Floats, sign: float) -> float:
    """Return the least of `sign` · i_b, looked at closer around its least sample."""
    at = int(np.argmin(values))
    near = np.linspace(gaps[max(at - 1, 0)], gaps[min(at + 1, gaps.size - 1)], _POSITIONS)
    return float(np.min(sign * balance_current(device, pull, near)))


def _root(device: Device, pull: CoenergyMap, current: float, low: float, high: float) -> float:
    """Return the gap between `low` and `high` where the forces balance (m)."""
    sign = math.copysign(1.0, float(finger_force(device, pull, current, low)))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if sign * float(finger_force(device, pull, current, middle)) > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
