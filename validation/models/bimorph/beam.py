"""The beam-element model."""

from __future__ import annotations

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.row_shape import CentreLine
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.engine.model import Modes, Refined
from tactgen.validation.models.bimorph.model import BeamTheoryModel


class BeamModel(BeamTheoryModel):
    """Timoshenko beam elements of order five."""

    name = "beam"
    _METHOD = (
        "difference from half as many elements (it bounds that mesh's error), and rounding of "
        "the elimination of inner unknowns"
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

        s = self.scene
        n = beam.elements_for(s.device, float(frequencies.max()))
        levels = [
            beam.assemble(s.device, s.support, s.beam, elements=e, lossy=lossy) for e in (n, n // 2)
        ]
        fine, coarse = (beam.condense(matrices, frequencies) for matrices in levels)
        elimination = beam.inner_condition(levels[0])
        return Refined(fine, ((coarse, 1.0),), self._METHOD, elimination=elimination)

    def _modes(self, *, open_circuit: bool) -> Refined[Modes]:
        from tactgen.fem.beam import beam

        s = self.scene
        n = 12 + 2 * s.modes
        (fine, rounding), (coarse, _) = (
            beam.bending_frequencies(
                beam.assemble(s.device, s.support, s.beam, elements=e, lossy=False),
                s.ends,
                s.modes,
                open_circuit=open_circuit,
            )
            for e in (n, n // 2)
        )
        classes = ("bending_x",) * fine.size
        judge = (Modes(coarse, classes), 1.0)
        return Refined(Modes(fine, classes), (judge,), self._METHOD, rounding)
