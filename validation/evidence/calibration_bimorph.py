"""Calibration of the transfer-matrix model on solids of random bimorphs.

``tactgen calibrate`` solves the solids, fits :mod:`tmm.beam.calibrated_section` to three quarters
of them and takes its errors from the last quarter.  All devices are clamped in all layers and free
at the tip; their lengths differ by nothing but scale, so only ratios are sampled.

A fit minimises the relative error of six static numbers: the tip's displacement and rotation per
force, moment and voltage, and the free capacitance (:func:`statics`), by Gauss-Newton steps on the
logarithms of the six factors.  The ratios of frequencies follow from what these leave.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Bools, Floats
from tactgen.geometry.store.values import storable
from tactgen.tmm.beam.calibrated_row import bending_frequencies, multiport, sections
from tactgen.tmm.beam.calibrated_section import (
    SectionFactors,
    TheoryChange,
    check_known,
    lengthwise_modes,
    section_factors,
    step_sizes,
    theory_change,
)
from tactgen.tmm.beam.calibration_fit import ERRORS, STEP_SIZES, Calibration, Fit, Widening
from tactgen.tmm.beam.dimensionless_groups import (
    core_shear,
    groups,
    interior,
    laminate,
    plain,
    root_length,
)
from tactgen.tmm.beam.modes import natural_frequencies
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.chebyshev import Products, weighted_powers
from tactgen.validation.evidence.fit_record import (
    covering,
    evidence,
    products_record,
    rounded,
    solve_normal,
)
from tactgen.validation.evidence.random_devices import (
    accepted,
    clamped_bimorph,
    clamped_laminate,
    sprung,
    unusual_bimorph,
)
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene

#: Random devices of the shipped fit, their seed, and the share that is fitted to.
DEVICES, SEED, FITTED = 6000, 1, 0.75
#: The same of listed layers.
LAMINATES = 1200
#: Properties that a fit does not know, and devices of each that tell by how much its errors grow.
UNUSUAL, EACH = ("tab", "glue", "bare ends", "tip extension", "range"), 120
UNUSUAL_LISTED = (
    "tab", "bare ends", "tip extension", "patch", "own widths", "poled along", "range",
)  # fmt: skip
#: Core shear above which a core is called soft where errors are shown.
_SOFT = 0.01
#: Level of bricks: within 1e-4 of much finer ones in all that is fitted.
_LEVEL = 1
#: Degree of a term, in which each group counts with its weight: of piezo, shim and piezo, and of
#: listed layers.  The second is of what multiplies the sizes of a clamp's effects.
_TERMS: dict[str, tuple[tuple[float, Sequence[float]], tuple[float, Sequence[float]]]] = {
    "three": (
        (3.0, (1.0, 1.0, 1.0, 1.0, 1.5, 2.0, 1.0, 3.0, 2.0, 2.0)),
        (3.0, (1.0, 1.0, 1.0, 1.0, 1.5, 2.0, 1.0, 2.0, 2.0, 2.0)),
    ),
    "listed": ((3.0, (1.0, 1.0, 1.0, 1.5, 1.0, 1.0)), (2.0, (1.0, 1.0, 1.0, 1.5, 1.0, 1.0))),
}
#: Ridge relative to the mean diagonal of the normal equations; Gauss-Newton steps.
_RIDGE, _STEPS = 3e-5, 10
#: Weights of the six static numbers: those of a displacement and the capacitance count more.
_COUNTS = np.array([3.0, 1.0, 1.0, 3.0, 1.0, 3.0])
#: Relative change by layerwise theory at which they count half: there a section's factors describe
#: the device less well, first the rotation of a soft core's face.  The same of a frequency's ratio.
_TRUSTED, _TRUSTED_RATIO = np.array([0.1, 0.003, 0.003, 0.1, 0.003, np.inf]), 0.02
#: Weight of equal ratios at neighbouring knots beside that of a frequency, 1 where the mode may be
#: one across; least ratio; weight of a frequency on springs.
_SMOOTH, _LEAST_RATIO, _ON_SPRINGS = 1e-2, 0.2, 0.7
#: Quantile of held-out errors that a stated error covers, and the least error (that of the bricks).
_QUANTILE, _LEAST = 0.97, 1e-4
#: Ridges of the errors' coefficients by group, and by the sizes of a row of several pieces.
_RIDGE_OF_ERRORS, _RIDGE_OF_STEPS = 1e-2, 3e-2
#: The same quantile of few devices, of which as many coefficients cover more than of fresh ones.
_QUANTILE_OF_STEPS = 0.975


@storable
@dataclass(frozen=True)
class Observed:
    """Solid of one random device."""

    overrides: tuple[str, ...]  #: Of the scene ``prototype``
    on_springs: tuple[str, ...]  #: The same on springs
    #: (6,) Static numbers in the order of :func:`statics`
    statics: Floats
    #: (3,) First frequencies of bending in x (Hz): clamped with electrodes shorted, and open,
    #: and on springs; nan of those of a wide plate that lie above its modes across
    short: Floats
    opened: Floats
    sprung: Floats


def observe(seed: int, number: int, what: str = "", listed: bool = False) -> Observed:
    """Solve the solid of a random device, or of one with a property that the fit does not know."""
    from tactgen.fem.piezo.modes import natural_modes
    from tactgen.fem.piezo.ports import static_multiport
    from tactgen.fem.piezo.solid import assemble
    from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks

    rng = np.random.default_rng([seed, number])

    def drawn() -> tuple[list[str], Scene]:
        found = clamped_laminate(rng) if listed else clamped_bimorph(rng)
        found = unusual_bimorph(rng, found, what) if what else found
        scene, _ = load_scene("prototype", found)
        if listed:
            check_known(scene.device, scene.support)
        return found, scene

    overrides, scene = accepted(drawn)
    softer = sprung(rng, overrides, laminate(plain(scene.device)).EI / scene.bimorph.length)
    system = assemble(scene.device, bimorph_bricks(scene.device, LEVELS[_LEVEL]), lossy=False)

    def first(ends: Any, *, open_circuit: bool = False) -> Floats:
        found = natural_modes(system, ends, 5 if listed else 3, open_circuit=open_circuit)
        if listed:  # without a plane of symmetry they stretch in the same class of motion
            found = [mode for mode in found if mode.kind == "bending_x"]
        return np.array([*(mode.frequency for mode in found), *[np.nan] * 3][:3])

    return Observed(
        tuple(overrides),
        tuple(softer),
        _of_ports(static_multiport(system).stiffness[0].real),
        first(scene.ends),
        first(scene.ends, open_circuit=True),
        first(load_scene("prototype", softer)[0].ends),
    )


def _of_ports(stiffness: Any) -> Floats:
    """Six static numbers from D(0) (5, 5), its base held."""
    flexible = np.linalg.inv(stiffness[2:4, 2:4])
    moved = -flexible @ stiffness[2:4, 4]
    free = stiffness[4, 4] + stiffness[4, 2:4] @ moved
    return np.asarray(np.abs([flexible[0, 0], flexible[0, 1], flexible[1, 1], *moved, free]))


# ---- six static numbers of a beam with a root of its own ----


@dataclass(frozen=True)
class Devices:
    """Observed devices as arrays over n of them."""

    scenes: tuple[Scene, ...]
    groups: Floats  #: (n, g)
    theory: TheoryChange  #: Arrays (n, ...)
    length: Floats
    root: Floats  #: (n,) Length of the zone next to the clamp (m)
    sections: Section  #: Far from the ends, arrays (n,)
    observed: tuple[Observed, ...]


def devices_of(observed: Sequence[Observed]) -> Devices:
    """Observed devices with their groups and their laminates."""
    scenes = tuple(load_scene("prototype", list(one.overrides))[0] for one in observed)
    devices = [scene.device for scene in scenes]
    plates, roots = [interior(device) for device in devices], [*map(root_length, devices)]
    theory = [theory_change(*each) for each in zip(devices, plates, roots, strict=True)]
    return Devices(
        scenes,
        np.array([groups(device) for device in devices]),
        TheoryChange(*(np.array(of) for of in zip(*theory, strict=True))),
        np.array([scene.bimorph.length for scene in scenes]),
        np.array(roots),
        Section(*(np.array([getattr(s, n) for s in plates]) for n in Section.__annotations__)),
        tuple(observed),
    )


def statics(factors: Floats, of: Devices) -> Floats:
    """Logarithms (n, 6) of the six static numbers, from those of what the fit puts on the factors.

    Displacement per force, rotation per force, rotation per moment, displacement and rotation per
    voltage, free capacitance.
    """
    stiffness, root, shear, coupling, root_coupling, capacitance = np.exp(
        of.theory.factors + factors
    ).T
    active, length, near = of.sections, of.length, of.root
    bend = 1.0 / (active.EI * stiffness)
    curve = np.abs(active.K) * coupling * bend
    far = length - near

    def turned(at_root: Floats, beyond: Floats) -> Floats:
        return near * at_root + far * beyond

    def moved(at_root: Floats, beyond: Floats) -> Floats:
        return near * (length - 0.5 * near) * at_root + 0.5 * far**2 * beyond

    bent = bend * (root * (length**3 - far**3) + far**3) / 3.0
    free = (active.C + active.K**2 / active.EI) * capacitance * length
    return np.asarray(np.log(np.stack([
        bent + length * shear / active.GA, moved(bend * root, bend), turned(bend * root, bend),
        moved(curve * root_coupling, curve), turned(curve * root_coupling, curve), free,
    ], axis=1)))  # fmt: skip


# ---- the fit ----


def fit(
    observed: Sequence[Observed], announce: Callable[[str], None]
) -> tuple[Fit, dict[str, dict[str, Any]]]:
    """Fit to a part of the devices, with errors from the rest, and what these show by group."""
    training = np.random.default_rng(SEED).random(len(observed)) < FITTED
    known, fresh = (devices_of(list(compress(observed, own))) for own in (training, ~training))
    every = np.concatenate([known.groups, fresh.groups])
    listed = bool(fresh.scenes[0].bimorph.layers)
    products, clamp = (
        Products(every.min(axis=0), every.max(axis=0), weighted_powers(weights, degree))
        for degree, weights in _TERMS["listed" if listed else "three"]
    )
    count = len(products.powers) + known.theory.sizes.shape[1] * len(clamp.powers)
    found = Fit(
        products, clamp, np.zeros((count, 6)), np.zeros((count, 3)),
        np.zeros((1 + 2 * every.shape[1], len(ERRORS))),
    )  # fmt: skip
    announce("calibration: factors of the section")
    found = replace(
        found, factors=_fit_factors(known, found.terms(known.groups, known.theory.sizes))
    )
    announce("calibration: ratios of frequencies")
    found = replace(found, ratios=_fit_ratios(known, found))
    announce("calibration: errors")
    pairs = zip(fresh.observed, fresh.scenes, strict=True)
    left = np.array([left_over(*pair, Calibration(found, {})) for pair in pairs])
    rows = found.products.quadratic(fresh.groups)
    found = replace(
        found, errors=covering(rows, np.maximum(left, _LEAST), _RIDGE_OF_ERRORS, _QUANTILE)
    )
    stated, shown = np.exp(rows @ found.errors), {}
    for group, which in _groups_shown(fresh, listed=listed).items():
        devices = [one.overrides for one in compress(fresh.observed, which)]
        shown[group] = {"evidence": evidence(ERRORS, left[which], stated[which], devices)}
    return found, shown


def _groups_shown(of: Devices, *, listed: bool) -> dict[str, Bools]:
    """Devices (n,) of the groups whose errors are shown apart."""
    if listed:
        return {"layers": np.ones(len(of.observed), dtype=bool)}
    soft = np.array([core_shear(scene.device) for scene in of.scenes]) > _SOFT
    return {"stiff": ~soft, "soft": soft}


def _fit_factors(of: Devices, terms: Floats) -> Floats:
    """Coefficients (t, 6) of the logarithms of the factors."""
    measured = np.log([one.statics for one in of.observed])
    count, step = terms.shape[1], 1e-6
    layered = np.pad(of.theory.layered, ((0, 0), (0, 1)))
    counts = _COUNTS / (1.0 + np.abs(layered) / _TRUSTED)
    found = np.zeros((count, 6))
    for _ in range(_STEPS):
        factors = terms @ found
        now = statics(factors, of)
        slopes = np.stack(
            [(statics(factors + step * np.eye(6)[k], of) - now) / step for k in range(6)], axis=2
        )
        rows = np.einsum("nij,nt->nijt", slopes * counts[..., None], terms)
        rows = rows.reshape(-1, 6 * count)
        right = ((measured - now) * counts).ravel()
        found = found + solve_normal(rows, right, _RIDGE, found.T.ravel()).reshape(6, count).T
    return found


def _fit_ratios(of: Devices, known: Fit) -> Floats:
    """Coefficients (t, 3) of the logarithms of the frequencies' ratios."""
    terms = known.terms(of.groups, of.theory.sizes)
    pairs = zip(of.observed, of.scenes, strict=True)
    sought = np.array([_ratios(*pair, Calibration(known, {})) for pair in pairs])
    found = []
    for left, known_part in zip(np.log(sought).T, of.theory.ratios.T[:3], strict=True):
        counts = 1.0 / (1.0 + np.abs(known_part) / _TRUSTED_RATIO)
        found.append(solve_normal(terms * counts[:, None], counts * (left - known_part), _RIDGE))
    return np.array(found).T


def _solved(scene: Scene, known: Calibration) -> tuple[SectionFactors, list[Element]]:
    """Factors of a scene's bimorph, and its lossless row."""
    factors = section_factors(scene.device, scene.beam, known)
    row = sections(scene.device, scene.support, scene.beam, factors, lossy=False)
    return factors, row


def _ratios(one: Observed, scene: Scene, known: Calibration) -> Floats:
    """Ratios (3,) at the knots, such that the beam has the solid's frequencies.

    As well as it can both clamped and on springs, where what the clamp does to short waves is less.
    Modes that may be across the width are left out: the ratio of the one below goes on.
    """
    factors, row = _solved(scene, known)
    knots = np.append(0.0, factors.knots[:3])
    lengthwise = np.arange(3) < lengthwise_modes(scene.device)
    smooth = np.where(lengthwise, _SMOOTH, 1.0)[:, None]
    rows, right = [smooth * (np.eye(3) - np.eye(3, k=-1))], [np.zeros(3)]
    soft = load_scene("prototype", list(one.on_springs))[0].ends
    for weight, ends, solid in ((1.0, scene.ends, one.short), (_ON_SPRINGS, soft, one.sprung)):
        beam = natural_frequencies(row, ends, 3, open_circuit=False).frequencies
        shares = np.array([np.interp(solid, knots, each) for each in np.eye(4)]).T[:, 1:]
        clear = lengthwise & np.isfinite(solid)
        rows.append(weight * shares[clear])
        right.append(weight * (beam / solid - 1.0)[clear])
    found, *_ = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)
    return np.asarray(np.maximum(1.0 + found, _LEAST_RATIO))


def left_over(one: Observed, scene: Scene, known: Calibration) -> Floats:
    """Relative errors (7,) of :data:`ERRORS` for one device; nan where a mode is not compared.

    Those of frequencies are the larger of clamped and on springs.
    """
    factors, row = _solved(scene, known)
    ends = (scene.ends, scene.ends, load_scene("prototype", list(one.on_springs))[0].ends)
    short, opened, soft = (
        bending_frequencies(row, factors, end, 3, open_circuit=q)
        for end, q in zip(ends, (False, True, False), strict=True)
    )
    port = multiport(row, factors, np.zeros(1))
    at_rest = _of_ports(port.stiffness[0].real) / one.statics - 1.0
    apart = np.maximum(np.abs(short / one.short - 1.0), np.abs(soft / one.sprung - 1.0))
    apart[lengthwise_modes(scene.device) :] = np.nan
    factor, right = (
        np.sqrt(max(1.0 - (s[0] / o[0]) ** 2, 0.0))
        for s, o in ((short, opened), (one.short, one.opened))
    )
    coupling = factor / right - 1.0 if right > 0.0 else np.nan
    return np.asarray(np.abs([at_rest[0], at_rest[3], at_rest[5], *apart, coupling]))


def calibrate(
    observed: Sequence[Observed],
    unusual: Mapping[str, Sequence[Observed]],
    announce: Callable[[str], None],
) -> dict[str, Any]:
    """Calibration as it is written to a file: of piezo, shim and piezo, or of listed layers."""
    found, shown = fit(observed, announce)
    # such a device has errors of the fit alone where no property is said to widen them
    none = Widening(
        np.zeros(STEP_SIZES), np.zeros(STEP_SIZES), np.zeros((1 + STEP_SIZES, len(ERRORS)))
    )
    known = Calibration(found, dict.fromkeys(unusual, none))
    beyond = {what: _widening(known, those) for what, those in unusual.items()}
    plain = products_record(found.products) | {"clamp": found.clamp.powers.tolist()}
    plain |= {name: rounded(getattr(found, name)) for name in ("factors", "ratios", "errors")}
    return {"devices": len(observed), "seed": SEED, "fit": plain, **shown, "beyond": beyond}


def _widening(known: Calibration, of: Sequence[Observed]) -> dict[str, Any]:
    """Factors that cover the devices of a property, as written to a file, with their evidence.

    Each half of the devices is judged by factors fitted to the other half.
    """
    scenes = [load_scene("prototype", list(one.overrides))[0] for one in of]
    left = np.array([left_over(*each, known) for each in zip(of, scenes, strict=True)])
    stated = np.array([section_factors(s.device, s.beam, known).errors for s in scenes])
    left[np.isnan(stated)] = np.nan  # none is known, whatever widens it
    sizes = np.array([step_sizes(s.device, s.beam) for s in scenes])
    ratios, low, high = np.maximum(left, _LEAST) / stated, sizes.min(axis=0), sizes.max(axis=0)

    def fitted(to: Bools) -> Widening:
        found = Widening(low, high, np.zeros((1 + STEP_SIZES, len(ERRORS))))
        terms = found.terms(sizes[to])
        logarithms = covering(terms, ratios[to], _RIDGE_OF_STEPS, _QUANTILE_OF_STEPS)
        return replace(found, logarithms=logarithms)

    even = np.arange(len(of)) % 2 == 0
    for fresh in (even, ~even):
        stated[fresh] *= fitted(~fresh)(sizes[fresh])
    whole = vars(fitted(np.ones_like(even)))
    record = {name: rounded(array) for name, array in whole.items()}
    return {**record, "evidence": evidence(ERRORS, left, stated, [one.overrides for one in of])}
