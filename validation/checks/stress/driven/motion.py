"""The machine in time driven to extremes: hard blows, no damping at all, circuits that are stiff.

Each run is held against one whose accuracy is ten times finer, within the error bars of both, and
its energy against the first law.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.tmm.generator.transient.march import simulate
from tactgen.tmm.generator.transient.record import output_at
from tactgen.tmm.generator.transient.waveform import Constant, Sine, Sources, Waveform
from tactgen.validation.checks.stress.answers import REFUSALS, Family
from tactgen.validation.checks.stress.result import Row, answered
from tactgen.validation.models.generator.transient import scene_machine
from tactgen.validation.scene.scene import load_scene

#: Accuracy of the runs that are judged, and what their witness's is of it.
_ACCURACY, _FINER = 0.05, 0.1
#: What the energy balance may miss, of all that was exchanged.
_BALANCE = 1e-10
_FREE = "load.kind=none"
_UNDAMPED = (
    _FREE, "contact.relaxation_time=0 s", "guide.axial_damping=0 N*s/m",
    "piezo.quality_factor=1e9", "contact.friction=0.001",
)  # fmt: skip
_OFF = Constant(0.0)


@dataclass(frozen=True)
class _Run:
    """One run: where it is, for people; what the scene sets; speed of the rod at the start (m/s).

    `coil` is what drives the winding, by current unless `by_voltage`.
    """

    where: str
    overrides: tuple[str, ...]
    until: float
    speed: float = 0.0
    coil: Waveform = _OFF
    by_voltage: bool = False


_BLOWS = tuple(
    _Run(f"{speed:g} m/s", (_FREE,), 3e-4 / max(speed, 1.0), speed)
    for speed in (0.01, 0.1, 0.5, 1.0, 2.0)
)
_LOSSLESS = tuple(
    _Run(f"{speed:g} m/s, no damping", _UNDAMPED, 2e-4, speed) for speed in (0.0, 0.05, 0.4)
)
#: Circuits whose resistance answers in seconds to fractions of a nanosecond; 50 mA at the end.
_CIRCUITS = tuple(
    _Run(
        f"source of {ohms:g} ohm", (_FREE, f"coil.source_resistance={ohms:g} ohm"), 2e-4,
        coil=Constant(0.05 * ohms), by_voltage=True,
    )
    for ohms in (1e1, 1e2, 1e3, 1e4, 1e5, 1e6)
)  # fmt: skip


def motion_rows(quick: bool) -> list[Row]:
    """Return the rows: seconds if `quick`, else a minute."""
    return [
        _row("machine: blows on its stop", "the rod at 1 cm/s to 2 m/s", _BLOWS, quick),
        _row("machine: without damping", "no loss in contact, guide, bimorph", _LOSSLESS, quick),
        _row("machine: stiff circuits", "10 ohm to 1 Mohm in series", _CIRCUITS, quick),
    ]


def _row(name: str, what: str, runs: tuple[_Run, ...], quick: bool) -> Row:
    family = Family()
    for run in runs[-1:] if quick else runs:
        try:
            _judge(family, run)
        except REFUSALS as error:
            family.refuse(error)
    return answered(name, what, family.points, family.refusals)


def _judge(family: Family, run: _Run) -> None:
    """Compare every output at its worst time, and the energy."""
    scene, _ = load_scene("generator", list(run.overrides))
    found = scene_machine(scene, coil="voltage" if run.by_voltage else "current", volts=10.0)
    velocity = np.zeros(found.rest.size)
    velocity[0] = run.speed
    judged, finer = (
        simulate(
            found.system, Sources(Sine(10.0, 200.0), run.coil), run.until,
            position=found.rest, velocity=velocity, accuracy=_ACCURACY * share,
        )
        for share in (1.0, _FINER)
    )  # fmt: skip
    for name, output in found.system.outputs.items():
        values, bar = judged.outputs[name], judged.bars[name] + finer.bars[name][-1]
        off = np.abs(values - output_at(finer.run, output.row, judged.run.time))
        size = float(np.abs(values).max()) or 1.0
        at = int(np.argmax(off / np.maximum(bar, np.finfo(float).tiny)))
        family.add(f"{run.where}, {name}", off[at] / size, bar[at] / size)
    if run.by_voltage:
        bar = judged.bars["current"][-1] + finer.bars["current"][-1]
        last, known = (answer.run.current[-1] for answer in (judged, finer))
        family.compare(f"{run.where}, current at the end", float(last), float(known), float(bar))
    family.add(f"{run.where}, energy", judged.run.worst_imbalance, _BALANCE)
