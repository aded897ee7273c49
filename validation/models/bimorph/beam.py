"""The beam-element model."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import CentreLine
from tactgen.tmm.ports.excitation_and_circuit import PortState
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.models.bimorph.model import BeamTheoryModel
from tactgen.validation.models.model import SAFETY, Modes, Refined, observed_factor

if TYPE_CHECKING:
    from tactgen.fem.beam import BeamMatrices

#: Elements are halved so many times: three meshes, of which the finest is the result.
_HALVINGS = 2
#: Order that is counted with at most.  Twice the elements' is what the energy's error goes to in
#: the limit (case BEAMO); with one wave in six elements it is between 7 and 10.
_ORDER = 8
#: Rounding is seen by summing and solving the finest elements again, in other units (N, C; not a
#: power of two, which would round alike) and with nodes by so much of an element elsewhere (what
#: their lengths are rounded to is alike in all units).  Twice the mean distance to four others
#: covers 98 of 100 errors if each of the five has its own.
_OTHERWISE, _OF_MEAN = ((1.1, 0.03), (1.3, -0.05), (1.7, 0.07), (1.9, -0.02)), 2.0
_SHARE = _OF_MEAN / len(_OTHERWISE)


class BeamModel(BeamTheoryModel):
    """Timoshenko beam elements of order five."""

    name = "beam"
    _METHOD = (
        "difference from half as many elements, gain in error as seen from a quarter of them to "
        f"half (at most {2**_ORDER}), safety factor {SAFETY}; and for rounding {_OF_MEAN:g} "
        f"times the mean distance to {len(_OTHERWISE)} evaluations in other units and nodes"
    )

    def mode_lines(self, *, open_circuit: bool) -> list[CentreLine]:
        """Centre lines of the modes, at the nodes of many elements."""
        from tactgen.fem import beam

        s = self.scene
        matrices = beam.assemble(s.device, s.support, s.beam, elements=beam.ELEMENTS, lossy=False)
        return beam.mode_lines(matrices, s.ends, s.modes, open_circuit=open_circuit)

    def driven_line(self, state: PortState) -> CentreLine:
        """Centre line between ports that move so."""
        from tactgen.fem import beam

        s, lossy = self.scene, state.frequency > 0.0
        number = max(beam.ELEMENTS, beam.elements_for(s.device, state.frequency))
        matrices = beam.assemble(s.device, s.support, s.beam, elements=number, lossy=lossy)
        return beam.driven_line(matrices, state)

    def _multiport(self, frequencies: Floats, *, lossy: bool) -> Refined[Multiport]:
        from tactgen.fem import beam

        number = beam.elements_for(self.scene.device, float(frequencies.max()))
        meshes = self._meshes(number, lossy=lossy, measured=True)
        others = self._rounded(number, lossy=lossy, measured=True)
        fine, middle, coarse = (beam.condense(matrices, frequencies) for matrices in meshes)
        size = np.sqrt(np.abs(np.einsum("nii->ni", fine.stiffness)).max(axis=0))
        before, last = (
            (np.abs(one.stiffness - other.stiffness) / np.outer(size, size)).max()
            for one, other in ((middle, coarse), (fine, middle))
        )
        factor = float(observed_factor(before, last, _ORDER))
        rounded = ((beam.condense(other, frequencies), _SHARE) for other in others)
        return Refined(fine, ((middle, factor), *rounded), self._METHOD, rounds_apart=True)

    def _modes(self, *, open_circuit: bool) -> Refined[Modes]:
        from tactgen.fem import beam

        s = self.scene
        number = 12 + 2 * s.modes

        def found(matrices: BeamMatrices) -> Floats:
            return beam.bending_frequencies(matrices, s.ends, s.modes, open_circuit=open_circuit)

        fine, middle, coarse = map(found, self._meshes(number, lossy=False))
        last = middle - fine
        factor = observed_factor(np.abs(coarse - middle), np.abs(last), _ORDER)
        others = map(found, self._rounded(number, lossy=False))
        classes = ("bending_x",) * fine.size
        coarser = [(fine + factor * last, 1.0), *((other, _SHARE) for other in others)]
        judges = tuple((Modes(judge, classes), share) for judge, share in coarser)
        return Refined(Modes(fine, classes), judges, self._METHOD)

    def _meshes(self, number: int, **how: bool) -> list[BeamMatrices]:
        """About `number` elements along the row, half of them and a quarter."""
        each = range(_HALVINGS, -1, -1)
        return [self._assembled(number, halvings=halvings, **how) for halvings in each]

    def _rounded(self, number: int, **how: bool) -> Iterator[BeamMatrices]:
        """Finest elements again, each time in other units and a little elsewhere."""
        for unit, shift in _OTHERWISE:
            yield self._assembled(number, halvings=_HALVINGS, unit=unit, shift=shift, **how)

    def _assembled(
        self, number: int, *, halvings: int, unit: float = 1.0, shift: float = 0.0, **how: bool
    ) -> BeamMatrices:
        from tactgen.fem import beam

        s, coarsest = self.scene, math.ceil(number / 2**_HALVINGS)
        parts = s.device, s.support, s.beam
        settings: dict[str, Any] = {"halvings": halvings, "unit": unit, "shift": shift} | how
        return beam.assemble(*parts, elements=coarsest, **settings)
