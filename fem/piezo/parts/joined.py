"""The solid in three parts as one system: foot and tip, which are kept, and what is between."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NoReturn

import numpy as np
from scipy import sparse

from tactgen.fem.piezo.parts.end import End, ReducedEnd
from tactgen.fem.piezo.parts.section_functions import section_functions
from tactgen.fem.piezo.parts.stretch import Section, Stretch, section_of
from tactgen.fem.piezo.symmetry import PORTS, Bordered, Motion
from tactgen.fem.piezo.system import Material, SolidSystem, loss_tensors, materials, volts_per_unit
from tactgen.fem.solvers.sparse_rows import wide_product
from tactgen.geometry.arrays import Ints, Numbers, Sparse
from tactgen.geometry.bimorph.bimorph_bricks import BrickParts
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.store.store import kept

#: What makes a reduced end, and a section.
_END, _SECTION = ("tactgen.fem.piezo.parts.end",), ("tactgen.fem.piezo.parts.stretch",)


def joined_system(
    device: Device,
    parts: BrickParts,
    *,
    lossy: bool,
    ceramic: Piezoceramic | None = None,
    motion: Motion = "bending_x",
) -> SolidSystem:
    """Assemble one class of motion of the bimorph in three parts.

    Its nodes are places of the stretch, which is where modes are told apart.  Ends and section
    come from the store if they were reduced before, whatever the length was.

    Parameters
    ----------
    device : Device
        Materials and poling.
    parts : BrickParts
        Where it is cut, and how it is divided.
    lossy : bool
        Take losses into account (complex matrices).
    ceramic : Piezoceramic, optional
        Full material to use instead of the device's own.
    motion : {"bending_x", "bending_y", "torsion", "axial"}
        Only the first takes part in what the ports do.
    """
    of = ceramic or device.piezo.ceramic()
    without, with_losses = (
        materials(device, parts.regions, of, lossy=losses) for losses in (False, True)
    )
    joined = _Joined(parts, without, with_losses)
    if not lossy:
        return joined.system(motion)
    with_losses_too = joined.system(motion).with_losses
    return with_losses_too() if with_losses_too is not None else _refused(motion)


@dataclass(frozen=True)
class _Joined:
    """The parts before they are held anywhere."""

    parts: BrickParts
    without: dict[str, Material]
    with_losses: dict[str, Material]

    def system(self, motion: Motion) -> SolidSystem:
        """Return the lossless system of one class of motion, of the whole body."""
        section = self._section(motion)
        foot, tip = self._end(motion, section, is_foot=True), self._end(motion, section)
        stretch = Stretch(section, self.parts.stretch)
        place = _Place(section.functions.values.shape[1], stretch.nodes, foot, tip)
        stiffness = place.joined(stretch.stiffness(lossy=False), foot.stiffness, tip.stiffness)
        nodes, seen, node_mass = stretch.whole_nodes()
        nothing = sparse.csr_matrix((seen.shape[0], foot.own + tip.own + PORTS))
        face = np.zeros((place.size + PORTS, 2))
        face[place.of(tip)] = tip.face
        potentials = place.shapes - section.functions.moving
        lossless = SolidSystem(
            stiffness=stiffness,
            mass=place.joined(stretch.mass(), foot.mass, tip.mass),
            tip=face,
            expand=sparse.hstack([seen, nothing], format="csr"),
            nodes=nodes,
            node_mass=node_mass,
            potentials=foot.charged + tip.charged + stretch.nodes * potentials,
            volts_per_unit=volts_per_unit(self.without),
            motion=motion,
            related=self.system,
            elimination=place.order,
            rounding=_rounding(stiffness.inner, place, section),
            behind=self.parts.values,
        )

        def with_losses() -> SolidSystem:
            of_ends = (end.stiffness + 1j * end.losses for end in (foot, tip))
            lossy = place.joined(stretch.stiffness(lossy=True), *of_ends)
            return replace(lossless, stiffness=lossy, related=_refused)

        return replace(lossless, with_losses=with_losses) if motion == "bending_x" else lossless

    def _section(self, motion: Motion) -> Section:
        parts, known = self.parts, self._known(self.parts.middle)

        def work() -> Section:
            lossless, lost = known[0], loss_tensors(known[1])
            functions = section_functions(parts.middle, lossless, lost, motion, parts.share)
            return section_of(parts.middle, functions, lossless, lost, motion)

        return kept("section", (*known, parts.middle, parts.share, motion), _SECTION, work)

    def _end(self, motion: Motion, section: Section, *, is_foot: bool = False) -> ReducedEnd:
        parts, end = self.parts, self._ends[is_foot]
        return kept(
            "end",
            (end.lossless, end.lossy, end.bricks, is_foot, parts.middle, parts.share, motion),
            _END,
            lambda: end.reduced(motion, section.functions),
        )

    @cached_property
    def _ends(self) -> tuple[End, End]:
        """Tip and foot."""
        tip, foot = self.parts.tip, self.parts.foot
        return End(tip, False, *self._known(tip)), End(foot, True, *self._known(foot))

    def _known(self, bricks: Bricks) -> tuple[dict[str, Material], dict[str, Material]]:
        """Return the materials that bricks are of, without and with losses."""
        without, lossy = (
            {region: known[region] for region in bricks.regions}
            for known in (self.without, self.with_losses)
        )
        return without, lossy


def _refused(motion: Motion) -> NoReturn:
    raise ValueError(
        f"losses of the ends are known of the motions that ports drive only, not of {motion}"
    )


@dataclass(frozen=True)
class _Place:
    """Where what is: [shapes at the stretch's nodes, the foot's own fields, the tip's, ports]."""

    shapes: int
    nodes: int
    foot: ReducedEnd
    tip: ReducedEnd

    @property
    def size(self) -> int:
        """Number of unknowns less the ports."""
        return self.nodes * self.shapes + self.foot.own + self.tip.own

    @property
    def order(self) -> Ints:
        """A good order of elimination: upwards."""
        of_nodes = np.arange(self.nodes * self.shapes)
        own = of_nodes.size + np.arange(self.foot.own + self.tip.own)
        return np.concatenate([own[: self.foot.own], of_nodes, own[self.foot.own :]])

    def of(self, end: ReducedEnd) -> Ints:
        """Return the places of an end's [own fields, section, ports]."""
        above = end is self.tip
        own = self.nodes * self.shapes + (self.foot.own if above else 0) + np.arange(end.own)
        section = (self.nodes - 1 if above else 0) * self.shapes + np.arange(self.shapes)
        return np.concatenate([own, section, self.size + np.arange(PORTS)])

    def joined(self, stretch: Bordered, foot: Numbers, tip: Numbers) -> Bordered:
        """Return the sum of all parts, each over what it has to do with."""
        between = self.nodes * self.shapes
        border = np.zeros((self.size, PORTS), dtype=np.result_type(stretch.border, foot, tip))
        border[:between] = stretch.border
        corner = np.array(stretch.corner, dtype=border.dtype)
        of_ends = []
        for end, matrix in ((self.foot, foot), (self.tip, tip)):
            at = self.of(end)[:-PORTS]
            border[at] += matrix[:-PORTS, -PORTS:]
            corner = corner + matrix[-PORTS:, -PORTS:]
            rows, columns = np.meshgrid(at, at, indexing="ij")
            of_ends.append((matrix[:-PORTS, :-PORTS].ravel(), rows.ravel(), columns.ravel()))
        data, rows, columns = (np.concatenate(part) for part in zip(*of_ends, strict=True))
        shape = (self.size, self.size)
        starts = np.pad(stretch.inner.indptr, (0, self.size - between), mode="edge")
        inner = sparse.csr_matrix((stretch.inner.data, stretch.inner.indices, starts), shape=shape)
        inner = inner + sparse.csr_matrix((data, (rows, columns)), shape=shape)
        return Bordered(inner, border, corner)


def _rounding(stiffness: Sparse, place: _Place, section: Section) -> float:
    """Return the stiffness (N/m) by which rounding may change that of bending.

    All but the foot moves along an axis without a force; this is the sum of those that it seems
    to need.
    """
    unit = np.zeros(place.shapes, dtype=np.longdouble)
    unit[0] = section.functions.values[0::4, 0].sum()  # orthonormal: an amplitude of 1 along x
    moved = np.zeros(place.size, dtype=np.longdouble)
    moved[: place.nodes * place.shapes] = np.tile(unit, place.nodes)
    work = moved * wide_product(stiffness, moved).real
    # the lowest node is held by the foot
    return float(np.abs(work[place.shapes :]).sum())
