"""Quantities of many members of a family of the solid, each with its error bar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.fem.bimorph.motions import Motion
from tactgen.fem.bimorph.reduction.parametric.answers import family_modes
from tactgen.fem.bimorph.reduction.parametric.expansion import Coefficients
from tactgen.fem.bimorph.reduction.parametric.family import ReducedFamily
from tactgen.fem.bimorph.reduction.parametric.reduced import Members
from tactgen.geometry.arrays import Floats, Numbers
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.multiport import in_series, round_off
from tactgen.tmm.ports.readout import ModalReadout, Readout
from tactgen.tmm.ports.terminations import attach
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.refinement import BRICK_FACTOR, least_difference
from tactgen.validation.models.bimorph.at_rest import least_at_rest
from tactgen.validation.models.bimorph.family.mixed_form import MixedForm
from tactgen.validation.models.bimorph.family.solid_family import SolidFamily
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
    value, bar : (n,), (n, modes) or (n, frequencies) array
        In the quantity's SI unit; the bar is that of the bricks and that of the bases together.
    basis : array
        The bar's part that the bases are to blame for.
    classes : (n, modes) array of str or None
        Class of each mode.
    """

    value: Numbers
    bar: Floats
    basis: Floats
    classes: Any = None


def gives_family(quantity: str) -> bool:
    """Return whether a quantity is read off a family: its ports, and natural frequencies."""
    return isinstance(QUANTITIES[quantity].read, ModalReadout | Readout)


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
    parts: list[dict[str, FamilyValues]] = []
    for i in range(0, count, _AT_ONCE):
        some = _Chunk(scene, family, {key: at[i : i + _AT_ONCE] for key, at in points.items()})
        parts.append({name: some.read(name) for name in quantities})
    return {name: joined([part[name] for part in parts]) for name in quantities}


def joined(parts: list[FamilyValues]) -> FamilyValues:
    """Return the values of several groups of members as those of one."""
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
        self._forms: dict[bool, tuple[MixedForm, MixedForm]] = {}
        self._modes: dict[bool, tuple[_Level, _Level]] = {}
        self._worth: dict[tuple[bool, bool], Coefficients] = {}
        self._members: dict[tuple[bool, Motion, bool], Members] = {}

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
        static = readout.static
        fine, coarse = self._ports(static=static)
        ends = self._scene.ends.lossless if static else self._scene.ends
        series = self._scene.bimorph.wiring == "series"

        def of(form: MixedForm) -> Any:
            wired = in_series(form.port) if series else form.port
            found = readout.read(attach(wired, ends), self._scene.drive.voltage)
            return np.asarray(found.real if static else found)

        value, other = of(fine), of(coarse)
        basis = np.zeros(value.shape)
        for form, at, factor in ((fine, value, 1.0), (coarse, other, BRICK_FACTOR)):
            for changed in form.changed:
                basis += factor * np.abs(of(changed) - at)
        rounding = np.abs(value) * round_off(attach(fine.port, ends))
        apart = np.abs(value - other)
        if static:
            apart += least_at_rest(fine.port, coarse.port) * np.abs(value)
        bar = BRICK_FACTOR * apart + basis + rounding
        shape = (-1,) if static else (-1, len(self._scene.frequency))
        return FamilyValues(value.reshape(shape), bar.reshape(shape), basis.reshape(shape))

    def _ports(self, *, static: bool) -> tuple[MixedForm, MixedForm]:
        """Return D of both levels; InputError where a frequency is beyond what a basis serves."""
        if static not in self._forms:
            fine, coarse = (
                self._form(level, static=static)
                for level in (self._family.fine, self._family.coarse)
            )
            self._forms[static] = fine, coarse
        return self._forms[static]

    def _form(self, level: ReducedFamily, *, static: bool) -> MixedForm:
        members = self._of(level, "bending_x", lossy=not static)
        if static:
            return MixedForm.static(members)
        form = MixedForm.harmonic(members, np.asarray(self._scene.frequency, dtype=float))
        beyond = form.frequencies[~np.isfinite(form.missing).all(axis=1)]
        if beyond.size:
            raise InputError(
                f"{beyond.min():g} Hz is beyond the {members.reduced.modes} modes that the reduced "
                "basis is made of; ask for more modes or a lower frequency"
            )
        return form

    def _of(self, level: ReducedFamily, motion: Motion, *, lossy: bool = False) -> Members:
        """Return the small systems of the members on one of the two levels."""
        fine = level is self._family.fine
        if (fine, lossy) not in self._worth:
            self._worth[fine, lossy] = level.terms.coefficients(
                self._scene.device, self._values, lossy=lossy
            )
        if (fine, motion, lossy) not in self._members:
            self._members[fine, motion, lossy] = level.motions[motion].members(
                level.terms, self._worth[fine, lossy]
            )
        return self._members[fine, motion, lossy]

    def _levels(self, *, open_circuit: bool) -> tuple[_Level, _Level]:
        if open_circuit not in self._modes:
            fine, coarse = (
                self._level(level, open_circuit=open_circuit)
                for level in (self._family.fine, self._family.coarse)
            )
            self._modes[open_circuit] = fine, coarse
        return self._modes[open_circuit]

    def _level(self, level: ReducedFamily, *, open_circuit: bool) -> _Level:
        frequencies, bounds, kinds = {}, {}, {}
        for motion, count in self._family.counts(self._scene.modes).items():
            members = self._of(level, motion)
            found = family_modes(members, self._scene.ends, count, open_circuit=open_circuit)
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
        rounding = np.array([read.rounding(float(v), len(fine) * _ROUNDING) for v in value])
        return FamilyValues(value, BRICK_FACTOR * np.abs(value - other) + basis + rounding, basis)


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
    found: dict[Motion, Floats] = {}
    for motion, (value, other) in pairs.items():
        near = (value, other) if value.shape[1] > 1 else together
        found[motion] = np.abs(value - other) + least_difference(*near)[:, None] * value
    return found
