"""Field result: a mesh, its states, and fields at its points.

Everything that is seen or written (page, film, still, .vtu, glTF) is made of this value.  Points
belong to one region each: where layers meet there are two at one place, so that what jumps
there (stress, field) stays sharp.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh import Mesh

Array = NDArray[np.number]

#: What a state is: a natural mode, at rest under a voltage, or vibrating at a frequency.
StateKind = Literal["mode", "static", "harmonic"]
#: Electrodes joined or left open in a mode; driven by the scene's voltage otherwise.
Circuit = Literal["short", "open", "driven"]


@dataclass(frozen=True)
class FieldKind:
    """Field: name, SI unit and component names."""

    title: str
    unit: str
    components: tuple[str, ...] = ()


_AXES = ("x", "y", "z")
#: Components of symmetric tensors in Voigt's order; shear strains are 2 S_yz and so on.
_VOIGT = ("xx", "yy", "zz", "yz", "xz", "xy")

#: Every field that some model has, by name.
FIELDS: dict[str, FieldKind] = {
    "displacement": FieldKind("displacement", "m", _AXES),
    "potential": FieldKind("electric potential", "V"),
    "strain": FieldKind("strain", "1", _VOIGT),
    "stress": FieldKind("stress", "Pa", _VOIGT),
    "electric_field": FieldKind("electric field", "V m^-1", _AXES),
    "electric_displacement": FieldKind("electric displacement", "C m^-2", _AXES),
    "flux_density": FieldKind("magnetic flux density", "T", _AXES),
    "magnetic_field": FieldKind("magnetic field strength", "A m^-1", _AXES),
}


@dataclass(frozen=True)
class State:
    """One state of the device.

    Attributes
    ----------
    bar : float
        Numerical error bar of a mode's frequency (Hz); nan where there is none.
    """

    name: str  #: Unique among the states of a result, such as "mode 1, short circuit"
    #: See :data:`StateKind` and :data:`Circuit`
    kind: StateKind
    circuit: Circuit
    frequency: float  #: Hz; 0 of a static state
    error: float
    #: By the names of :data:`FIELDS`, SI, real or complex peak amplitudes with the time factor
    #: e^{+jΩt}.  Modes are scaled to a largest displacement of :data:`MODE_SIZE`
    fields: Mapping[str, Array]
    tip: complex = 0.0  #: Mean of u_x over the tip face (m)
    charge: complex = 0.0  #: On the outer electrodes (C), layers in parallel
    motion: str = ""  #: Class of a mode, as the quantities name it
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
    voltage: float  #: Drive of driven states, peak (V)
    theory: str  #: Of the model, as its row names it
    lines: Floats | None = None  #: (m, 2, 3) Segments of flux lines (m)
    #: Regions that move as rigid bodies: of these only the displacement is known
    rigid: tuple[str, ...] = ()

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
