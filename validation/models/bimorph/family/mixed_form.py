"""D of many members at many frequencies in mixed form, and what its entries may be off by.

A reduced basis answers base motion, voltage and tip forces; the error of what one of these does
to another is at most the product of two norms.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.answers import family_statics
from tactgen.fem.bimorph.reduction.parametric.harmonic import family_harmonic
from tactgen.fem.bimorph.reduction.parametric.reduced import Members
from tactgen.fem.piezo.ports import ports_from_blocks
from tactgen.geometry.arrays import Complex, Floats
from tactgen.tmm.ports.multiport import Multiport
from tactgen.tmm.ports.port import BIMORPH

#: Number of (w_base, ψ_base, U), before the tip's force and moment.
_SOURCES = 3


@dataclass(frozen=True)
class MixedForm:
    """D of n members at f frequencies, one row for each (n f,), frequencies running fastest.

    Attributes
    ----------
    frequencies : (n f,) array
        In Hz.
    held, through, follows, compliance : (n f, 3, 3), (n f, 3, 2), (n f, 2, 3), (n f, 2, 2)
        See :func:`fem.piezo.ports.ports_from_blocks`.
    missing : (n f, 5) array
        Norms whose products bound the errors of the entries.
    """

    frequencies: Floats
    held: Complex
    through: Complex
    follows: Complex
    compliance: Complex
    missing: Floats

    @classmethod
    def static(cls, members: Members) -> MixedForm:
        """Return D(0) of members without losses."""
        found = family_statics(members)
        count = found.missing.shape[0]
        missing = np.zeros((count, 5))
        missing[:, _SOURCES - 1 :] = found.missing
        return cls(
            np.zeros(count), found.held, found.through, found.follows, found.compliance, missing
        )

    @classmethod
    def harmonic(cls, members: Members, frequencies: Floats) -> MixedForm:
        """Return D(Ω) of members at frequencies (f,) in Hz."""
        found = family_harmonic(members, frequencies)
        parts = (found.held, found.through, found.follows, found.compliance, found.missing)
        flat: Any = (part.reshape(-1, *part.shape[2:]) for part in parts)
        return cls(np.tile(frequencies, found.missing.shape[0]), *flat)

    @property
    def port(self) -> Multiport:
        """The five-port."""
        stiffness = ports_from_blocks(self.held, self.through, self.follows, self.compliance)
        return Multiport(self.frequencies, stiffness, BIMORPH)

    @property
    def work(self) -> Floats:
        """Charge per volt, and tip motion per force and moment (n f, 3), at rest."""
        own = np.einsum("nii->ni", self.compliance)
        return np.asarray(np.column_stack([-self.held[:, 2, 2], own]).real)

    def richer(self, more: Floats) -> MixedForm:
        """Return the form with what a volt, a force and a moment do besides (n f, 3, 3)."""
        held, through = self.held.copy(), self.through.copy()
        follows = self.follows.copy()
        held[:, 2, 2] -= more[:, 0, 0]
        through[:, 2] -= more[:, 0, 1:]
        follows[:, :, 2] += more[:, 1:, 0]
        compliance = self.compliance + more[:, 1:, 1:]
        return replace(self, held=held, through=through, follows=follows, compliance=compliance)

    @property
    def changed(self) -> Iterator[MixedForm]:
        """Each form in which one entry, and what mirrors it, is moved by its bound."""
        for i, j in itertools.combinations_with_replacement(range(5), 2):
            size = self.missing[:, i] * self.missing[:, j]
            if size.any():
                yield self._moved(i, j, size)

    def _moved(self, i: int, j: int, size: Floats) -> MixedForm:
        held, through = self.held.copy(), self.through.copy()
        follows, compliance = self.follows.copy(), self.compliance.copy()
        tip = j - _SOURCES
        if j < _SOURCES:
            held[:, i, j] -= size
            held[:, j, i] = held[:, i, j]
        elif i < _SOURCES:
            follows[:, tip, i] += size
            through[:, i, tip] -= size
        else:
            compliance[:, i - _SOURCES, tip] += size
            compliance[:, tip, i - _SOURCES] = compliance[:, i - _SOURCES, tip]
        return replace(self, held=held, through=through, follows=follows, compliance=compliance)
