"""The transfer-matrix model as a function of its parameters, many sets of values at once.

A *point* is a frequency with one value for each parameter that is varied.  The values are
arrays over the points.  Nothing is modelled here; sections, spans and port algebra are those of
every other answer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.segments import Piece, measured_pieces
from tactgen.geometry.device.bimorph import Dimensions
from tactgen.geometry.device.parameters import Beam, Bimorph, Circuit, Device, Drive, Load, Support
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import Unit, quoted
from tactgen.tmm.beam.mounted_beam import uniform_response
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.transfer_matrix import SEGMENTS, chain, elements
from tactgen.tmm.ports.excitation_and_circuit import ELECTRICAL, excitation_of, excited
from tactgen.tmm.ports.multiport import MEASURED, Multiport, Response, in_series, respond
from tactgen.tmm.ports.supports_and_loads import attach, ends_of

#: Values by scene key, each a number or an array over the points.
Values = Mapping[str, Any]

#: Groups of scene keys that a one-dimensional model can read, in the scene's order.
_GROUPS = ("bimorph", "piezo", "shim", "glue", "rod", "support", "load", "drive", "circuit", "beam")
#: Those that are not the device's.
_OWN = ("support", "load", "beam", "drive", "circuit")
#: Where it is tried whether a key matters (Hz), and by which relative change: a power of
#: two, so that the steps themselves are exact.
_TRIAL, _STEP = np.array([1000.0]), 2.0**-10
#: Points worked out at once: what lies between inputs and results stays small beside them.
_AT_ONCE = 2**16


@dataclass(frozen=True)
class Actuator:
    """Lateral actuator with support, load, drive and circuit.

    `segments` is the number of prismatic stretches that stand for a tapered piece.
    """

    device: Device
    support: Support
    load: Load
    beam: Beam
    drive: Drive
    circuit: Circuit = field(default_factory=Circuit)
    segments: int = SEGMENTS

    @property
    def ends(self) -> Ends:
        """Support and load at the ports."""
        return ends_of(self.support, self.load)

    def value(self, key: str) -> float:
        """Value of a scene key such as ``piezo.s11`` (SI)."""
        group, _, name = key.partition(".")
        return float(self.group(group).value(name))

    def with_values(self, values: Values) -> Actuator:
        """Actuator with other values (unchecked: arrays and complex ones pass)."""
        changes: dict[str, dict[str, Any]] = {}
        for key, value in values.items():
            group, _, name = key.partition(".")
            changes.setdefault(group, {})[name] = value
        groups = {g: self.group(g).changed(change) for g, change in changes.items()}
        own = {g: groups.pop(g) for g in _OWN if g in groups}
        return replace(self, device=self.device.model_copy(update=groups), **own)

    def group(self, name: str) -> Any:
        """Group of parameters by its scene key."""
        return getattr(self if name in _OWN else self.device, name)


@lru_cache(maxsize=4)  # asked by several for one scene
def parameter_keys(actuator: Actuator) -> tuple[str, ...]:
    """Scene keys of all numbers that the model reads and that can be varied.

    Found by trying.  Left out are numbers that are zero, of which there is no percentage,
    and lengths at which a piece of the row of beams appears or vanishes (a rod that ends
    at its flange): there the model has a kink.
    """
    usual = terminated(actuator, {}, _TRIAL).stiffness

    def matters(key: str) -> bool:
        moved = {key: actuator.value(key) * (1.0 + _STEP)}
        return bool((terminated(actuator, moved, _TRIAL).stiffness != usual).any())

    return tuple(
        key
        for key in _number_keys(actuator)
        if _slopes(actuator, key) is not None and (_drives(actuator, key) or matters(key))
    )


def _drives(actuator: Actuator, key: str) -> bool:
    """Whether a key is of the excitation, which no port matrix shows."""
    if key == "drive.voltage":
        return actuator.circuit.kind == "source"
    return key.startswith(("drive.", "circuit."))


def _number_keys(actuator: Actuator) -> list[str]:
    found = []
    for name in _GROUPS:
        group = actuator.group(name)
        for member, info in type(group).model_fields.items():
            if any(isinstance(m, Unit) for m in info.metadata) and getattr(group, member):
                found.append(f"{name}.{member}")
    return [*found, *(f"bimorph.{name}" for name in actuator.device.bimorph.layers.smooth_sizes)]


def has_kink(actuator: Actuator, key: str) -> bool:
    """Whether a piece of the row of beams appears or vanishes at a key's value."""
    return _slopes(actuator, key) is None


def _unvariable(actuator: Actuator, key: str) -> InputError:
    if key == "bimorph.length":
        check_length_free(actuator.device.bimorph)
    listed = ", ".join(parameter_keys(actuator))
    return InputError(
        f"key {quoted(key)} is no number other than 0 on which a transfer-matrix model "
        f"can depend smoothly; this scene's depends on {listed}"
    )


def check_length_free(bimorph: Bimorph) -> None:
    """Refuse to vary the ceramic's length where a profile is stated for the present one.

    Raises InputError naming the profile.
    """
    for name in bimorph.profiles:
        raise InputError(
            f"bimorph.length cannot be varied, since bimorph.{name} is stated for "
            f"{1e3 * bimorph.length:g} mm; leave the profile out"
        )


def terminated(
    actuator: Actuator, values: Values, frequencies: Floats, *, lossless: bool = False
) -> Multiport:
    """D(Ω) with support and load attached, wired as the device is.

    Parameters
    ----------
    values : dict of str to array
        Scene keys with their values, each a number or (n,).
    frequencies : (n,) array
        Frequencies (Hz), one per point.
    lossless : bool
        Without any damping and, as for all static values and modes, without the finger.

    Raises InputError if the row of pieces does not follow a key smoothly.
    """
    row, ends, series = _mounted(actuator, values, lossless=lossless)
    return attach(_ports(actuator, row, frequencies, series=series), ends)


def tip_response(
    actuator: Actuator, values: Values, frequencies: Floats, *, lossless: bool = False
) -> Response:
    """Motion of tip and place of measurement, and charge (n,) per volt, wired as the device is.

    In closed form for one uniform beam, by D(Ω) for any other row, a block of points at a
    time; arguments as of :func:`terminated`.
    """
    f = np.asarray(frequencies, dtype=float)
    below = actuator.device.measurement.below_tip
    names = ("w_tip", "psi_tip", *([MEASURED.name] if below else []))
    motion = {name: np.empty(f.size, dtype=complex) for name in names}
    charge = np.empty(f.size, dtype=complex)
    for start in range(0, f.size, _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        here = {key: v[part] if np.ndim(v) else v for key, v in values.items()}
        row, ends, series = _mounted(actuator, here, lossless=lossless)
        closed = None if below else uniform_response(row, ends, f[part], series=series)
        if closed is not None:
            found = closed.response
        else:
            port = _ports(actuator, row, f[part], series=series)
            found = respond(attach(port, ends), {"voltage": 1.0})
        for name, values_of in motion.items():
            values_of[part] = found.motion[name]
        charge[part] = found.effort["voltage"]
    return Response(motion, {"voltage": charge})


def charge_drawn(actuator: Actuator, values: Values, frequencies: Floats) -> Complex:
    """Charge (n,) in C from the circuit under all that drives the actuator, a block at a time."""
    found = np.empty(frequencies.size, dtype=complex)
    for start in range(0, frequencies.size, _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        here = {key: v[part] if np.ndim(v) else v for key, v in values.items()}
        row, ends, series = _mounted(actuator, here, lossless=False)
        now = actuator.with_values({k: v for k, v in here.items() if _drives(actuator, k)})
        port = _ports(actuator, row, frequencies[part], series=series)
        excitation = excitation_of(now.circuit, now.drive)
        found[part] = excited(port, ends, excitation).effort[ELECTRICAL]
    return found


def _ports(
    actuator: Actuator, row: list[Element], frequencies: Floats, *, series: bool
) -> Multiport:
    port = chain(row, frequencies, actuator.device.measurement.below_tip)
    return in_series(port) if series else port


def _mounted(
    actuator: Actuator, values: Values, *, lossless: bool
) -> tuple[list[Element], Ends, bool]:
    """Row of elements, boundary conditions, and whether it is wired in series."""
    # where a layer begins and ends say the pieces
    sizes = {key: v for key, v in values.items() if not key.endswith((".start", ".end"))}
    now = actuator.with_values(sizes)
    row: list[Element] = []
    for piece in _pieces(actuator, values):
        row += elements(piece, now.device, now.beam, lossy=not lossless, segments=actuator.segments)
    ends = now.ends.lossless if lossless else now.ends
    return row, ends, now.device.bimorph.wiring == "series"


def _pieces(actuator: Actuator, values: Values) -> list[Piece]:
    """Row of pieces with their dimensions at the varied values.

    Which pieces there are is decided by the actuator's own values.  Their dimensions are
    sums and differences of parameters, so that one step gives each slope exactly; a piece
    itself cannot be made with arrays, since it takes comparisons.
    """
    row = measured_pieces(actuator.device, actuator.support)
    dimensions: list[list[Any]] = [list(_dimensions(piece)) for piece in row]
    for key, value in values.items():
        slopes = _slopes(actuator, key)
        if slopes is None:
            raise _unvariable(actuator, key)
        for i, k in zip(*np.nonzero(slopes), strict=True):
            dimensions[i][k] = dimensions[i][k] + slopes[i, k] * (value - actuator.value(key))
    if any(np.min(length) <= 0.0 for length, *_ in dimensions):
        raise InputError(
            f"{', '.join(values)} leave nothing of a part of the bimorph; keep bimorph.length "
            "above the end of every layer, electrode and place of measurement"
        )
    return [_with_dimensions(piece, d) for piece, d in zip(row, dimensions, strict=True)]


def _slopes(actuator: Actuator, key: str) -> Floats | None:
    """Derivatives (pieces, 8) of the pieces' dimensions by a parameter.

    None if pieces appear or vanish.
    """
    row = measured_pieces(actuator.device, actuator.support)
    if key.partition(".")[0] not in ("bimorph", "rod", "glue"):
        return np.zeros((len(row), 8))
    value = actuator.value(key)
    more, less = (
        measured_pieces(actuator.with_values({key: value * (1.0 + s)}).device, actuator.support)
        for s in (_STEP, -_STEP)
    )
    kinds = [
        [(piece.section, piece.electrode, piece.without) for piece in pieces]
        for pieces in (row, more, less)
    ]
    if kinds[0] != kinds[1] or kinds[0] != kinds[2]:
        return None
    steps = [
        np.subtract(_dimensions(one), _dimensions(other))
        for one, other in zip(more, less, strict=True)
    ]
    return np.array(steps) / (2.0 * _STEP * value)


def _dimensions(piece: Piece) -> tuple[float, ...]:
    """Length, radius, and the layers at both ends (0 where they are the device's)."""
    if piece.ends is None:
        return (piece.length, piece.radius, *[0.0] * 6)
    ends = ((end.width, end.piezo_thickness, end.shim_thickness) for end in piece.ends)
    return (piece.length, piece.radius, *(size for end in ends for size in end))


def _with_dimensions(piece: Piece, dimensions: Sequence[Any]) -> Piece:
    length, radius, *layers = dimensions
    if piece.ends is None:
        return replace(piece, length=length, radius=radius)
    ends = (Dimensions(*layers[:3]), Dimensions(*layers[3:]))
    return replace(piece, length=length, radius=radius, ends=ends)
