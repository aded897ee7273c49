"""Bars of the lateral actuator's models: random bimorphs against 80 digits and finer divisions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, Literal, TypeAlias

import mpmath as mp
import numpy as np

from tactgen.fem.piezo.bricks import assemble_bricks
from tactgen.fem.piezo.krylov import reduce_to_ports
from tactgen.fem.piezo.modal_model import Motion
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import static_multiport
from tactgen.geometry.bimorph.bricks import LEVELS, BrickMeshing, Bricks, bimorph_bricks
from tactgen.geometry.bimorph.segments import beam_pieces
from tactgen.geometry.device.checks import beyond_plain_layers
from tactgen.tmm.beam.calibrated_section import check_known
from tactgen.tmm.beam.dimensionless_groups import laminate
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.transfer_matrix import SEGMENTS, sections
from tactgen.tmm.ports.multiport import respond
from tactgen.tmm.ports.supports_and_loads import attach
from tactgen.validation.engine.solve import solve
from tactgen.validation.engine.surrogate import build_surrogate
from tactgen.validation.evidence.calibration_bimorph import UNUSUAL, UNUSUAL_LISTED
from tactgen.validation.evidence.cases import exact_beam as exact
from tactgen.validation.evidence.cases.exact_beam import Row, natural_frequency
from tactgen.validation.evidence.judgement import Judged, relative
from tactgen.validation.evidence.random_devices import (
    CERAMICS,
    accepted,
    between,
    bimorph_on_rod,
    clamped_bimorph,
    clamped_laminate,
    slender_bimorph,
    solid_bimorph,
    sprung,
    tapered_bimorph,
    unusual_bimorph,
)
from tactgen.validation.evidence.stress_beam import attached
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene

_STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
_HARMONIC = ("tip_displacement", "admittance")
_SHORT, _OPEN = "short_circuit_frequencies", "open_circuit_frequencies"
_BEAM = (*_STATIC[:2], _SHORT, _OPEN, *_HARMONIC)
_ONE_IN_THREE = 1.0 / 3.0


def judge_beam(rng: np.random.Generator) -> list[Judged]:
    """Answers of beam elements against exact spans; one in three is on its rod."""
    on_rod = rng.random() < _ONE_IN_THREE
    name, sampled = ("bimorph_on_rod", bimorph_on_rod) if on_rod else ("prototype", slender_bimorph)

    def attempt() -> tuple[Scene, str]:
        overrides = sampled(rng)
        return load_scene(name, overrides)[0], f"{name} {' '.join(overrides)}"

    scene, where = accepted(attempt)
    found, answers = solve(scene, ["beam", "tmm"], _BEAM), list[Judged]()
    for name in _BEAM:
        beam, right = found.get(name, "beam"), found.get(name, "tmm").value
        answers += relative(where, name, beam.value, beam.error, right)
    return answers


#: How many times as many segments the reference has: its own error is 1/256 of the one judged.
_FINER = 4


def judge_taper(rng: np.random.Generator) -> list[Judged]:
    """Frequencies of a tapered bimorph against those of more segments."""
    overrides = tapered_bimorph(rng)
    scene, _ = load_scene("prototype", overrides)
    found = solve(scene, ["tmm"], [_SHORT]).quantities[0]
    row = sections(scene.device, scene.support, scene.beam, lossy=False, segments=_FINER * SEGMENTS)
    right = bending_frequencies(row, scene.ends.lossless, found.value.size, open_circuit=False)
    return relative(" ".join(overrides), _SHORT, found.value, found.error, right)


def judge_tmm(rng: np.random.Generator) -> list[Judged]:
    """Answers of the transfer matrix against 80 digits; every other has bare ends.

    A uniform beam has a closed form; a row of three is joined.
    """
    layer = between(rng, 0.05, 0.5)
    length = between(rng, 15.0, 120.0) * 3.0 * layer
    overrides = slender_bimorph(rng, length=length, layer=layer)
    if rng.random() < 0.5:
        overrides += [
            f"bimorph.bare_{where}={length * between(rng, 0.01, 0.2):.4g}mm"
            for where in ("below", "above")
        ]
    scene, _ = load_scene("prototype", [*overrides, "modes=3"])
    return against_digits(scene, " ".join(overrides))


def against_digits(scene: Scene, where: str) -> list[Judged]:
    """Answers of a bimorph of one cross-section on its support, its tip free."""
    driven = ("tip_displacement", "tip_rotation", "admittance")
    quantities = solve(scene, ["tmm"], (*_STATIC, *driven, _SHORT, _OPEN)).quantities
    lossless, (at_rest, _, free, blocked) = _row(scene, lossy=False), _by_digits(scene, 0.0)
    right: dict[str, Sequence[Any]] = {
        name: [value] for name, value in zip(_STATIC, (at_rest, free, blocked), strict=True)
    }
    moved, turned, charges, _ = zip(*(_by_digits(scene, f) for f in scene.frequency), strict=True)
    with mp.workdps(exact.DIGITS):
        currents = [
            2j * mp.pi * mp.mpf(f) * charge
            for f, charge in zip(scene.frequency, charges, strict=True)
        ]
    right |= dict(zip(driven, (moved, turned, currents), strict=True))
    answers = []
    for quantity in quantities:
        values, bars = np.ravel(quantity.value), np.ravel(quantity.error)
        known = right.get(quantity.name) or [
            natural_frequency(lossless, scene.ends, float(f), open_circuit=quantity.name == _OPEN)
            for f in values
        ]
        for i, (value, bar, digits) in enumerate(zip(values, bars, known, strict=True)):
            error = exact.relative_error(value, digits)
            which = f"{i + 1}" if values.size > 1 else ""
            answers.append(Judged(where, quantity.name, error, float(bar / abs(digits)), which))
    return answers


def _by_digits(scene: Scene, frequency: float) -> tuple[Any, Any, Any, Any]:
    """Tip's displacement (m) and rotation (rad), and capacitances free and blocked (F).

    Without losses at rest.
    """
    base, _ = attached(scene.ends if frequency else scene.ends.lossless, frequency)
    with mp.workdps(exact.DIGITS):
        omega, volts = 2 * mp.pi * mp.mpf(frequency), scene.drive.voltage
        row = _row(scene, lossy=bool(frequency))
        d = reduce(exact.join, [exact.dynamic_stiffness(*piece, omega) for piece in row])
        moved, charge, turned = exact.tip_motion(d, base, 0)
        return moved * volts, turned * volts, charge, d[4, 4]


def _row(scene: Scene, *, lossy: bool) -> Row:
    """Section constants and length of the pieces, none of which is bare shim."""
    active = exact.bimorph_constants(scene.device, scene.beam, lossy=lossy)
    bare = exact.without_electrode(active)
    pieces = beam_pieces(scene.device, scene.support)
    return [(active if piece.electrode else bare, piece.length) for piece in pieces]


#: Where responses of solids are judged, per first resonance: at all but rest, about the first
#: resonance, and beyond it.
AT = (0.05, 0.9, 1.1, 2.0, 4.0)
#: References are solved so many levels above the one judged; that of tetrahedra.
_ABOVE, _FOR_TETRAHEDRA = 2, LEVELS[3]
#: Error that the reduction of a reference may add: far less than bricks have.
_REDUCTION = 1e-7
#: Largest quarter (functions of its reference) that is affordable.
_MOST_FUNCTIONS = {"solid": 9_000, "cad": 6_500}

#: Numbers by quantity and class of motion, ascending.
Known: TypeAlias = dict[tuple[str, str], list[complex]]


@dataclass(frozen=True)
class Case:
    """Bimorph and its compared quantities."""

    overrides: tuple[str, ...]  #: Of the scene ``prototype``
    level: int = 2  #: Level (2 or 3) of bricks
    #: On bricks, or on tetrahedra for the accuracy that the scene asks for by default
    model: Literal["solid", "cad"] = "solid"
    #: Judge the frequencies of all classes of motion; else those that bend in x
    all_motions: bool = False
    #: Frequencies at which the response is judged as well, per first resonance
    at: tuple[float, ...] = ()

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities compared."""
        return (*_STATIC, _SHORT, "coupling_factor", *(_HARMONIC if self.at else ()))

    def scene(self) -> Scene:
        """Scene to be solved."""
        more = [f"mesh.level={self.level}"] if self.model == "solid" else []
        if self.at:
            scene, _ = load_scene("prototype", list(self.overrides))
            first = solve(scene, ["tmm"], [_SHORT]).quantities[0].value[0]
            more.append("frequency=" + ",".join(f"{part * first:.6g} Hz" for part in self.at))
        return load_scene("prototype", [*self.overrides, *more])[0]

    @property
    def reference(self) -> BrickMeshing:
        """The division that its reference is solved on."""
        return _FOR_TETRAHEDRA if self.model == "cad" else LEVELS[self.level - 1 + _ABOVE]

    @property
    def affordable(self) -> bool:
        """Whether its reference is."""
        bricks = bimorph_bricks(self.scene().device, self.reference)
        return int((bricks.used() & bricks.products()).sum()) <= _MOST_FUNCTIONS[self.model]


def affordable_case(rng: np.random.Generator, model: Literal["solid", "cad"] = "solid") -> Case:
    """Random bimorph whose reference is affordable; for the model cad of those that CAD knows.

    One in three bricks are of listed layers, patches or each with a width of its own.
    """
    while True:
        listed = model == "solid" and rng.random() < _ONE_IN_THREE
        overrides = (
            unusual_bimorph(rng, clamped_laminate(rng), str(rng.choice(("patch", "own widths"))))
            if listed
            else solid_bimorph(rng)
        )
        if overrides is None:
            continue
        case = Case(tuple(overrides), model=model, all_motions=model == "cad")
        plain = model == "solid" or not beyond_plain_layers(case.scene().device.bimorph)
        if plain and case.affordable:
            return case


def judge_solid(rng: np.random.Generator) -> list[Judged]:
    """Answers of one device by bricks, of a third all motions or responses."""
    case = affordable_case(np.random.default_rng(int(rng.integers(2**31))))
    every, responds = rng.random(2) < _ONE_IN_THREE
    return judged(replace(case, all_motions=bool(every), at=AT if responds else ()))


def _with_mass(rng: np.random.Generator, overrides: Sequence[str]) -> list[str]:
    """The same bimorph with a tip mass of 0.1 to 3 of its own, and no other load."""
    scene, _ = load_scene("prototype", list(overrides))
    mass = laminate(scene.device).m * scene.bimorph.length * between(rng, 0.1, 3.0)
    kept = (one for one in overrides if not one.startswith("load."))
    return [*kept, "load.kind=mass", f"load.mass={1e6 * mass:.5g}mg"]


def judge_calibrated(rng: np.random.Generator) -> list[Judged]:
    """Modelling errors of the transfer matrix for a fresh device of those that it is calibrated on.

    A third clamped and free, a third on springs, a third with a tip mass.  Whichever it is, one in
    three is of listed layers.
    """
    fresh = _fresh_stream(rng)
    listed = rng.random() < _ONE_IN_THREE
    overrides = clamped_laminate(fresh) if listed else clamped_bimorph(fresh)
    scene, _ = load_scene("prototype", overrides)
    kind = fresh.random()
    if kind < _ONE_IN_THREE:
        overrides = sprung(fresh, overrides, laminate(scene.device).EI / scene.bimorph.length)
    elif kind < 2.0 * _ONE_IN_THREE:
        overrides = _with_mass(fresh, overrides)
    return _against_solid(overrides)


def judge_pieces(rng: np.random.Generator) -> list[Judged]:
    """The same of a device with a property that widens these errors, such as a tab.

    Half of them are of listed layers.
    """
    fresh, listed = _fresh_stream(rng), rng.random() < 0.5

    def drawn() -> list[str]:
        plain = (clamped_laminate if listed else clamped_bimorph)(fresh)
        what = str(fresh.choice(UNUSUAL_LISTED if listed else UNUSUAL))
        found = unusual_bimorph(fresh, plain, what)
        scene, _ = load_scene("prototype", found)
        check_known(scene.device, scene.support)
        return found

    return _against_solid(accepted(drawn))


def _fresh_stream(rng: np.random.Generator) -> np.random.Generator:
    """Stream that no calibration has drawn its devices from."""
    return np.random.default_rng(int(rng.integers(2**62)))


def _against_solid(overrides: Sequence[str]) -> list[Judged]:
    """Modelling errors of the transfer matrix, as far as they are known."""
    scene, _ = load_scene("prototype", [*overrides, "mesh.level=2"])
    asked = (*_STATIC, _SHORT, "coupling_factor")
    found = solve(scene, ["tmm", "solid"], asked)
    answers = []
    for name in asked:
        beam, solid = found.get(name, "tmm"), found.get(name, "solid")
        right = np.atleast_1d(solid.value)
        if solid.classes is not None:
            right = right[np.array(solid.classes) == "bending_x"]
        count = min(right.size, np.size(beam.value))
        value, error = (np.atleast_1d(a)[:count] for a in (beam.value, beam.modelling_error))
        of_all = relative(" ".join(overrides), name, value, error, right[:count])
        answers += [one for one in of_all if np.isfinite(one.bar)]
    return answers


#: Peaks of a harvester; resistance per impedance of its capacitance; losses of its elastic layers.
_OF_HARVESTER = ("tip_displacement", "electrode_voltage", "circuit_power")
_RESISTANCE, _LOSSES = (0.03, 30.0), (0.0, 0.002, 0.01, 0.03)


def judge_harvester(rng: np.random.Generator) -> list[Judged]:
    """Modelling errors of what a harvester of patches or with a bare end gives at resonance.

    As far as they are known.
    """
    fresh = _fresh_stream(rng)
    what = str(fresh.choice(["patch", "tip extension"]))
    plain = (clamped_laminate if what == "patch" else clamped_bimorph)(fresh)
    overrides = [*unusual_bimorph(fresh, plain, what), f"shim.loss_factor={fresh.choice(_LOSSES)}"]
    overrides = _with_mass(fresh, overrides)
    scene, _ = load_scene("prototype", overrides)
    modes, capacitance = solve(scene, ["tmm"], [_SHORT, "capacitance_free"]).quantities
    first = float(modes.value[0])
    impedance = 1.0 / (2.0 * np.pi * first * float(capacitance.value))
    scene, _ = load_scene("prototype", [
        *overrides, "drive.voltage=0V", "drive.base_acceleration=0.05g", "circuit.kind=load",
        f"circuit.resistance={impedance * between(fresh, *_RESISTANCE):.5g}ohm",
        f"frequency={0.7 * first:.6g}:{1.4 * first:.6g}:21", "mesh.level=2",
    ])  # fmt: skip
    found = solve(scene, ["tmm", "solid"], _OF_HARVESTER)
    answers = []
    for name in _OF_HARVESTER:
        beam, peak = found.get(name, "tmm"), found.get(name, "solid").extreme
        assert beam.extreme is not None
        assert peak is not None
        bar = float(beam.alone_at_extreme.modelling_error)
        if np.isfinite(bar):
            answers += relative(" ".join(overrides), name, beam.extreme.value, bar, peak.value)
    return answers


def judge_cad(rng: np.random.Generator) -> list[Judged]:
    """Answers of one device by tetrahedra of its CAD solids."""
    return judged(affordable_case(np.random.default_rng(int(rng.integers(2**31))), "cad"))


def judged(case: Case) -> list[Judged]:
    """Every answer of a case with its error; modes by their order in their class."""
    quantities = solve(case.scene(), [case.model], case.quantities).quantities
    kinds = {kind for q in quantities for kind in q.classes or ()} if case.all_motions else set()
    known, where, answers = reference(case, kinds), " ".join(case.overrides), []
    for q in quantities:
        values, errors = np.ravel(q.value), np.ravel(q.error)
        classes = q.classes or ("",) * values.size
        for i, (value, error, kind) in enumerate(zip(values, errors, classes, strict=True)):
            if kind not in ("", "bending_x") and not case.all_motions:
                continue
            number = classes[:i].count(kind)
            right = known[q.name, kind][number]
            which = f"{kind} {number + 1}".lstrip() if values.size > 1 or kind else ""
            off, size = abs(value - right), abs(right)
            answers.append(Judged(where, q.name, float(off / size), float(error / size), which))
    return answers


def reference(case: Case, kinds: Iterable[str]) -> Known:
    """Quantities on the reference division; frequencies of the motions in `kinds`."""
    scene = case.scene()
    bricks = bimorph_bricks(scene.device, case.reference)
    system = assemble_bricks(scene.device, bricks, lossy=False)
    port = static_multiport(system)
    response = respond(attach(port, scene.ends.lossless), {"voltage": scene.drive.voltage})
    modes = natural_modes(system, scene.ends, scene.modes)
    opened = natural_modes(system, scene.ends, 1, open_circuit=True)[0]
    known: Known = {
        ("static_tip_displacement", ""): [complex(response.motion["w_tip"][0])],
        ("capacitance_free", ""): [complex(response.effort["voltage"][0]) / scene.drive.voltage],
        ("capacitance_blocked", ""): [complex(port["voltage", "voltage"][0])],
        ("coupling_factor", ""): [
            complex(np.sqrt(1.0 - (modes[0].frequency / opened.frequency) ** 2))
        ],
    }
    others: tuple[Motion, ...] = ("bending_y", "torsion", "axial")
    for motion in others:
        if motion in kinds or "mixed" in kinds:
            system = assemble_bricks(scene.device, bricks, lossy=False, motion=motion)
            modes += natural_modes(system, scene.ends, scene.modes)
    for mode in sorted(modes, key=lambda mode: mode.frequency):
        known.setdefault((_SHORT, mode.kind), []).append(mode.frequency)
    return known | (_responses(scene, bricks) if case.at else {})


def _responses(scene: Scene, bricks: Bricks) -> Known:
    frequencies = np.asarray(scene.frequency, dtype=float)
    system = assemble_bricks(scene.device, bricks, lossy=True)
    port = reduce_to_ports(system, frequencies, tolerance=_REDUCTION).multiport(frequencies)
    response = respond(attach(port, scene.ends), {"voltage": scene.drive.voltage})
    current = 2j * np.pi * frequencies * response.effort["voltage"] / scene.drive.voltage
    return {
        ("tip_displacement", ""): [complex(value) for value in response.motion["w_tip"]],
        ("admittance", ""): [complex(value) for value in current],
    }


#: Where the response of a surrogate is judged, per first resonance; how far its lengths reach.
_AT_SURROGATE, _REACH = 0.9, 1.2


def judge_surrogate(rng: np.random.Generator) -> list[Judged]:
    """Answers at one length by the surrogate of one bimorph."""
    names = (*_STATIC, _SHORT, "coupling_factor", *_HARMONIC)
    layer = between(rng, 0.1, 0.4)
    length = between(rng, 15.0, 40.0) * 3.0 * layer
    sampled = (
        f"bimorph.width={layer * between(rng, 2.0, 10.0):.4g}mm",
        f"bimorph.piezo_thickness={layer:.4g}mm",
        f"bimorph.shim_thickness={layer * between(rng, 0.3, 2.0):.4g}mm",
        f"piezo.material={rng.choice(CERAMICS)}",
        "support.kind=clamped", "accuracy=0.1", "modes=1",
    )  # fmt: skip
    ends = 1e-3 * length / _REACH, 1e-3 * length * _REACH
    member = between(rng, *ends)
    case = Case((*sampled, f"bimorph.length={1e3 * member:.12g}mm"), at=(_AT_SURROGATE,))
    scene, _ = load_scene("prototype", [*sampled, f"frequency={case.scene().frequency[0]:.12g} Hz"])
    surrogate = build_surrogate(scene, "solid", names, {"bimorph.length": ends})
    (estimates,) = surrogate.answers({"bimorph.length": np.array([member])})
    found = {q.name: q for q in estimates}
    kinds = dict.fromkeys(names, "") | {_SHORT: (found[_SHORT].classes or ("",))[0]}
    right, where = reference(case, kinds.values()), " ".join(case.overrides)
    answers: list[Judged] = []
    for name, kind in kinds.items():
        value, bar = (np.ravel(of)[:1] for of in (found[name].value, found[name].error))
        answers += relative(where, name, value, bar, right[name, kind][0])
    return answers
