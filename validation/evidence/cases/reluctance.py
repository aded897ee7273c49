"""The checks of the normal actuator as declarative rows; see :mod:`validation.evidence.case`."""

from __future__ import annotations

import math
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
from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.tmm.reluctance.network import largest_rms_current, network_samples
from tactgen.tmm.reluctance.switching import spring_force
from tactgen.validation.engine.results import Estimate
from tactgen.validation.evidence.case import Check
from tactgen.validation.evidence.cases import actuator as collared_actuator
from tactgen.validation.evidence.cases import actuator as scaled_actuator
from tactgen.validation.evidence.cases import actuator as square_law
from tactgen.validation.evidence.cases import coils as coaxial_coils
from tactgen.validation.evidence.cases import coils as infinite_solenoid
from tactgen.validation.evidence.cases.actuator import field_point
from tactgen.validation.evidence.cases.ball import Potential, ball_error
from tactgen.validation.evidence.cases.coils import conductors
from tactgen.validation.evidence.cases.team20 import TEAM20_CHECKS
from tactgen.validation.evidence.mesh_levels import cached, degree, intervals, size
from tactgen.validation.models.generator.small_signal import rod_of
from tactgen.validation.scene.scene import load_scene

#: Currents (A) and gaps (m) of the device at which force and flux linkage are compared: the
#: paper's point, half closed with less current, nearly closed, and beyond both in saturation.
STATES = ((0.13, 0.2e-3), (0.05, 0.1e-3), (0.02, 0.02e-3), (0.195, 0.25e-3))


def _potential(name: str) -> Potential:
    from tactgen.fem.magnetics.problem_3d import ScalarPotential, VectorPotential

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
    """Its stored energy iλ − W' (J)."""
    linkage = float(square_law.by_ladder().flux_linkage[0, 0])
    return square_law.CURRENT * linkage - ladder_coenergy()


@cached
def _square_law_map() -> CoenergyMap:
    return square_law.by_map()


def map_coenergy() -> float:
    """Co-energy of the same transformer read off a co-energy map (J)."""
    return float(_square_law_map().coenergy(square_law.CURRENT, square_law.SQUARE_LAW_GAP))


def map_energy() -> float:
    """Its stored energy by the map (J)."""
    return float(_square_law_map().energy(square_law.CURRENT, square_law.SQUARE_LAW_GAP))


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
    """Value over that of a field with its bar, of which the quotient has the share."""
    return Estimate(value / field, abs(value / field * bar / field))


def network_over_field_straight_iron() -> Estimate:
    """Ratio at the paper's point with linear iron, µr = 1000."""
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
    """Closed-loop work of the network's map."""
    device = Device()
    return _loop(fit(network_samples(device, *map_grid(device))).sampled, 64)


def field_map_loop_work() -> float:
    """Closed-loop work of the axisymmetric field's map."""
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
    """Number of the generator's rod at 50 mA by the network over that by the field."""
    one, other = (_number(_rod(model, history), name) for model in ("network", "axisymmetric"))
    return one / other


_MAXWELL = "Maxwell, Treatise, art. 701: elliptic integrals over both sections"


_OPEN = "the accuracy wanted; walls at eighty coil radii leave 2e-6"


_VM172 = "Ampère's law; profile of ANSYS VM172"


_ORDER6 = "interpolation of 1/r² at order 6, 18^-5"


_CORE = "the square of the winding's 5e-7 times µr, and Newton's 1e-8"


_VM213 = "ANSYS VM213 (prints 0.0333 and 0.0166 J); λ ∝ √i in closed form"


_BALL = "3 µr B0/(µr + 2), corrected for the concentric sphere that holds φ"


_BALL_REASON = "three intervals per edge leave 4e-3 locally, most of which averages out"


_VM188 = "ANSYS VM188; closed form for thin strips"


_STRIPS = "0.1 % of mesh, 0.02 % for the bars' thickness, 0.01 % for the walls"


_KNOWN: tuple[Check, ...] = (
    Check(
        "COI-1", "code verification",
        "Two coaxial ring coils in air have Maxwell's mutual inductance.",
        1.6463772056050563e-4, "H", _MAXWELL, 1e-5, _OPEN, coils_mutual_inductance,
    ),
    Check(
        "COI-2", "code verification",
        "The axial force between them, by virtual work, is the derivative of that.",
        -3.829353438769843e-2, "N", _MAXWELL, 1e-5, _OPEN, coils_force,
    ),
    Check(
        "COI-3", "code verification",
        "So is the force by the stress in the air.",
        -3.829353438769843e-2, "N", _MAXWELL, 1e-5, _OPEN, coils_force_by_stress,
    ),
    Check(
        "SOL-B", "code verification",
        "Inside a thick infinite solenoid (10 to 20 mm, 1 A/mm²) B is µ0 J (r2 − r1).",
        4e-3 * math.pi, "T", _VM172, 18.0**-5, _ORDER6, solenoid_bore,
    ),
    Check(
        "SOL-P", "code verification",
        "Its whole profile is µ0 J (r2 − r) in the winding and nothing outside.",
        (0.0, 18.0**-5), "1", _VM172, 0.0, _ORDER6, solenoid_profile_error,
    ),
    Check(
        "SOL-L", "code verification",
        "A long core with µr = 1000 in it, at 100 A/m, has µ0 µr H.",
        4e-2 * math.pi, "T", "Ampère's law", 2e-8, _CORE, linear_core,
    ),
    *(
        Check(
            f"SOL-S{number}", "code verification",
            f"A long core of saturating steel at {field:g} A/m has the B of its curve.",
            exact, "T", "Ampère's law; " + source, 2e-8, _CORE, partial(saturating_core, field),
        )
        for number, (field, exact, source) in enumerate(
            (
                (5950.0, 1.7, "a point of the curve, at its knee"),
                (110e3, 2.25, "a point of the curve, saturated"),
                (1e7, 2.3 + 4e-7 * math.pi * (1e7 - 135e3), "vacuum's slope beyond the curve"),
            ),
            start=1,
        )
    ),
    Check(
        "VM213-1", "code verification",
        "The circuit's solver finds the co-energy of a core with B ∝ √H at 0.2 A.",
        1.0 / 30.0, "J", _VM213, 1e-11, "Newton's 1e-12, and rounding", ladder_coenergy,
    ),
    Check(
        "VM213-2", "code verification",
        "Its stored energy iλ − W' is half of that.",
        1.0 / 60.0, "J", _VM213, 1e-11, "Newton's 1e-12, and rounding", ladder_energy,
    ),
    Check(
        "VM213-3", "code verification",
        "A co-energy map of the same transformer has that co-energy.",
        1.0 / 30.0, "J", _VM213, 1e-3, "no spline follows the root's infinite slope at 0 A",
        map_coenergy,
    ),
    Check(
        "VM213-4", "code verification",
        "And that energy.",
        1.0 / 60.0, "J", _VM213, 3e-3, "as VM213-3, with λ a derivative more", map_energy,
    ),
    *(
        Check(
            f"BALL-{name}", "code verification",
            f"The mean B in a ball (µr = 1000) in a uniform field, in 3D by {name}, is exact.",
            1.0, "1", _BALL, 1e-3, _BALL_REASON, partial(ball_mean, name),
        )
        for name in ("A", "phi")
    ),
    *(
        Check(
            f"VM188-{name}", "code verification",
            f"Two long conductors with 24 A repel as published, in 3D by {name}.",
            9.684e-3, "N/m", _VM188, 1.5e-3, _STRIPS, partial(conductor_force, name),
        )
        for name in ("A", "phi")
    ),
    *(
        Check(
            f"ACT-{letter}{1 + number}", "code verification",
            f"The field of an actuator with a collar has the {name} found by another program at "
            f"{current * 1e3:g} mA.",
            known[place], unit, "axisymmetric solution by a program that shares nothing with this "
            "one, not published", 1e-3,
            "the accuracy wanted; the other program states 3e-4 and 1e-4 of its own",
            partial(measure, current),
        )
        for number, (current, known) in enumerate(collared_actuator.KNOWN.items())
        for place, (letter, name, unit, measure) in enumerate(
            (
                ("F", "pull", "N", collared_force),
                ("L", "flux linkage per turn", "Wb", collared_linkage),
            )
        )
    ),
    Check(
        "LOOP-1", "code verification",
        "The network's flux linkage and force do no net work around a loop of current and gap.",
        (0.0, 1e-6), "1", "both belong to one co-energy", 0.0,
        "relative to one side's work; kinks of the steel's curve under the quadrature",
        network_loop_work,
    ),
    Check(
        "LOOP-2", "code verification",
        "Nor do those of the co-energy map made from it.",
        (0.0, 1e-6), "1", "both belong to one co-energy", 0.0, "as LOOP-1",
        network_map_loop_work,
    ),
    Check(
        "LOOP-3", "code verification",
        "Nor those of the map made from the axisymmetric field.",
        (0.0, 1e-6), "1", "both belong to one co-energy", 0.0, "as LOOP-1",
        field_map_loop_work, heavy=True,
    ),
    *(
        Check(
            f"EULER-{letter}", "code verification",
            f"The {words} of a device whose lengths and current are grown together grows as its "
            "power of the size.",
            power, "1", "at one H and B, W' grows as s³, λ and F as s²", 2e-3,
            "grids of two devices, and air that does not grow",
            partial(scaled_actuator.power_of_size, name), heavy=True,
        )
        for letter, words, name, power in (
            ("W", "co-energy", "coenergy", 3.0),
            ("L", "flux linkage", "flux_linkage", 2.0),
            ("F", "pull", "magnetic_force", 2.0),
        )
    ),
)  # fmt: skip


def _at(state: int) -> str:
    current, gap = STATES[state]
    return f"at {current * 1e3:g} mA and {gap * 1e3:g} mm"


_ROUTES: tuple[Check, ...] = (
    *(
        Check(
            f"FORCE-{1 + state}", "solution verification",
            f"Stress in the air and virtual work give one force of the device {_at(state)}.",
            1.0, "1", "two routes to one force", 1e-3, "the accuracy wanted of the force",
            partial(routes_ratio, state),
        )
        for state in range(len(STATES))
    ),
    *(
        Check(
            f"FORCE-D{1 + state}", "solution verification",
            f"The force {_at(state)} is −ΔW'/Δg between gaps that are meshed separately.",
            1.0, "1", "difference quotient", 2e-3,
            "the force's 1e-3, and (step/gap)² = 6e-4 of the quotient",
            partial(difference_quotient_ratio, state),
        )
        for state in range(len(STATES))
    ),
)  # fmt: skip


_DESIGN = "what the network would need to replace the field in a design"


_NO_LEAKAGE = (
    "the network has no field outside the sleeve, below the flange and from the shaft above the "
    "coil, so it misses flux that links the winding: with unsaturated iron (µr = 1000) its flux "
    "linkage is 5 to 17 % too small while its force is right (NET-F0)"
)


_SATURATED = (
    "only the saturated steel differs (NET-F0): the leakage that the network leaves out would "
    "saturate the shaft earlier and leave less for the gap"
)


#: What of the machine is compared, the rod up or held down, and why it differs, by how much.
_MACHINE: tuple[tuple[Number, str, str, float], ...] = (
    ("rocking stiffness", "rising", "", 0.0),
    ("rocking stiffness", "falling",
     ("the contact carries the pull less the spring: a pull some 5 % larger in the closed gap "
      "leaves more than that"), 0.065),
    ("pull per current", "rising", "", 0.0),
    ("pull per current", "falling",
     ("a mixed derivative of the field's map where it is steepest: its bar, which the report "
      "shows, is twice as wide as the difference"), 0.054),
    ("inductance", "rising", _NO_LEAKAGE, -0.150),
    ("inductance", "falling", "", 0.0),
)  # fmt: skip


#: Deviations of force and flux linkage that the explanations were written for; 0 where within 5 %.
_FORCE_DEVIATIONS = (0.119, 0.0, 0.0, 0.191)


_LINKAGE_DEVIATIONS = (-0.115, -0.120, -0.051, -0.110)


_MODELS: tuple[Check, ...] = (
    Check(
        "NET-F0", "cross-model",
        f"Network and field agree in the force with straight iron (µr = 1000) {_at(0)}.",
        1.0, "1", "axisymmetric field", 0.05, _DESIGN, network_over_field_straight_iron,
    ),
    *(
        Check(
            f"NET-F{1 + state}", "cross-model",
            f"Network and field agree in the force {_at(state)}.",
            1.0, "1", "axisymmetric field", 0.05, _DESIGN,
            partial(network_over_field_force, state),
            explained=_SATURATED if known else "", known=known,
        )
        for state, known in enumerate(_FORCE_DEVIATIONS)
    ),
    *(
        Check(
            f"NET-L{1 + state}", "cross-model",
            f"Network and field agree in the flux linkage {_at(state)}.",
            1.0, "1", "axisymmetric field", 0.05, _DESIGN,
            partial(network_over_field_linkage, state), explained=_NO_LEAKAGE, known=known,
        )
        for state, known in enumerate(_LINKAGE_DEVIATIONS)
    ),
    *(
        Check(
            f"NET-M{1 + number}", "cross-model",
            f"In the machine at 50 mA, {history}, network and field agree in the {name}.",
            1.0, "1", "axisymmetric field", 0.05, _DESIGN,
            partial(network_over_field_machine, name, history), explained=why, known=known,
            heavy=True,
        )
        for number, (name, history, why, known) in enumerate(_MACHINE)
    ),
)  # fmt: skip


_VALIDATION: tuple[Check, ...] = (
    Check(
        "PAP-9", "validation",
        "At 130 mA and the 0.2 mm gap the pull is the 110 mN of the spring.",
        0.110, "N", "paper section 5.1", 0.5e-3 / 110e-3, "the last printed digit",
        paper_force, scene="reluctance",
        fitted="the paper gives neither turns nor iron, and 560 turns were chosen to give this "
        "force",
    ),
    Check(
        "PAP-10", "validation",
        "50 mA hold the rod firmly at its lower stop: the spring has less force there than the "
        "magnet.",
        (0.0, 1.0), "1", "paper, set-up of the lateral actuator's measurements", 0.0,
        "a statement without a number; the lower stop's 20 µm and the spring's 100 N/m are assumed",
        spring_over_pull_held, scene="reluctance",
    ),
    Check(
        "PAP-11", "validation",
        "120 mA pull the rod down from the 0.2 mm gap, as in the measurement over time.",
        (0.0, 1.0), "1", "paper, set-up of the tactile generator's measurement", 0.0,
        "a statement without a number", spring_over_pull_at_upper_stop,
        scene="reluctance",
        explained="the device is reconstructed from the other statement, that about 130 mA are "
        "needed at 0.2 mm against 110 mN; the paper's actuator then had a smaller gap, a weaker "
        "spring (it is set by screws), or needs less than 130 mA",
        known=0.0825,
    ),
    Check(
        "PAP-13", "validation",
        "The winding stands the 50 mA that hold the rod, for good, at its enamel's 155 °C.",
        (50e-3, 1.0), "A", "paper, set-up of the lateral actuator's measurements", 0.0,
        "in still air of 20 °C with 25 W/(m² K), the most of free convection",
        largest_held_current, scene="reluctance",
        explained="the reconstruction was searched for least heat, and still air alone carries "
        "away that of 49.5 mA, one percent less; the circuit board, in which the sleeve is fixed, "
        "is left out and carries the rest many times over",
        known=-0.010,
    ),
    Check(
        "PAP-12", "validation",
        "Lateral and normal actuator together are 41 mm high, from the tip to the sleeve's lower "
        "end.",
        41e-3, "m", "paper section 5.1", 0.5 / 41.0, "the last printed digit",
        generator_height, scene="reluctance",
        fitted="the sleeve was given the length that is left",
    ),
)  # fmt: skip


#: Every row of the normal actuator.
CASES: tuple[Check, ...] = (
    *_KNOWN, *_ROUTES, *_MODELS, *TEAM20_CHECKS, *_VALIDATION,
)  # fmt: skip
