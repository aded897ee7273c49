"""Moment that the linear support of the machine bears, beside those at which the head lifts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.generator.contact import stops_of
from tactgen.tmm.ports.excitation_and_circuit import excitation_of, excited
from tactgen.tmm.ports.multiport import wired
from tactgen.tmm.ports.supports_and_loads import outside_known_range
from tactgen.validation.scene.scene import Scene


@dataclass(frozen=True)
class BaseMoment:
    """Moments (N m) on the rod's head under the drive, by the transfer matrix."""

    largest: float
    at: float  #: Its frequency (Hz)
    least: float
    uplift: float  #: From which on the head leaves the stop at one side
    tipping: float  #: From which on it stands on its edge


def base_moment(scene: Scene) -> BaseMoment:
    """Moment of a scene on the contact of head and stop, at its frequencies."""
    assert scene.rest is not None
    place, springs = scene.rest
    frequencies = np.asarray(scene.frequency, dtype=float)
    port = transfer_matrix.multiport(scene.device, scene.support, scene.beam, frequencies)
    port = wired(port, scene.bimorph.wiring)
    tilt = excited(port, scene.ends, excitation_of(scene.circuit, scene.drive)).motion["psi_base"]
    omega = 2.0 * np.pi * frequencies
    borne = np.abs(tilt * (springs.rotational_stiffness + 1j * omega * springs.rotational_damping))
    borne[outside_known_range(scene.load, frequencies)] = 0.0
    at = int(np.argmax(borne))
    law = stops_of(scene.device).holding(place.lift)
    return BaseMoment(
        largest=float(borne[at]),
        at=float(frequencies[at]),
        least=float(borne[borne > 0.0].min(initial=float(borne[at]))),
        uplift=float(law.uplift_moment(place.contact_force)),
        tipping=float(law.tipping_moment(place.contact_force)),
    )
