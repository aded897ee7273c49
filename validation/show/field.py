"""Field result: a mesh, its states, and fields at its points.

Everything that is seen or written (page, film, still, .vtu, glTF) is made of this value.  Points
belong to one region each: where layers meet there are two at one place, so that what jumps
there (stress, field) stays sharp.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import engineering, with_error
from tactgen.geometry.meshing.mesh import Mesh

Array = NDArray[np.number]
#: What a state is: a natural mode, at rest under a voltage, or vibrating at a frequency.
StateKind = Literal["mode", "static", "harmonic"]
#: Electrodes joined or left open in a mode; driven by the scene's voltage otherwise.
Circuit = Literal["short", "open", "driven"]


@dataclass(frozen=True)
class FieldKind:
    """Field: name and SI unit."""

    title: str
    unit: str


#: Every field that some model has, by name.  Symmetric tensors are in Voigt's order xx, yy, zz, yz,
#: xz, xy; shear strains are 2 S_yz and so on.
FIELDS: dict[str, FieldKind] = {
    "displacement": FieldKind("displacement", "m"),
    "potential": FieldKind("electric potential", "V"),
    "strain": FieldKind("strain", "1"),
    "stress": FieldKind("stress", "Pa"),
    "electric_field": FieldKind("electric field", "V m^-1"),
    "electric_displacement": FieldKind("electric displacement", "C m^-2"),
    "flux_density": FieldKind("magnetic flux density", "T"),
    "magnetic_field": FieldKind("magnetic field strength", "A m^-1"),
}


@dataclass(frozen=True)
class State:
    """One state of the device."""

    name: str  #: Unique among the states of a result, such as "mode 1, short circuit"
    #: See :data:`StateKind` and :data:`Circuit`
    kind: StateKind
    circuit: Circuit
    frequency: float  #: Hz; 0 of a static state
    error: float  #: Numerical error bar of a mode's frequency (Hz); nan where there is none
    #: By the names of :data:`FIELDS`, SI, real or complex peak amplitudes with the time factor
    #: e^{+jΩt}.  Modes are scaled to a largest displacement of :data:`MODE_SIZE`
    fields: Mapping[str, Array]
    tip: complex = 0.0  #: Mean of u_x over the tip face, or the section where it is measured (m)
    charge: complex = 0.0  #: On the outer electrodes (C), layers in parallel
    motion: str = ""  #: Class of a mode, as the quantities name it
    #: Modelling error in words, of a mode's frequency or the tip's motion; empty if there is none
    modelling: str = ""
    #: Coupling factor √(1 − (f_short / f_open)²) of a mode that bends in x; nan of others
    coupling: float = float("nan")
    #: (float, float) Of a magnetic state the force that closes the gap, and its error bar (N)
    pull: tuple[float, float] | None = None


#: Largest displacement of a mode (m), whose own size means nothing.
MODE_SIZE = 1e-6


@dataclass(frozen=True)
class FieldResult:
    """Field result of one model."""

    #: Names
    scene: str
    model: str
    mesh: Mesh  #: Points (n, 3) in m, each of one region
    states: tuple[State, ...]  #: With fields at the points
    #: What drives the driven states, and what acts on the static one, in words
    drive: str
    drive_at_rest: str
    theory: str  #: Of the model, as its row names it
    lines: Floats | None = None  #: (m, 2, 3) Segments of flux lines (m)
    #: Regions that move as rigid bodies: of these only the displacement is known
    rigid: tuple[str, ...] = ()
    conditions: str = ""  #: How the device is held, loaded, wired and driven
    place: str = "tip"  #: Where the motion of the tip is read

    @property
    def has(self) -> tuple[str, ...]:
        """Names of the fields that every state has."""
        return tuple(name for name in FIELDS if all(name in state.fields for state in self.states))

    def state(self, name: str) -> State:
        """State by name.

        Raises InputError with the names that there are.
        """
        for state in self.states:
            if state.name == name:
                return state
        known = ", ".join(f'"{state.name}"' for state in self.states)
        raise InputError(f'state "{name}" is unknown to the model {self.model}; it has {known}')


def von_mises(stress: Array) -> Floats:
    """Von Mises stress (n,) of real stresses (n, 6) in Voigt's order, same unit."""
    xx, yy, zz, yz, xz, xy = np.asarray(stress).T
    normal = 0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2)
    return np.asarray(np.sqrt(normal + 3.0 * (yz**2 + xz**2 + xy**2)))


def at_phase(amplitude: Array, phase: float) -> Floats:
    """Real part of amplitudes times e^{j phase}, phase in radians."""
    return np.asarray(np.real(amplitude * np.exp(1j * phase)), dtype=float)


#: A tip whose middle moves by less than this part of the largest displacement is twisted.
_TWISTS = 0.3
#: Classes of modes in words.
MOTIONS = {
    "bending_x": "bending in x", "bending_y": "bending in y", "torsion": "torsion",
    "axial": "axial", "mixed": "mixed",
}  # fmt: skip
#: Models in words.
MODELS = {
    "solid": "solid (bricks)", "cad": "solid (tetrahedra)", "tmm": "transfer matrix",
    "beam": "beam elements", "lumped": "lumped", "axisymmetric": "axisymmetric field",
}  # fmt: skip
#: Regions in words.
REGIONS = {
    "piezo_top": "ceramic, x > 0", "piezo_bottom": "ceramic, x < 0", "shim": "shim",
    "glue": "glue", "rod": "rod", "coil": "coil", "sleeve": "sleeve",
}  # fmt: skip


def region_title(region: str) -> str:
    """Region in words; layers that are numbered by what they are."""
    kind, _, number = region.partition("_")
    if region in REGIONS or not number.isdigit():
        return REGIONS.get(region, region)
    return f"layer {number}: {'ceramic' if kind == 'piezo' else kind}"


def drawn_size(points: Floats, displacement: Array) -> float:
    """Drawn size (m) of the largest displacement (n, 3) at points (n, 3).

    Linear displacements of a twist are a stretch if drawn large, so a tip that turns about its
    own middle is turned by half a radian at most.
    """
    moved = np.abs(displacement)
    z = points[:, 2]
    tip = z > z.max() - 0.02 * np.ptp(z)
    middle = float(np.linalg.norm(np.abs(displacement[tip].mean(axis=0))))
    far = 0.12 * float(np.ptp(z))
    if middle > _TWISTS * float(np.linalg.norm(moved, axis=1).max()):
        return far
    across = points[tip, :2] - points[tip, :2].mean(axis=0)
    return min(far, 0.5 * float(np.linalg.norm(across, axis=1).max()))


def enlargement(result: FieldResult, state: State) -> float:
    """By how much displacements are drawn enlarged; 0 where nothing moves."""
    values = state.fields.get("displacement")
    if values is None:
        return 0.0
    values = np.asarray(values)
    largest = float(np.linalg.norm(np.abs(values), axis=1).max())
    return drawn_size(result.mesh.points, values) / largest if largest > 0.0 else 0.0


@dataclass(frozen=True)
class Words:
    """Caption of a state: short name, number, more, title, size."""

    short: str
    number: str
    detail: str
    title: str
    note: str


def words_of(result: FieldResult, state: State) -> Words:
    """Caption of a state; every number is the quantity's."""
    name = state.name[:1].upper() + state.name[1:]
    modelling = f" · modelling error {state.modelling}" if state.modelling else ""
    if state.kind == "mode":
        coupling = "" if math.isnan(state.coupling) else f" · k = {state.coupling:.3g}"
        short = state.name.split(",")[0]
        number = with_error(state.frequency, state.error, "Hz")
        detail = MOTIONS[state.motion] + coupling + modelling
        return Words(short, number, detail, name, "at a largest displacement of 1 µm")
    if "displacement" not in state.fields:
        pull = "" if state.pull is None else f"pull {with_error(*state.pull, 'N')}"
        return Words("field", pull, state.name, name, "")
    tip = f"{result.place} {engineering(abs(state.tip), 'm', 4)}"
    if state.kind == "static":
        still = result.drive_at_rest
        return Words("static", tip, still + modelling, "Static", still)
    degrees = math.degrees(math.atan2(state.tip.imag, state.tip.real))
    number = f"{tip}, {degrees:.0f}°".replace("-", "−")
    return Words(
        state.name, number, result.drive + modelling, f"Driven at {state.name}", result.drive
    )
