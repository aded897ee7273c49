"""The report's section about the whole machine: where the rod rests, what that holds, how it moves.

By the reluctance network and the transfer-matrix model, which cost next to nothing; shown for a
bimorph that stands on the rod's contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.beam.transfer import transfer_matrix
from tactgen.tmm.generator.contact import RoughContact
from tactgen.tmm.generator.moving_mass import moving_rod
from tactgen.tmm.generator.network_pull import network_pull
from tactgen.tmm.generator.positions import RestingPlace, axial_forces, resting_places
from tactgen.tmm.generator.stops import contact_of
from tactgen.tmm.ports.multiport import in_series, respond
from tactgen.tmm.ports.terminations import attach, outside_known_range
from tactgen.validation.catalogue.bimorph import SHORT_CIRCUIT_FREQUENCIES
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.models.generator.small_signal import machine_of, measured_poles
from tactgen.validation.report.sections.section import Context, Section
from tactgen.validation.report.study import Study
from tactgen.validation.scene.scene import Scene

#: Direct current with which the paper holds the rod down (A), section 6.
_HELD = 50e-3
#: Units of the transfers from voltage and current to the tip.
TRANSFERS = ("m/V", "m/A")
#: Preloads shown beside the scene's, as shares of it: what a grub screw may do.
_PRELOADS = (0.5, 1.0, 2.0)


@dataclass(frozen=True)
class SupportRow:
    """The support in one state, by its contact (SI)."""

    state: str
    place: RestingPlace
    rotational_stiffness: float
    rotational_damping: float
    lateral_stiffness: float
    first_frequency: float
    uplift_moment: float
    tipping_moment: float


def machine_section(study: Study) -> Context | None:
    """Return the machine's positions, support and small motions; None off the contact."""
    scene = study.scene
    if scene.support.kind != "contact":
        return None
    from tactgen.validation.report.figures.machine import position_plot, transfer_plot

    magnetic = bool(study.solution.models_of("reluctance")) or scene.coil.current != 0.0
    context: dict[str, Any] = {
        "rows": [_support(scene, state, made) for state, made in _states(scene, magnetic)],
        "moment": _base_moment(scene),
        "law": contact_of(scene.device),
        "rod": moving_rod(scene.device),
        "magnetic": magnetic,
        "rated": Device().spring.preload,
    }
    if magnetic:
        pull = network_pull(scene.device)
        forces = axial_forces(scene.device, pull, scene.load.normal_force)
        current = abs(scene.coil.current)
        linear = machine_of(scene)
        context |= {
            "places": resting_places(forces, current),
            "loop": position_plot(forces, _loop_currents(scene, pull.current_limit), current),
            "linear": linear,
            "poles": {
                supply: measured_poles(_with(scene, supply=supply), linear).listed
                for supply in ("current", "voltage")
            },
            "transfers": transfer_plot(study.solution, TRANSFERS)
            if _in_motion(study.solution)
            else "",
        }
    return context


def _states(scene: Scene, magnetic: bool) -> list[tuple[str, Scene]]:
    """Return the scene in the states whose supports are compared."""
    found = []
    for share in _PRELOADS:
        preload = share * scene.spring.preload
        spring = scene.spring.model_copy(update={"preload": preload})
        alone = _with(scene, current=0.0).model_copy(update={"spring": spring})
        found.append((f"spring alone, preload {1e3 * preload:.3g} mN", alone))
    if magnetic:
        for current in sorted({_HELD, abs(scene.coil.current)} - {0.0}):
            for history in ("rising", "falling"):
                state = f"{1e3 * current:.3g} mA, {history}"
                found.append((state, _with(scene, current=current, history=history)))
    return found


def _with(scene: Scene, **coil: Any) -> Scene:
    return scene.model_copy(update={"coil": scene.coil.model_copy(update=coil)})


def _support(scene: Scene, state: str, made: Scene) -> SupportRow:
    assert made.rest is not None
    place, springs = made.rest
    law: RoughContact = contact_of(made.device)
    answer = solve(made, ["tmm"], [SHORT_CIRCUIT_FREQUENCIES.name]).quantities[0]
    return SupportRow(
        state=state,
        place=place,
        rotational_stiffness=springs.rotational_stiffness,
        rotational_damping=springs.rotational_damping,
        lateral_stiffness=springs.lateral_stiffness,
        first_frequency=float(answer.value[0]),
        uplift_moment=float(law.uplift_moment(place.contact_force)),
        tipping_moment=float(law.tipping_moment(place.contact_force)),
    )


def _base_moment(scene: Scene) -> Context:
    """Return the largest moment (N m) that the linear support bears under the drive, and where."""
    assert scene.rest is not None
    place, springs = scene.rest
    frequencies = np.asarray(scene.frequency, dtype=float)
    port = transfer_matrix.multiport(scene.device, scene.support, scene.beam, frequencies)
    if scene.bimorph.wiring == "series":
        port = in_series(port)
    tilt = respond(attach(port, scene.ends), {"voltage": scene.drive.voltage}).motion["psi_base"]
    omega = 2.0 * np.pi * frequencies
    borne = np.abs(tilt * (springs.rotational_stiffness + 1j * omega * springs.rotational_damping))
    borne[outside_known_range(scene.load, frequencies)] = 0.0
    at = int(np.argmax(borne))
    law = contact_of(scene.device)
    return {
        "largest": float(borne[at]),
        "at": float(frequencies[at]),
        "least": float(borne[borne > 0.0].min(initial=float(borne[at]))),
        "uplift": float(law.uplift_moment(place.contact_force)),
        "tipping": float(law.tipping_moment(place.contact_force)),
    }


def _loop_currents(scene: Scene, limit: float) -> Floats:
    """Return currents (A) over which the loop is drawn."""
    return np.linspace(0.0, min(limit, max(0.2, 1.2 * abs(scene.coil.current))), 121)


def _in_motion(solution: Solution) -> bool:
    """Return whether some transfer of the machine was asked for."""
    return any(q.unit in TRANSFERS for q in solution.quantities)


MACHINE = Section("machine", "The machine: positions, support, small motions", machine_section)
