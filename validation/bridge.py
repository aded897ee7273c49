"""From the transfer-matrix model to the solid, one assumption at a time, in percent.

Each rung changes one thing; what a theory predicts for a rung stands beside what is
measured, and the rest is shown as unexplained rather than absorbed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fem.piezo_solid import assemble
from fem.solid_response import Attachment, natural_modes, static_multiport
from geometry.beam_pieces import Piece
from geometry.materials import Piezoceramic
from geometry.mesh import Mesh
from tmm import transfer_matrix
from tmm.laminate import static_response
from tmm.modes import Fixture, bending_frequencies
from tmm.multiport import respond
from tmm.section import section
from tmm.terminations import static_termination
from validation.models import SolidModel
from validation.scene import Scene


@dataclass(frozen=True)
class Rung:
    """One step of the bridge: values and their change from the rung before.

    `predicted` holds the changes (fractions; deflection, frequency, capacitance) that
    a closed form gives, nan where none is known.
    """

    name: str
    what: str
    deflection: float
    first_frequency: float
    capacitance: float
    predicted: tuple[float, float, float] = (np.nan, np.nan, np.nan)
    theory: str = ""


def bridge(scene: Scene, solid: SolidModel, announce: Callable[[str], None]) -> list[Rung]:
    """Return the rungs from TMM to the scene's solid, on the solid's coarser mesh.

    All values are those of the tip per drive voltage, statically free, and the first
    short-circuit bending mode on the scene's support.
    """
    mesh = solid.meshes()[1]
    announce("bridge: beam-like solid")
    beam_like = _solid_values(_beam_like_scene(scene), mesh, _beam_like(scene.piezo.ceramic()))
    announce("bridge: full solid")
    full = _solid_values(scene, mesh, None)
    return [
        Rung("TMM", "exact Timoshenko beam, uniform field in each layer", *_tmm_values(scene)),
        Rung(
            "beam-like solid",
            "3D field with constants that couple only along the beam (no Poisson effect, no d32, "
            "d33, d15): the field now varies through each layer, shear is not averaged, and the "
            "base section stays plane",
            *beam_like,
            predicted=_field_variation(scene),
            theory="each layer's own bending stiffened by 1/(1 - k31^2)",
        ),
        Rung(
            "solid",
            "the full tensors: Poisson's effect and d32 across the width, clamping of the width "
            "at the base",
            *full,
            predicted=_width(scene, beam_like),
            theory=(
                "laminate theory of a wide plate; the free side edges of a bimorph only "
                f"{scene.bimorph.width / scene.bimorph.thickness:.1f} thicknesses wide take part "
                "of it back"
            ),
        ),
    ]


def _tmm_values(scene: Scene) -> tuple[float, float, float]:
    port = transfer_matrix.multiport(
        scene.device, scene.support, scene.beam, np.zeros(1), lossy=False
    )
    response = respond(port, static_termination(scene.support, scene.load), 1.0)
    pieces = transfer_matrix.sections(scene.device, scene.support, scene.beam, lossy=False)
    clamped = scene.support.kind != "spring"
    fixture = Fixture(clamped, *((0.0, 0.0, 0.0) if clamped else _springs(scene)))
    first = bending_frequencies(pieces, fixture, 1, open_circuit=False)[0]
    return float(response.w_tip[0].real), float(first), float(response.charge[0].real)


def _springs(scene: Scene) -> tuple[float, float, float]:
    support = scene.support
    return support.lateral_stiffness, support.rotational_stiffness, support.rotational_inertia


def _solid_values(
    scene: Scene, mesh: Mesh, ceramic: Piezoceramic | None
) -> tuple[float, float, float]:
    system = assemble(scene.device, mesh, lossy=False, ceramic=ceramic)
    end = static_termination(scene.support, scene.load)
    response = respond(static_multiport(system), end, 1.0)
    attachment = Attachment(None if scene.support.kind != "spring" else _springs(scene))
    modes = natural_modes(system, attachment, 3)
    first = next(mode.frequency for mode in modes if mode.kind == "bending_x")
    return float(response.w_tip[0].real), first, float(response.charge[0].real)


def _beam_like(ceramic: Piezoceramic) -> Piezoceramic:
    """Return the ceramic with everything off that a beam theory does not know."""
    s = np.diag(np.diag(ceramic.s))
    d = np.zeros((3, 6))
    d[2, 0] = ceramic.d[2, 0]
    return replace(ceramic, s=s, d=d)


def _beam_like_scene(scene: Scene) -> Scene:
    """Return the scene with the shim's Poisson effect off."""
    shim = scene.shim.model_copy(update={"poisson_ratio": 0.0})
    return scene.model_copy(update={"shim": shim})


def _field_variation(scene: Scene) -> tuple[float, float, float]:
    """Predict the effect of the field's variation through each layer.

    Bending makes d31 polarisation vary linearly through a layer; with no free charge
    inside, the field follows it and stiffens each layer's bending about its own middle
    by 1 / (1 - k31^2).  Deflection and the bending part of the capacitance fall with EI;
    the frequency follows EI alone only on a clamp.
    """
    piezo, bimorph = scene.piezo, scene.bimorph
    length = bimorph.length
    ceramic = section(Piece("bimorph", length), scene.device, scene.beam, lossy=False)
    stiffness = complex(ceramic.EI).real
    k2 = piezo.d31**2 / (piezo.s11 * scene.device.piezo.ceramic().eps_t[2, 2])
    own = 2.0 * bimorph.width * bimorph.piezo_thickness**3 / (12.0 * piezo.s11)
    ratio = 1.0 + own * k2 / (1.0 - k2) / stiffness
    bending = complex(ceramic.K).real ** 2 * length / stiffness
    total = complex(ceramic.C).real * length + bending
    frequency = np.sqrt(ratio) - 1.0 if scene.support.kind == "clamped" else np.nan
    loss = 1.0 / ratio - 1.0
    return loss, float(frequency), loss * bending / total


def _width(scene: Scene, before: tuple[float, float, float]) -> tuple[float, float, float]:
    """Predict the effect of the width by laminate theory, for a bimorph without a tab."""
    if scene.bimorph.tab_length > 0.0:
        return np.nan, np.nan, np.nan
    plate = static_response(scene.device)
    return plate.tip_displacement / before[0] - 1.0, np.nan, plate.capacitance / before[2] - 1.0
