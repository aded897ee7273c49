"""Bars of the normal actuator's models and of the machine: random devices against finer answers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, TypeAlias, TypeVar

import numpy as np

from tactgen.fem.magnetics.actuator_3d import solve_solid
from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.reluctance.section_grid import actuator_regions, air_radius
from tactgen.geometry.reluctance.sector_tets import Sector
from tactgen.tmm.generator.equilibrium import axial_forces, resting_place
from tactgen.tmm.generator.transient.machine import Machine
from tactgen.tmm.generator.transient.system import System
from tactgen.tmm.generator.transient.time_integration import Answer, output_at, simulate
from tactgen.tmm.generator.transient.waveform import Sine, Sources, Step
from tactgen.tmm.reluctance.calibrated import VALUES, State, sizes
from tactgen.tmm.reluctance.magnetic_circuit import CELLS
from tactgen.tmm.reluctance.map_range import map_grid, network_map
from tactgen.tmm.reluctance.network import DirectForce, network_samples
from tactgen.tmm.reluctance.switching import between_stops, spring_force
from tactgen.validation.catalogue.quantities import QUANTITIES, AnswerReadout
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.evidence import random_devices
from tactgen.validation.evidence.judgement import Judged, relative
from tactgen.validation.evidence.random_devices import accepted, between
from tactgen.validation.models.classes import make_model, map_of
from tactgen.validation.models.model import Stages
from tactgen.validation.models.small_signal import RodWithError, SmallSignal, rod_by_network
from tactgen.validation.models.transient import scene_machine
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene

#: The reference's order, refinement of the grid, and how many times as far its walls are.
_ORDER, _REFINEMENT, _FARTHER = 5, 1.5, 3.0
#: Quantities of the network, in the order of the calibration's values.
_NETWORK = ("magnetic_force", *VALUES[1:])

T = TypeVar("T")

#: A field with its error bars, and a better one.
Fields: TypeAlias = tuple[Any, Any]


def judge_axisymmetric(rng: np.random.Generator) -> list[Judged]:
    """Answers of one device, drawn by `rng`."""

    def solved(device: Device) -> Fields:
        farther = _FARTHER * air_radius(actuator_regions(device, device.gap))
        right = solve_point(device, order=_ORDER, refinement=_REFINEMENT, outer_radius=farther)
        return solve_point(device), right

    return judged_fields(rng, solved)


def judged_fields(rng: np.random.Generator, solved: Callable[[Device], Fields]) -> list[Judged]:
    """Answers of one device, drawn by `rng`; dimensions that do not fit are redrawn."""
    _, where, (found, right) = _fitting(
        "reluctance", lambda: random_devices.overrides(rng, random_devices.ACTUATOR),
        lambda scene: solved(scene.device),
    )  # fmt: skip
    return [
        one for name in VALUES
        for one in relative(where, name, getattr(found, name), getattr(found.errors, name),
                            getattr(right, name))
    ]  # fmt: skip


def judge_network(rng: np.random.Generator) -> list[Judged]:
    """Modelling errors of the network for a fresh actuator of those that it is calibrated on.

    Relative to the sizes that the calibration's errors are stated for.
    """
    fresh = np.random.default_rng(int(rng.integers(2**62)))  # no stream of the calibration's own
    scene, where, (found, field) = _fitting(
        "reluctance", lambda: random_devices.any_actuator(fresh),
        lambda scene: (solve(scene, ["network"], _NETWORK), solve_point(scene.device)),
    )  # fmt: skip
    right = np.array([getattr(field, name) for name in VALUES])
    state = State(*right[:, None])
    size = sizes(state, np.array([scene.coil.current]), np.array([scene.gap]))[:, 0]
    judged = []
    for name, known, of in zip(_NETWORK, right, size, strict=True):
        q = found.get(name, "network")
        off = float(abs(q.value - known) / of)
        judged.append(Judged(where, name, off, float(q.modelling_error / of)))
    return judged


#: Lines of the sector's grid, of the usual: less than half to two thirds.
_REFINEMENTS = 0.4, 0.65


def judge_magnetic3d(rng: np.random.Generator) -> list[Judged]:
    """Answers of one device without a slot, drawn by `rng`."""

    def solved(device: Device) -> Fields:
        # drawn anew with each device: too coarse a grid is refused
        sector = Sector(refinement=between(rng, *_REFINEMENTS))
        return solve_solid(device, device.coil.current, device.gap, sector), solve_point(device)

    return judged_fields(rng, solved)


#: How many times as many cells as the map's the references' ladders have: of switching currents,
#: and of small motions, which are solved with twice as many.
_FINER, _FINEST = 4, 8
#: How many times as long the reference's differences are: in so many cells rounding is larger.
_LONGER = 4.0
_MOTIONS = (
    "lateral_tip_per_voltage", "axial_tip_per_current", "axial_tip_per_coil_voltage",
    "coil_impedance",
)  # fmt: skip
_SWITCHING = ("pull_in_current", "holding_current", "drop_out_current")
#: Currents and gaps at which a map is judged; gaps among which an extreme is looked for.
_POINTS, _GAPS = 20, 9


def judge_map(rng: np.random.Generator) -> list[Judged]:
    """Largest errors of one device's map, drawn by `rng`, against the network itself.

    Relative to a tenth of the largest at that gap, where less: so the map states them.  Judged
    inside, and at the largest current and at both ends of the gaps.
    """
    scene, where, surface = _machine(rng, lambda scene: network_map(scene.device))
    most, ends = surface.current_limit, surface.gap_limits
    currents = np.sort(np.append(rng.uniform(0.0, most, _POINTS), most))
    gaps = np.append(rng.uniform(*ends, _POINTS), ends)
    right, judged = network_samples(scene.device, currents, gaps), []
    for name in ("flux_linkage", "force"):
        known = getattr(right, name)
        off = np.abs(getattr(surface, name)(currents[:, None], gaps) - known)
        error = off / np.maximum(np.abs(known), 0.1 * np.abs(known[-1]))
        bar = getattr(surface.interpolation_error, name)
        judged.append(Judged(where, name, float(error.max()), bar))
    return judged


def judge_switching(rng: np.random.Generator) -> list[Judged]:
    """Switching currents of one device against balances of a finer network."""
    scene, where, solution = _machine(rng, lambda scene: solve(scene, ("network",), _SWITCHING))
    right = _balances(scene)
    found = []
    for name in _SWITCHING:
        of = solution.get(name, "network")
        if np.isfinite(of.value) and np.isfinite(right[name]):
            found += relative(where, name, of.value, of.error, right[name])
    return found


def judge_motions(rng: np.random.Generator) -> list[Judged]:
    """One machine's small motions against those about where a finer network holds it."""
    scene, where, _ = _machine(rng, lambda scene: scene.rest)
    model = make_model("tmm", scene, Stages(make_plan(scene, ("tmm",), _MOTIONS).keys))
    found = []
    judged = model.answer("small_signal")
    # a network finer than any that judges it, without a map anywhere
    coarse = DirectForce(scene.device, CELLS, map_of(scene).gap_limits)
    forces = axial_forces(scene.device, coarse, scene.load.normal_force)
    place = resting_place(forces, abs(scene.coil.current), scene.coil.history)
    finest = replace(coarse, cells=_FINEST * CELLS, step=_LONGER * coarse.step)
    rod = RodWithError(rod_by_network(scene, finest, place))
    right: SmallSignal = replace(judged, linear=rod)
    for name in _MOTIONS:
        read = QUANTITIES[name].read
        assert isinstance(read, AnswerReadout)
        answer, known = read.of(judged), read.of(right)
        found += relative(where, name, answer.value, answer.error, known.value)
    return found


def _fitting(
    name: str, sampled: Callable[[], list[str]], tried: Callable[[Scene], T]
) -> tuple[Scene, str, T]:
    """Sampled scene that `tried` accepts, its changes, and what that gave."""

    def attempt() -> tuple[Scene, str, T]:
        overrides = sampled()
        scene, _ = load_scene(name, overrides)
        return scene, " ".join(overrides), tried(scene)

    return accepted(attempt)


def _machine(rng: np.random.Generator, tried: Callable[[Scene], T]) -> tuple[Scene, str, T]:
    """The same of a machine."""
    return _fitting("generator", lambda: random_devices.machine(rng), tried)


def _balances(scene: Scene) -> dict[str, float]:
    """Switching currents (A) by a finer network; nan where no current balances."""
    from scipy.optimize import minimize_scalar

    currents, around = map_grid(scene.device)
    exact = DirectForce(scene.device, _FINER * CELLS, (around[0], around[-1]))
    balance = partial(_balance, exact, currents)
    gaps = between_stops(scene.device, _GAPS)
    needed = np.array([balance(float(gap)) for gap in gaps])
    found = {"holding_current": float(needed[0])}
    for name, sign in (("pull_in_current", -1.0), ("drop_out_current", 1.0)):
        at = int(np.argmin(sign * needed))
        if at in (0, _GAPS - 1):  # at a stop
            found[name] = float(needed[at])
            continue
        ends = float(gaps[at - 1]), float(gaps[at + 1])
        closer = minimize_scalar(
            lambda gap, sign=sign: sign * balance(gap), bounds=ends, method="bounded",
            options={"xatol": 1e-3 * (ends[1] - ends[0])},
        )  # fmt: skip
        found[name] = sign * min(sign * float(needed[at]), float(closer.fun))
    return found if np.isfinite(needed).all() else dict.fromkeys(found, np.nan)


def _balance(exact: DirectForce, currents: np.ndarray, gap: float) -> float:
    """Least current (A) whose pull balances the spring at a gap (m); nan for none."""
    from scipy.optimize import brentq

    against = float(spring_force(exact.device, gap))
    over = exact.force(currents, gap) >= against
    if not over.any() or over[0]:
        return np.nan
    first = int(np.argmax(over))
    low, high = currents[first - 1 : first + 1]
    return float(brentq(lambda i: float(exact.force(i, gap)) - against, low, high, xtol=1e-12))


#: Seconds that are run.
_UNTIL = 2e-4
#: Accuracy of the reference, of the run's that is judged, and its longest step, of the time: by
#: the accuracy alone both might take the same steps.
_FINER_IN_TIME, _LONGEST = 0.01, 1e-3


def judge_in_time(rng: np.random.Generator) -> list[Judged]:
    """Outputs of one run, drawn by `rng`: the largest error until some time.

    That is what a bar in time is of; relative to the output's largest.
    """
    return accepted(lambda: _in_time(rng))


def _in_time(rng: np.random.Generator) -> list[Judged]:
    ohms, accuracy, speed = (
        between(rng, *limits) for limits in ((1.0, 1e4), (0.01, 0.3), (1e-3, 1.0))
    )
    overrides = [
        "load.kind=none",
        f"coil.source_resistance={ohms:.4g}ohm",
        f"bimorph.length={between(rng, 12.0, 30.0):.4g}mm",
        f"contact.decay_length={between(rng, 0.03, 0.3):.4g}um",
        f"spring.preload={between(rng, 50.0, 300.0):.4g}mN",
    ]
    scene, _ = load_scene("generator", overrides)
    found = scene_machine(scene, coil="voltage", volts=10.0)
    coil = Step(between(rng, 1e-3, 0.05) * (ohms + 20.0))
    drive = Sine(between(rng, 1.0, 50.0), between(rng, 50.0, 2000.0))
    run, finer = two_runs(found, Sources(drive, coil), _UNTIL, speed, accuracy)
    where = f"{' '.join(overrides)}, {speed:.4g} m/s, accuracy {accuracy:.3g}"
    at = int(rng.integers(run.run.time.size // 10, run.run.time.size))
    errors = time_errors(found.system, run, finer, at)
    return [Judged(where, name, *of) for name, of in errors.items()]


def two_runs(
    machine: Machine, sources: Sources, until: float, speed: float, accuracy: float
) -> tuple[Answer, Answer]:
    """Run of a machine at rest but for its rod's speed (m/s), and its reference in finer steps."""
    velocity = np.zeros(machine.rest.size)
    velocity[0] = speed
    run, finer = (
        simulate(
            machine.system, sources, until,
            position=machine.rest, velocity=velocity, accuracy=wanted, longest=longest,
        )
        for wanted, longest in ((accuracy, math.inf), (_FINER_IN_TIME * accuracy, _LONGEST * until))
    )  # fmt: skip
    return run, finer


def time_errors(
    system: System, run: Answer, finer: Answer, count: int
) -> dict[str, tuple[float, float]]:
    """Largest error of each output in a run's first steps, and the bar there.

    Both relative to the output's largest.
    """
    errors, times = {}, run.run.time[:count]
    for name, values in run.outputs.items():
        right = (
            np.interp(times, finer.run.time, finer.run.current)
            if name == "current"
            else output_at(finer.run, system.outputs[name].row, times)
        )
        off = np.abs(values[:count] - right).max()
        size = float(np.abs(values).max()) or 1.0
        errors[name] = float(off / size), float(run.bars[name][count - 1] / size)
    return errors
