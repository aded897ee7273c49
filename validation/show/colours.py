"""What colours a picture: fields, their scales and their colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.show.field import Array, FieldResult, State, at_phase, von_mises

#: Phases at which the largest von Mises stress of a period is looked for.
_PHASES = 24


@dataclass(frozen=True)
class Shade:
    """A quantity that colours a picture."""

    #: Name, words, SI unit
    key: str
    title: str
    unit: str
    field: str  #: The field that it is read off
    #: Of a vector or tensor in Voigt's order; −1 takes the size, of stress von Mises'
    component: int = -1
    signed: bool = True  #: Whether it swings about zero

    def amplitude(self, state: State) -> Array | None:
        """Amplitude that swings with the phase (n,); of sizes the largest; or None."""
        values = state.fields.get(self.field)
        if values is None:
            return None
        values = np.asarray(values)
        if values.ndim == 1:
            return values
        if self.component >= 0:
            return values[:, self.component]
        if self.field == "stress":
            # over a period; the other half is the same
            phases = np.pi * np.arange(1 if np.isrealobj(values) else _PHASES) / _PHASES
            return np.asarray(np.max([von_mises(at_phase(values, p)) for p in phases], axis=0))
        return np.asarray(np.linalg.norm(values, axis=1))

    def at(self, state: State, phase: float) -> Floats:
        """Values (n,) at a phase (rad)."""
        if self.key == "size":
            moved = at_phase(np.asarray(state.fields["displacement"]), phase)
            return np.asarray(np.linalg.norm(moved, axis=1))
        amplitude = self.amplitude(state)
        assert amplitude is not None
        if self.signed:
            return at_phase(amplitude, phase)
        return np.asarray(np.real(amplitude), dtype=float)

    def top(self, state: State) -> float:
        """End of the colour scale: the largest amplitude."""
        amplitude = self.amplitude(state)
        return 0.0 if amplitude is None else float(np.abs(amplitude).max())


SHADES: tuple[Shade, ...] = (
    Shade("size", "|u|", "m", "displacement", signed=False),
    Shade("u_x", "displacement u_x", "m", "displacement", 0),
    Shade("u_y", "displacement u_y", "m", "displacement", 1),
    Shade("u_z", "displacement u_z", "m", "displacement", 2),
    Shade("potential", "electric potential", "V", "potential"),
    Shade("strain_zz", "strain S_zz", "1", "strain", 2),
    Shade("stress_zz", "stress T_zz", "Pa", "stress", 2),
    Shade("von_mises", "von Mises stress, largest in a period", "Pa", "stress", signed=False),
    Shade("flux_density", "|B|", "T", "flux_density", signed=False),
)


def shades_of(result: FieldResult) -> tuple[Shade, ...]:
    """Fields that pictures of a result can be coloured by."""
    return tuple(shade for shade in SHADES if shade.field in result.has)


#: Matplotlib's maps: perceptually even for sizes, ColorBrewer's red and blue for what swings.
MAGNITUDE, SIGNED = "viridis", "RdBu_r"
_STOPS = 33


def colour_stops(name: str) -> list[list[int]]:
    """Scale of one of these as (red, green, blue), 0 to 255, from low to high."""
    import matplotlib as mpl

    colours = np.rint(255.0 * mpl.colormaps[name](np.linspace(0.0, 1.0, _STOPS))[:, :3])
    return cast("list[list[int]]", colours.astype(int).tolist())
