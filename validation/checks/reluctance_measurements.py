"""What the rows of :mod:`validation.checks.reluctance` measure: known cases, and the device."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from tactgen.fem.magnetics.axisymmetric import FieldPoint, solve_map
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.layout import total_height
from tactgen.geometry.device.parameters import Device, Limits, Steel
from tactgen.geometry.device.steel_law import TEAM20, MagnetisationCurve, linear
from tactgen.tmm.generator.small_signal import Linearised
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap, Samples, closed_loop_work
from tactgen.tmm.reluctance.coil_heat import largest_rms_current
from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.tmm.reluctance.network import network_samples
from tactgen.tmm.reluctance.switching import spring_force
from tactgen.validation.checks.cases.fineness import cached, degree, intervals, size
from tactgen.validation.checks.cases.magnetics import (
    coaxial_coils,
    collared_actuator,
    infinite_solenoid,
    square_law,
)
from tactgen.validation.checks.cases.magnetics.actuator_field import field_point
from tactgen.validation.checks.cases.magnetics.long_conductors import conductors
from tactgen.validation.checks.cases.magnetics.sphere_in_field import Potential, ball_error
from tactgen.validation.engine.results import Estimate
from tactgen.validation.models.generator.small_signal import rod_of
from tactgen.validation.scene.scene import load_scene

#: Currents (A) and gaps (m) of the device at which force and flux linkage are compared: the
#: paper's point, half closed with less current, nearly closed, and beyond both in saturation.
STATES = ((0.13, 0.2e-3), (0.05, 0.1e-3), (0.02, 0.02e-3), (0.195, 0.25e-3))


def _potential(name: str) -> Potential:
    from tactgen.fem.magnetics.scalar_potential import ScalarPotential
    from tactgen.fem.magnetics.vector_potential import VectorPotential

    return VectorPotential if name == "A" else ScalarPotential


def coils_mutual_inductance() -> float:
    """Mutual inductance of the two coaxial coils (H)."""
    return float(coaxial_coils.solved().incremental_inductance[0, 1])


def coils_force() -> float:
    """Force between them by virtual work (N)."""
    from tactgen.fem.magnetics.axisymmetric_force import virtual_work_force

    return virtual_work_force(coaxial_coils.solved())


def coils_force_by_stress() -> float:
    """Force between them by the stress in the air (N)."""
    from tactgen.fem.magnetics.axisymmetric_force import eggshell_force, eggshell_weight

    field = coaxial_coils.solved()
    return eggshell_force(field, eggshell_weight(field.discretisation))


def solenoid_bore() -> float:
    """Flux density inside the thick solenoid at 1 A/mm² (T): the mean over the bore's points."""
    field = infinite_solenoid.infinite_solenoid(1e6)
    inside = field.discretisation.radii < infinite_solenoid.INNER
    return float(field.flux_density[..., 1][inside].mean())


def solenoid_profile_error() -> float:
    """Largest deviation from µ0 J (r2 − r) anywhere, over the bore's flux density."""
    field = infinite_solenoid.infinite_solenoid(1e6)
    exact = infinite_solenoid.exact_profile(1e6, field.discretisation.radii)
    return float(np.abs(field.flux_density[..., 1] - exact).max() / exact.max())


def _core(curve: MagnetisationCurve, field_strength: float) -> float:
    thickness = infinite_solenoid.OUTER - infinite_solenoid.INNER
    field = infinite_solenoid.infinite_solenoid(field_strength / thickness, curve)
    return float(infinite_solenoid.flux_density_in_core(field).mean())


def linear_core() -> float:
    """Flux density in a core of µr = 1000 at 100 A/m (T)."""
    return _core(linear(1000.0), 100.0)


def saturating_core(field_strength: float) -> float:
    """Flux density in a core of TEAM problem 20's steel (T)."""
    return _core(TEAM20, field_strength)


def ladder_coenergy() -> float:
    """Co-energy of the square-law transformer by the circuit's solver (J)."""
    return float(square_law.by_ladder().coenergy[0, 0])


def ladder_energy() -> float:
    """Return its stored energy iλ − W' (J)."""
    linkage = float(square_law.by_ladder().flux_linkage[0, 0])
    return square_law.CURRENT * linkage - ladder_coenergy()


@cached
def _square_law_map() -> CoenergyMap:
    return square_law.by_map()


def map_coenergy() -> float:
    """Co-energy of the same transformer read off a co-energy map (J)."""
    return float(_square_law_map().coenergy(square_law.CURRENT, square_law.GAP))


def map_energy() -> float:
    """Return its stored energy by the map (J)."""
    return float(_square_law_map().energy(square_law.CURRENT, square_law.GAP))


def ball_mean(potential: str) -> float:
    """Mean flux density in the ball over the exact one, three intervals along each edge."""
    return 1.0 + ball_error(_potential(potential), intervals(3, least=1))[0]


def conductor_force(potential: str) -> float:
    """Force per length between the long strips by the stress in the air (N/m)."""
    return conductors(_potential(potential), size(0.7))[0]


def _point(state: int) -> FieldPoint:
    return field_point(Device(), *STATES[state])


@cached
def _network(state: int) -> Samples:
    current, gap = STATES[state]
    return network_samples(Device(), np.array([current]), np.array([gap]))


def routes_ratio(state: int) -> float:
    """Force by the stress in the air over force by virtual work, on a finer grid.

    Stress needs the field itself and errs by 0.1 % on an answer's grid, where virtual work, which
    needs the energy, errs by 0.005 %.
    """
    found = field_point(Device(), *STATES[state], refinement=1.25)
    return found.force_eggshell / found.force


def difference_quotient_ratio(state: int) -> float:
    """−ΔW'/Δg between two separately meshed gaps, over the force by virtual work."""
    current, gap = STATES[state]
    step = gap / 40.0
    wide, narrow = (field_point(Device(), current, gap + s).coenergy for s in (step, -step))
    return (narrow - wide) / (2.0 * step) / _point(state).force


def network_over_field_force(state: int) -> Estimate:
    """Force of the network over the field's."""
    found = _point(state)
    return _over(float(_network(state).force[0, 0]), found.force, found.errors.force)


def _over(value: float, field: float, bar: float) -> Estimate:
    """Return a value over that of a field with its bar, of which the quotient has the share."""
    return Estimate(value / field, abs(value / field * bar / field))


def network_over_field_straight_iron() -> Estimate:
    """Return the same at the paper's point with straight iron, µr = 1000."""
    device = Device(steel=Steel(curve="linear", relative_permeability=1000.0))
    current, gap = STATES[0]
    network = network_samples(device, np.array([current]), np.array([gap]))
    found = field_point(device, current, gap)
    return _over(float(network.force[0, 0]), found.force, found.errors.force)


def network_over_field_linkage(state: int) -> Estimate:
    """Flux linkage of the network over the field's."""
    found, linkage = _point(state), float(_network(state).flux_linkage[0, 0])
    return _over(linkage, found.flux_linkage, found.errors.flux_linkage)


def collared_force(current: float) -> Estimate:
    """Pull of the actuator with a collar (N)."""
    found = collared_actuator.field(current)
    return Estimate(found.force, found.errors.force)


def collared_linkage(current: float) -> Estimate:
    """Flux linkage per turn of the same (Wb)."""
    found, turns = collared_actuator.field(current), collared_actuator.COLLARED.coil.turns
    return Estimate(found.flux_linkage / turns, found.errors.flux_linkage / turns)


def largest_held_current() -> float:
    """Effective current that the winding stands for good in still air (A)."""
    return largest_rms_current(Device(), Limits())


def generator_height() -> float:
    """Height of the built-in generator, from the tip to the sleeve's lower end (m)."""
    return total_height(load_scene("bimorph_on_rod")[0].device)


def paper_force() -> Estimate:
    """Pull of the reconstructed device at 130 mA and 0.2 mm by the axisymmetric field (N)."""
    found = _point(0)
    return Estimate(found.force, found.errors.force)


def spring_over_pull_held() -> Estimate:
    """Force of the spring over the pull with 50 mA at the lower stop."""
    device = Device()
    gap = device.spring.stop_gap
    found = field_point(device, 50e-3, gap)
    return _over(float(spring_force(device, gap)), found.force, found.errors.force)


def spring_over_pull_at_upper_stop() -> Estimate:
    """Force of the spring over the pull with 120 mA at the upper stop."""
    device = Device()
    found = field_point(device, 120e-3)
    return _over(float(spring_force(device, device.gap)), found.force, found.errors.force)


def _loop(model: Callable[[Floats, Floats], Samples], panels: int) -> float:
    net, side = closed_loop_work(model, (0.02, 0.15), (0.03e-3, 0.2e-3), panels)
    return abs(net) / side


def network_loop_work() -> float:
    """Net work of the network itself around a loop, over that of one side."""
    return _loop(partial(network_samples, Device()), 8)


def network_map_loop_work() -> float:
    """Return the same of the map made from the network."""
    device = Device()
    return _loop(fit(network_samples(device, *map_grid(device))).sampled, 64)


def field_map_loop_work() -> float:
    """Return the same of the map made from the axisymmetric field."""
    device = Device()
    currents, gaps = map_grid(device, 8, 8)
    rows = solve_map(device, gaps.tolist(), currents.tolist(), order=degree(3))
    linkage, force = (
        np.array([[getattr(point, name) for point in row] for row in rows]).T
        for name in ("flux_linkage", "force")
    )
    return _loop(fit(Samples(currents, gaps, linkage, force)).sampled, 64)


#: What is compared: see :class:`tmm.generator.small_signal.Linearised`.
Number = Literal["rocking stiffness", "pull per current", "inductance"]


@cached
def _rod(model: str, history: str) -> Linearised:
    held = ("coil.current=50mA", f"coil.history={history}", f"models=tmm,{model}")
    scene, _ = load_scene("generator", held)
    return rod_of(scene, scene.pull)


def _number(rod: Linearised, name: Number) -> float:
    numbers = {
        "rocking stiffness": float(rod.stiffness[1, 1]),
        "pull per current": -rod.motional,
        "inductance": rod.inductance,
    }
    return numbers[name]


def network_over_field_machine(name: Number, history: str) -> float:
    """Return a number of the generator's rod at 50 mA by the network over that by the field."""
    one, other = (_number(_rod(model, history), name) for model in ("network", "axisymmetric"))
    return one / other
