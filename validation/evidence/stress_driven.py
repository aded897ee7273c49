"""Scenes with one key driven over its range, and random ones: each model against a second one.

Lumped and beam elements are held against the exact spans of the transfer matrix, which is itself
held against 80 digits elsewhere.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np

from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.judgement import FAR, PROMISED, Family, Judged, relative
from tactgen.validation.evidence.random_devices import any_scene
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene

#: Points of keys over their ranges, each as overrides of a scene.
Sweep: TypeAlias = Sequence[tuple[str, ...]]


def each(key: str, values: Sequence[object], unit: str = "", *more: str) -> Sweep:
    """Points of a key at these values, with other overrides that are the same."""
    return [(f"{key}={value} {unit}".strip(), *more) for value in values]


def decades(key: str, unit: str, low: int, high: int, *more: str, step: int = 1) -> Sweep:
    """Points 10^low to 10^high of a key."""
    return each(key, [f"1e{power}" for power in range(low, high + 1, step)], unit, *more)


@dataclass(frozen=True)
class Pair:
    """Two models of the same numbers."""

    #: Whose bars are judged, and by whom
    judged: str
    witness: str
    quantities: tuple[str, ...]  #: What both give
    scene: str  #: What is driven
    form: float = 0.0  #: Relative difference that the two theories may have beside their bars
    few: int = 3  #: Points of a quick run at most

    def judge(self, sweep: Sweep, family: Family, quick: bool) -> None:
        """Add the judged model's answers over a sweep; a quick run takes ends and middle."""
        few = sorted({0, len(sweep) // 2, len(sweep) - 1})[: self.few]
        for overrides in (sweep[i] for i in few) if quick else sweep:
            with family.attempt():
                scene, _ = load_scene(self.scene, list(overrides))
                self.add(family, "; ".join(overrides), scene)

    def add(self, family: Family, where: str, scene: Scene) -> None:
        """Solve a scene by both models, and add of every quantity the worst entry that both have.

        Of a curve's many entries as many are passed over as their bars do not promise to hold,
        unless one is far off.
        """
        found = solve(scene, (self.judged, self.witness), self.quantities)
        for name in self.quantities:
            one, other = (found.get(name, model) for model in (self.judged, self.witness))
            both = min(np.size(one.value), np.size(other.value))
            value, right, bar, known = (
                np.ravel(of)[:both] for of in (one.value, other.value, one.error, other.error)
            )
            bar = bar + known + self.form * np.abs(right)
            bar[~np.isfinite(bar)] = np.nan  # as wrong as no number
            entries = sorted(relative(where, name, value, bar, right), key=lambda one: one.share)
            over = 0 if entries[-1].share > FAR else int((1.0 - PROMISED) * both)
            family.take([entries[-1 - over]])


#: Seconds of processor time after which a scene counts as endless: usual is a tenth of one.
_ENDLESS = 20.0
_STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
# lumped takes the row element by element: 1e-6 for what rounding does to extremes
_LUMPED = Pair("lumped", "tmm", _STATIC, "prototype", form=1e-6)
_BEAM = Pair(
    "beam", "tmm",
    (*_STATIC, "short_circuit_frequencies", "coupling_factor", "tip_displacement", "admittance"),
    "prototype", form=1e-12,
)  # fmt: skip
_CAD = Pair("cad", "solid", ("static_tip_displacement", "capacitance_free"), "j1", few=1)
MACHINE = Pair(
    "beam", "tmm",
    ("lateral_tip_per_voltage", "axial_tip_per_voltage", "axial_tip_per_current",
     "lateral_tip_per_current", "axial_tip_per_coil_voltage", "coil_impedance", "axial_poles",
     "tip_displacement"),
    "generator", form=1e-12,
)  # fmt: skip


def families(pair: Pair, sweeps: Mapping[str, Sweep]) -> dict[str, Callable[[Family, bool], None]]:
    """Families of sweeps by title with the range, answered by a pair."""
    return {
        f"{pair.judged} against {pair.witness}, {what}": partial(pair.judge, sweep)
        for what, sweep in sweeps.items()
    }


def shim(power: float) -> tuple[str, ...]:
    """Shim 10^power times as thick as a layer of ceramic, 0.77 mm in all."""
    piezo = 0.77 / (2.0 + 10.0**power)
    return (
        f"bimorph.piezo_thickness={piezo:.9g} mm",
        f"bimorph.shim_thickness={10.0**power * piezo:.9g} mm",
    )


_FREE, _LEVEL = "load.kind=none", "mesh.level=2"
_GENERAL: dict[str, Sweep] = {
    "length: 1 µm to 10 m": decades("bimorph.length", "m", -6, 1),
    "shim over ceramic: shim 1e-3 to 1e3 times as thick, at 0.77 mm in all":
        [shim(power) for power in range(-3, 4)],
    "support stiffness: rotational spring 1e-9 to 1e6 N m/rad":
        decades("support.rotational_stiffness", "N*m/rad", -9, 6, "support.kind=spring", step=3),
    "tip mass: 1 pg to 1 kg": decades("load.mass", "kg", -15, 0, "load.kind=mass", step=3),
    "taper: tip 1 to 1e-4 times as wide as the base":
        each("bimorph.width_profile",
             [f"0 mm: 2 mm, 14 mm: {2.0 * 10.0**-p:g} mm" for p in range(5)]),
}  # fmt: skip
FREQUENCY = decades("frequency", "Hz", -6, 9, _FREE)
#: The lateral actuator's sweeps.
FAMILIES = families(_LUMPED, _GENERAL) | families(_BEAM, _GENERAL | {
    "quality factor: 10 to 1e9, tan δ its inverse":
        [(f"piezo.quality_factor=1e{p}", f"piezo.loss_tangent=1e-{p}", _FREE)
         for p in range(1, 10, 2)],
    "frequency: 1 µHz to 1 GHz, refused beyond 10 MHz": FREQUENCY,
}) | families(_CAD, {
    "length: 0.5 to 100 mm": each("bimorph.length", ("0.5", "5", "100"), "mm", _LEVEL),
    "shim over ceramic: shim 1e-2 to 1e2 times as thick":
        [(*shim(power), _LEVEL) for power in (-2, 0, 2)],
})  # fmt: skip


def judge_random(rng: np.random.Generator) -> list[Judged]:
    """Answers of one random scene, a bimorph or a machine.

    Any exception that is no refusal is a failure, as is a scene that takes too long.
    """
    name, overrides = any_scene(rng)
    family, where = Family(name), f"{name} {'; '.join(overrides)}"
    started = time.process_time()
    try:
        with family.attempt():
            scene, _ = load_scene(name, overrides)
            for pair in (_LUMPED, _BEAM) if name == "prototype" else (MACHINE,):
                pair.add(family, where, scene)
    except Exception as error:  # noqa: BLE001 what a user would see as a traceback
        family.add(f"{where}: {type(error).__name__}: {error}", np.inf, 0.0)
    if time.process_time() - started > _ENDLESS:
        family.add(f"{where}: endless", np.inf, 0.0)
    return family.answers
