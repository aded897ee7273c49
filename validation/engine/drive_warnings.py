"""What a reader must be told when a drive leaves what ceramic, poling and beam theory stand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tactgen.tmm.ports.readout import Readout
from tactgen.validation.catalogue.bimorph import CERAMIC_STRESS
from tactgen.validation.catalogue.models import MODELS, gives, ranked
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import DrivenReadout
from tactgen.validation.engine.model import Model
from tactgen.validation.engine.reading import read
from tactgen.validation.engine.results import Quantity
from tactgen.validation.scene.scene import Scene

#: A beam shorter than this many thicknesses is no longer slender.
SLENDER = 10.0

#: Frequencies up to which the stress is looked at unasked; more take longer than what was asked.
_FREQUENCIES = 5000


def field_warnings(scene: Scene, quantities: Sequence[str]) -> tuple[str, ...]:
    """Return a warning if the drive voltage may depole the ceramic."""
    if not any(_follows_voltage(name) for name in quantities):
        return ()
    share = 0.5 if scene.bimorph.wiring == "series" else 1.0
    field = share * abs(scene.drive.voltage) / scene.bimorph.piezo_thickness
    limit = scene.limits.depoling_field
    if not field > limit:
        return ()
    sentence = (
        f"drive.voltage = {scene.drive.voltage:g} V is {1e-6 * field:.3g} kV/mm in a layer, half "
        f"of each period against the poling; limits.depoling_field = {1e-6 * limit:g} kV/mm is "
        f"reached with {limit * scene.bimorph.piezo_thickness / share:.3g} V"
    )
    return (sentence,)


def slenderness_warnings(scene: Scene, models: Sequence[str]) -> tuple[str, ...]:
    """Return a warning if beam theory is asked about an actuator that is no beam."""
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
    """Return a warning if the ceramic is strained beyond its strength at an asked frequency.

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
    """Return whether a quantity's value is that at the drive voltage."""
    match QUANTITIES[name].read:
        case Readout(unit_voltage=False, level=None):
            return True
        case DrivenReadout():
            return name == CERAMIC_STRESS.name
    return False
