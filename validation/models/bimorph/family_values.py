"""Quantities of many members of a family of the solid, each with its error bar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.fem.bimorph.motions import Motion
from tactgen.fem.bimorph.ports import ports_from_blocks
from tactgen.fem.bimorph.reduction.parametric.answers import (
    FamilyStatics,
    family_modes,
    family_statics,
)
from tactgen.fem.bimorph.reduction.parametric.family import ReducedFamily
from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.multiport import Multiport, in_series, round_off
from tactgen.tmm.ports.port import BIMORPH
from tactgen.tmm.ports.readout import ModalReadout, Readout
from tactgen.tmm.ports.terminations import attach
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.refinement import BRICK_FACTOR, least_difference
from tactgen.validation.models.bimorph.solid_family import SolidFamily
from tactgen.validation.scene.scene import Scene

#: Members worked out at once: what lies between inputs and results stays small.
_AT_ONCE = 128
#: Relative rounding of a frequency by the sums of terms: the largest are (L/h)² times what is
#: left of them, and each is right to 1e-15.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class FamilyValues:
    """A quantity of n members.

    Attributes
    ----------
    value, bar : (n,) or (n, modes) array
        In the quantity's SI unit; the bar is that of the bricks and that of the bases together.
    basis : (n,) or (n, modes) array
        The bar's part that the bases are to blame for.
    classes : (n, modes) array of str or None
        Class of each mode.
    """

    value: Floats
    bar: Floats
    basis: Floats
    classes: Any = None


def gives_family(quantity: str) -> bool:
    """Return whether a quantity is read off a family: statics and natural frequencies."""
    read = QUANTITIES[quantity].read
    return isinstance(read, ModalReadout) or (isinstance(read, Readout) and read.static)


def family_values(
    scene: Scene, family: SolidFamily, values: Mapping[str, Floats], quantities: Sequence[str]
) -> dict[str, FamilyValues]:
    """Return quantities of the bimorphs that differ from the scene's in `values` (n,) each.

    Raises
    ------
    InputError
        For a point outside the family's range, or a quantity that it does not give.
    """
    points = {key: np.atleast_1d(np.asarray(value, dtype=float)) for key, value in values.items()}
    for key, (low, high) in family.ranges.items():
        at = points[key]
        beyond = at[(at < low) | (at > high)]
        if beyond.size:
            raise InputError(
                f"{key} = {beyond[0]:g} is outside the family's range of {low:g} to {high:g}; "
                "build it for a range that reaches there"
            )
    for name in quantities:
        if not gives_family(name):
            raise InputError(f'quantity "{name}" is not read off a family of the solid')
    count = next(iter(points.values())).size
    parts = [
        _Chunk(scene, family, {key: at[i : i + _AT_ONCE] for key, at in points.items()})
        for i in range(0, count, _AT_ONCE)
    ]
    return {name: _joined([part.read(name) for part in parts]) for name in quantities}


def _joined(parts: list[FamilyValues]) -> FamilyValues:
    classes = None
    if parts[0].classes is not None:
        classes = np.concatenate([part.classes for part in parts])
    value, bar, basis = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("value", "bar", "basis")
    )
    return FamilyValues(value, bar, basis, classes)


@dataclass(frozen=True)
class _Level:
    """Modes of one level by class of motion: frequencies, bounds, classes (n, modes)."""

    frequencies: dict[Motion, Floats]
    bounds: dict[Motion, Floats]
    kinds: dict[Motion, Any]


class _Chunk:
    """Some members; what several quantities are read from is worked out once."""

    def __init__(self, scene: Scene, family: SolidFamily, values: dict[str, Floats]) -> None:
        self._scene, self._family, self._values = scene, family, values
        self._static: tuple[FamilyStatics, FamilyStatics] | None = None
        self._modes: dict[bool, tuple[_Level, _Level]] = {}

    def read(self, name: str) -> FamilyValues:
        """Return a quantity."""
        read = QUANTITIES[name].read
        if isinstance(read, Readout):
            return self._of_ports(read)
        assert isinstance(read, ModalReadout)
        if read.combine is None:
            return self._frequencies(open_circuit=read.circuits == ("open",))
        return self._combination(read)

    def _of_ports(self, readout: Readout) -> FamilyValues:
        if self._static is None:
            fine, coarse = (
                family_statics(level.members("bending_x", self._scene.device, self._values))
                for level in (self._family.fine, self._family.coarse)
            )
            self._static = fine, coarse
        ends, wiring = self._scene.ends.lossless, self._scene.bimorph.wiring

        def of(statics: FamilyStatics, change: _Change | None = None) -> Floats:
            port = _multiport(statics, change)
            wired = in_series(port) if wiring == "series" else port
            found = readout.read(attach(wired, ends), self._scene.drive.voltage)
            return np.asarray(found.real)

        fine, coarse = self._static
        value, other = of(fine), of(coarse)
        basis = np.zeros_like(value)
        for statics, at, factor in ((fine, value, 1.0), (coarse, other, BRICK_FACTOR)):
            for change in _CHANGES:
                basis += factor * np.abs(of(statics, change) - at)
        rounding = np.abs(value) * round_off(attach(_multiport(fine), ends))
        return FamilyValues(value, BRICK_FACTOR * np.abs(value - other) + basis + rounding, basis)

    def _levels(self, *, open_circuit: bool) -> tuple[_Level, _Level]:
        if open_circuit not in self._modes:
            motions = tuple(self._family.fine.motions)
            fine, coarse = (
                self._level(level, motions, open_circuit=open_circuit)
                for level in (self._family.fine, self._family.coarse)
            )
            self._modes[open_circuit] = fine, coarse
        return self._modes[open_circuit]

    def _level(
        self, level: ReducedFamily, motions: tuple[Motion, ...], *, open_circuit: bool
    ) -> _Level:
        frequencies, bounds, kinds = {}, {}, {}
        for motion in motions:
            members = level.members(motion, self._scene.device, self._values)
            found = family_modes(
                members, self._scene.ends, self._scene.modes, open_circuit=open_circuit
            )
            frequencies[motion], bounds[motion] = found.frequencies, found.bars
            if level is self._family.fine:
                kinds[motion] = np.where(found.shares(members) >= 0.5, motion, "mixed")
        return _Level(frequencies, bounds, kinds)

    def _frequencies(self, *, open_circuit: bool) -> FamilyValues:
        fine, coarse = self._levels(open_circuit=open_circuit)
        values, bars, bases, kinds = [], [], [], []
        apart = _apart(fine, coarse)
        for motion, value in fine.frequencies.items():
            count = apart[motion].shape[1]
            value = value[:, :count]
            basis = fine.bounds[motion][:, :count] + BRICK_FACTOR * coarse.bounds[motion][:, :count]
            values.append(value)
            bases.append(basis)
            bars.append(BRICK_FACTOR * apart[motion] + basis + _ROUNDING * value)
            kinds.append(fine.kinds[motion][:, :count])
        every = np.concatenate(values, axis=1)
        first = np.argsort(every, axis=1, kind="stable")[:, : self._scene.modes]

        def lowest(parts: list[Any]) -> Any:
            return np.take_along_axis(np.concatenate(parts, axis=1), first, axis=1)

        return FamilyValues(lowest(values), lowest(bars), lowest(bases), lowest(kinds))

    def _combination(self, read: ModalReadout) -> FamilyValues:
        combine = read.combine
        assert combine is not None
        levels = [self._levels(open_circuit=circuit == "open") for circuit in read.circuits]

        def first(level: _Level, of: Mapping[Motion, Floats]) -> Floats:
            bends = level.kinds["bending_x"] == "bending_x"
            at = np.argmax(bends, axis=1)[:, None]
            found = np.take_along_axis(of["bending_x"], at, axis=1)[:, 0]
            return np.where(bends.any(axis=1), found, np.nan)

        fine = [first(f, f.frequencies) for f, _ in levels]
        coarse = [first(f, c.frequencies) for f, c in levels]
        value = combine(*fine)
        other = combine(*coarse)
        basis = np.zeros_like(value)
        for number, (f, c) in enumerate(levels):
            for own, at, bound, factor in (
                (fine, value, f.bounds, 1.0),
                (coarse, other, c.bounds, BRICK_FACTOR),
            ):
                moved = list(own)
                moved[number] = moved[number] + first(f, bound)
                basis += factor * np.abs(combine(*moved) - at)
        gain = np.array([read.rounding_gain(float(v)) for v in value])
        rounding = len(fine) * _ROUNDING * gain * np.abs(value)
        return FamilyValues(value, BRICK_FACTOR * np.abs(value - other) + basis + rounding, basis)


#: An entry of the mixed form of D(0), by the loads (volt, tip force, tip moment) of its bound.
_Change = tuple[int, int]
_CHANGES: tuple[_Change, ...] = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def _multiport(statics: FamilyStatics, change: _Change | None = None) -> Multiport:
    """Return D(0) of n members, one entry of its mixed form moved by its bound."""
    held, through = statics.held.copy(), statics.through.copy()
    follows, compliance = statics.follows.copy(), statics.compliance.copy()
    if change is not None:
        i, j = change
        size = statics.missing[:, i] * statics.missing[:, j]
        if j == 0:
            held[:, 2, 2] -= size
        elif i == 0:
            follows[:, j - 1, 2] += size
            through[:, 2, j - 1] -= size
        else:
            compliance[:, i - 1, j - 1] += size
            if i != j:
                compliance[:, j - 1, i - 1] += size
    stiffness = ports_from_blocks(held, through, follows, compliance)
    return Multiport(np.zeros(held.shape[0]), stiffness, BIMORPH)


def _apart(fine: _Level, coarse: _Level) -> dict[Motion, Floats]:
    """Return the distances (n, modes) of the levels' frequencies, what each counts with included.

    A mode that is alone in its class has all others for neighbours.
    """
    pairs = {}
    for motion, value in fine.frequencies.items():
        other = coarse.frequencies[motion]
        count = min(value.shape[1], other.shape[1])
        pairs[motion] = value[:, :count], other[:, :count]
    together = [np.concatenate(parts, axis=1) for parts in zip(*pairs.values(), strict=True)]
    found = {}
    for motion, (value, other) in pairs.items():
        near = (value, other) if value.shape[1] > 1 else together
        least = np.array([least_difference(f, c) for f, c in zip(*near, strict=True)])
        found[motion] = np.abs(value - other) + least[:, None] * value
    return found
