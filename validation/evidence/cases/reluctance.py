"""The normal actuator: fields and circuits, TEAM problem 20, the paper."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from tactgen.fem.magnetics.axisymmetric import FieldPoint
from tactgen.fem.magnetics.axisymmetric_force import Eggshell, eggshell_force, virtual_work_force
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.magnetisation import MU0, TEAM20, MagnetisationCurve, linear
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.parts import total_height
from tactgen.geometry.device.reluctance import Steel
from tactgen.geometry.device.support_load_drive import Limits
from tactgen.tmm.generator.small_signal import Linearised
from tactgen.tmm.reluctance.coenergy_map import Samples, closed_loop_work
from tactgen.tmm.reluctance.network import largest_rms_current, network_samples
from tactgen.tmm.reluctance.switching import spring_force
from tactgen.validation.evidence.case import Case, Check, Null, case, nth
from tactgen.validation.evidence.cases import actuator, coils, team20
from tactgen.validation.evidence.cases.actuator import field_point
from tactgen.validation.evidence.cases.ball import ball_error, potential_of
from tactgen.validation.evidence.mesh_levels import cached, intervals, size
from tactgen.validation.models.classes import map_of
from tactgen.validation.models.model import Estimate
from tactgen.validation.models.small_signal import rod_of
from tactgen.validation.scene.load import load_scene

_AXISYMMETRIC = "model axisymmetric: quadrilaterals of order 4 to 6 in the half section"
_EDGE = "second-order edge elements and second-order scalar potential on swept tetrahedra"


# --- air and iron alone ------------------------------------------------------------------------


def _coils_force_by_stress() -> float:
    """Force between them by the stress in the air (N)."""
    field = coils.solved()
    return eggshell_force(field, Eggshell(field.discretisation).weight(field.discretisation))


#: Force (N) between the two coils by the derivative of their mutual inductance.
_COILS_FORCE = math.prod(coils.CURRENTS) * coils.between_windings(
    coils.LOW, coils.HIGH, coils.mutual_inductance_slope
)

_COILS = case(
    "COI", "Two coaxial ring coils in air",
    "Mutual inductance and axial force of two coils of rectangular section on one axis, no iron.",
    [
        Check("Two coaxial ring coils in air have Maxwell's mutual inductance.",
              coils.between_windings(coils.LOW, coils.HIGH, coils.mutual_inductance), "H",
              lambda: float(coils.solved().incremental_inductance[0, 1])),
        Check("The axial force between them, by virtual work, is the derivative of that.",
              _COILS_FORCE, "N", lambda: virtual_work_force(coils.solved())),
        Check("So is the force by the stress in the air.", _COILS_FORCE, "N",
              _coils_force_by_stress),
    ],
    model=_AXISYMMETRIC,
    source="Maxwell, Treatise, art. 701: elliptic integrals over both sections",
    tolerance=1e-5, reason="the accuracy wanted; walls at eighty coil radii leave 2e-6",
)  # fmt: skip


def _profile_error() -> float:
    """Largest deviation from µ0 J (r2 − r) anywhere, over the bore's flux density."""
    field = coils.infinite_solenoid(1e6)
    inside = coils.OUTER - coils.INNER
    exact = MU0 * 1e6 * np.clip(coils.OUTER - field.discretisation.radii, 0.0, inside)
    return float(np.abs(field.flux_density[..., 1] - exact).max() / exact.max())


def _core(curve: MagnetisationCurve, field_strength: float) -> float:
    """Flux density in a long core (T)."""
    field = coils.infinite_solenoid(field_strength / (coils.OUTER - coils.INNER), curve)
    return float(coils.flux_density_in_core(field).mean())


_SOLENOIDS = case(
    "SOL", "Long solenoids, empty and with a core",
    "An infinite solenoid of 10 mm inner and 20 mm outer radius at 1 A/mm²: B on the axis and"
    " across the winding. Then a long core in it: linear (µr = 1000), and of steel, at the knee of "
    "its curve, saturated, and far beyond its last point.",
    [
        Check("The whole profile of a thick infinite solenoid (10 to 20 mm, 1 A/mm²) is µ0 J (r2 − "
              "r1) inside, µ0 J (r2 − r) in the winding and nothing outside.",
              (0.0, coils.SOLENOID_ERROR), "1", _profile_error, 0.0,
              "interpolation of 1/r² at order 6, 18^-5",
              "Ampère's law; profile of ANSYS VM172", "P"),
        Check("A long core with µr = 1000 in it, at 100 A/m, has µ0 µr H.", 4e-2 * math.pi, "T",
              partial(_core, linear(1000.0), 100.0), id="L"),
        *(
            Check(f"A long core of saturating steel at {field:g} A/m has the B of its curve.",
                  exact, "T", partial(_core, TEAM20, field), source="Ampère's law; " + source,
                  id=f"S{number}")
            for number, field, exact, source in (
                (1, 5950.0, 1.7, "a point of the curve, at its knee"),
                (2, 110e3, 2.25, "a point of the curve, saturated"),
                (3, 1e7, 2.3 + 4e-7 * math.pi * (1e7 - 135e3), "vacuum's slope beyond the curve"),
            )
        ),
    ],
    model=_AXISYMMETRIC, source="Ampère's law", tolerance=2e-8,
    reason="the square of the winding's 5e-7 times µr, and Newton's 1e-8",
)  # fmt: skip


_NEWTON = "Newton's 1e-12, and rounding"
_SQUARE_LAW = case(
    "VM213", "Energy and co-energy of a core with B ∝ √H",
    "A transformer core whose flux linkage grows as the root of the current: co-energy and stored "
    "energy at 0.2 A. For this law one is twice the other.",
    [
        Check("The circuit's solver finds the co-energy of a core with B ∝ √H at 0.2 A.",
              1.0 / 30.0, "J", nth(actuator.by_ladder, 0), 1e-11, _NEWTON),
        Check("Its stored energy iλ − W' is half of that.", 1.0 / 60.0, "J",
              nth(actuator.by_ladder, 1), 1e-11, _NEWTON),
        Check("A co-energy map of the same transformer has that co-energy.", 1.0 / 30.0, "J",
              nth(actuator.by_map, 0), 1e-3,
              "no spline follows the root's infinite slope at 0 A"),
        Check("And that energy.", 1.0 / 60.0, "J", nth(actuator.by_map, 1), 3e-3,
              "as VM213-3, with λ a derivative more"),
    ],
    model="model network, and a co-energy map fitted to its samples",
    source="ANSYS VM213 (prints 0.0333 and 0.0166 J); λ ∝ √i in closed form",
)  # fmt: skip


def _ball(potential: str) -> float:
    """Mean flux density in the ball over the exact one, three intervals along each edge."""
    return 1.0 + ball_error(potential_of(potential), intervals(3, least=1))[0]


def _conductors(potential: str) -> float:
    """Force per length between the long strips by the stress in the air (N/m)."""
    return coils.conductors(potential_of(potential), size(0.7))[0]


_BALL = case(
    "BALL", "A permeable ball in a uniform field",
    "A ball of µr = 1000 in a field that is uniform far away has a uniform field inside. The outer "
    "boundary is a concentric sphere, which the reference takes into account.",
    [
        Check(f"The mean B in a ball (µr = 1000) in a uniform field, in 3D by {name}, is exact.",
              1.0, "1", partial(_ball, name), id=name)
        for name in ("A", "phi")
    ],
    model=_EDGE, source="3 µr B0/(µr + 2), corrected for the concentric sphere that holds φ",
    tolerance=1e-3,
    reason="three intervals per edge leave 4e-3 locally, most of which averages out",
)  # fmt: skip
_STRIPS = case(
    "VM188", "Two long parallel conductors",
    "Two long strips that carry 24 A in opposite directions: force per length.",
    [
        Check(f"Two long conductors with 24 A repel as published, in 3D by {name}.", 9.684e-3,
              "N/m", partial(_conductors, name), id=name)
        for name in ("A", "phi")
    ],
    model=_EDGE, source="ANSYS VM188; closed form for thin strips", tolerance=1.5e-3,
    reason="0.1 % of mesh, 0.02 % for the bars' thickness, 0.01 % for the walls",
)  # fmt: skip

# --- the actuator ------------------------------------------------------------------------------


def _estimate(found: FieldPoint, name: str, scale: float = 1.0) -> Estimate:
    """A value of a field over a scale, with its bar."""
    return Estimate(getattr(found, name) / scale, abs(getattr(found.errors, name) / scale))


def _collared(name: str, current: float) -> Estimate:
    """Pull (N), or flux linkage per turn (Wb), of the actuator with a collar."""
    found = field_point(actuator.COLLARED, current, actuator.GAP)
    scale = actuator.COLLARED.coil.turns if name == "flux_linkage" else 1.0
    return _estimate(found, name, scale)


_COLLAR = case(
    "ACT", "An actuator with a collar, solved elsewhere",
    "A reluctance actuator of this kind with a collar on its sleeve, of nonlinear steel: pull and "
    "flux linkage per turn at two currents, by a program that shares nothing with this one. That "
    "solution is not published; the device is stated in full in the source.",
    [
        Check(f"The field of an actuator with a collar has the {words} found by another program "
              f"at {current * 1e3:g} mA.", known[at], unit, partial(_collared, name, current),
              id=f"{letter}{number}")
        for number, (current, known) in enumerate(actuator.KNOWN.items(), start=1)
        for at, (letter, words, unit, name) in enumerate((
            ("F", "pull", "N", "force"), ("L", "flux linkage per turn", "Wb", "flux_linkage"),
        ))
    ],
    model=_AXISYMMETRIC, tolerance=1e-3,
    source="axisymmetric solution by a program that shares nothing with this one, not published",
    reason="the accuracy wanted; the other program states 3e-4 and 1e-4 of its own",
)  # fmt: skip


def _loop(model: Callable[[Floats, Floats], Samples], panels: int) -> float:
    """Net work around a loop of current and gap, over that of one side."""
    net, side = closed_loop_work(model, (0.02, 0.15), (0.03e-3, 0.2e-3), panels)
    return abs(net) / side


def _map_loop(model: str) -> float:
    """The same of the co-energy map that a model makes of the built-in device."""
    return _loop(map_of(load_scene("reluctance", [f"models={model}"])[0]).sampled, 64)


_LOOPS = case(
    "LOOP", "No work around a closed loop",
    "Force and flux linkage that belong to one co-energy do no net work when current and gap are "
    "taken around a rectangle and back.",
    [
        Check("The network's flux linkage and force do no net work around a loop of current and "
              "gap.", (0.0, 1e-6), "1", lambda: _loop(partial(network_samples, Device()), 8), 0.0,
              "relative to one side's work; kinks of the steel's curve under the quadrature"),
        Check("Nor do those of the co-energy map made from it.", (0.0, 1e-6), "1",
              partial(_map_loop, "network")),
        Check("Nor those of the map made from the axisymmetric field.", (0.0, 1e-6), "1",
              partial(_map_loop, "axisymmetric"), heavy=True),
    ],
    model="model network; the co-energy maps made from network and axisymmetric field",
    source="both belong to one co-energy", reason="as LOOP-1",
)  # fmt: skip
_EULER = case(
    "EULER", "Derivatives by all dimensions",
    "If all lengths of a normal actuator grow, and the current with them, H and B stay: the "
    "co-energy grows as the cube of the size, pull and flux linkage as its square. So the "
    "logarithmic derivatives by all lengths and the current, each taken alone, add up to 3, 2 and "
    "2.",
    [
        Check(f"The {words} of a device whose lengths and current are grown together grows as its "
              "power of the size.", power, "1", nth(actuator.powers_of_size, name), id=letter,
              heavy=True)
        for letter, words, name, power in (
            ("W", "co-energy", "coenergy", 3.0), ("L", "flux linkage", "flux_linkage", 2.0),
            ("F", "pull", "magnetic_force", 2.0),
        )
    ],
    model="model axisymmetric, differences on grids that move with each dimension",
    source="at one H and B, W' grows as s³, λ and F as s²", tolerance=2e-3,
    reason="grids of two devices, and air that does not grow",
)  # fmt: skip

#: Currents (A) and gaps (m) of the device at which force and flux linkage are compared: the
#: paper's point, half closed with less current, nearly closed, and beyond both in saturation.
STATES = ((0.13, 0.2e-3), (0.05, 0.1e-3), (0.02, 0.02e-3), (0.195, 0.25e-3))
_AT = [f"at {current * 1e3:g} mA and {gap * 1e3:g} mm" for current, gap in STATES]


def _point(state: int) -> FieldPoint:
    return field_point(Device(), *STATES[state])


def _routes(state: int) -> float:
    """Force by the stress in the air over force by virtual work, on a finer grid.

    Stress needs the field itself and errs by 0.1 % on an answer's grid, where virtual work, which
    needs the energy, errs by 0.005 %.
    """
    found = field_point(Device(), *STATES[state], refinement=1.25)
    return found.force_eggshell / found.force


def _quotient(state: int) -> float:
    """−ΔW'/Δg between two separately meshed gaps, over the force by virtual work."""
    current, gap = STATES[state]
    step = gap / 40.0
    wide, narrow = (field_point(Device(), current, gap + s).coenergy for s in (step, -step))
    return (narrow - wide) / (2.0 * step) / _point(state).force


_FORCES = case(
    "FORCE", "One force by independent routes",
    "The built-in normal actuator at four pairs of current and gap: force by the stress in the "
    "air, by virtual work on one mesh, and as the difference quotient of the co-energy between "
    "gaps that are meshed separately.",
    [
        *(
            Check(f"Stress in the air and virtual work give one force of the device {at}.", 1.0,
                  "1", partial(_routes, state), 1e-3, "the accuracy wanted of the force",
                  "two routes to one force")
            for state, at in enumerate(_AT)
        ),
        *(
            Check(f"The force {at} is −ΔW'/Δg between gaps that are meshed separately.", 1.0, "1",
                  partial(_quotient, state), 2e-3,
                  "the force's 1e-3, and (step/gap)² = 6e-4 of the quotient",
                  "difference quotient", f"D{1 + state}")
            for state, at in enumerate(_AT)
        ),
    ],
    model=_AXISYMMETRIC, tier="solution verification",
)  # fmt: skip

# --- the network against the field -------------------------------------------------------------


def _over(value: float, found: FieldPoint, name: str) -> Estimate:
    """Value over that of a field with its bar, of which the quotient has the share."""
    field, bar = getattr(found, name), getattr(found.errors, name)
    return Estimate(value / field, abs(value / field * bar / field))


def _network_over_field(name: str, state: int, straight: bool = False) -> Estimate:
    """Force or flux linkage of the network over the field's; straight iron has µr = 1000."""
    steel = Steel(curve="linear", relative_permeability=1000.0)
    device, (current, gap) = Device(steel=steel) if straight else Device(), STATES[state]
    network = network_samples(device, np.array([current]), np.array([gap]))
    value = float(getattr(network, name)[0, 0])
    return _over(value, field_point(device, current, gap), name)


@cached
def _rod(model: str, history: str) -> Linearised:
    """The generator's rod at 50 mA in small motions."""
    held = ("coil.current=50mA", f"coil.history={history}", f"models=tmm,{model}")
    scene, _ = load_scene("generator", held)
    return rod_of(scene, map_of(scene))


def _machine(number: Callable[[Linearised], float], history: str) -> float:
    one, other = (number(_rod(model, history)) for model in ("network", "axisymmetric"))
    return one / other


_NO_LEAKAGE = (
    "the network has no field outside the sleeve, below the flange and from the shaft above the "
    "coil, so it misses flux that links the winding, in unsaturated iron as well, where its "
    "force is right (NET-F0)"
)
_SATURATED = (
    "only the saturated steel differs (NET-F0): the leakage that the network leaves out would "
    "saturate the shaft earlier and leave less for the gap"
)
_MACHINE: tuple[tuple[str, Callable[[Linearised], float], str, str, float], ...] = (
    ("rocking stiffness", lambda rod: float(rod.stiffness[1, 1]),
     ("the contact carries the pull less the spring: a pull that is larger by a share leaves more "
     "than that share"), "falling", 0.065),
    ("pull per current", lambda rod: -rod.motional,
     ("a mixed derivative of the field's map where it is steepest: its bar, which the report "
      "shows, is wider than the difference"), "falling", 0.054),
    ("inductance", lambda rod: rod.inductance, _NO_LEAKAGE, "rising", -0.150),
)  # fmt: skip
_NETWORK = case(
    "NET", "The network against the field",
    "Pull and flux linkage of the built-in normal actuator at four pairs of current and gap, first "
    "with straight iron. A network knows flux tubes and no field; what is left is its model form.",
    [
        Check(f"Network and field agree in the force with straight iron (µr = 1000) {_AT[0]}.",
              1.0, "1", partial(_network_over_field, "force", 0, True), id="F0"),
        *(
            Check(f"Network and field agree in the {words} {_AT[state]}.", 1.0, "1",
                  partial(_network_over_field, name, state), id=f"{letter}{1 + state}",
                  explained=why if known else "", known=known)
            for letter, words, name, why, deviations in (
                ("F", "force", "force", _SATURATED, (0.119, 0.0, 0.0, 0.191)),
                ("L", "flux linkage", "flux_linkage", _NO_LEAKAGE,
                 (-0.115, -0.120, -0.051, -0.110)),
            )
            for state, known in enumerate(deviations)
        ),
        *(
            Check(f"In the machine at 50 mA, {history}, network and field agree in the {words}.",
                  1.0, "1", partial(_machine, number, history), id=f"M{2 * i + j + 1}", heavy=True,
                  explained=why if history == differs else "",
                  known=known if history == differs else 0.0)
            for i, (words, number, why, differs, known) in enumerate(_MACHINE)
            for j, history in enumerate(("rising", "falling"))
        ),
    ],
    model="models network and axisymmetric", tier="cross-model", source="axisymmetric field",
    tolerance=0.05, reason="what the network would need to replace the field in a design",
)  # fmt: skip

# --- the paper ---------------------------------------------------------------------------------


def _spring_over_pull(current: float, gap: float) -> Estimate:
    """Force of the spring over the pull."""
    return _over(float(spring_force(Device(), gap)), field_point(Device(), current, gap), "force")


def _spring_over_square_law() -> float:
    """Force of the spring over a pull that goes as (current / gap)²."""
    device = Device()
    gap = device.spring.stop_gap
    pull = 0.110 * (50e-3 / 130e-3 * device.gap / gap) ** 2
    return float(spring_force(device, gap) / pull)


_LATERAL = "paper, set-up of the lateral actuator's measurements"
_PAPER = case(
    "PAP", "The normal actuator against what the paper reports",
    "The reconstructed actuator: pull at 130 mA, holding at 50 mA, pull-in at 120 mA, heat, and "
    "height. It was reconstructed from some of these, and such rows say so.",
    [
        Check("At 130 mA and the 0.2 mm gap the pull is the 110 mN of the spring.", 0.110, "N",
              lambda: _estimate(_point(0), "force"), 0.5e-3 / 110e-3, "the last printed digit",
              "paper section 5.1", "9",
              fitted="the paper gives neither turns nor iron, and 560 turns were chosen to give "
              "this force"),
        Check("50 mA hold the rod firmly at its lower stop: the spring has less force there than "
              "the magnet.", (0.0, 1.0), "1",
              lambda: _spring_over_pull(50e-3, Device().spring.stop_gap), 0.0,
              "a statement without a number; the lower stop's 20 µm and the spring's 100 N/m are "
              "assumed", _LATERAL, "10",
              null=Null("110 mN at 130 mA and 0.2 mm, by the square of current over gap",
                        _spring_over_square_law)),
        Check("120 mA pull the rod down from the 0.2 mm gap, as in the measurement over time.",
              (0.0, 1.0), "1", lambda: _spring_over_pull(120e-3, Device().gap), 0.0,
              "a statement without a number",
              "paper, set-up of the tactile generator's measurement", "11", known=0.0825,
              explained="the device is reconstructed from the other statement, that about 130 mA "
              "are needed at 0.2 mm against 110 mN; the paper's actuator then had a smaller gap, a "
              "weaker spring (it is set by screws), or needs less than 130 mA"),
        Check("The winding stands the 50 mA that hold the rod, for good, at its enamel's 155 °C.",
              (50e-3, 1.0), "A", lambda: largest_rms_current(Device(), Limits()), 0.0,
              "in still air of 20 °C with 25 W/(m² K), the most of free convection", _LATERAL, "13",
              known=-0.010,
              explained="the reconstruction was searched for least heat, and still air alone "
              "carries away that of a little less current; the circuit board, in which the "
              "sleeve is fixed, is left out and carries the rest many times over"),
        Check("Lateral and normal actuator together are 41 mm high, from the tip to the sleeve's "
              "lower end.", 41e-3, "m",
              lambda: total_height(load_scene("bimorph_on_rod")[0].device), 0.5 / 41.0,
              "the last printed digit", "paper section 5.1", "12",
              fitted="the sleeve was given the length that is left"),
    ],
    model="models axisymmetric and network; the CAD layout", tier="validation", scene="reluctance",
)  # fmt: skip

CASES: tuple[Case, ...] = (
    _COILS, _SOLENOIDS, _SQUARE_LAW, _BALL, _STRIPS, _COLLAR, _LOOPS, _EULER, _FORCES, _NETWORK,
    team20.CASE, _PAPER,
)  # fmt: skip
