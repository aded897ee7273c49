"""Quantities read off models' answers, each with its numerical error bar.

What is read off the fine result is also read off the coarser ones; the distances are the bar.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.tmm.beam.port_quantities import driven_ceramic
from tactgen.tmm.ports.elements import attach, tip_stiffness
from tactgen.tmm.ports.loads import OF_THE_TABLE, disturbed
from tactgen.tmm.ports.multiport import Multiport, Response, in_series, respond
from tactgen.tmm.ports.readout import ELECTRICAL, ModalReadout, PortMatrix, Readout
from tactgen.validation.catalogue.quantities import (
    AnswerReadout,
    DrivenReadout,
    LoadReadout,
    QuantityRow,
)
from tactgen.validation.models.model import Estimate, Model, Modes, Refined, rounding_of_ports
from tactgen.validation.scene.scene import Scene

Array = NDArray[Any]

#: Rounding of a frequency that a model solved for exactly.
_ROUNDING = 1e-13
#: Rounding of a moment inside the ceramic, which follows from the tip by two small solutions.
_OF_A_MOMENT = 1e-10


def read(row: QuantityRow, model: Model) -> Estimate:
    """Quantity by a model that gives it."""
    ends = model.scene.ends
    found = _read(row, model, ends)
    if not row.loaded or isinstance(row.read, AnswerReadout):
        return found
    apart = [np.abs(found.value - _read(row, model, other).value) for other in disturbed(ends)]
    if not apart:
        return found
    bar = found.error + np.hypot(*apart)
    return replace(found, error=bar, method=f"{found.method}; {OF_THE_TABLE}")


def _read(row: QuantityRow, model: Model, ends: Ends) -> Estimate:
    """Quantity of the actuator with support and load."""
    answers = [model.answer(need) for need in row.needs]
    match row.read:
        case AnswerReadout(of=of):
            found = of(answers[0])
            classes = found.classes if isinstance(found, Estimate) else None
            value, bar = np.asarray(found.value), np.asarray(found.error)
            return Estimate(value, bar, answers[0].method, classes)
        case ModalReadout(combine=None):
            return _frequencies(answers[0], model.scene.modes)
        case ModalReadout():
            return _combination(row.read, answers)
        case DrivenReadout():
            of_ceramic = _of_ceramic(row.read, model.scene, ends)
            return _of_response(of_ceramic, model, answers[0], ends, _OF_A_MOMENT)
        case LoadReadout():
            of_load = _of_load(row.read, model.scene, ends)
            # the power goes with the square of the motion
            return _of_response(of_load, model, answers[0], ends, 0.0, gain=2.0)
        case PortMatrix() | Readout():
            return _at_ports(row.read, model, answers[0], ends)


def _judge(
    refined: Refined[Any],
    of: Callable[[Any], Any],
    rounding: Any,
    size: Callable[[Array], Array] = np.abs,
) -> Estimate:
    """Apply `of` to the fine and the coarser results; the bars add, rounding being of `size`."""
    value = np.asarray(of(refined.fine))
    apart = np.zeros(value.shape)
    for coarser, factor in refined.coarser:
        apart = apart + factor * np.abs(value - np.asarray(of(coarser)))
    apart = np.maximum(apart, refined.least * size(value))
    bar = apart + size(value) * (rounding + refined.rounding)
    return Estimate(value, np.asarray(bar, dtype=float), refined.method)


def _at_ports(
    readout: Readout | PortMatrix, model: Model, refined: Refined[Multiport], ends: Ends
) -> Estimate:
    scene = model.scene
    static = isinstance(readout, Readout) and readout.static
    ends = ends.lossless if static else ends
    if isinstance(readout, Readout) and readout.is_of_tip and not static:
        closed, f = model.closed_form(ends), np.asarray(scene.frequency, dtype=float)
        if closed is not None:
            voltage, variable = scene.drive.voltage, readout.variable
            return _judge(closed, lambda r: readout.scaled(variable(r), voltage, f), 0.0)
    rounding = rounding_of_ports(refined, attach(refined.fine, ends))

    def wired(port: Multiport) -> Multiport:
        return in_series(port) if scene.bimorph.wiring == "series" else port

    if isinstance(readout, PortMatrix):
        return _judge(
            refined, lambda port: wired(port).stiffness, rounding[:, None, None], balanced_size
        )

    def of(port: Multiport) -> Array:
        found = readout.read(attach(wired(port), ends), scene.drive.voltage)
        return np.asarray(found[0].real) if static else found

    return _judge(refined, of, rounding[0] if static else rounding)


def balanced_size(matrix: Array) -> Array:
    """√|D_ii D_jj| (n, p, p), so that entries that should be 0 have a bar too."""
    own = np.sqrt(np.abs(np.diagonal(matrix, axis1=1, axis2=2)))
    return np.asarray(np.maximum(np.abs(matrix), own[:, :, None] * own[:, None, :]))


def _of_ceramic(readout: DrivenReadout, scene: Scene, ends: Ends) -> Callable[[Response], Array]:
    """Read the ceramic's load off the tip's motion and the charge."""
    frequencies = np.asarray(scene.frequency, dtype=float)

    def of(response: Response) -> Array:
        driven = driven_ceramic(scene.device, scene.beam, ends, frequencies, response)
        return np.asarray(readout.of(driven, scene.limits, scene.drive.voltage))

    return of


def _of_load(readout: LoadReadout, scene: Scene, ends: Ends) -> Callable[[Response], Array]:
    """Read the load's force off the tip's motion."""
    frequencies = np.asarray(scene.frequency, dtype=float)
    stiffness, omega = tip_stiffness(ends.tip, frequencies), 2.0 * np.pi * frequencies
    voltage = scene.drive.voltage
    return lambda found: np.asarray(readout.of(stiffness, voltage * found.motion["w_tip"], omega))


def _of_response(
    of: Callable[[Response], Array],
    model: Model,
    refined: Refined[Multiport],
    ends: Ends,
    rounding: float,
    gain: float = 1.0,
) -> Estimate:
    """Read something off tip and charge at 1 V, by closed form or ports, whoever gives them."""
    closed = model.closed_form(ends)
    if closed is not None:
        return _judge(replace(closed, rounding=gain * closed.rounding), of, rounding)
    series = model.scene.bimorph.wiring == "series"

    def of_port(port: Multiport) -> Array:
        attached = attach(in_series(port) if series else port, ends)
        return of(respond(attached, {ELECTRICAL: 1.0}))

    by_ports = rounding_of_ports(refined, attach(refined.fine, ends))
    return _judge(refined, of_port, gain * by_ports + rounding)


def _frequencies(refined: Refined[Modes], count: int) -> Estimate:
    rounding = _ROUNDING + _by_mode(refined)[:count]
    found = _judge(replace(refined, rounding=0.0), lambda m: m.frequencies[:count], rounding)
    return replace(found, classes=refined.fine.classes[:count])


def _combination(readout: ModalReadout, answers: Sequence[Refined[Modes]]) -> Estimate:
    combine = readout.combine
    assert combine is not None

    def of(modes: Sequence[Modes]) -> Array:
        return np.asarray(combine(*(m.first_bending for m in modes)))

    together = Refined(
        tuple(answer.fine for answer in answers),
        tuple(
            (tuple(modes for modes, _ in level), max(factor for _, factor in level))
            for level in zip(*(answer.beside or answer.coarser for answer in answers), strict=True)
        ),
        answers[0].method,
    )
    rounding = sum((_of_bending(answer) for answer in answers), _ROUNDING)
    found = _judge(together, of, 0.0)
    return replace(found, error=found.error + readout.rounding(float(found.value), rounding))


def _by_mode(refined: Refined[Modes]) -> Array:
    """Rounding error of each mode."""
    return np.broadcast_to(refined.rounding, refined.fine.frequencies.shape)


def _of_bending(refined: Refined[Modes]) -> float:
    """Rounding error of the first bending mode in x, nan if there is none."""
    bends = np.array(refined.fine.classes) == "bending_x"
    return float(_by_mode(refined)[bends][0]) if bends.any() else float("nan")
