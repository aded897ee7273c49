"""The beam-element model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.row_shape import CentreLine
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.engine.model import Modes, Refined
from tactgen.validation.engine.refinement import SAFETY, observed_factor
from tactgen.validation.models.bimorph.model import BeamTheoryModel

if TYPE_CHECKING:
    from tactgen.fem.beam.beam import BeamMatrices

#: Elements are halved so many times: three meshes, of which the finest is the result.
_HALVINGS = 2
#: Order that is counted with at most.  Twice the elements' is what the energy's error goes to in
#: the limit; with one wave in six elements it is between 7 and 10 (tests/fem/beam/test_beam.py).
_ORDER = 8


class BeamModel(BeamTheoryModel):
    """Timoshenko beam elements of order five."""

    name = "beam"
    _METHOD = (
        "difference from half as many elements, gain in error as seen from a quarter of them to "
        f"half (at most {2**_ORDER}), safety factor {SAFETY}; and rounding of the elimination of "
        "inner unknowns"
    )

    def mode_lines(self, *, open_circuit: bool) -> list[CentreLine]:
        """Return the centre lines of the modes, at the nodes of many elements."""
        from tactgen.fem.beam import beam, shapes

        s = self.scene
        matrices = beam.assemble(s.device, s.support, s.beam, elements=shapes.ELEMENTS, lossy=False)
        return shapes.mode_lines(matrices, s.ends, s.modes, open_circuit=open_circuit)

    def driven_line(self, frequency: float, voltage: float, *, lossy: bool) -> CentreLine:
        """Return the centre line at a frequency and a voltage across each layer."""
        from tactgen.fem.beam import beam, shapes

        s = self.scene
        number = max(shapes.ELEMENTS, beam.elements_for(s.device, frequency))
        matrices = beam.assemble(s.device, s.support, s.beam, elements=number, lossy=lossy)
        ends = s.ends if lossy else s.ends.lossless
        return shapes.driven_line(matrices, ends, frequency, voltage)

    def _multiport(self, frequencies: Floats, *, lossy: bool) -> Refined[Multiport]:
        from tactgen.fem.beam import beam

        number = beam.elements_for(self.scene.device, float(frequencies.max()))
        meshes = self._meshes(number, lossy=lossy)
        fine, middle, coarse = (beam.condense(matrices, frequencies) for matrices in meshes)
        size = np.sqrt(np.abs(np.einsum("nii->ni", fine.stiffness)).max(axis=0))
        before, last = (
            (np.abs(one.stiffness - other.stiffness) / np.outer(size, size)).max()
            for one, other in ((middle, coarse), (fine, middle))
        )
        factor = float(observed_factor(before, last, _ORDER))
        elimination = beam.inner_condition(meshes[0])
        return Refined(fine, ((middle, factor),), self._METHOD, elimination=elimination)

    def _modes(self, *, open_circuit: bool) -> Refined[Modes]:
        from tactgen.fem.beam import beam

        s = self.scene
        (fine, rounding), (middle, _), (coarse, _) = (
            beam.bending_frequencies(matrices, s.ends, s.modes, open_circuit=open_circuit)
            for matrices in self._meshes(12 + 2 * s.modes, lossy=False)
        )
        last = middle - fine
        factor = observed_factor(np.abs(coarse - middle), np.abs(last), _ORDER)
        classes = ("bending_x",) * fine.size
        judge = (Modes(fine + factor * last, classes), 1.0)
        return Refined(Modes(fine, classes), (judge,), self._METHOD, rounding)

    def _meshes(self, number: int, *, lossy: bool) -> list[BeamMatrices]:
        """Return about `number` elements along the row, half of them and a quarter."""
        from tactgen.fem.beam import beam

        s = self.scene
        return [
            beam.assemble(
                s.device, s.support, s.beam,
                elements=number // 2**_HALVINGS, halvings=halvings, lossy=lossy,
            )
            for halvings in range(_HALVINGS, -1, -1)
        ]  # fmt: skip
