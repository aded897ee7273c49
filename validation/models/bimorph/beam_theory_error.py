"""How far beam theory is from the solid, told from the device alone: no solid is solved.

Two causes, both known to the bridge.  The width: far from the ends the section lies between
a narrow strip, which the beam models are, and the wide plate of laminate theory.  The ends:
there the clamp and the free edge reach about a width or a thickness into the body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.device.parameters import Bimorph
from tactgen.geometry.device.profile import UNIFORM
from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.bimorph import (
    CAPACITANCE_FREE,
    SHORT_CIRCUIT_FREQUENCIES,
    STATIC_TIP_DISPLACEMENT,
)
from tactgen.validation.scene.scene import Scene

#: Share of a value that the ends may move, over (width + 1.5 thickness) / length.  Found by
#: holding tmm against solid for sixty clamped bimorphs at random, 0.5 to 10 thicknesses wide and
#: 2 to 40 long, of three ceramics and two shims: 0.132 bounds them all, most by far.  A heavy
#: test asks sixty others.
_ENDS, _THICKNESSES = 0.15, 1.5
#: Share from which on an answer by beam theory is given with a warning.
_STUBBY = 0.1


@dataclass(frozen=True)
class Band:
    """Relative differences (tmm / solid − 1) between which the two are expected."""

    low: float
    high: float


def end_share(bimorph: Bimorph) -> float:
    """Return which share of deflection, first frequency or capacitance the ends may move."""
    width = max((w for _, w in bimorph.width_profile), default=bimorph.width)
    return float(_ENDS * (width + _THICKNESSES * bimorph.thickness) / bimorph.length)


def expected_differences(scene: Scene) -> dict[str, Band]:
    """Return by quantity how far beam theory is expected from the solid; empty on a rod.

    From nothing (a narrow strip) to what laminate theory makes of the scene's layers (a
    wide plate), and on both sides what the ends may do.  A taper counts by its layers where
    they are nominal, glue between them not at all.
    """
    from tactgen.tmm.beam.sections import laminate_section
    from tactgen.validation.models.bimorph.beam_values import beam_values

    if scene.support.kind == "rod":
        return {}
    plain = {**dict.fromkeys(scene.bimorph.profiles, UNIFORM), "glue_thickness": 0.0}
    uniform = scene.model_copy(update={"bimorph": scene.bimorph.model_copy(update=plain)})
    strip = beam_values(uniform)
    plate = beam_values(uniform, laminate_section(uniform.device, uniform.beam))
    ends = end_share(scene.bimorph)
    found = {}
    for row, narrow, wide in (
        (STATIC_TIP_DISPLACEMENT, strip.deflection, plate.deflection),
        (SHORT_CIRCUIT_FREQUENCIES, strip.first_frequency, plate.first_frequency),
        (CAPACITANCE_FREE, strip.capacitance, plate.capacitance),
    ):
        if wide != 0.0 and np.isfinite(narrow / wide):
            width = narrow / wide - 1.0
            found[row.name] = Band(min(0.0, width) - ends, max(0.0, width) + ends)
    return found


def check_beam(scene: Scene) -> None:
    """Refuse a bimorph shorter than it is thick, about which no beam theory says anything.

    Raises
    ------
    InputError
        With the model to be asked instead.
    """
    bimorph, mm = scene.bimorph, 1e3
    if bimorph.length < bimorph.thickness:
        raise InputError(
            f"bimorph.length = {bimorph.length * mm:g} mm is less than the layers' thickness of "
            f"{bimorph.thickness * mm:g} mm: that is no beam, and the models lumped, tmm and beam "
            "have no answer; make it longer or ask for --set models=solid"
        )


def stubby_warning(scene: Scene) -> str:
    """Return what is said of a short bimorph's answer by beam theory, nothing of a slender one."""
    bimorph = scene.bimorph
    share = end_share(bimorph)
    if share < _STUBBY:
        return ""
    return (
        f"bimorph.length = {1e3 * bimorph.length:g} mm is {bimorph.length / bimorph.thickness:.2g} "
        f"thicknesses and {bimorph.length / bimorph.width:.2g} widths, which is stubby for the "
        "one-dimensional models: their deflection, frequency and capacitance may be "
        f"{100.0 * share:.0f} % off by the ends alone; compare with --set models=solid"
    )
