"""A scene in time: bimorph by beam elements, magnets by the network or a map, on one rod.

:func:`run_scene` solves it; :func:`phases` cuts a run by where the rod is: lower position, rising,
upper position, falling.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.checks import check_linear_ceramic, check_one_plane
from tactgen.geometry.device.parameters import Device, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.machine import BimorphModes, Machine, bimorph_modes, machine
from tactgen.tmm.generator.transient.system import RoughPoint
from tactgen.tmm.generator.transient.time_integration import Answer, simulate
from tactgen.tmm.generator.transient.waveform import Sources
from tactgen.tmm.ports.supports_and_loads import chain_of
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.beam import BeamMatrices
from collections.abc import Sequence
from itertools import pairwise

#: Modes of the bimorph up to this frequency (Hz) move; those above follow statically.
_HIGHEST = 20e3


@dataclass(frozen=True)
class Simulation:
    """Result of a simulated scene."""

    scene: Scene  #:
    machine: Machine  #:
    answer: Answer  #:
    stop_force: dict[str, Floats]  #: Of each stop on the head (N), 0 or more

    @property
    def load_misfit(self) -> float:
        """Largest relative misfit of the time-domain load to its law of frequency."""
        return chain_of(self.scene.ends.tip).misfit

    @property
    def sideways(self) -> Floats:
        """Offset of the rod's flange from the sleeve's axis over time (k,), m: w − z ψ."""
        rod, gap = self.scene.device.rod, self.scene.device.gap
        top = -(rod.head_thickness + gap + rod.flange_position)
        w, psi = self.answer.run.position[:, 1], self.answer.run.position[:, 2]
        edges = (top, top - rod.flange_thickness)
        return np.asarray(np.max([np.abs(w - z * psi) for z in edges], axis=0))

    @property
    def flange_gap(self) -> float:
        """Way between flange and sleeve to either side (m); a wall in a run is its guide only."""
        return float(self.scene.device.sleeve.inner_radius - self.scene.device.rod.flange_radius)

    @property
    def stroke(self) -> float:
        """Way between the stops (m)."""
        device = self.scene.device
        return float(device.gap - device.spring.stop_gap)


def run_scene(
    scene: Scene,
    sources: Sources,
    until: float,
    *,
    coil: Literal["current", "voltage"],
    accuracy: float,
    pull: CoenergyMap | None = None,
    announce: Callable[[str], None] = lambda _: None,
) -> Simulation:
    """Simulation of a scene's generator from its upper stop, whatever its support.kind is.

    Parameters
    ----------
    sources : Sources
        Voltage across the bimorph; current or voltage of the coil.
    until : float
        End (s).
    accuracy : float
        Error aimed at, over the stroke and over the static deflection.
    pull : CoenergyMap, optional
        Of the normal actuator; by default the reluctance network's.

    Raises InputError if the scene has no time simulation, or the run fails.
    """
    announce("machine")
    found = scene_machine(scene, coil=coil, volts=sources.bimorph.peak, pull=pull)

    def tell(share: float) -> None:
        announce(f"time steps, {100.0 * share:.0f} %")

    answer = simulate(
        found.system, sources, until, position=found.rest, accuracy=accuracy, announce=tell
    )
    forces = {}
    for element in found.system.elements:
        if not isinstance(element.law, RoughPoint):
            continue
        deformed = answer.run.position @ element.direction.T + element.offset
        rate = answer.run.velocity @ element.direction.T
        forces[element.name] = np.asarray(element.law.force(deformed, rate).sum(axis=1))
    return Simulation(scene, found, answer, forces)


def scene_machine(
    scene: Scene,
    *,
    coil: Literal["current", "voltage"],
    volts: float,
    pull: CoenergyMap | None = None,
) -> Machine:
    """Generator of a scene driven by `volts`.

    Raises InputError if something of it is known at one frequency only.
    """
    check_in_time(scene, "time simulation")
    load = chain_of(scene.ends.tip)
    if pull is None:
        from tactgen.tmm.reluctance.map_range import network_map

        pull = network_map(scene.device)
    modes = scene_modes(scene)
    return machine(scene.device, modes, pull, load=load, source=coil, drive_scale=volts or 1.0)


def check_in_time(scene: Scene, purpose: str) -> None:
    """Refuse what is known over frequency only.

    An upper board on springs, a rod that rocks in both planes, a ceramic that grows with the field.
    """
    check_linear_ceramic(scene.piezo, purpose)
    check_one_plane(scene.device, purpose)
    if scene.contact.board_stiffness:
        raise InputError(
            f"contact.board_stiffness = {scene.contact.board_stiffness:g} N/m has no {purpose} "
            "yet; set 0 N/m"
        )


def scene_modes(scene: Scene) -> BimorphModes:
    """Modes of a scene's bimorph above the rod's head, by beam elements."""
    found = scene_beam(scene)[1]
    share = 0.5 if scene.bimorph.wiring == "series" else 1.0
    return bimorph_modes(
        found.stiffness,
        found.mass,
        share * found.coupling,
        share**2 * found.capacitance,
        found.ports[:2],
        int(found.ports[2]),
        found.seen,
        _HIGHEST,
    )


def scene_beam(scene: Scene) -> tuple[Device, BeamMatrices]:
    """Scene's device with its row beginning at the rod's head, and that row's elements."""
    from tactgen.fem.beam import assemble, elements_for

    device = above_the_head(scene.device, scene.support)
    elements = elements_for(device, _HIGHEST)
    parts = device, Support(), scene.beam
    return device, assemble(*parts, elements=elements, lossy=True, measured=True)


def above_the_head(device: Device, support: Support) -> Device:
    """Device whose row of pieces begins at the rod's head.

    In a slot only the free part of the tab bends; the bond below it is taken as rigid.
    """
    if support.kind != "rod":
        return device
    bimorph = device.bimorph.model_copy(update={"tab_length": device.ceramic_base})
    return device.model_copy(update={"bimorph": bimorph})


#: A rod so close to a stop (m) is on it: far above a contact's approach, far below the stroke.
_NEAR = 2e-6
#: What is shorter (s) belongs to the phase before: a bounce.
_SHORT = 0.15e-3
#: Instants at which an oscillation is fitted within a phase.
_SAMPLES = 500


@dataclass(frozen=True)
class Phase:
    """A stretch of time."""

    name: str  #:
    #: s
    start: float
    end: float
    #: Half the way between the outermost positions of the tip in it, laterally (m); what drifts
    #: counts too.  For the answer to the drive alone see :func:`common_oscillation`
    amplitude: float


def phases(found: Simulation) -> tuple[Phase, ...]:
    """Phases of a run in order."""
    run, tip = found.answer.run, found.answer.outputs["lateral_tip"]
    lift = found.answer.outputs["rod_lift"]
    state = np.where(lift < -found.stroke + _NEAR, -1, np.where(lift > -_NEAR, 1, 0))
    edges = np.flatnonzero(np.diff(state)) + 1
    bounds = [0, *edges.tolist(), state.size - 1]
    stretches: list[tuple[int, int, int]] = []  # state, first, last
    for first, last in pairwise(bounds):
        if last == first:
            continue
        short = run.time[last] - run.time[first] < _SHORT
        if stretches and (short or stretches[-1][0] == state[first]):
            stretches[-1] = (stretches[-1][0], stretches[-1][1], last)
        else:
            stretches.append((int(state[first]), first, last))
    result = []
    came = 1
    for kind, first, last in stretches:
        if kind:
            came = kind
        name = {1: "pressed", -1: "held", 0: "falling" if came > 0 else "rising"}[kind]
        part = tip[first : last + 1]
        result.append(
            Phase(name, float(run.time[first]), float(run.time[last]), 0.5 * float(np.ptp(part)))
        )
    return tuple(result)


def common_oscillation(
    seen: Sequence[tuple[Simulation, Phase, float]], frequency: float
) -> complex:
    """Complex amplitude (m) at a frequency (Hz) that phases of several runs share.

    The tip moves as its real part times e^{j(2π f t + angle)}, and in each phase beside a straight
    line of that phase's own: where a blow has shifted the head, the finger lets the tip follow over
    milliseconds, which is no oscillation.  Of runs whose drives are a quarter of a period apart
    half a period is enough: what resembles a line in one of them does not in the other.

    Parameters
    ----------
    seen : sequence of (Simulation, Phase, float)
        Each with the angle of its drive (rad).
    """
    rows, values = [], []
    for number, (found, phase, angle) in enumerate(seen):
        time = np.linspace(phase.start, phase.end, _SAMPLES)
        turn = 2.0 * np.pi * frequency * time + angle
        lines = np.zeros((_SAMPLES, 2 * len(seen)))
        lines[:, 2 * number] = 1.0
        lines[:, 2 * number + 1] = (time - phase.start) / (phase.end - phase.start)
        rows.append(np.column_stack([np.cos(turn), -np.sin(turn), lines]))
        run, tip = found.answer.run, found.answer.outputs["lateral_tip"]
        values.append(np.interp(time, run.time, tip))
    fitted = np.linalg.lstsq(np.vstack(rows), np.concatenate(values), rcond=None)[0]
    return complex(fitted[0], fitted[1])
