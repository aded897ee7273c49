"""A modelled curve as a function of a scene's parameters: direct, fast, differentiable.

By the transfer-matrix model, with everything attached to its ports, past the machinery of
stages and error bars that a single answer goes through.  A curve of the machine is that model on
its rod, coil and contact in small motions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.tmm.beam.transfer_matrix import multiport
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import Multiport, in_series
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout
from tactgen.validation.engine.model import Refined
from tactgen.validation.scene.keys import with_values
from tactgen.validation.scene.scene import Scene

#: What the bimorph is made of.  All else acts through its ports' terminations: D(Ω) does not
#: depend on it.
_DIVIDED = ("bimorph.", "piezo.", "shim.", "glue.", "beam.", "rod.")
#: Step in ln p for sensitivities: truncation and rounding are then both below 1e-6.
_STEP = 1e-4


@dataclass(frozen=True)
class CurveModel:
    """The modelled curve as a function of some parameters' values.

    Attributes
    ----------
    scene : Scene
        Everything that is not varied.
    quantity : str
        Name of one that is read off the ports, or off the machine in small motions.
    frequencies : (n,) array
        Hz.
    keys : tuple of str
        Scene keys of the varied parameters.
    port : Multiport or None
        D(Ω), if none of the keys changes it.
    """

    scene: Scene
    quantity: str
    frequencies: Floats
    keys: tuple[str, ...]
    port: Multiport | None

    def __call__(self, values: Floats) -> Complex:
        """Return the curve (n,) for values (p,) in SI units."""
        scene = with_values(self.scene, dict(zip(self.keys, map(float, values), strict=True)))
        f = self.frequencies
        port = self.port if self.port is not None else _port(scene, f)
        row = QUANTITIES[self.quantity]
        if isinstance(row.read, AnswerReadout):
            return _of_machine(scene, port, row.read)
        wired = in_series(port) if scene.bimorph.wiring == "series" else port
        return row.port_readout.read(attach(wired, scene.ends), scene.drive.voltage)

    def thinned(self, most: int) -> tuple[CurveModel, Ints]:
        """Return the model at no more than `most` of its frequencies, and their positions."""
        n = self.frequencies.size
        at = np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(int))
        f = self.frequencies[at]
        port = None
        if self.port is not None:
            port = replace(self.port, frequencies=f, stiffness=self.port.stiffness[at])
        return replace(self, frequencies=f, port=port), at


def curve_model(
    scene: Scene, quantity: str, frequencies: Floats, keys: Sequence[str]
) -> CurveModel:
    """Return the model of a curve; D(Ω) is computed once if the keys leave it as it is."""
    fixed = not any(key.startswith(_DIVIDED) for key in keys)
    port = _port(scene, frequencies) if fixed else None
    return CurveModel(scene, quantity, frequencies, tuple(keys), port)


def _port(scene: Scene, frequencies: Floats) -> Multiport:
    return multiport(scene.device, scene.support, scene.beam, frequencies)


def _of_machine(scene: Scene, port: Multiport, read: AnswerReadout) -> Complex:
    from tactgen.validation.models.generator.judged_rod import JudgedRod, rod_of
    from tactgen.validation.models.generator.small_signal import SmallSignal

    rod = JudgedRod(rod_of(scene, scene.pull))
    value: Complex = read.of(SmallSignal(scene, Refined(port, (), ""), rod)).value
    return value


def sensitivities(model: CurveModel, values: Floats) -> Complex:
    """Return ∂ ln(curve) / ∂ ln(parameter), shape (n, p), by central differences."""
    columns = []
    for i in range(values.size):
        up, down = values.copy(), values.copy()
        up[i] *= np.exp(_STEP)
        down[i] *= np.exp(-_STEP)
        above, below = model(up), model(down)
        if np.array_equal(above, below):  # no effect at all: no rounding of the logarithm either
            columns.append(np.zeros(above.shape, dtype=complex))
        else:
            columns.append(np.log(above / below) / (2.0 * _STEP))
    return np.stack(columns, axis=1)
