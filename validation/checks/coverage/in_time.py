"""Bars of the machine in time: random runs against runs ten times finer."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.march import Sources, simulate
from tactgen.tmm.generator.transient.record import output_at
from tactgen.tmm.generator.transient.waveform import Constant, Sine
from tactgen.validation.checks.coverage.result import Judged
from tactgen.validation.checks.coverage.scenes import between
from tactgen.validation.models.generator.transient import scene_machine
from tactgen.validation.scene.scene import load_scene

#: Accuracy of the reference, of the run's that is judged.
_FINER = 0.1
#: Seconds that are run.
_UNTIL = 2e-4


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the outputs of one run, drawn by `rng`: the largest error until some time.

    That is what a bar in time is of; relative to the output's largest.
    """
    while True:
        try:
            return _judged(rng)
        except InputError:
            continue


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
            position=found.rest, velocity=velocity, accuracy=accuracy * share,
        )
        for share in (1.0, _FINER)
    )  # fmt: skip
    where = f"{' '.join(overrides)}, {speed:.4g} m/s, accuracy {accuracy:.3g}"
    at = int(rng.integers(run.run.time.size // 10, run.run.time.size))
    judged = []
    for name, output in found.system.outputs.items():
        values, bar = run.outputs[name][:at], run.bars[name][at - 1]
        off = np.abs(values - output_at(finer.run, output.row, run.run.time[:at])).max()
        size = float(np.abs(run.outputs[name]).max()) or 1.0
        judged.append(Judged(where, name, float(off / size), float(bar / size)))
    return judged
