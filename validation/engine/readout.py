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
from tactgen.tmm.beam.ceramic_stress import driven_ceramic
from tactgen.tmm.ports.excitation_and_circuit import (
    Excitation,
    electrical,
    excitation_of,
    excited,
    rounding_of_inertia,
    superposed,
)
from tactgen.tmm.ports.measured_loads import OF_THE_TABLE, disturbed
from tactgen.tmm.ports.multiport import BIMORPH, Multiport, Response, reduce, wired
from tactgen.tmm.ports.readout import ModalReadout, PortMatrix, Readout
from tactgen.tmm.ports.supports_and_loads import attach, load_motion, tip_stiffness
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.quantities import (
    AnswerReadout,
    CircuitReadout,
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
    """Quantity by a model that gives it; a level is the detection threshold of its scene."""
    ends = model.scene.ends
    if row.has_level:
        level = threshold_of(model.scene.threshold).at
        row = replace(row, read=replace(row.port_readout, level=level))
    found = _read(row, model, ends)
    measured_base = ends.base is not None and ends.base.law is not None
    if not (row.loaded or measured_base) or isinstance(row.read, AnswerReadout):
        return found
    apart = [np.abs(found.value - _read(row, model, other).value) for other in disturbed(ends)]
    if not apart:
        return found
    bar = found.error + np.sqrt(np.sum(np.square(apart), axis=0))
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
        case Readout():
            return _at_ports(row.read, model, answers[0], ends)
        case PortMatrix() | CircuitReadout():
            return _of_ports(row.read, model.scene, answers[0], ends)
        case DrivenReadout() | LoadReadout():
            return _of_tip(row.read, model, answers[0], ends)


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


def _of_ports(
    readout: PortMatrix | CircuitReadout, scene: Scene, refined: Refined[Multiport], ends: Ends
) -> Estimate:
    """The whole matrix D(Ω), or something off what the circuit takes."""
    wiring, excitation = scene.bimorph.wiring, excitation_of(scene.circuit, scene.drive)
    if isinstance(readout, CircuitReadout):
        # power goes with the square of the motion
        return _judge(
            refined, lambda port: readout.of(electrical(wired(port, wiring), ends, excitation)),
            2.0 * _rounding(refined, ends, excitation),
        )  # fmt: skip
    rounding, names = _rounding(refined, ends), [port.name for port in BIMORPH]
    return _judge(
        refined, lambda port: reduce(wired(port, wiring), names).stiffness,
        rounding[:, None, None], balanced_size,
    )  # fmt: skip


def _at_ports(readout: Readout, model: Model, refined: Refined[Multiport], ends: Ends) -> Estimate:
    """Variable of a port under the readout's excitation."""
    excitation = readout.under or excitation_of(model.scene.circuit, model.scene.drive)
    if readout.static:
        ends, excitation = ends.lossless, excitation.at_rest

    def of(response: Response) -> Array:
        found = readout.scaled(readout.variable(response), 1.0, refined.fine.frequencies)
        if readout.absolute:
            found = found + excitation.acceleration
        return np.asarray(found[0].real) if readout.static else found

    return _of_response(
        of, model, refined, ends, excitation, held=readout.held, static=readout.static
    )


def _rounding(
    refined: Refined[Multiport], ends: Ends, excitation: Excitation | None = None
) -> Array:
    """Relative rounding (n,) of the ports, or of a response to an excitation."""
    found = np.asarray(rounding_of_ports(refined, attach(refined.fine, ends)))
    accelerated = excitation is not None and excitation.acceleration
    return found + rounding_of_inertia(refined.fine) if accelerated else found


def balanced_size(matrix: Array) -> Array:
    """√|D_ii D_jj| (n, p, p), so that entries that should be 0 have a bar too."""
    own = np.sqrt(np.abs(np.diagonal(matrix, axis1=1, axis2=2)))
    return np.asarray(np.maximum(np.abs(matrix), own[:, :, None] * own[:, None, :]))


def _of_tip(
    readout: DrivenReadout | LoadReadout, model: Model, refined: Refined[Multiport], ends: Ends
) -> Estimate:
    """Read the ceramic's or the load's value off the motion of the tip and the charge."""
    scene, frequencies = model.scene, np.asarray(model.scene.frequency, dtype=float)
    excitation = excitation_of(scene.circuit, scene.drive)
    if isinstance(readout, LoadReadout):
        stiffness, omega = tip_stiffness(ends.tip, frequencies), 2.0 * np.pi * frequencies

        def on_load(found: Response) -> Array:
            moved = load_motion(ends.tip, found.motion["w_tip"], found.motion["psi_tip"])
            return np.asarray(readout.of(stiffness, moved, omega))

        # the power goes with the square of the motion
        return _of_response(on_load, model, refined, ends, excitation, gain=2.0)
    excitation = readout.under or excitation

    def in_ceramic(found: Response) -> Array:
        driven = driven_ceramic(scene.device, scene.beam, ends, frequencies, found, excitation)
        return np.asarray(readout.of(driven, scene.limits))

    return _of_response(in_ceramic, model, refined, ends, excitation, rounding=_OF_A_MOMENT)


def _of_response(
    of: Callable[[Response], Array],
    model: Model,
    refined: Refined[Multiport],
    ends: Ends,
    excitation: Excitation,
    *,
    held: Sequence[str] = (),
    rounding: float = 0.0,
    gain: float = 1.0,
    static: bool = False,
) -> Estimate:
    """Read something off the response to an excitation, by closed form or ports.

    `gain` is the relative change of what is read per relative change of the response.
    """
    frequencies = refined.fine.frequencies
    by_tip = not static and not held and not excitation.is_mechanical
    closed = model.closed_form(ends) if by_tip else None
    if closed is not None:
        return _judge(
            replace(closed, rounding=gain * closed.rounding),
            lambda per_volt: of(superposed(per_volt, frequencies, excitation)),
            rounding,
        )

    def of_port(port: Multiport) -> Array:
        return of(excited(wired(port, model.scene.bimorph.wiring), ends, excitation, held))

    by_ports = gain * _rounding(refined, ends, excitation) + rounding
    return _judge(refined, of_port, by_ports[0] if static else by_ports)


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
