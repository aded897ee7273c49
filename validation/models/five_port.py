"""The five-port of a scene's bimorph at whatever frequencies are asked for, by a named model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.multiport import Multiport, in_series
from tactgen.validation.scene.scene import Scene

FivePort = Callable[[Floats], Multiport]


def five_port(scene: Scene, model: str) -> FivePort:
    """Bimorph over its ports, with losses and wired as it is, support and load apart.

    Returns
    -------
    callable
        From frequencies (n,) in Hz.  A solid is reduced for the scene's frequencies and their
        lower harmonics.

    Raises InputError if it is no model of the lateral actuator.
    """
    makers = {"tmm": _row, "lumped": _row, "beam": _beam, "solid": _solid, "cad": _solid}
    if model not in makers:
        raise InputError(f'model "{model}" has no ports; use one of {", ".join(makers)}')
    made = makers[model](scene, model)
    if scene.bimorph.wiring == "series":
        return lambda frequencies: in_series(made(frequencies))
    return made


def _row(scene: Scene, model: str) -> FivePort:
    from tactgen.tmm.beam import lumped, transfer_matrix

    if model == "lumped":
        return lambda f: lumped.multiport(scene.device, scene.support, scene.beam, f, lossy=True)
    row = transfer_matrix.sections(scene.device, scene.support, scene.beam, lossy=True)
    return lambda f: transfer_matrix.chain(row, f)


def _beam(scene: Scene, _: str) -> FivePort:
    from tactgen.fem import beam

    count = beam.elements_for(scene.device, _highest(scene))
    matrices = beam.assemble(scene.device, scene.support, scene.beam, elements=count, lossy=True)
    return lambda frequencies: beam.condense(matrices, frequencies)


def _solid(scene: Scene, model: str) -> FivePort:
    from tactgen.fem.piezo.reduction_files import reduced_solid
    from tactgen.validation.models.bimorph.solid import mesh_pair

    # any support: the ports know none
    free = scene.model_copy(
        update={"support": scene.support.model_copy(update={"kind": "clamped"}), "models": (model,)}
    )
    mesh = mesh_pair(free).meshes[0]
    reach = np.array([0.0, _highest(scene)])
    tolerance = 1e-3 * scene.accuracy
    reduced = reduced_solid(scene.device, mesh, reach, tolerance=tolerance)
    return reduced.multiport


#: Harmonics of the highest frequency at which a model must still be right.
_HARMONICS = 5


def _highest(scene: Scene) -> float:
    return _HARMONICS * max(scene.frequency)
