"""A run of the generator as files: a film, and time steps for ParaView."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.export.fields import write_steps
from tactgen.validation.fields.gather import body_of
from tactgen.validation.fields.result import Array
from tactgen.validation.models.generator.transient import Simulation, phases
from tactgen.validation.view.run.frames import Instant, run_frames, run_still
from tactgen.validation.view.stills import save_film

#: Pictures of a film, and milliseconds that each is shown; time steps in a file.
_FRAMES, _SHOWN, _STEPS = 150, 60, 150


def write_run_film(
    path: Path, found: Simulation, announce: Callable[[str], None] = lambda _: None
) -> None:
    """Write a run as a film, by its suffix a .gif or .mp4, whole or not at all.

    Raises
    ------
    InputError
        If it cannot be made or written.
    """
    images = run_frames(body_of(found), list(_instants(found, _FRAMES)), announce)
    save_film(path, images, _SHOWN)


def still_of_run(found: Simulation) -> bytes:
    """Return a run as one picture (PNG), with its curves.

    Raises
    ------
    InputError
        If it cannot be made.
    """
    buffer = io.BytesIO()
    run_still(body_of(found), list(_instants(found, _FRAMES))).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def write_run_steps(path: Path, found: Simulation) -> None:
    """Write a run as a .pvd of time steps in s: displacement at the points of what moves.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    body = body_of(found)

    def at(instant: Instant) -> tuple[float, dict[str, Array]]:
        return instant.time, {"displacement (m)": body.displacement(instant.position)}

    write_steps(path, path.stem, body.mesh, map(at, _instants(found, _STEPS)))


def _instants(found: Simulation, count: int) -> Iterator[Instant]:
    """Yield the run at times evenly spaced from its start to its end."""
    run, outputs = found.answer.run, found.answer.outputs
    named = phases(found)
    for time in np.linspace(0.0, run.time[-1], count):
        position: Floats = np.array([np.interp(time, run.time, x) for x in run.position.T])
        phase = next((p.name for p in named if time <= p.end), named[-1].name)
        yield Instant(
            time=float(time),
            position=position,
            lift=float(np.interp(time, run.time, outputs["rod_lift"])),
            tip=float(np.interp(time, run.time, outputs["lateral_tip"])),
            current=float(np.interp(time, run.time, run.current)),
            phase=phase,
        )
