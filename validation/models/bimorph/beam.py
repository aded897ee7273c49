"""The beam-element model."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.engine.model import Modes, Refined
from tactgen.validation.models.bimorph.model import BimorphModel


class BeamModel(BimorphModel):
    """Timoshenko beam elements of order five."""

    name = "beam"
    _METHOD = (
        "difference from half as many elements (it bounds that mesh's error), and rounding of "
        "the elimination of inner unknowns"
    )

    def ports(self) -> Refined[Multiport]:
        """Return D(Ω) with losses over the scene's frequencies."""
        return self.run("ports", lambda: self._refined(self.frequencies, lossy=True))

    def static(self) -> Refined[Multiport]:
        """Return the lossless D(0)."""
        return self.run("static", lambda: self._refined(np.zeros(1), lossy=False))

    def _refined(self, frequencies: Floats, *, lossy: bool) -> Refined[Multiport]:
        from tactgen.fem.beam import beam

        s = self.scene
        n = beam.elements_for(s.device, float(frequencies.max()))
        levels = [
            beam.assemble(s.device, s.support, s.beam, elements=e, lossy=lossy) for e in (n, n // 2)
        ]
        fine, coarse = (beam.condense(matrices, frequencies) for matrices in levels)
        elimination = beam.inner_condition(levels[0])
        return Refined(fine, ((coarse, 1.0),), self._METHOD, elimination=elimination)

    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Return the lossless modes."""
        short, opened = self.run("modes", self._both_modes)
        return opened if open_circuit else short

    def _both_modes(self) -> tuple[Refined[Modes], ...]:
        from tactgen.fem.beam import beam

        s = self.scene
        n = 12 + 2 * s.modes
        levels = [
            beam.assemble(s.device, s.support, s.beam, elements=e, lossy=False) for e in (n, n // 2)
        ]
        out = []
        for circuit in (False, True):
            (fine, rounding), (coarse, _) = (
                beam.bending_frequencies(matrices, s.ends, s.modes, open_circuit=circuit)
                for matrices in levels
            )
            classes = ("bending_x",) * fine.size
            out.append(
                Refined(
                    Modes(fine, classes),
                    ((Modes(coarse, classes), 1.0),),
                    self._METHOD,
                    rounding,
                )
            )
        return tuple(out)
