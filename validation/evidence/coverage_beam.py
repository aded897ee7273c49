"""Bars of the beam elements: random bimorphs against the exact spans of the transfer matrix."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import reduce
from typing import Any

import mpmath as mp
import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.pieces import beam_pieces
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.transfer_matrix import SEGMENTS, sections
from tactgen.tmm.ports.elements import base_stiffness
from tactgen.validation.checks.cases import reference_beam as reference
from tactgen.validation.checks.cases.reference_modes import Row, natural_frequency
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.coverage import Judged
from tactgen.validation.evidence.random_devices import accepted, between, compared, drawn_bimorph
from tactgen.validation.scene.scene import Scene, load_scene

_QUANTITIES = (
    "static_tip_displacement", "capacitance_free", "short_circuit_frequencies",
    "open_circuit_frequencies", "tip_displacement", "admittance",
)  # fmt: skip


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one device, drawn by `rng`: one in three is glued into its rod."""
    on_rod = rng.random() < 1.0 / 3.0
    scene, where = accepted(lambda: _on_rod(rng) if on_rod else _alone(rng))
    return compared((scene, "beam"), (scene, "tmm"), _QUANTITIES, where)


def _alone(rng: np.random.Generator) -> tuple[Scene, str]:
    overrides = drawn_bimorph(rng)
    return load_scene("prototype", overrides)[0], " ".join(overrides)


def _on_rod(rng: np.random.Generator) -> tuple[Scene, str]:
    drawn = drawn_bimorph(rng)
    overrides = [one for one in drawn if not one.startswith("support.")]
    overrides += [
        "load.kind=none",  # the finger's model ends at 1000 Hz
        f"bimorph.tab_length={between(rng, 0.5, 5.0):.4g}mm",
        f"glue.thickness={between(rng, 0.5, 60.0):.4g}um",
    ]
    return load_scene("bimorph_on_rod", overrides)[0], "on its rod, " + " ".join(overrides)


_STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
_HARMONIC = ("tip_displacement", "tip_rotation", "admittance")
_MODES = ("short_circuit_frequencies", "open_circuit_frequencies")


def judge_tmm(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one device, drawn by `rng`: every other one has bare ends.

    A uniform beam has a closed form; a row of three is joined.
    """
    layer = between(rng, 0.05, 0.5)
    length = between(rng, 15.0, 120.0) * 3.0 * layer
    overrides = drawn_bimorph(rng, length=length, layer=layer)
    if rng.random() < 0.5:
        overrides += [
            f"bimorph.bare_{where}={length * between(rng, 0.01, 0.2):.4g}mm"
            for where in ("below", "above")
        ]
    scene, _ = load_scene("prototype", [*overrides, "modes=3"])
    return against_digits(scene, " ".join(overrides))


def against_digits(scene: Scene, where: str) -> list[Judged]:
    """Return the answers of a bimorph of one cross-section on its support, its tip free."""
    found = {q.name: q for q in solve(scene, ["tmm"], (*_STATIC, *_HARMONIC, *_MODES)).quantities}
    exact = {name: _roots(scene, found[name]) for name in _MODES}
    for names, points in ((_STATIC, [_at_rest(scene)]), (_HARMONIC, list(_driven(scene)))):
        exact |= {name: [point[i] for point in points] for i, name in enumerate(names)}
    return [one for name, right in exact.items() for one in _judged(found[name], right, where)]


def _judged(quantity: Quantity, exact: list[Any], where: str) -> Iterable[Judged]:
    values, bars = np.ravel(quantity.value), np.ravel(quantity.error)
    for i, (value, bar, right) in enumerate(zip(values, bars, exact, strict=True)):
        name = f"{quantity.name} {i + 1}" if values.size > 1 else quantity.name
        error = reference.relative_error(value, right)
        yield Judged(where, name, error, float(bar / abs(right)))


def _roots(scene: Scene, quantity: Quantity) -> list[Any]:
    """Return the exact frequencies (Hz) next to those found."""
    row, opened = _row(scene, lossy=False), quantity.name == "open_circuit_frequencies"
    return [
        natural_frequency(row, scene.ends, float(near), open_circuit=opened)
        for near in quantity.value
    ]


def _at_rest(scene: Scene) -> tuple[Any, ...]:
    """Return static deflection (m) and the capacitances free and blocked (F)."""
    d = _stiffness(_row(scene, lossy=False), 0.0)
    base = scene.ends.lossless.base
    held = None if base is None else (base.lateral_stiffness, base.rotational_stiffness)
    moved, charge, _ = reference.tip_motion(d, held, 0)
    with mp.workdps(reference.DIGITS):
        return moved * scene.drive.voltage, charge, d[4, 4]


def _driven(scene: Scene) -> Iterator[tuple[Any, ...]]:
    """Return the tip's displacement (m) and rotation (rad) and the admittance (S) by frequency."""
    row, volts = _row(scene, lossy=True), scene.drive.voltage
    for frequency in scene.frequency:
        base = None
        if scene.ends.base is not None:
            lateral, rotational = base_stiffness(scene.ends.base, np.array([frequency]))
            base = complex(lateral[0]), complex(rotational[0])
        with mp.workdps(reference.DIGITS):
            omega = 2 * mp.pi * mp.mpf(frequency)
            moved, charge, turned = reference.tip_motion(_stiffness(row, omega), base, 0)
            yield moved * volts, turned * volts, mp.j * omega * charge


def _row(scene: Scene, *, lossy: bool) -> Row:
    """Return section constants and length of the pieces, none of which is bare shim."""
    layers = reference.Layers.of(scene.device, scene.beam)
    if not lossy:
        layers = replace(layers, quality_factor=mp.inf, loss_tangent=0)
    active = reference.bimorph_constants(layers)
    bare = reference.without_electrode(active)
    return [
        (active if piece.electrode else bare, piece.length)
        for piece in beam_pieces(scene.device, scene.support)
    ]


def _stiffness(row: Row, omega: Any) -> mp.matrix:
    parts = [reference.dynamic_stiffness(constants, length, omega) for constants, length in row]
    return reduce(reference.join, parts)


#: How many times as many segments the reference has: its own error is 1/256 of the one judged.
_FINER = 4
_NAME = "short_circuit_frequencies"


def judge_taper(rng: np.random.Generator) -> list[Judged]:
    """Return the frequencies of one tapered device, drawn by `rng`."""
    length = rng.uniform(8.0, 40.0)
    width, share = rng.uniform(0.5, 3.0), rng.uniform(0.1, 0.9)
    step, layer = rng.uniform(0.2, 0.8) * length, rng.uniform(0.1, 0.4)
    points = ((0.0, width), (step, width), (length, share * width))
    profile = ", ".join(f"{z:.6g} mm: {w:.4g} mm" for z, w in points)
    overrides = [
        *drawn_bimorph(rng, length=length, layer=layer), f"bimorph.width_profile={profile}",
    ]  # fmt: skip
    scene, _ = load_scene("prototype", overrides)
    quantity = solve(scene, ["tmm"], [_NAME]).quantities[0]
    right = _reference(scene, quantity.value.size)
    where = " ".join(overrides)
    return [
        Judged(where, f"{_NAME} {i + 1}", abs(value / exact - 1.0), bar / exact)
        for i, (value, bar, exact) in enumerate(
            zip(quantity.value, quantity.error, right, strict=True)
        )
    ]


def _reference(scene: Scene, count: int) -> Floats:
    row = sections(scene.device, scene.support, scene.beam, lossy=False, segments=_FINER * SEGMENTS)
    return bending_frequencies(row, scene.ends.lossless, count, open_circuit=False)
