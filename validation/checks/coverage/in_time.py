"""Bars of the machine in time: random runs against runs in many times finer steps."""

from __future__ import annotations

import math

import numpy as np

from tactgen.tmm.generator.transient.march import simulate
from tactgen.tmm.generator.transient.record import output_at
from tactgen.tmm.generator.transient.waveform import Constant, Sine, Sources
from tactgen.validation.checks.coverage.result import Judged
from tactgen.validation.checks.coverage.scenes import accepted, between
from tactgen.validation.models.generator.transient import scene_machine
from tactgen.validation.scene.scene import load_scene

#: Seconds that are run.
_UNTIL = 2e-4
#: Accuracy of the reference, of the run's that is judged, and its longest step (s): a tenth of the
#: run's, a hundredth of the time.  By the accuracy alone both might take the same steps.
_FINER, _LONGEST = 0.01, 1e-3 * _UNTIL


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the outputs of one run, drawn by `rng`: the largest error until some time.

    That is what a bar in time is of; relative to the output's largest.
    """
    return accepted(lambda: _judged(rng))


def _judged(rng: np.random.Generator) -> list[Judged]:
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
    velocity = np.zeros(found.rest.size)
    velocity[0] = speed
    coil = Constant(between(rng, 1e-3, 0.05) * (ohms + 20.0))
    drive = Sine(between(rng, 1.0, 50.0), between(rng, 50.0, 2000.0))
    run, finer = (
        simulate(
            found.system, Sources(drive, coil), _UNTIL,
            position=found.rest, velocity=velocity, accuracy=accuracy * share, longest=longest,
        )
        for share, longest in ((1.0, math.inf), (_FINER, _LONGEST))
    )  # fmt: skip
    where = f"{' '.join(overrides)}, {speed:.4g} m/s, accuracy {accuracy:.3g}"
    at = int(rng.integers(run.run.time.size // 10, run.run.time.size))
    judged = []
    for name, values in run.outputs.items():
        times, bar = run.run.time[:at], run.bars[name][at - 1]
        right = (
            np.interp(times, finer.run.time, finer.run.current)
            if name == "current"
            else output_at(finer.run, found.system.outputs[name].row, times)
        )
        off = np.abs(values[:at] - right).max()
        size = float(np.abs(values).max()) or 1.0
        judged.append(Judged(where, name, float(off / size), float(bar / size)))
    return judged
