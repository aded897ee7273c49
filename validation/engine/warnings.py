"""Refusals of a request, and limits of validity of its answers, a sentence each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from tactgen.geometry.bimorph.segments import beam_pieces, bimorph_stack
from tactgen.geometry.device.bimorph import Piezo, Shim
from tactgen.geometry.device.ceramic_constants import moved
from tactgen.geometry.device.support_table import support_table
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import engineering
from tactgen.geometry.formats import share as share_of
from tactgen.tmm.beam.sections import section
from tactgen.tmm.ports.excitation_and_circuit import excitation_of
from tactgen.tmm.ports.finger_and_pad import FINGER_RANGE
from tactgen.tmm.ports.measured_loads import MeasuredLaw
from tactgen.tmm.ports.readout import ModalReadout, Readout
from tactgen.tmm.ports.supports_and_loads import outside_known_range
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.models import MODELS, gives
from tactgen.validation.catalogue.quantities import (
    CERAMIC_STRESS,
    QUANTITIES,
    CircuitReadout,
    DrivenReadout,
    LoadReadout,
)
from tactgen.validation.engine.answers import representative
from tactgen.validation.engine.base_moment import base_moment
from tactgen.validation.engine.extremes import extreme
from tactgen.validation.engine.readout import read
from tactgen.validation.models.model import Extreme, Model, Quantity
from tactgen.validation.scene.conditions import beyond_voltage
from tactgen.validation.scene.scene import Scene

#: Largest displacement (share of the length) that linear theory of bending is about.
_SMALL_DEFLECTION = 0.1
#: How the tip's displacement at the drive voltage is read.
_DEFLECTIONS = (Readout("w_tip", "motion"), Readout("w_tip", "motion", static=True))
#: Modelling error of a number (relative) from which on it is given with a warning.
_LARGE = 0.1
#: Quantities whose numerical error is too large that a warning names, the worst.
_NAMED = 3
#: Square of the section's coupling factor that is nothing but rounding.
_NO_COUPLING = 1e-18
#: Frequencies up to which the stress is looked at unasked; more take longer than what was asked.
_FREQUENCIES = 5000


def request_warnings(
    scene: Scene, models: Sequence[str], quantities: Sequence[str]
) -> tuple[str, ...]:
    """Warnings about a request before anything is computed.

    Raises InputError if it cannot be answered, whichever the models.
    """
    scene = scene.asking(models)
    _check_base(scene, quantities)
    return (
        *_no_bending(scene, quantities), *load_warnings(scene, quantities),
        *_of_constants(scene, quantities), *_of_threshold(scene, quantities),
        *_of_losses(scene, quantities),
        *_of_support_over_frequency(scene, quantities),
        *(() if scene.awaits_map else held_warnings(scene, models, quantities)),
        *field_warnings(scene, quantities),
    )  # fmt: skip


def _check_base(scene: Scene, quantities: Sequence[str]) -> None:
    """Refuse 0 Hz for a quantity under an acceleration of the base."""
    if 0.0 not in scene.frequency:
        return
    own = excitation_of(scene.circuit, scene.drive)
    for row in (QUANTITIES[name] for name in quantities):
        match row.read:
            case Readout(under=under, static=False):
                excitation = under or own
            case LoadReadout() | CircuitReadout() | DrivenReadout(under=None):
                excitation = own
            case _:
                continue
        if excitation.acceleration:
            raise InputError(
                f"frequency = 0 Hz has no {row.name} under an acceleration of the base; choose "
                "frequencies above it, for example 0.1 Hz for a constant acceleration"
            )


def _of_constants(scene: Scene, quantities: Sequence[str]) -> Iterator[str]:
    """Stated constants that contradict each other a little, and what is taken."""
    asked = any(QUANTITIES[name].actuator == "bimorph" for name in quantities)
    used = "piezo" in scene.bimorph.own_materials
    if asked and used and (taken := moved(scene.piezo.base, scene.piezo.constants)):
        yield (
            f"the constants of piezo.constants contradict each other a little; taken are "
            f"{', '.join(taken)}; leave out the one that is known least"
        )


def _of_losses(scene: Scene, quantities: Sequence[str]) -> Iterator[str]:
    """Metals without losses, where the power of a harvester is asked for."""
    rows = [QUANTITIES[name] for name in quantities]
    of_power = any(isinstance(row.read, CircuitReadout) and row.unit == "W" for row in rows)
    if not of_power or not excitation_of(scene.circuit, scene.drive).is_mechanical:
        return
    lossless = {
        of.material.material
        for of in bimorph_stack(scene.device)
        if isinstance(of.material, Shim) and not of.material.loss_factor
    }
    if lossless:
        yield (
            f"power at resonance depends on losses, and {' and '.join(sorted(lossless))} is taken "
            "without (loss factor 0); state shim.loss_factor, in bimorph.layers for a layer called "
            "shim"
        )


def _no_bending(scene: Scene, quantities: Sequence[str]) -> Iterator[str]:
    """Listed layers whose driven ceramics stretch the bimorph and do not bend it."""
    asked = any(QUANTITIES[name].actuator == "bimorph" for name in quantities)
    if not (asked and scene.bimorph.layers):
        return
    found = [
        section(piece, scene.device, scene.beam, lossy=False)
        for piece in beam_pieces(scene.device, scene.support)
        if piece.section == "bimorph"
    ]
    driven = any(
        layer.hot and layer.material.d31
        for layer in bimorph_stack(scene.device)
        if isinstance(layer.material, Piezo)
    )
    if driven and all(of.K**2 <= _NO_COUPLING * of.EI * of.C for of in found):
        yield (
            f'the ceramics of bimorph.layers = "{scene.bimorph.layers}" stretch it and do not bend '
            "it, so that voltage and bending do not couple; turn the poling of one, or name its "
            "hot face"
        )


def held_warnings(scene: Scene, models: Sequence[str], quantities: Sequence[str]) -> Iterator[str]:
    """Where a current holds the rod of the contact, or that the spring does not hold it up.

    Raises InputError if a rigid-body motion is free and a value at 0 Hz is asked for.
    """
    check_held(scene, quantities)
    if scene.rest is None:
        return
    place, springs = scene.rest
    if scene.coil.current == 0.0 and place.kind == "floating":
        yield (
            f"spring.preload = {1e3 * scene.device.spring.preload:g} mN does not press the rod on "
            f"its upper stop: the equilibrium is {-1e6 * place.lift:.4g} um below; increase "
            "spring.preload, for example to 110 mN"
        )
    elif scene.coil.current and any(MODELS[name].actuator == "bimorph" for name in models):
        where = f"at its {place.kind}" if "stop" in place.kind else "between its stops"
        yield (
            f"with coil.current = {1e3 * scene.coil.current:g} mA ({scene.coil.history}) the rod "
            f"is {where} with a contact force of {1e3 * place.contact_force:.4g} mN (model "
            f"{scene.map_model}), which gives a support of {springs.rotational_stiffness:.3g} "
            "N m/rad; for the spring alone set coil.current = 0 mA"
        )


def number_warnings(scene: Scene, found: Sequence[Quantity]) -> tuple[str, ...]:
    """Warnings about numbers: large errors of either kind, motion beyond linear theory."""
    return (
        *accuracy_warnings(scene, found), *modelling_warnings(found), *_of_deflection(scene, found),
    )  # fmt: skip


def answer_warnings(
    scene: Scene, models: Mapping[str, Model], found: Sequence[Quantity]
) -> tuple[str, ...]:
    """Warnings about the answers of models."""
    own = [
        warning
        for name, model in models.items()
        for warning in model.warnings([q.name for q in found if q.model == name])
    ]
    quantities = tuple(dict.fromkeys(q.name for q in found))
    return (
        *own, *number_warnings(scene, found), *_of_stress(scene, models, quantities, found),
        *_of_tipping(scene, quantities),
    )  # fmt: skip


def accuracy_warnings(scene: Scene, found: Sequence[Quantity]) -> Iterator[str]:
    """Quantities whose error exceeds the wanted accuracy, by models that refine for it."""
    for model in (row for row in MODELS.values() if row.remedy):
        # entries of a matrix may be small
        own = [q for q in found if q.model == model.name and q.value.ndim < 2]
        missed = sorted((of for q in own if (of := _excess(q, scene.accuracy))), reverse=True)
        if missed:
            named = [text for _, text in missed[:_NAMED]]
            if len(missed) > _NAMED:
                named.append(f"less so in {len(missed) - _NAMED} other quantities")
            yield (
                f"the numerical error of the model {model.name} exceeds the requested "
                f"{100.0 * scene.accuracy:g} % in {', '.join(named)}; {model.remedy}"
            )


def modelling_warnings(found: Sequence[Quantity]) -> Iterator[str]:
    """Quantities of which the modelling error of a model is large."""
    for model in dict.fromkeys(q.model for q in found):
        own = {q.name: _modelling_share(q) for q in found if q.model == model}
        large = {name: share for name, share in own.items() if share > _LARGE}
        if large:
            named = ", ".join(f"{name} ({share_of(share)})" for name, share in large.items())
            detailed = "solid" if MODELS[model].actuator == "bimorph" else "axisymmetric"
            yield (
                f"the modelling error of the model {model} reaches {share_of(max(large.values()))}"
                f": {named}; compare with --set models={detailed}"
            )


def _modelling_share(q: Quantity) -> float:
    """Largest relative modelling error of numbers, 0 where none is known.

    Of a response over frequency none counts: beside a minimum all errors are large.
    """
    if q.value.ndim > 1 or q.frequency is not None:
        return 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        of = q.value if q.modelling is None else q.modelling.expected
        shares = np.atleast_1d(q.modelling_error / np.abs(of))
    return float(np.nanmax(np.where(np.isfinite(shares), shares, 0.0), initial=0.0))


def _of_deflection(scene: Scene, found: Sequence[Quantity]) -> Iterator[str]:
    """A displacement beyond linear theory."""
    tips = [representative(q) for q in found if QUANTITIES[q.name].read in _DEFLECTIONS]
    largest = max(tips, key=lambda tip: abs(tip.value), default=None)
    share = abs(largest.value) / scene.bimorph.length if largest else 0.0
    if largest and share > _SMALL_DEFLECTION:
        where = f" at {largest.at:.4g} Hz" if largest.at else ""
        yield (
            f"the tip displacement reaches {1e3 * abs(largest.value):.3g} mm{where}, "
            f"{share_of(share)} of the length; all models are linear, so values above "
            f"{100.0 * _SMALL_DEFLECTION:g} % are not valid: reduce "
            f"{'the excitation' if beyond_voltage(scene) else 'drive.voltage'}"
        )


def _excess(q: Quantity, accuracy: float) -> tuple[float, str] | None:
    """Largest relative error, and the quantity with it in words; None if it is small enough."""
    size = np.abs(q.value)
    beyond = q.error > accuracy * size
    if not beyond.any():
        return None
    if beyond.ndim == 0 and q.error >= size:
        return np.inf, f"{q.name} (zero within its error)"
    # no value, no bar: a threshold voltage outside the threshold's range
    worst = float(np.nanmax(q.error / np.where(size > 0.0, size, np.inf)))
    where = f" at {int(beyond.sum())} of {beyond.size} values" if beyond.ndim else ""
    shown = float(f"{worst:.2g}")
    digits = 2 if shown > accuracy else 4  # so many that it is seen to be beyond
    return worst, f"{q.name} (up to {100.0 * worst:.{digits}g} %{where})"


def check_held(scene: Scene, quantities: Sequence[str]) -> None:
    """Refuse a static question about an actuator that its springs do not hold."""
    rows = [QUANTITIES[name] for name in quantities]
    at_rest = [
        row.name for row in rows if row.held_by_support and (row.static or 0.0 in scene.frequency)
    ]
    if not at_rest or not scene.ends.rigid_motions:
        return
    free = f"so {at_rest[0]} has no value at 0 Hz"
    if scene.support.kind == "contact" and scene.guide.clearance:
        raise InputError(
            f"guide.clearance = {1e3 * scene.guide.clearance:g} mm lets a rod that no stop carries "
            f"move as a rigid body, {free}; set guide.clearance = 0 mm or ask for frequencies "
            "above 0 Hz"
        )
    if scene.support.kind == "pinned":
        raise InputError(
            f'support.kind = "pinned" lets the actuator turn as a rigid body, {free}; set '
            'load.kind = "pinned" as well or ask for frequencies above 0 Hz'
        )
    if scene.support.kind == "table":
        table = support_table(scene.support)
        raise InputError(
            f"{table.source} has no positive real part at its lowest frequency of "
            f"{table.band[0]:g} Hz, {free}; remove the line or ask for responses above 0 Hz"
        )
    springs = ("rotational_stiffness", "lateral_stiffness")
    loose = next(name for name in springs if getattr(scene.held, name) == 0.0)
    group = "support" if scene.support.kind == "spring" else "guide"
    raise InputError(
        f"{group}.{loose} = 0 leaves the actuator free to move as a rigid body, {free}; give the "
        f"{group} a stiffness or ask for frequencies above 0 Hz"
    )


def _of_support_over_frequency(scene: Scene, quantities: Sequence[str]) -> Iterator[str]:
    """Quantities that take a support that goes with frequency at one frequency."""
    resonates = scene.contact.board_stiffness or scene.spring.tilts_both_planes
    rows = [QUANTITIES[name] for name in quantities]
    modal = [r.name for r in rows if isinstance(r.read, ModalReadout)]
    if scene.support.kind == "contact" and resonates and modal:
        yield (
            f"{', '.join(modal[:3])}{', …' if modal[3:] else ''}: without the resonance of the "
            "upper board (contact.board_stiffness) and of the rod across the width "
            "(spring.eccentricity_angle); the peaks of tip_displacement over frequency contain them"
        )
    if scene.support.kind != "table":
        return
    constant = [r.name for r in rows if r.static or isinstance(r.read, ModalReadout)]
    if constant:
        lowest = support_table(scene.support).band[0]
        yield (
            f"{', '.join(constant[:3])}{', …' if constant[3:] else ''} takes the support's "
            f"stiffness at {lowest:g} Hz, the lowest frequency of support.file, for all motions; "
            "a response over frequency has the whole table"
        )


def load_warnings(scene: Scene, quantities: Sequence[str]) -> Iterator[str]:
    """Frequencies outside the range of the load model, and a fit that stands for a table.

    Raises InputError if all are outside, or one of them where nothing continues a table.
    """
    if not any(QUANTITIES[name].loaded for name in quantities):
        return
    frequencies = np.asarray(scene.frequency)
    outside = outside_known_range(scene.load, frequencies)
    if scene.load.kind == "table":
        law = scene.ends.tip
        assert isinstance(law, MeasuredLaw)
        law(frequencies)  # refuses what it does not reach
        if law.fits:
            beyond = (
                f"; {int(outside.sum())} of {frequencies.size} frequencies are outside the table, "
                "where the error is an estimate"
            )
            (low, high), (largest, usual) = law.table.band, law.misfit
            yield (
                f"{law.table.source} ({low:g} to {high:g} Hz) is replaced by springs, dampers and "
                f"masses, with a misfit of at most {share_of(largest)} and "
                f"{share_of(usual)} in the mean; the errors contain it"
                f"{beyond if outside.any() else ''}"
            )
        return
    low, high = FINGER_RANGE
    if outside.all():
        raise InputError(
            f"frequency = {scene.frequency[0]:g} Hz is outside the range of the finger's load "
            f"model ({low:g} to {high:g} Hz); choose frequencies inside it, or another load.kind"
        )
    if outside.any():
        yield (
            f"{int(outside.sum())} of {outside.size} frequencies are outside the range in which "
            f"the finger was measured ({low:g} to {high:g} Hz); there its stiffness and damping "
            "have the value at the nearer end"
        )


def _of_threshold(scene: Scene, quantities: Sequence[str]) -> Iterator[str]:
    """Frequencies outside the range of the detection threshold, where a level has no value.

    Raises InputError if all of them are and nothing else was asked for.
    """
    asked = [name for name in quantities if QUANTITIES[name].has_level]
    if not asked:
        return
    threshold = threshold_of(scene.threshold)
    outside = threshold.outside(np.asarray(scene.frequency))
    low, high = threshold.range
    if outside.all() and set(quantities) == set(asked):
        raise InputError(
            f"frequency = {scene.frequency[0]:g} Hz is outside the range of the detection "
            f"threshold ({low:g} to {high:g} Hz); choose frequencies inside it"
        )
    if outside.any():
        yield (
            f"{int(outside.sum())} of {outside.size} frequencies are outside the range in which "
            f"the detection threshold is stated ({low:g} to {high:g} Hz); {' and '.join(asked)} "
            f"{'has' if len(asked) == 1 else 'have'} no value there"
        )


def field_warnings(scene: Scene, quantities: Sequence[str]) -> Iterator[str]:
    """A drive voltage that may depole the ceramic."""
    if scene.circuit.kind != "source":
        return
    share = 0.5 if scene.bimorph.wiring == "series" else 1.0
    field = share * abs(scene.drive.voltage) / scene.bimorph.electrode_distance
    limit = scene.limits.depoling_field
    if field > limit and any(map(_follows_voltage, quantities)):
        yield (
            f"drive.voltage = {scene.drive.voltage:g} V is {1e-6 * field:.3g} kV/mm in a layer, "
            "against the poling in half of each period; limits.depoling_field = "
            f"{1e-6 * limit:g} kV/mm allows "
            f"{_rounded_down(limit * scene.bimorph.electrode_distance / share)} V"
        )


def _of_stress(
    scene: Scene, models: Mapping[str, Model], quantities: Sequence[str], found: Sequence[Quantity]
) -> Iterator[str]:
    """Stress of the ceramic beyond its strength, from what was `found` if it was asked for."""
    asked = [
        name
        for name in quantities
        if QUANTITIES[name].by_frequency
        and (_follows_voltage(name) or isinstance(QUANTITIES[name].read, CircuitReadout))
    ]
    able = [name for name in models if any(gives(name, quantity) for quantity in asked)]
    if not able or len(scene.frequency) > _FREQUENCIES:
        return
    limit, stresses = scene.limits.ceramic_strength, []
    for name in able:
        known = [q.extreme for q in found if (q.name, q.model) == (CERAMIC_STRESS.name, name)]
        peak = known[0] if known else extreme(CERAMIC_STRESS, models[name])
        is_searched = peak is not None
        if peak is None:
            size = read(CERAMIC_STRESS, models[name]).value
            worst = int(np.argmax(np.nan_to_num(size)))
            peak = Extreme(scene.frequency[worst], float(np.nan_to_num(size[worst])), 0.0)
        stresses.append((peak.value, peak.frequency, name, is_searched))
    stress, frequency, name, is_searched = max(stresses)
    if stress > limit:
        band = f"from {min(scene.frequency):.4g} Hz to {max(scene.frequency):.4g} Hz"
        if not is_searched:
            band = "at the frequencies of the scene; a sweep also finds the resonance"
        yield (
            f"the stress in the ceramic reaches {1e-6 * stress:.3g} MPa at {frequency:.4g} Hz "
            f"(model {name}), more than limits.ceramic_strength = {1e-6 * limit:g} MPa, and the "
            f"ceramic may break; {_lower_drive(scene, limit / stress)} it below {band}"
        )


def _of_tipping(scene: Scene, quantities: Sequence[str]) -> Iterator[str]:
    """Motions for which the rod's head would tip on its stop, which a linear support cannot."""
    asked = any(QUANTITIES[q].by_frequency and _follows_voltage(q) for q in quantities)
    if scene.support.kind != "contact" or not asked or len(scene.frequency) > _FREQUENCIES:
        return
    found = base_moment(scene)
    if found.largest > found.tipping > 0.0:
        lower = _lower_drive(scene, found.tipping / found.largest)
        yield (
            f"the moment on the head reaches {engineering(found.largest, 'N m', 2)} at "
            f"{found.at:.4g} Hz and the head tips at {engineering(found.tipping, 'N m', 2)}: the "
            f"linear answers are not valid there; {lower} it below that at the frequencies of the "
            "scene, and tactgen backbone follows the head that rocks"
        )


def _lower_drive(scene: Scene, share: float) -> str:
    """What keeps a response to the whole drive within a share of it."""
    excitation = excitation_of(scene.circuit, scene.drive)
    parts = {
        "voltage": (excitation.source, "V"),
        "base_acceleration": (excitation.acceleration, "m/s^2"),
        "tip_force": (excitation.force, "N"),
    }
    lower = [
        f"drive.{name} = {_rounded_down(abs(size) * share)} {unit}"
        for name, (size, unit) in parts.items() if size
    ]  # fmt: skip
    return f"{' and '.join(lower)} {'keeps' if len(lower) == 1 else 'keep'}"


def _rounded_down(value: float) -> str:
    """Positive number to three digits, never above itself."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    # what is a round number but for rounding stays so
    return f"{math.floor(value / unit * (1.0 + 1e-12)) * unit:.3g}"


def _follows_voltage(name: str) -> bool:
    """Whether a quantity's value is that at the drive voltage."""
    row = QUANTITIES[name]
    static = isinstance(row.read, Readout) and row.read.static and row.read.under is None
    return static or (row.is_amplitude and not isinstance(row.read, LoadReadout))
