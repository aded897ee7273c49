"""A bimorph in time that its own support holds, under its own load, by modes of beam elements.

Modes are those of the bimorph with the springs of its support and with what the tip's coordinate
carries, so that a heavy tip mass leaves them exact; a loss factor becomes viscous damping that
takes as much at each mode's own frequency.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex
from tactgen.geometry.device.checks import check_linear_ceramic
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.machine import bimorph_modes
from tactgen.tmm.generator.transient.system import Output, System
from tactgen.tmm.generator.transient.time_integration import Answer, simulate
from tactgen.tmm.generator.transient.waveform import Sources, Waveform
from tactgen.tmm.ports.supports_and_loads import Chain, chain_of
from tactgen.validation.scene.scene import Scene

#: Modes up to this frequency (Hz) move; those above follow statically.
_HIGHEST = 20e3
#: A deflection (m) below which it is none that steps must follow.
_STILL = 1e-9


@dataclass(frozen=True)
class HeldRun:
    """A held bimorph that moved."""

    scene: Scene
    system: System
    answer: Answer
    load_misfit: float  #: Largest relative misfit of the load in time to its law of frequency


def run_held(
    scene: Scene,
    voltage: Waveform,
    until: float,
    *,
    accuracy: float,
    announce: Callable[[str], None] = lambda _: None,
) -> HeldRun:
    """Run of a scene's bimorph on its own support, from rest without voltage.

    Parameters
    ----------
    until : float
        End (s).
    accuracy : float
        Error aimed at, over the static deflection without load.

    Raises InputError if the scene has no time simulation, or the run fails.
    """
    check_linear_ceramic(scene.piezo, "time simulation")
    announce("modes")
    load = chain_of(scene.ends.tip)
    system = held_system(scene, load, voltage.peak)

    def tell(share: float) -> None:
        announce(f"time steps, {100.0 * share:.0f} %")

    answer = simulate(system, Sources(voltage), until, accuracy=accuracy, announce=tell)
    return HeldRun(scene, system, answer, load.misfit)


def held_system(scene: Scene, load: Chain, volts: float) -> System:
    """Equations of motion of a held bimorph: its modes, then the load's parts.

    Raises InputError if springs of the support leave the base loose.
    """
    from tactgen.fem.beam import assemble, elements_for

    base = scene.ends.base
    check_base_held(scene, "a run in time")
    beam = assemble(scene.device, scene.support, scene.beam,
                    elements=elements_for(scene.device, _HIGHEST), lossy=True,
                    measured=True)  # fmt: skip
    w, psi, tip, _ = map(int, beam.ports)
    stiffness, mass = beam.stiffness.copy(), beam.mass.copy()
    if base is not None:
        stiffness[w, w] += base.lateral_stiffness
        stiffness[psi, psi] += base.rotational_stiffness
        mass[psi, psi] += base.rotational_inertia
    share = 0.5 if scene.bimorph.wiring == "series" else 1.0
    held = beam.ports[: 2 if base is None else 0]
    free = np.setdiff1d(np.arange(mass.shape[0]), held)
    bent = np.zeros(mass.shape[0])
    bent[free] = np.linalg.solve(stiffness.real[np.ix_(free, free)], beam.coupling.real[free])
    scale = max(abs(float(share * volts * bent[beam.seen])), _STILL)
    stiffness[tip, tip] += load.stiffness[0, 0]
    mass[tip, tip] += load.mass[0, 0]
    modes = bimorph_modes(
        stiffness, mass, share * beam.coupling, share**2 * beam.capacitance, held, tip, beam.seen,
        _HIGHEST,
    )  # fmt: skip
    k, parts = modes.omega.size, load.mass.shape[0] - 1
    own = slice(0, k)
    carries, seen = (
        np.concatenate([row[held.size :], np.zeros(parts)]) for row in (modes.tip, modes.seen)
    )
    loaded = np.vstack([carries, np.eye(k + parts)[k:]])
    left = {"mass": load.mass.copy(), "stiffness": load.stiffness.copy()}
    for matrix in left.values():
        matrix[0, 0] = 0.0  # in the modes
    whole = {name: loaded.T @ matrix @ loaded for name, matrix in left.items()}
    damping = loaded.T @ load.damping @ loaded
    whole["mass"][own, own] += np.eye(k)
    whole["stiffness"][own, own] += np.diag(modes.omega**2)
    damping[own, own] += np.diag(modes.damping)
    if base is not None:
        turned = modes.shapes[psi]
        damping[own, own] += base.rotational_damping * np.outer(turned, turned)
    coupling = np.concatenate([modes.coupling, np.zeros(parts)])
    return System(
        mass=whole["mass"],
        damping=damping,
        stiffness=whole["stiffness"],
        load=np.zeros(k + parts),
        coupling=coupling,
        capacitance=modes.capacitance,
        outputs={
            "lateral_tip": Output(seen, "m", scale, f"lateral motion {scene.measurement.where}")
        },
    )


def check_base_held(scene: Scene, purpose: str) -> None:
    """Refuse a support of which a spring is zero, and say what needs it."""
    if scene.support.kind == "pinned":
        raise InputError(
            f'support.kind = "pinned" does not hold the base, which {purpose} needs; set '
            'support.kind = "clamped" or "spring"'
        )
    if scene.support.kind == "table":
        raise InputError(
            f'support.kind = "table" is known over frequency only, and {purpose} needs constants; '
            'set support.kind = "spring" with what fits the table'
        )
    if scene.ends.base is None:
        return
    for name, unit in (("rotational_stiffness", "N m/rad"), ("lateral_stiffness", "N/m")):
        if getattr(scene.ends.base, name) == 0.0:
            raise InputError(
                f"support.{name} = 0 {unit} does not hold the base, which {purpose} needs; give it "
                'a stiffness or set support.kind = "clamped"'
            )


def oscillations(system: System) -> list[tuple[float, float]]:
    """Natural frequency (Hz) and damping ratio of each oscillating pole, ascending."""
    from scipy.linalg import eig

    n = system.mass.shape[0]
    one, zero = np.eye(n), np.zeros((n, n))
    left = np.block([[zero, one], [-system.stiffness, -system.damping]])
    right = np.block([[one, zero], [zero, system.mass]])
    poles: Complex = eig(left, right, right=False)
    found = poles[np.isfinite(poles) & (poles.imag > 0.0)].tolist()
    return sorted((abs(pole) / (2.0 * np.pi), -pole.real / abs(pole)) for pole in found)
