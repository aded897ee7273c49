"""The model solid for many bimorphs of one family: reduced bases, and what judges them.

A family on the level of bricks that the scene's accuracy asks for.  The bar of a value is that of
single bimorphs, found at a few of the range, and what the basis may miss.  A family on the next
coarser level says which classes of motion are needed, and how far responses are off beyond the
first resonance.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.answers import FamilyModes, family_modes
from tactgen.fem.bimorph.reduction.parametric.expansion import GROUPS
from tactgen.fem.bimorph.reduction.parametric.family import ReducedFamily, build_family
from tactgen.fem.piezo.symmetry import Motion
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing
from tactgen.geometry.bimorph.ends import Ends
from tactgen.geometry.bimorph.stretching import LEVELS, piece_lengths
from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import kept, recalled
from tactgen.geometry.store.values import storable
from tactgen.tmm.ports.readout import ModalReadout
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.costs import record
from tactgen.validation.engine.error_bars import FAMILY_FACTOR
from tactgen.validation.models.bimorph.family.surplus import FamilySurplus, family_surplus
from tactgen.validation.models.bimorph.solid import SolidModel, level_for
from tactgen.validation.scene.scene import Scene

#: Error bound of the bases beside the accuracy that the scene asks for.
_SHARE = 0.02
#: A mode of the coarser level this close above the last one wanted may come below it.
_CLOSE = 1.03
#: Classes of motion, that with ports first.
MOTIONS: tuple[Motion, ...] = ("bending_x", "bending_y", "torsion", "axial")
#: As what families are kept.
KIND = "solid.family"
#: What makes a family.
_MADE_OF = (
    "tactgen.fem.bimorph.reduction.parametric.family",
    "tactgen.validation.models.bimorph.family.surplus",
)

#: Least error bar of responses per difference of the two levels.  About the first resonance what is
#: missing at rest is enough; beyond the second 19 of 20 errors are below this share.
RESPONSE_FACTOR = 0.7

Ranges = Mapping[str, tuple[float, float]]


@storable
@dataclass(frozen=True)
class SolidFamily:
    """Two reduced families of one range: on a finer level of bricks, and on a coarser one.

    Attributes
    ----------
    fine, coarse : ReducedFamily
        On the two levels.
    surplus : FamilySurplus
        What the finer bricks lack.
    """

    fine: ReducedFamily
    coarse: ReducedFamily
    surplus: FamilySurplus

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest value of each scene key that varies (SI)."""
        return self.fine.ranges

    @property
    def method(self) -> str:
        """How the error bars come about, for the reader."""
        return (
            f"what polynomials of one degree more make of the residual of {self.fine.unknowns} "
            f"unknowns, at {len(self.surplus.modes)} bimorphs of the range, times "
            f"{FAMILY_FACTOR:g}; of responses no less than {RESPONSE_FACTOR:g} "
            f"times the difference from {self.coarse.unknowns} unknowns; and the residual's bound "
            f"of reduced bases made of {self.fine.asked} and {self.coarse.asked} bimorphs"
        )

    def counts(self, modes: int) -> dict[Motion, int]:
        """Return of which classes of motion modes are wanted, and how many of each at most.

        The finer level has those that any member needs.
        """
        return {motion: min(modes, own.modes) for motion, own in self.fine.motions.items()}

    def covers(self, ranges: Ranges) -> bool:
        """Return whether all of a range lies within the family's."""
        return all(
            self.ranges[key][0] <= low and high <= self.ranges[key][1]
            for key, (low, high) in ranges.items()
        )


def solid_family(
    scene: Scene,
    ranges: Ranges,
    quantities: Sequence[str],
    announce: Callable[[str], None] = lambda _: None,
) -> SolidFamily:
    """Return the family of bimorphs of a range of scene keys, from the store if it is there.

    One that is there and reaches less far is built anew, over both ranges.

    Parameters
    ----------
    ranges : mapping of str to (float, float)
        Lowest and highest value of keys such as ``bimorph.length`` or ``piezo.s11`` (SI).
    quantities : sequence of str
        What is to be read off it: without natural frequencies bending in x alone is reduced,
        with responses also at the scene's frequencies.

    Raises
    ------
    InputError
        If the model cannot take the scene, a key is none of the bimorph's numbers, or a piece
        of the bimorph vanishes somewhere in the range.
    """
    entry = _Entry.of(scene, ranges, quantities)
    wanted = dict(entry.wanted)

    def serves(found: SolidFamily) -> bool:
        if found.covers(wanted):
            return True
        for key, (low, high) in found.ranges.items():
            wanted[key] = (min(low, wanted[key][0]), max(high, wanted[key][1]))
        announce("solid family: beyond the range that is kept, which grows")
        return False

    def built(meshing: BrickMeshing, modes: Mapping[Motion, int]) -> ReducedFamily:
        return build_family(
            scene.device, wanted, meshing, modes,
            tolerance=entry.tolerance, frequencies=entry.frequencies, announce=announce,
        )  # fmt: skip

    def work() -> SolidFamily:
        start = time.perf_counter()
        coarser, finer = LEVELS[entry.level - 1 : entry.level + 1]
        modes: dict[Motion, int] = {"bending_x": scene.modes}
        coarse = built(coarser, dict.fromkeys(MOTIONS, scene.modes) if entry.modal else modes)
        if entry.modal:
            modes = needed(coarse, scene, scene.modes)
        announce("solid: members that tell what the bricks lack")
        surplus = family_surplus(scene.device, wanted, finer, modes)
        found = SolidFamily(built(finer, modes), coarse, surplus)
        record({cost_name(len(wanted)): time.perf_counter() - start})
        return found

    return kept(KIND, entry.inputs, _MADE_OF, work, serves=serves, announce=announce)


def is_family_kept(scene: Scene, ranges: Ranges, quantities: Sequence[str]) -> bool:
    """Return whether the store has a family that covers a range; refusals as `solid_family`."""
    entry = _Entry.of(scene, ranges, quantities)
    found: SolidFamily | None = recalled(
        KIND, entry.inputs, _MADE_OF, lambda family: family.covers(entry.wanted)
    )
    return found is not None


def cost_name(keys: int) -> str:
    """Return by what name the cost of building a family is written down."""
    return f"{KIND} of {keys} keys"


@dataclass(frozen=True)
class _Entry:
    """What a kept family depends on; `wanted` is the range that it must cover."""

    wanted: dict[str, tuple[float, float]]
    rest: dict[str, Any]
    level: int
    modes: int
    tolerance: float
    modal: bool
    frequencies: tuple[float, ...]

    @classmethod
    def of(cls, scene: Scene, ranges: Ranges, quantities: Sequence[str]) -> _Entry:
        SolidModel.check(scene)
        for key, (low, high) in ranges.items():
            if not is_family_key(scene, key):
                raise InputError(
                    f"{key} does not vary within a family of the solid; vary numbers of "
                    f"{', '.join(GROUPS)} such as bimorph.length"
                )
            if not low < high:
                raise InputError(f"{key} runs from {low:g} to {high:g}; begin below where it ends")
        wanted = {key: (float(low), float(high)) for key, (low, high) in ranges.items()}
        lengths = {k.partition(".")[2]: e for k, e in wanted.items() if k.startswith("bimorph.")}
        piece_lengths(scene.device.bimorph, lengths)
        rest = scene.model_dump(mode="json", include=set(GROUPS))
        for key in wanted:
            group, _, name = key.partition(".")
            rest[group].pop(name)
        modal, frequencies = reading(scene, quantities)
        return cls(
            wanted, rest, level_for(scene), scene.modes, _SHARE * scene.accuracy,
            modal, frequencies,
        )  # fmt: skip

    @property
    def inputs(self) -> tuple[object, ...]:
        """All but the range, in the order of the store's key."""
        return (
            self.rest, sorted(self.wanted), self.level, self.modes, self.tolerance, self.modal,
            self.frequencies,
        )  # fmt: skip


def reading(scene: Scene, quantities: Sequence[str]) -> tuple[bool, tuple[float, ...]]:
    """Return whether natural frequencies of all classes are read, and where responses are (Hz)."""
    rows = [QUANTITIES[name] for name in quantities]
    modal = any(isinstance(row.read, ModalReadout) and row.read.combine is None for row in rows)
    return modal, scene.frequency if any(row.by_frequency for row in rows) else ()


def is_family_key(scene: Scene, key: str) -> bool:
    """Return whether a scene key may vary within a family: a number that the bricks read.

    On its rod the bimorph is in three parts, of which there are no families.
    """
    if scene.support.kind == "rod":
        return False
    group, _, name = key.partition(".")
    if group not in GROUPS or name not in type(getattr(scene, group)).model_fields:
        return False
    value = getattr(getattr(scene, group), name)
    # glue.thickness is that of the rod's slot, of which bricks know nothing
    return isinstance(value, float) and key != "glue.thickness"


def needed(coarse: ReducedFamily, scene: Scene, count: int) -> dict[Motion, int]:
    """Return the classes of motion, and how many modes of each, that any member needs.

    A load and an open circuit raise a mode of bending in x past one other at most each.
    """
    rng = np.random.default_rng(3)
    values = {key: rng.uniform(*ends, 64) for key, ends in coarse.ranges.items()}
    found: dict[Motion, FamilyModes] = {
        motion: family_modes(
            coarse.members(motion, scene.device, values), Ends(), count + 2, open_circuit=False
        )
        for motion in MOTIONS
    }
    bending = found["bending_x"].frequencies[:, 2 : count + 2]
    others = {motion: modes.frequencies[:, :count] for motion, modes in found.items()}
    others.pop("bending_x")
    together: Floats = np.sort(np.concatenate([bending, *others.values()], axis=1), axis=1)
    reach = _CLOSE * np.maximum(together[:, count - 1], bending[:, 0])
    few = {
        motion: int((frequencies <= reach[:, None]).sum(axis=1).max())
        for motion, frequencies in others.items()
    }
    needed: dict[Motion, int] = {"bending_x": count}
    return needed | {motion: n for motion, n in few.items() if n}
