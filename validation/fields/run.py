"""What moves in a run of the generator, and by which coordinates."""

from __future__ import annotations

from tactgen.validation.fields.moving import MovingBody, moving_body
from tactgen.validation.models.generator.transient import Simulation, scene_beam


def body_of(found: Simulation) -> MovingBody:
    """Return what moves in a run."""
    device, beam = scene_beam(found.scene)
    return moving_body(device, beam, found.machine.modes)
