"""Do the bars of the models solid and cad hold?  Varied bimorphs against much finer bricks.

A list of cases, each a set of overrides of one scene, and what is found on each: value,
error bar and reference of every quantity.  The error bar is what a user is shown.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from tactgen.fem.piezo.bricks import assemble_bricks
from tactgen.fem.piezo.krylov import reduce_to_ports
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import ports_from_blocks
from tactgen.fem.piezo.symmetry import Motion
from tactgen.fem.piezo.system import SolidSystem
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bimorph_bricks import LEVELS, BrickMeshing, bimorph_bricks
from tactgen.geometry.bimorph.bricks import Bricks, Held
from tactgen.geometry.device.checks import beyond_plain_layers
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import Multiport, respond
from tactgen.tmm.ports.port import BIMORPH
from tactgen.validation.engine.model import Model, make_model
from tactgen.validation.engine.plan import make_plan
from tactgen.validation.engine.solve import evaluate, solve
from tactgen.validation.engine.stages import Stages
from tactgen.validation.evidence.coverage import Judged
from tactgen.validation.evidence.random_devices import between
from tactgen.validation.models.bimorph.family.solid_family import solid_family
from tactgen.validation.models.bimorph.family.values import family_values
from tactgen.validation.models.bimorph.solid import BrickPair, SolidModel
from tactgen.validation.scene.scene import Scene, load_scene

_STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
_MODES = ("short_circuit_frequencies", "coupling_factor")
_HARMONIC = ("tip_displacement", "admittance")

#: Where responses are judged, per first resonance: at all but rest, about the first resonance, and
#: beyond it.
_AT = (0.05, 0.9, 1.1, 2.0, 4.0)
#: References are solved so many levels above the one judged.
_ABOVE = 2
#: Error that the reduction of a reference may add: far less than bricks have.
_REDUCTION = 1e-7
#: Bricks that tetrahedra are judged by.
_FOR_TETRAHEDRA = LEVELS[3]
#: Largest quarter (functions of its reference) that is affordable: of bricks, and of those that
#: judge tetrahedra.
_MOST_FUNCTIONS, _MOST_FUNCTIONS_FOR_CAD = 9_000, 6_500
#: Share of the devices of which all classes of motion are judged, and of those whose response is.
_ONE_IN_THREE = 1.0 / 3.0


#: Numbers by quantity and class of motion, ascending.
Known: TypeAlias = dict[tuple[str, str], list[complex]]


@dataclass(frozen=True)
class Case:
    """One bimorph, the level it is judged at, and what is judged.

    Attributes
    ----------
    overrides : tuple of str
        Of the scene ``prototype``.
    level : int
        Level of the family (2 or 3), of bricks.
    held : {"layers", "shim"}
        What the base is.
    model : {"solid", "cad"}
        On bricks, or on tetrahedra for the accuracy that the scene asks for by default.
    all_motions : bool
        Judge the frequencies of all classes of motion; else those that bend in x.
    at : tuple of float
        Frequencies at which the response is judged as well, per first resonance.
    """

    overrides: tuple[str, ...]
    level: int = 2
    held: Held = "layers"
    model: Literal["solid", "cad"] = "solid"
    all_motions: bool = False
    at: tuple[float, ...] = ()

    @property
    def quantities(self) -> tuple[str, ...]:
        """What is judged."""
        return (*_STATIC, *_MODES, *(_HARMONIC if self.at else ()))

    def scene(self) -> Scene:
        """Return what is solved."""
        more = [f"mesh.level={self.level}"] if self.model == "solid" else []
        if self.at:
            scene, _ = load_scene("prototype", list(self.overrides))
            first = solve(scene, ["tmm"], ["short_circuit_frequencies"]).quantities[0].value[0]
            more.append("frequency=" + ",".join(f"{part * first:.6g} Hz" for part in self.at))
        return load_scene("prototype", [*self.overrides, *more])[0]

    @property
    def reference(self) -> BrickMeshing:
        """The division that its reference is solved on."""
        return _FOR_TETRAHEDRA if self.model == "cad" else LEVELS[self.level - 1 + _ABOVE]


@dataclass(frozen=True)
class Answer:
    """One number with its error bar; of a mode with its class and which of its class it is."""

    quantity: str
    value: complex
    error: float
    kind: str = ""
    number: int = 0


class _ShimHeldModel(SolidModel):
    """The solid model on a base that is the shim alone."""

    def make_pair(self) -> BrickPair:
        """Return bricks of the scene's level and of the next coarser one, so held."""
        level, device = self.scene.mesh.level, self.scene.device
        fine, coarse = (bimorph_bricks(device, LEVELS[i], "shim") for i in (level - 1, level - 2))
        return BrickPair(device, (fine, coarse))


def answers(case: Case) -> list[Answer]:
    """Return what the solid model says, as a user would be told."""
    scene = case.scene()
    keys = make_plan(scene, (case.model,), case.quantities).keys
    if case.held == "shim":  # of which a scene's keys know nothing
        keys = {name: f"{key}, held by the shim" for name, key in keys.items()}
        model: Model = _ShimHeldModel(scene, Stages(keys))
    else:
        model = make_model(case.model, scene, Stages(keys))
    found = []
    for name in case.quantities:
        quantity = evaluate(name, model)
        values, bars = np.ravel(quantity.value), np.ravel(quantity.error)
        kinds = quantity.classes or ("",) * values.size
        found += [
            Answer(name, complex(v), float(b), k, kinds[:i].count(k))
            for i, (v, b, k) in enumerate(zip(values, bars, kinds, strict=True))
            if case.all_motions or k in ("", "bending_x")
        ]
    return found


def reference(case: Case, kinds: Iterable[str]) -> Known:
    """Return the quantities on the reference division; frequencies of the motions in `kinds`."""
    scene = case.scene()
    bricks = bimorph_bricks(scene.device, case.reference, case.held)
    system = assemble_bricks(scene.device, bricks, lossy=False)
    port = _at_rest(system)
    response = respond(attach(port, scene.ends.lossless), {"voltage": scene.drive.voltage})
    found: Known = {
        ("static_tip_displacement", ""): [complex(response.motion["w_tip"][0])],
        ("capacitance_free", ""): [complex(response.effort["voltage"][0]) / scene.drive.voltage],
        ("capacitance_blocked", ""): [complex(port["voltage", "voltage"][0])],
    }
    modes = natural_modes(system, scene.ends, scene.modes)
    opened = natural_modes(system, scene.ends, 1, open_circuit=True)[0]
    coupling = np.sqrt(1.0 - (modes[0].frequency / opened.frequency) ** 2)
    found["coupling_factor", ""] = [complex(coupling)]
    others: tuple[Motion, ...] = ("bending_y", "torsion", "axial")
    for motion in others:
        if motion in kinds or "mixed" in kinds:
            system = assemble_bricks(scene.device, bricks, lossy=False, motion=motion)
            modes += natural_modes(system, scene.ends, scene.modes)
    for mode in sorted(modes, key=lambda mode: mode.frequency):
        found.setdefault(("short_circuit_frequencies", mode.kind), []).append(mode.frequency)
    if case.at:
        found |= _harmonic(scene, bricks)
    return found


def _harmonic(scene: Scene, bricks: Bricks) -> Known:
    frequencies = np.asarray(scene.frequency, dtype=float)
    system = assemble_bricks(scene.device, bricks, lossy=True)
    port = reduce_to_ports(system, frequencies, tolerance=_REDUCTION).multiport(frequencies)
    response = respond(attach(port, scene.ends), {"voltage": scene.drive.voltage})
    current = 2j * np.pi * frequencies * response.effort["voltage"] / scene.drive.voltage
    return {
        ("tip_displacement", ""): [complex(value) for value in response.motion["w_tip"]],
        ("admittance", ""): [complex(value) for value in current],
    }


def _at_rest(system: SolidSystem) -> Multiport:
    """Return D(0) to some seven digits, with no residual in long double."""
    n, stiffness = system.inner, system.stiffness
    x: Floats = np.zeros((n + 3, 5))
    x[n:, :3] = np.eye(3)
    x[:n] = system.held_factor.solve(np.hstack([-stiffness.border, system.tip[:n]]))
    force, seen = stiffness @ x, system.tip.T @ x
    blocks = (force[n:, :3], force[n:, 3:], seen[:, :3], seen[:, 3:])
    stacked = (np.array([part], dtype=complex) for part in blocks)
    return Multiport(np.zeros(1), ports_from_blocks(*stacked), BIMORPH)


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one device, drawn by `rng`, of a third all motions or responses."""
    (case,) = varied_cases(int(rng.integers(2**31)), 1, finer=0)
    every, responds = rng.random(2) < _ONE_IN_THREE
    return judged(replace(case, all_motions=bool(every), at=_AT if responds else ()))


def judged(case: Case) -> list[Judged]:
    """Return every answer of a case with its error; modes by their order in their class."""
    found = answers(case)
    known = reference(case, {answer.kind for answer in found})
    outcomes = []
    for answer in found:
        right = known[answer.quantity, answer.kind][answer.number]
        error = abs(answer.value - right) / abs(right)
        several = answer.kind or answer.quantity in _HARMONIC
        which = f" {answer.kind} {answer.number + 1}".replace("  ", " ") if several else ""
        where = " ".join((*case.overrides, case.held))
        outcomes.append(Judged(where, answer.quantity + which, error, answer.error / abs(right)))
    return outcomes


def varied_cases(seed: int, count: int = 44, finer: int = 6) -> list[Case]:
    """Return bimorphs drawn at random from all that could be built, and more.

    Lengths 3 to 60 mm, widths 0.3 to 10 mm, layers 20 µm to 1 mm, even on a logarithmic
    scale; three ceramics, two shims; tabs, bare ends, glue; masses and springs at the tip;
    springs and clamps at the base, of all layers or of the shim alone.  The first `finer` that
    are small enough come at level 3 as well.
    """
    rng = np.random.default_rng(seed)
    cases: list[Case] = []
    while len(cases) < count:
        case = _drawn(rng, len(cases))
        if case is None or _functions(case) > _MOST_FUNCTIONS:
            continue
        cases.append(case)
        again = replace(case, level=3, all_motions=False, at=())
        if finer and _functions(again) < _MOST_FUNCTIONS:
            finer -= 1
            cases.append(again)
    return cases[:count]


def cad_cases(seed: int, count: int = 20) -> list[Case]:
    """Return bimorphs drawn alike of those that CAD knows, for the model cad."""
    rng = np.random.default_rng(seed)
    cases: list[Case] = []
    while len(cases) < count:
        case = _drawn(rng, len(cases))
        if case is None or case.held == "shim":
            continue
        if beyond_plain_layers(case.scene().device.bimorph):
            continue
        case = replace(case, model="cad", all_motions=True)
        if _functions(case) < _MOST_FUNCTIONS_FOR_CAD:
            cases.append(case)
    return cases


def _functions(case: Case) -> int:
    bricks = bimorph_bricks(case.scene().device, case.reference, case.held)
    return int((bricks.used() & bricks.products()).sum())


def _drawn(rng: np.random.Generator, number: int) -> Case | None:
    """Return a random case, None if it is too stout, too slender or too wide to be one."""

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    piezo, shim, length, width = (
        between(*limits) for limits in ((0.02, 1.0), (0.02, 1.0), (3.0, 60.0), (0.3, 10.0))
    )
    chance = rng.random(7)
    tab, below, above = rng.uniform(0.5, 3.0), rng.uniform(0.05, 0.15), rng.uniform(0.02, 0.1)
    glue = min(between(0.005, 0.05), 0.3 * min(piezo, shim))
    mass, stiffness = between(0.1, 100.0), between(10.0, 1e4)
    material = rng.choice(["M1876", "PZT-5H", "PZT-5A"])
    thickness = 2.0 * piezo + shim
    if not 4.0 * thickness <= length <= 120.0 * thickness or width > 40.0 * thickness:
        return None
    held: Held = "shim" if 0.3 <= chance[0] < 0.5 else "layers"
    overrides = [
        f"bimorph.length={length:.4g}mm",
        f"bimorph.width={width:.4g}mm",
        f"bimorph.piezo_thickness={piezo:.4g}mm",
        f"bimorph.shim_thickness={shim:.4g}mm",
        f"piezo.material={material}",
    ]
    options = {
        f"bimorph.tab_length={tab:.3g}mm": chance[0] < 0.3,
        f"bimorph.bare_below={below * length:.3g}mm": chance[1] < 0.2,
        f"bimorph.bare_above={above * length:.3g}mm": chance[2] < 0.2,
        f"bimorph.glue_thickness={glue:.3g}mm": chance[3] < 0.25,
        # the springs were fitted to a bimorph of 2.1 mm
        "support.kind=clamped": chance[4] < 0.5 or width > 2.0,
        "shim.shear_modulus=53.846GPa": chance[5] < 0.4,
        "load.kind=mass": chance[6] < 0.2,
        f"load.mass={mass:.3g}mg": chance[6] < 0.2,
        "load.kind=spring_damper": 0.2 <= chance[6] < 0.4,
        f"load.stiffness={stiffness:.3g}N/m": 0.2 <= chance[6] < 0.4,
    }
    overrides += [key for key, wanted in options.items() if wanted]
    at = _AT if number % 4 == 3 else ()
    return Case(tuple(overrides), held=held, all_motions=number % 3 == 0, at=at)


_NAMES = (
    "static_tip_displacement", "capacitance_free", "capacitance_blocked",
    "short_circuit_frequencies", "coupling_factor", "tip_displacement", "admittance",
)  # fmt: skip
#: Where the response is judged, per first resonance.
_AT_REDUCED = 0.9
#: Of which there is one, of whichever class of motion is the lowest.
_MODE = "short_circuit_frequencies"
#: How far a family's lengths reach to either side.
_REACH = 1.2


def judge_reduced(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one member of one family, drawn by `rng`."""
    layer = between(rng, 0.1, 0.4)
    length = between(rng, 15.0, 40.0) * 3.0 * layer
    drawn = (
        f"bimorph.width={layer * between(rng, 2.0, 10.0):.4g}mm",
        f"bimorph.piezo_thickness={layer:.4g}mm",
        f"bimorph.shim_thickness={layer * between(rng, 0.3, 2.0):.4g}mm",
        f"piezo.material={rng.choice(['M1876', 'PZT-5H', 'PZT-5A'])}",
        "support.kind=clamped", "accuracy=0.1", "modes=1",
    )  # fmt: skip
    ends = 1e-3 * length / _REACH, 1e-3 * length * _REACH
    member = between(rng, *ends)
    case = Case((*drawn, f"bimorph.length={1e3 * member:.12g}mm"), at=(_AT_REDUCED,))
    frequency = case.scene().frequency[0]
    scene, _ = load_scene("prototype", [*drawn, f"frequency={frequency:.12g} Hz"])
    basis = solid_family(scene, {"bimorph.length": ends}, _NAMES)
    found = family_values(scene, basis, {"bimorph.length": np.array([member])}, _NAMES)
    kinds = dict.fromkeys(_NAMES, "") | {_MODE: str(found[_MODE].classes[0, 0])}
    right, where = reference(case, kinds.values()), " ".join(case.overrides)
    judged = []
    for name, kind in kinds.items():
        known = right[name, kind][0]
        value, bar = (np.ravel(of)[0] for of in (found[name].value, found[name].error))
        judged.append(Judged(where, name, abs(value / known - 1.0), float(bar) / abs(known)))
    return judged


def judge_cad(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one device, drawn by `rng`."""
    (case,) = cad_cases(int(rng.integers(2**31)), 1)
    return judged(case)
