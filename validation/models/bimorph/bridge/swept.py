"""Why the beam's tip moves otherwise than the solid's at a frequency: the bridge's steps, driven.

Each model of the bridge is driven with its losses, under the scene's load and on its support, so
that what a step does to the stiffness, the resonance and the minima is in its share at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.fem.bimorph.ports import direct_multiport
from tactgen.fem.bimorph.solid import assemble
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.pieces import beam_pieces
from tactgen.tmm.beam.transfer import transfer_matrix
from tactgen.tmm.ports.multiport import Multiport, respond
from tactgen.tmm.ports.readout import ELECTRICAL
from tactgen.tmm.ports.terminations import attach
from tactgen.validation.models.bimorph.bridge.assumptions import solid_cases, with_energy_shear
from tactgen.validation.scene.scene import Scene


@dataclass(frozen=True)
class SweptStep:
    """One step of the bridge at n frequencies.

    Attributes
    ----------
    name : str
        As in the bridge.
    motion : (n,) array
        Size of the tip's displacement per volt after it (m).
    share : (n,) array
        What it adds to (beam / solid − 1); 0 of the first, which is the beam.
    """

    name: str
    motion: Floats
    share: Floats


def swept_bridge(
    scene: Scene, frequencies: Floats, announce: Callable[[str], None], *, level: int = 1
) -> list[SweptStep]:
    """Return the steps from the transfer-matrix model to the solid at `frequencies` (n,) in Hz.

    `scene` has a bimorph whose lower end is the base (no rod); `level` is that of the bricks.
    """
    found = [
        ("TMM", _tip(scene, _by_beam(scene, frequencies))),
        ("shear factor", _tip(scene, _by_beam(with_energy_shear(scene), frequencies))),
    ]
    for name, case in solid_cases(scene, level):
        announce(f"bridge at frequencies: {name}")
        system = assemble(
            case.scene.device,
            case.bricks(),
            lossy=True,
            ceramic=case.ceramic,
            uniform_field=case.uniform_field,
        )
        found.append((name, _tip(scene, direct_multiport(system, frequencies))))
    motions = [motion for _, motion in found]
    before = [motions[0], *motions[:-1]]
    return [
        SweptStep(name, motion, (last - motion) / motions[-1])
        for (name, motion), last in zip(found, before, strict=True)
    ]


def _by_beam(scene: Scene, frequencies: Floats) -> Multiport:
    row = [
        element
        for piece in beam_pieces(scene.device, scene.support)
        for element in transfer_matrix.elements(
            piece, scene.device, scene.beam, lossy=True, segments=transfer_matrix.SEGMENTS
        )
    ]
    return transfer_matrix.chain(row, frequencies)


def _tip(scene: Scene, port: Multiport) -> Floats:
    driven = respond(attach(port, scene.ends), {ELECTRICAL: 1.0})
    return np.abs(driven.motion["w_tip"])
