"""Differences of models by assumption, given up one at a time.

A breakdown leads from a simple model to a detailed one.  Each step solves the device without one
assumption more; beside its effect stands what a closed form, or the simple model, predicts.

    beam_to_solid     transfer matrices -> solid: shear factor, field, constants, width
    formula_to_field  one-gap formula -> reluctance network -> field

A difference that no step measures is the remainder; see :mod:`validation.engine.comparison`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from tactgen.geometry.bimorph.segments import beam_pieces
from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.laminate import laminate_section
from tactgen.tmm.beam.layerwise import layerwise_beam
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.sections import Section, without_electrode
from tactgen.tmm.ports.excitation_and_circuit import ELECTRICAL
from tactgen.tmm.ports.multiport import Multiport, respond
from tactgen.tmm.ports.readout import MECHANICAL
from tactgen.tmm.ports.supports_and_loads import attach
from tactgen.validation.catalogue.quantities import (
    CAPACITANCE_BLOCKED,
    CAPACITANCE_FREE,
    COUPLING_FACTOR,
    FLUX_LINKAGE,
    MAGNETIC_FORCE,
    OPEN_CIRCUIT_FREQUENCIES,
    SHORT_CIRCUIT_FREQUENCIES,
    STATIC_TIP_DISPLACEMENT,
    coupling_factor,
)
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.piezo.system import SolidSystem

#: Numbers by the name of their quantity, of frequencies the first bending mode in x.
Values = Mapping[str, float]

DEFLECTION = STATIC_TIP_DISPLACEMENT.name
FIRST_FREQUENCY = SHORT_CIRCUIT_FREQUENCIES.name
OPEN_FREQUENCY = OPEN_CIRCUIT_FREQUENCIES.name
CAPACITANCE = CAPACITANCE_FREE.name
BLOCKED_CAPACITANCE = CAPACITANCE_BLOCKED.name
COUPLING = COUPLING_FACTOR.name

Announce = Callable[[str], None]


# Steps and causes


@dataclass(frozen=True)
class Step:
    """One step of a breakdown."""

    #: The assumption given up: short, and in a sentence
    name: str
    meaning: str
    values: Values  #: With this step, by the detailed model
    simple: Values  #: The same by the closed form or the simple model; nan where it has none
    #: Relative change of both since the step before; nan at the start
    change: Values
    predicted: Values
    theory: str = ""  #: The closed form in words


@dataclass(frozen=True)
class Cause:
    """Assumption and its contribution to (simple / detailed − 1) by quantity."""

    name: str
    shares: Values


def change(values: Values, before: Values) -> dict[str, float]:
    """Relative change of each quantity."""
    return {name: value / before[name] - 1.0 for name, value in values.items()}


def chain(entries: Iterable[tuple[str, str, Values, Values, str]]) -> list[Step]:
    """Steps from (name, meaning, values, simple model's values, theory) in order."""
    steps: list[Step] = []
    for name, meaning, values, simple, theory in entries:
        before = steps[-1] if steps else None
        moved = change(values, before.values) if before else _unknown(values)
        predicted = change(simple, before.simple) if before else _unknown(values)
        steps.append(Step(name, meaning, values, simple, moved, predicted, theory))
    return steps


def remaining(steps: Sequence[Step]) -> list[dict[str, float]]:
    """Difference of each step from the last one, as a fraction of it."""
    return [change(step.values, steps[-1].values) for step in steps]


def causes(steps: Sequence[Step]) -> list[Cause]:
    """Contribution of each step to (first / last − 1)."""
    return [
        Cause(step.name, {name: before[name] - after[name] for name in after})
        for step, (before, after) in zip(steps[1:], pairwise(remaining(steps)), strict=True)
    ]


def _unknown(values: Values) -> dict[str, float]:
    return dict.fromkeys(values, math.nan)


# Headline numbers of a bimorph, by transfer matrices and by a solid on bricks


def beam_row(scene: Scene, active: Section | None = None) -> list[Element]:
    """Row of beams of the scene; `active` replaces the section under the electrodes."""
    row: list[Element] = []
    for piece in beam_pieces(scene.device, scene.support):
        if active is not None and piece.section == "bimorph":
            row.append((active if piece.electrode else without_electrode(active), piece.length))
        else:
            row += transfer_matrix.elements(
                piece, scene.device, scene.beam, lossy=False, segments=transfer_matrix.SEGMENTS
            )
    return row


def beam_values(scene: Scene, active: Section | None = None) -> Values:
    """Headline numbers by transfer matrices, on the scene's support and under its load."""
    return row_values(scene, beam_row(scene, active))


def row_values(scene: Scene, row: list[Element]) -> Values:
    """Headline numbers of a row of beams."""
    short, opened = (
        float(bending_frequencies(row, scene.ends, 1, open_circuit=circuit)[0])
        for circuit in (False, True)
    )
    return _values(scene, transfer_matrix.chain(row, np.zeros(1)), short, opened)


def _values(scene: Scene, static: Multiport, short: float, opened: float) -> Values:
    """Headline numbers from D(0) and the first frequencies (Hz) at U = 0 and Q = 0."""
    port = attach(static, scene.ends.lossless)
    free = respond(port, {ELECTRICAL: 1.0})
    fixed = {name: 0.0 for name in MECHANICAL if name in port.names}
    blocked = respond(port, {ELECTRICAL: 1.0} | fixed)
    return {
        DEFLECTION: float(free.motion["w_tip"][0].real),
        FIRST_FREQUENCY: short,
        CAPACITANCE: float(free.effort[ELECTRICAL][0].real),
        OPEN_FREQUENCY: opened,
        COUPLING: float(coupling_factor(short, opened)),
        BLOCKED_CAPACITANCE: float(blocked.effort[ELECTRICAL][0].real),
    }


@dataclass(frozen=True)
class SolidCase:
    """A bimorph without rod on bricks, and the assumptions made of it."""

    scene: Scene  #: Device, support and load
    ceramic: Piezoceramic | None = None  #: Full material in place of the scene's
    uniform_field: bool = False  #: Potential linear through each layer
    held: Literal["layers", "shim"] = "layers"  #: Part of the lowest section that the base holds
    level: int = 1  #: Index of the division into bricks

    def assembled(self) -> SolidSystem:
        """Lossless system."""
        from tactgen.fem.piezo.bricks import assemble_bricks
        from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks

        device = self.scene.device
        bricks = bimorph_bricks(device, LEVELS[self.level], self.held)
        return assemble_bricks(
            device, bricks, lossy=False, ceramic=self.ceramic, uniform_field=self.uniform_field
        )


def solid_values(case: SolidCase) -> Values:
    """Headline numbers of a solid: statics and the first bending mode in x."""
    from tactgen.fem.piezo.modes import natural_modes
    from tactgen.fem.piezo.ports import static_multiport

    scene, system = case.scene, case.assembled()
    # a whole body also bends the other way, twists and stretches
    count = 1 if system.motion == "bending_x" else 4
    short, opened = (
        next(
            mode.frequency
            for mode in natural_modes(system, scene.ends, count, open_circuit=circuit)
            if mode.kind == "bending_x"
        )
        for circuit in (False, True)
    )
    return _values(scene, static_multiport(system), short, opened)


# From the beam to the solid


@dataclass(frozen=True)
class Assumption:
    """Assumption of beam theory: name, meaning, closed form of its effect."""

    name: str
    meaning: str
    theory: str


_, FIELD, POLING, D32, POISSON = BEAM_ASSUMPTIONS = (
    Assumption(
        "three dimensions",
        "a solid whose constants couple only along the beam (no Poisson effect, no d32, d33, d15), "
        "its field uniform through each layer: all that a beam assumes, but for the ends",
        "beam theory with the energy-consistent shear factor: no change",
    ),
    Assumption(
        "field varies",
        "the potential is free through each layer, so that the field follows the strain",
        "layers stiffened about their own middle by 1/(1 - k31^2)",
    ),
    Assumption(
        "d33 and d15",
        "the piezoelectric constants that act through the thickness and in shear",
        "no change, as a thin layer has no stress through its thickness",
    ),
    Assumption(
        "d32", "the piezoelectric effect across the width", "laminate theory of a wide plate"
    ),
    Assumption(
        "Poisson's effect",
        "ceramic and shim contract across, which the free side edges allow in part: now the "
        "tensors are the scene's",
        "laminate theory of a wide plate, without side edges",
    ),
)


def without(scene: Scene, given_up: Sequence[Assumption], level: int = 1) -> SolidCase:
    """Solid that still makes the beam's assumptions but those given up."""
    poisson = POISSON in given_up
    ceramic = scene.device.piezo.ceramic()
    d = np.zeros((3, 6))
    d[2, 0] = ceramic.d[2, 0]
    if D32 in given_up:
        d[2, 1] = ceramic.d[2, 1]
    if POLING in given_up:
        d[2, 2], d[0, 4], d[1, 3] = ceramic.d[2, 2], ceramic.d[0, 4], ceramic.d[1, 3]
    s = ceramic.s if poisson else np.diag(np.diag(ceramic.s))
    if not poisson:
        across = scene.shim.modulus_across
        scene = _with(scene, "shim", poisson_ratio=0.0, transverse_modulus=across)
    uniform = FIELD not in given_up
    return SolidCase(scene, replace(ceramic, s=s, d=d), uniform_field=uniform, level=level)


def _closed_form(scene: Scene, given_up: Sequence[Assumption]) -> Values:
    """Beam with the section of laminate theory; none with glue between layers, which may slide."""
    if "glue" in scene.bimorph.own_materials:
        return dict.fromkeys(HEADLINE, math.nan)
    poisson, d32, varying = (one in given_up for one in (POISSON, D32, FIELD))
    section = laminate_section(
        scene.device, scene.beam, poisson=poisson, d32=d32, varying_field=varying
    )
    return beam_values(scene, section)


#: The quantities of a bimorph that a breakdown follows.
HEADLINE = (
    DEFLECTION, FIRST_FREQUENCY, CAPACITANCE, OPEN_FREQUENCY, COUPLING, BLOCKED_CAPACITANCE,
)  # fmt: skip


def beam_to_solid(
    scene: Scene, announce: Announce = lambda _: None, *, level: int = 1
) -> list[Step]:
    """Steps from transfer matrices to the solid, on the scene's support (not a rod).

    A set of constants that no material could have is passed over: its assumption is given up
    together with the next.  `level` is the index of the division into bricks, one for all steps; on
    coarse bricks the shares move by 0.1 % of the value at most.
    """
    factor = layerwise_beam(scene.device).shear_correction
    consistent = _with(scene, "beam", shear_correction=factor)
    start, sheared = beam_values(scene), beam_values(consistent)
    plain = (
        "exact Timoshenko beam, uniform field in each layer, shear correction "
        f"{scene.beam.shear_correction:.3f}"
    )
    entries = [
        ("TMM", plain, start, start, ""),
        (
            "shear factor",
            f"the beam's shear correction by the shear energy of its layers, {factor:.3f}",
            sheared, sheared, "the same formulas, evaluated",
        ),
    ]  # fmt: skip
    passed: list[Assumption] = []
    for number, assumption in enumerate(BEAM_ASSUMPTIONS, start=1):
        passed.append(assumption)
        given_up = BEAM_ASSUMPTIONS[:number]
        case = without(consistent, given_up, level)
        assert case.ceramic is not None
        try:
            case.ceramic.check_admissible()
        except InputError:
            continue
        name = " and ".join(one.name for one in passed)
        announce(f"breakdown: {name}")
        meaning = "; ".join(one.meaning for one in passed)
        simple = _closed_form(consistent, given_up)
        entries.append((name, meaning, solid_values(case), simple, assumption.theory))
        passed = []
    return chain(entries)


# From a clamp to the rod

#: Tab of a scene that has none (m): that of the built-in scene ``bimorph_on_rod``.
USUAL_TAB = 2e-3


def on_rod(scene: Scene) -> Scene:
    """Scene in its rod, free of load, with a tab."""
    tab = scene.bimorph.tab_length or USUAL_TAB
    return _on(_with(scene, "bimorph", tab_length=tab), "rod")


def clamped(scene: Scene, tab: float = 0.0) -> Scene:
    """Bimorph alone, free of load, on a tab (m), its lowest section clamped."""
    return _on(_with(scene, "bimorph", tab_length=tab), "clamped")


def _with(scene: Scene, group: str, **changed: float) -> Scene:
    return scene.model_copy(update={group: getattr(scene, group).model_copy(update=changed)})


def _on(scene: Scene, kind: str) -> Scene:
    support = scene.support.model_copy(update={"kind": kind})
    load = scene.load.model_copy(update={"kind": "none"})
    return scene.model_copy(update={"support": support, "load": load})


# From the one-gap formula to the field

#: The network's assumptions by the name of the step that gives them up.
NETWORK_ASSUMPTIONS = {
    "one straight gap, perfect iron": "all ampere-turns stand across one gap with a uniform "
    "field: F = µ0 N² i² A / (2 g²), the textbook's formula",
    "fringing beside the pole faces": "flux also crosses beside the faces, the more so the wider "
    "the gap",
    "parasitic gap at the flange": "the way back from the sleeve into the rod takes its share of "
    "the ampere-turns",
    "leakage across the coil": "part of the flux crosses from shaft to sleeve inside the coil; it "
    "links turns but hardly pulls",
    "iron at its highest permeability": "the steel takes ampere-turns as well, as few as it ever "
    "does",
    "saturation": "the steel's real curve: the shaft carries what it can",
}
#: What is left between network and field.
_TUBES = (
    "flux takes its own way in air and spreads unevenly over the iron; the network has tubes of "
    "assumed shape and full sections"
)


def formula_to_field(
    device: Device, current: float, gap: float, field: Values | None = None
) -> list[Step]:
    """Steps from the one-gap formula over the network to the field's values, where given."""
    from tactgen.tmm.reluctance.network import network_refinements

    rows: list[tuple[str, str, Values]] = [
        (
            row.step,
            NETWORK_ASSUMPTIONS[row.step],
            {MAGNETIC_FORCE.name: row.force, FLUX_LINKAGE.name: row.flux_linkage},
        )
        for row in network_refinements(device, current, gap)
    ]
    if field is not None:
        rows.append(("the field", _TUBES, field))
    return chain((name, meaning, values, _unknown(values), "") for name, meaning, values in rows)
