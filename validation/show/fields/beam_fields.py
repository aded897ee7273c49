"""Fields of the beam theories: their centre line on the solid shape of the row."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.bimorph.pieces import CentreLine, RowShape, beam_pieces, row_shape
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.models.bimorph.model import BeamTheoryModel
from tactgen.validation.show.fields.result import MODE_SIZE
from tactgen.validation.show.fields.solid_fields import Found


class RowFields:
    """The states of a beam theory: displacement and potential, at points of one mesh."""

    def __init__(self, model: BeamTheoryModel) -> None:
        self._model = model
        scene = model.scene
        rod = scene.support.kind == "rod"
        base = scene.device.ceramic_base if rod else scene.bimorph.tab_length
        lines = model.mode_lines(open_circuit=False)
        pieces = beam_pieces(scene.device, scene.support)
        top = base + scene.bimorph.length
        self._shape: RowShape = row_shape(pieces, scene.bimorph, lines[0].z, top)
        self._short = lines

    @property
    def mesh(self) -> Mesh:
        """The points and cells."""
        return self._shape.mesh

    def modes(self, count: int, *, open_circuit: bool) -> list[tuple[str, Found]]:
        """Class and fields of the lowest `count` modes, ascending."""
        lines = self._model.mode_lines(open_circuit=True) if open_circuit else self._short
        out = []
        for line in lines[:count]:
            values = self._shape.values(line)
            size = float(np.linalg.norm(values[:, :3], axis=1).max())
            out.append(("bending_x", self._found(line, MODE_SIZE / size)))
        return out

    def static(self, voltage: float) -> Found:
        """Lossless fields at rest under a voltage (V) across each layer."""
        fields, tip, charge = self._found(self._model.driven_line(0.0, voltage, lossy=False))
        real = {name: np.real(values) for name, values in fields.items()}
        return real, tip.real, charge.real

    def harmonic(self, frequency: float, voltage: float) -> Found:
        """Fields with losses at a frequency (Hz) and voltage (V) across each layer."""
        return self._found(self._model.driven_line(frequency, voltage, lossy=True))

    def _found(self, line: CentreLine, factor: float = 1.0) -> Found:
        values = factor * self._shape.values(line)
        fields = {"displacement": values[:, :3], "potential": values[:, 3]}
        return fields, factor * line.tip, factor * line.charge
