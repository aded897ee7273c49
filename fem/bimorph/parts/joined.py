"""The solid in two parts as one system: a foot that is kept, and the free part on its bricks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from tactgen.fem.bimorph.bordered import PORTS, Bordered
from tactgen.fem.bimorph.bricks.assembly import quarter_matrices, tip_functionals, whole_nodes
from tactgen.fem.bimorph.bricks.order import elimination_order
from tactgen.fem.bimorph.motions import Motion
from tactgen.fem.bimorph.parts.foot import Foot, ReducedFoot, joined_unknowns
from tactgen.fem.bimorph.symmetry import lumped
from tactgen.fem.bimorph.system import Material, SolidSystem, materials, volts_per_unit
from tactgen.geometry.arrays import Bools, Floats, Numbers, Sparse
from tactgen.geometry.bimorph.brick_parts import BrickParts
from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.store.store import kept

#: What makes a reduced foot.
_MADE_OF = ("tactgen.fem.bimorph.parts.foot",)


def joined_system(
    device: Device,
    parts: BrickParts,
    *,
    lossy: bool,
    ceramic: Piezoceramic | None = None,
    motion: Motion = "bending_x",
) -> SolidSystem:
    """Assemble one class of motion of the bimorph in two parts.

    Its nodes are those of the free part, which is where modes are told apart; the foot is a few
    hundred unknowns more, from the store if it was reduced before.

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
    return _Joined(Foot(parts, without, with_losses), with_losses if lossy else without).system(
        motion
    )


@dataclass(frozen=True)
class _Joined:
    """The two parts before they are held anywhere; `known` are the materials of the free part."""

    foot: Foot
    known: dict[str, Material]

    @cached_property
    def matrices(self) -> tuple[Sparse, Sparse]:
        """Stiffness and mass of the free part."""
        bricks = self.foot.parts.free
        own = {region: self.known[region] for region in bricks.regions}
        return quarter_matrices(bricks, own, volts_per_unit(self.known))

    def system(self, motion: Motion) -> SolidSystem:
        """Return the system of one class of motion, of the whole body."""
        bricks, unit = self.foot.parts.free, volts_per_unit(self.known)
        foot = self._reduced(motion)
        stiffness, mass = self.matrices
        unknowns = joined_unknowns(bricks, motion, unit, foot.section, top=False)
        nodes, expand, node_mass = whole_nodes(bricks, unknowns, motion, unit, lumped(mass))
        at, own, shapes = unknowns.index, foot.own, foot.section.shape[1]
        order = np.argsort(4 * elimination_order(bricks)[at // 4] + at % 4)
        seen = unknowns.seen(tip_functionals(bricks))
        nothing = sparse.csr_matrix((expand.shape[0], own))
        lossy = self.known is self.foot.lossy
        if lossy and motion != "bending_x":
            raise ValueError("losses of the foot are known of the motions that ports drive only")
        small = foot.stiffness + foot.losses if lossy else foot.stiffness
        return SolidSystem(
            stiffness=_joined(unknowns.bordered(stiffness), foot, small),
            mass=_joined(unknowns.bordered(mass), foot, foot.mass),
            tip=np.vstack([seen[:-PORTS], np.zeros((own, 2)), seen[-PORTS:]]),
            expand=sparse.hstack([expand[:, :-PORTS], nothing, expand[:, -PORTS:]], format="csr"),
            nodes=nodes,
            node_mass=node_mass,
            potentials=int(unknowns.free[:, 3].sum()) + foot.charged + shapes - foot.section_moving,
            volts_per_unit=unit,
            motion=motion,
            related=self.system,
            elimination=np.concatenate([order, at.size + np.arange(shapes + own)]),
            translation=_translation(at % 4 == 0, foot),
        )

    def _reduced(self, motion: Motion) -> ReducedFoot:
        foot, parts = self.foot, self.foot.parts
        return kept(
            "foot",
            (foot.lossless, foot.lossy, parts.foot, parts.middle, parts.share, motion),
            _MADE_OF,
            lambda: foot.reduced(motion),
        )


def _translation(along_x: Bools, foot: ReducedFoot) -> Floats:
    """Return a translation in x of free part and section; the foot's own fields are no part."""
    shapes = foot.section[0::4].sum(axis=0)  # orthonormal, so these are the amplitudes
    return np.concatenate([along_x, shapes, np.zeros(foot.own + PORTS)])


def _joined(free: Bordered, foot: ReducedFoot, small: Floats | Numbers) -> Bordered:
    """Add the foot's small matrix to the free part's, over [free, section, foot's own, ports]."""
    own, shapes = foot.own, foot.section.shape[1]
    n = free.inner.shape[0]
    # section and ports after the foot's own fields, there and here
    both = np.array(small, dtype=np.result_type(small, free.corner))
    both[own:, own:] += free.corner
    at = np.concatenate([own + np.arange(shapes), np.arange(own)])
    ports = own + shapes + np.arange(PORTS)
    added = sparse.csr_matrix(both[np.ix_(at, at)])
    across = sparse.hstack(
        [sparse.csr_matrix(free.border[:, :shapes]), sparse.csr_matrix((n, own))], format="csr"
    )
    inner = sparse.bmat([[free.inner, across], [across.T, added]], format="csr")
    inner.sort_indices()
    return Bordered(
        inner,
        np.vstack([free.border[:, shapes:], both[np.ix_(at, ports)]]),
        both[np.ix_(ports, ports)],
    )
