"""Refusals of a request, and limits of validity of its answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.elements import outside_known_range
from tactgen.tmm.ports.loads import FINGER_RANGE, MeasuredLaw
from tactgen.tmm.ports.readout import Readout
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.models import MODELS, gives, ranked
from tactgen.validation.catalogue.quantities import CERAMIC_STRESS, QUANTITIES, DrivenReadout
from tactgen.validation.engine.readout import read
from tactgen.validation.models.model import Model, Quantity
from tactgen.validation.scene.scene import Scene

#: Largest displacement (share of the length) that linear theory of bending is about.
_SMALL_DEFLECTION = 0.1
#: How the tip's displacement at the drive voltage is read.
_DEFLECTIONS = (Readout("w_tip", "motion"), Readout("w_tip", "motion", static=True))


def accuracy_warnings(scene: Scene, found: Sequence[Quantity]) -> tuple[str, ...]:
    """Warnings about quantities whose error exceeds the wanted accuracy."""
    warnings = []
    for model in (row for row in MODELS.values() if row.remedy):
        missed = [
            text
            for q in found
            if q.model == model.name and q.value.ndim < 2  # entries of a matrix may be small
            if (text := _excess(q, scene.accuracy))
        ]
        if missed:
            warnings.append(
                f"the {model.name} model's error bar exceeds the {100.0 * scene.accuracy:g} % "
                f"asked for in {', '.join(missed)}; {model.remedy}"
            )
    return tuple(warnings)


def deflection_warnings(scene: Scene, found: Sequence[Quantity]) -> tuple[str, ...]:
    """Warning if a displacement is beyond linear theory."""
    tips = [q for q in found if QUANTITIES[q.name].read in _DEFLECTIONS]
    largest = max((float(np.nanmax(np.abs(q.value))) for q in tips), default=0.0)
    share = largest / scene.bimorph.length
    if not share > _SMALL_DEFLECTION:
        return ()
    sentence = (
        f"the tip moves by up to {1e3 * largest:.3g} mm, {100.0 * share:.2g} % of the length: all "
        "models are linear, so this says no more than that there is a resonance or too much voltage"
    )
    return (sentence,)


def _excess(q: Quantity, accuracy: float) -> str:
    """Quantity's name and how wide its bar is, or nothing if it is narrow enough."""
    size = np.abs(q.value)
    beyond = q.error > accuracy * size
    if not beyond.any():
        return ""
    if beyond.ndim == 0 and q.error >= size:
        return f"{q.name} (zero within its bar)"
    # no value, no bar: a threshold voltage outside the threshold's range
    worst = float(np.nanmax(q.error / np.where(size > 0.0, size, np.inf)))
    where = f" at {int(beyond.sum())} of {beyond.size} values" if beyond.ndim else ""
    shown = float(f"{worst:.2g}")
    digits = 2 if shown > accuracy else 4  # so many that it is seen to be beyond
    return f"{q.name} (up to {100.0 * worst:.{digits}g} %{where})"


def check_held(scene: Scene, quantities: Sequence[str]) -> None:
    """Refuse a static question about an actuator that its springs do not hold.

    Raises InputError if a rigid-body motion is free and a value at 0 Hz is asked for.
    """
    if not scene.ends.rigid_motions:
        return
    rows = [QUANTITIES[name] for name in quantities]
    at_rest = [
        row.name for row in rows if row.held_by_support and (row.static or 0.0 in scene.frequency)
    ]
    if not at_rest:
        return
    free = f"so {at_rest[0]} has no value at 0 Hz"
    if scene.support.kind == "contact" and scene.guide.clearance:
        raise InputError(
            f"guide.clearance = {1e3 * scene.guide.clearance:g} mm lets a rod that no stop carries "
            f"move as a rigid body, {free}; set guide.clearance = 0 mm or ask for frequencies "
            "above 0 Hz"
        )
    springs = ("rotational_stiffness", "lateral_stiffness")
    loose = next(name for name in springs if getattr(scene.held, name) == 0.0)
    group = "support" if scene.support.kind == "spring" else "guide"
    raise InputError(
        f"{group}.{loose} = 0 leaves the actuator free to move as a rigid body, {free}; give the "
        f"{group} a stiffness or ask for frequencies above 0 Hz"
    )


def held_warnings(scene: Scene, models: Sequence[str]) -> tuple[str, ...]:
    """Where a current holds the rod, if the lateral actuator stands on its contact.

    Or that nothing does: a spring without preload leaves the rod where the stops' tails balance.
    """
    rest = scene.rest
    if rest is None:
        return ()
    place, springs = rest
    if scene.coil.current == 0.0 and place.kind == "floating":
        sentence = (
            f"spring.preload = {1e3 * scene.device.spring.preload:g} mN does not hold the rod up: "
            f"it floats {-1e6 * place.lift:.4g} um below its upper stop; give it the force with "
            "which it presses there, such as 110 mN"
        )
        return (sentence,)
    lateral = any(MODELS[name].actuator == "bimorph" for name in models)
    if scene.coil.current == 0.0 or not lateral:
        return ()
    where = f"at its {place.kind}" if "stop" in place.kind else "between its stops"
    sentence = (
        f"coil.current = {1e3 * scene.coil.current:g} mA, {scene.coil.history}, leaves the rod "
        f"{where}, pressed with {1e3 * place.contact_force:.4g} mN (by "
        f"the model {scene.map_model}): "
        f"a support of {springs.rotational_stiffness:.3g} N m/rad; set coil.current = 0 mA for "
        "the spring alone"
    )
    return (sentence,)


def load_warnings(scene: Scene, quantities: Sequence[str]) -> tuple[str, ...]:
    """Check the frequencies against the range of the load model.

    Returns a warning if some lie outside, or if a fit stands for a measured table.

    Raises InputError if all of them do, or one of them where nothing continues a table.
    """
    if not any(QUANTITIES[name].loaded for name in quantities):
        return ()
    frequencies = np.asarray(scene.frequency)
    outside = outside_known_range(scene.load, frequencies)
    if scene.load.kind == "table":
        return _table_warnings(scene.ends.tip, frequencies, int(outside.sum()))
    if not outside.any():
        return ()
    low, high = FINGER_RANGE
    if outside.all():
        first = scene.frequency[0]
        raise InputError(
            f"frequency = {first:g} Hz is outside the range of the finger's load model "
            f"({low:g} to {high:g} Hz); choose frequencies inside it, or another load.kind"
        )
    warning = (
        f"{int(outside.sum())} of {outside.size} frequencies lie outside the range in which the "
        f"finger was measured ({low:g} to {high:g} Hz); there its stiffness and damping are held "
        "at the nearer end of that range"
    )
    return (warning,)


def _table_warnings(law: object, frequencies: Floats, outside: int) -> tuple[str, ...]:
    """Say of a fit to a table how far it is off, and for how many frequencies it continues it."""
    assert isinstance(law, MeasuredLaw)
    law(frequencies)  # refuses what it does not reach
    if not law.fits:
        return ()
    low, high = law.table.band
    largest, usual = law.misfit
    beyond = (
        f"; {outside} of {frequencies.size} frequencies lie beyond it, where the bar is an estimate"
        if outside
        else ""
    )
    warning = (
        f"springs, dampers and masses fitted to {law.table.source} ({low:g} to {high:g} Hz) stand "
        f"for it, {100.0 * largest:.2g} % off at most and {100.0 * usual:.2g} % in the mean, which "
        f"the error bars contain{beyond}"
    )
    return (warning,)


def level_warnings(scene: Scene, quantities: Sequence[str]) -> tuple[str, ...]:
    """Check the frequencies against the range of the detection threshold.

    Returns a warning if some lie outside, where the voltage that reaches it has no value.

    Raises InputError if all of them do and nothing else was asked for.
    """
    asked = [name for name in quantities if QUANTITIES[name].has_level]
    if not asked:
        return ()
    threshold = threshold_of(scene.threshold)
    outside = threshold.outside(np.asarray(scene.frequency))
    if not outside.any():
        return ()
    low, high = threshold.range
    if outside.all() and set(quantities) == set(asked):
        raise InputError(
            f"frequency = {scene.frequency[0]:g} Hz is outside the range of the detection "
            f"threshold ({low:g} to {high:g} Hz); choose frequencies inside it"
        )
    warning = (
        f"{int(outside.sum())} of {outside.size} frequencies lie outside the range in which the "
        f"detection threshold is stated ({low:g} to {high:g} Hz); {' and '.join(asked)} "
        f"{'has' if len(asked) == 1 else 'have'} no value there"
    )
    return (warning,)


#: A beam shorter than this many thicknesses is no longer slender.
SLENDER = 10.0

#: Frequencies up to which the stress is looked at unasked; more take longer than what was asked.
_FREQUENCIES = 5000


def field_warnings(scene: Scene, quantities: Sequence[str]) -> tuple[str, ...]:
    """Warning if the drive voltage may depole the ceramic."""
    share = 0.5 if scene.bimorph.wiring == "series" else 1.0
    field = share * abs(scene.drive.voltage) / scene.bimorph.piezo_thickness
    limit = scene.limits.depoling_field
    if not field > limit or not any(map(_follows_voltage, quantities)):
        return ()
    sentence = (
        f"drive.voltage = {scene.drive.voltage:g} V is {1e-6 * field:.3g} kV/mm in a layer, half "
        f"of each period against the poling; limits.depoling_field = {1e-6 * limit:g} kV/mm is "
        f"reached with {limit * scene.bimorph.piezo_thickness / share:.3g} V"
    )
    return (sentence,)


def slenderness_warnings(scene: Scene, models: Sequence[str]) -> tuple[str, ...]:
    """Warning if beam theory is asked about an actuator that is no beam."""
    slenderness = scene.bimorph.length / scene.bimorph.thickness
    if slenderness >= SLENDER or not any(MODELS[name].takes_sections_as_plane for name in models):
        return ()
    sentence = (
        f"bimorph.length = {1e3 * scene.bimorph.length:.4g} mm is {slenderness:.2g} times the "
        "thickness, too stubby for a beam model to be trusted; compare with the model solid"
    )
    return (sentence,)


def stress_warnings(
    scene: Scene, models: Mapping[str, Model], quantities: Sequence[str], found: Sequence[Quantity]
) -> tuple[str, ...]:
    """Warning if the ceramic is strained beyond its strength at an asked frequency.

    The stress is taken from what was `found`, if it was asked for.
    """
    asked = [
        name for name in quantities if QUANTITIES[name].by_frequency and _follows_voltage(name)
    ]
    able = [name for name in models if any(gives(name, quantity) for quantity in asked)]
    if not able or len(scene.frequency) > _FREQUENCIES:
        return ()
    best = ranked(able)[-1]
    known = [q.value for q in found if (q.name, q.model) == (CERAMIC_STRESS.name, best)]
    stress = known[0] if known else read(CERAMIC_STRESS, models[best]).value
    limit = scene.limits.ceramic_strength
    if not np.nanmax(stress, initial=0.0) > limit:
        return ()
    worst = int(np.nanargmax(stress))
    sentence = (
        f"the ceramic's stress reaches {1e-6 * stress[worst]:.3g} MPa at "
        f"{scene.frequency[worst]:.4g} Hz, more than limits.ceramic_strength = {1e-6 * limit:g} "
        f"MPa: it may break; drive.voltage = {scene.drive.voltage * limit / stress[worst]:.3g} V "
        "stays below it"
    )
    return (sentence,)


def _follows_voltage(name: str) -> bool:
    """Whether a quantity's value is that at the drive voltage."""
    match QUANTITIES[name].read:
        case Readout(unit_voltage=False, level=None):
            return True
        case DrivenReadout():
            return name == CERAMIC_STRESS.name
    return False
