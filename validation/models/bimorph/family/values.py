"""Quantities of many members of a family of the solid, each with its error bar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.answers import family_modes
from tactgen.fem.bimorph.reduction.parametric.expansion import Coefficients
from tactgen.fem.bimorph.reduction.parametric.family import ReducedFamily
from tactgen.fem.bimorph.reduction.parametric.reduced import Members
from tactgen.fem.piezo.symmetry import Motion
from tactgen.geometry.arrays import Floats, Numbers
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import Multiport, in_series, round_off
from tactgen.tmm.ports.readout import ModalReadout, Readout
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.error_bars import FAMILY_FACTOR
from tactgen.validation.models.bimorph.family.mixed_form import MixedForm
from tactgen.validation.models.bimorph.family.solid_family import RESPONSE_FACTOR, SolidFamily
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
    error: Floats
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
        for name in ("value", "error", "basis")
    )
    return FamilyValues(value, bar, basis, classes)


@dataclass(frozen=True)
class _Modes:
    """Modes by class of motion: frequencies, bounds, classes (n, modes).

    And by how much what the bricks lack moves them (n, 2, modes), relative.
    """

    frequencies: dict[Motion, Floats]
    bounds: dict[Motion, Floats]
    kinds: dict[Motion, Any]
    moved: dict[Motion, Floats]


class _Chunk:
    """Some members; what several quantities are read from is worked out once."""

    def __init__(self, scene: Scene, family: SolidFamily, values: dict[str, Floats]) -> None:
        self._scene, self._family, self._values = scene, family, values
        self._forms: dict[tuple[bool, bool], MixedForm] = {}
        self._modes: dict[bool, _Modes] = {}
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
        fine = self._form(self._family.fine, static=static)
        ends = self._scene.ends.lossless if static else self._scene.ends
        series = self._scene.bimorph.wiring == "series"

        def of(port: Multiport) -> Any:
            wired = in_series(port) if series else port
            found = readout.read(attach(wired, ends), self._scene.drive.voltage)
            return np.asarray(found.real if static else found)

        value, judges = of(fine.port), self._judges(fine)
        apart = sum(np.abs(of(judge) - value) for judge in judges)
        bar = FAMILY_FACTOR * apart
        basis = sum((np.abs(of(moved.port) - value) for moved in fine.changed), np.zeros(bar.shape))
        if not static:
            coarse = self._form(self._family.coarse, static=False)
            other = of(coarse.port)
            bar = np.maximum(bar, RESPONSE_FACTOR * np.abs(value - other))
            for moved in coarse.changed:
                basis = basis + RESPONSE_FACTOR * np.abs(of(moved.port) - other)
        bar = bar + basis + np.abs(value) * round_off(attach(fine.port, ends))
        shape = (-1,) if static else (-1, len(self._scene.frequency))
        return FamilyValues(*(part.reshape(shape) for part in (value, bar, basis)))

    def _judges(self, fine: MixedForm) -> list[Multiport]:
        """Return D with what displacements that the finer bricks lack add, and what potentials.

        About the first resonance the tip moves as at rest, and so does what is missing.
        """
        rest = self._form(self._family.fine, static=True)
        more = self._family.surplus.at_rest(self._values, rest.work)
        repeated = fine.frequencies.size // rest.frequencies.size
        added = (
            rest.richer(sign * more[:, i]).port.stiffness - rest.port.stiffness
            for i, sign in enumerate((1.0, -1.0))
        )
        own = fine.port
        return [
            replace(own, stiffness=own.stiffness + np.repeat(of, repeated, axis=0)) for of in added
        ]

    def _form(self, level: ReducedFamily, *, static: bool) -> MixedForm:
        """Return D of a level; InputError where a frequency is beyond what a basis serves."""
        key = level is self._family.fine, static
        if key not in self._forms:
            self._forms[key] = self._solved(level, static=static)
        return self._forms[key]

    def _solved(self, level: ReducedFamily, *, static: bool) -> MixedForm:
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

    def _of_circuit(self, *, open_circuit: bool) -> _Modes:
        if open_circuit not in self._modes:
            self._modes[open_circuit] = self._solved_modes(open_circuit=open_circuit)
        return self._modes[open_circuit]

    def _solved_modes(self, *, open_circuit: bool) -> _Modes:
        ends, family = self._scene.ends, self._family
        judged = family.surplus.of_modes(
            self._values, ends, self._scene.modes, open_circuit=open_circuit
        )
        frequencies, bounds, kinds, moved = {}, {}, {}, {}
        for motion, wanted in family.counts(self._scene.modes).items():
            count = min(wanted, judged[motion].shape[2])
            members = self._of(family.fine, motion)
            found = family_modes(members, ends, count, open_circuit=open_circuit)
            frequencies[motion], bounds[motion] = found.frequencies, found.bars
            kinds[motion] = np.where(found.shares(members) >= 0.5, motion, "mixed")
            moved[motion] = judged[motion][:, :, : found.frequencies.shape[1]]
        return _Modes(frequencies, bounds, kinds, moved)

    def _frequencies(self, *, open_circuit: bool) -> FamilyValues:
        found = self._of_circuit(open_circuit=open_circuit)
        values, bars, bases, kinds = [], [], [], []
        for motion, value in found.frequencies.items():
            basis = found.bounds[motion]
            apart = np.abs(found.moved[motion]).sum(axis=1) * value
            values.append(value)
            bases.append(basis)
            bars.append(FAMILY_FACTOR * apart + basis + _ROUNDING * value)
            kinds.append(found.kinds[motion])
        every = np.concatenate(values, axis=1)
        first = np.argsort(every, axis=1, kind="stable")[:, : self._scene.modes]

        def lowest(parts: list[Any]) -> Any:
            return np.take_along_axis(np.concatenate(parts, axis=1), first, axis=1)

        return FamilyValues(lowest(values), lowest(bars), lowest(bases), lowest(kinds))

    def _combination(self, read: ModalReadout) -> FamilyValues:
        combine = read.combine
        assert combine is not None
        circuits = [self._of_circuit(open_circuit=circuit == "open") for circuit in read.circuits]

        def first(modes: _Modes, of: Floats) -> Floats:
            bends = modes.kinds["bending_x"] == "bending_x"
            at = np.argmax(bends, axis=1)[:, None]
            return np.where(bends.any(axis=1), np.take_along_axis(of, at, axis=1)[:, 0], np.nan)

        own = [first(m, m.frequencies["bending_x"]) for m in circuits]
        value = combine(*own)
        # what moves all circuits alike, then what moves the others beside the first
        levels: list[list[Any]] = [
            [1.0 + first(circuits[0], circuits[0].moved["bending_x"][:, judge])] * len(own)
            for judge in range(2)
        ]
        apart = np.sqrt(1.0 + self._family.surplus.opened(self._values, self._scene.ends))
        levels.append([apart if circuit != read.circuits[0] else 1.0 for circuit in read.circuits])
        bar = np.zeros_like(value)
        for shares in levels:
            richer = combine(*(share * f for share, f in zip(shares, own, strict=True)))
            bar += FAMILY_FACTOR * np.abs(richer - value)
        basis = np.zeros_like(value)
        for number, modes in enumerate(circuits):
            moved = list(own)
            moved[number] = moved[number] + first(modes, modes.bounds["bending_x"])
            basis += np.abs(combine(*moved) - value)
        rounding = np.array([read.rounding(float(v), len(own) * _ROUNDING) for v in value])
        return FamilyValues(value, bar + basis + rounding, basis)
