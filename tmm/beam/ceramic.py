"""What the ceramic of a driven bimorph carries: bending stress, field and current per volt.

Plane sections: in a layer at the distance x from the middle the axial stress is

    σ = Y (x ψ' − d31 E),   with   EI ψ' = M + K U,

where the bending moment M(z) follows from what is above z alone: the tip's motion, its load, the
voltage and the inertia between.  So the tip's state by any model tells it, whatever holds the
base.  Stress concentrations at the ceramic's root, where a solid's stress is singular, are no
part of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.ends import Ends
from tactgen.geometry.bimorph.pieces import Piece
from tactgen.geometry.device.checks import beyond_plain_layers
from tactgen.geometry.device.parameters import Beam, Device
from tactgen.tmm.beam.section.section import section
from tactgen.tmm.beam.transfer.timoshenko import dynamic_stiffness, wavenumbers
from tactgen.tmm.ports.multiport import Response
from tactgen.tmm.ports.terminations import tip_stiffness

#: Heights at which the stress is looked for, as shares of the ceramic's length from its root: a
#: mode of order n has its largest curvature within a tenth of a wave of one of them up to n = 5.
_HEIGHTS = np.linspace(0.0, 0.95, 20)
#: Where bending waves decay by more than this exponent along the ceramic, its root cannot be told
#: from its tip: e^20 leaves seven of sixteen digits.
_DECAY = 20.0
#: Frequencies at which all heights are worked out at once: some megabytes.
_AT_ONCE = 500


@dataclass(frozen=True)
class DrivenCeramic:
    """Per volt of the drive, peak amplitudes, (n,) over the frequencies.

    Attributes
    ----------
    stress : (n,) float
        Largest axial stress along the ceramic, at the faces of its layers (Pa/V); nan where the
        layers are not plain and uniform, and where bending waves die out along the ceramic.
    field : float
        Field in a layer (1/m).
    current : (n,) float
        Drawn by one bimorph (A/V).
    """

    stress: Floats
    field: float
    current: Floats


def driven_ceramic(
    device: Device, beam: Beam, ends: Ends, frequencies: Floats, response: Response
) -> DrivenCeramic:
    """Return what the ceramic carries, from the tip's motion and the charge at 1 V as wired.

    Parameters
    ----------
    frequencies : (n,) float
        Hz.
    response : Response
        Motions `w_tip`, `psi_tip` (m, rad) and effort `voltage` (C) of the terminated actuator.
    """
    bimorph = device.bimorph
    layer = 0.5 if bimorph.wiring == "series" else 1.0
    charge = response.effort["voltage"]
    return DrivenCeramic(
        stress=_stress(device, beam, ends, frequencies, response, layer),
        field=layer / bimorph.piezo_thickness,
        current=np.abs(2.0 * np.pi * frequencies * charge),
    )


def _stress(
    device: Device, beam: Beam, ends: Ends, frequencies: Floats, response: Response, layer: float
) -> Floats:
    """Return the largest stress over height and faces (n,), Pa per volt of the drive."""
    b = device.bimorph
    key = beyond_plain_layers(b)
    if key and key != "glue_thickness":
        return np.full(frequencies.shape, np.nan)
    cross = section(Piece("bimorph", b.length), device, beam, lossy=True)
    omega = 2.0 * np.pi * frequencies
    known = np.flatnonzero(wavenumbers(cross, b.length, omega)[1] < _DECAY)
    modulus = (1.0 + 1j / device.piezo.quality_factor) / device.piezo.s11
    tip = np.stack([response.motion["w_tip"], response.motion["psi_tip"]], axis=1)
    force = -tip_stiffness(ends.tip, frequencies) * tip[:, 0]
    arm = b.shim_thickness + 2.0 * b.glue_thickness + b.piezo_thickness
    blocked = cross.K * layer / (b.width * arm * b.piezo_thickness)
    faces = np.array([0.5 * b.thickness, 0.5 * b.thickness - b.piezo_thickness])
    lengths = (1.0 - _HEIGHTS[:, None]) * b.length
    largest = np.full(frequencies.shape, np.nan)
    for first in range(0, known.size, _AT_ONCE):
        at = known[first : first + _AT_ONCE]
        above = dynamic_stiffness(cross, lengths, omega[at])
        curvature = (_moment(above, tip[at], force[at], layer) + cross.K * layer) / cross.EI
        stress = np.abs(modulus * faces[:, None, None] * curvature - blocked)
        largest[at] = stress.max(axis=(0, 1))
    return largest


def _moment(above: Complex, tip: Complex, force: Complex, voltage: float) -> Complex:
    """Return the bending moment (..., n) at the lower end of what is above a height.

    Parameters
    ----------
    above : (..., n, 5, 5) complex
        Dynamic stiffness of that part alone.
    tip : (n, 2) complex
        w and ψ of the tip.
    force : (n,) complex
        On the tip; no moment acts there.
    """
    effort = np.stack([force, np.zeros_like(force)], axis=1)
    to_tip, to_base = above[..., 2:4, 2:4], above[..., 2:4, 0:2]
    rest = effort - np.einsum("...ij,...j->...i", to_tip, tip) - above[..., 2:4, 4] * voltage
    base = np.linalg.solve(to_base, rest[..., None])[..., 0]
    on_base = np.einsum("...j,...j->...", above[..., 1, 0:2], base)
    on_base += np.einsum("...j,...j->...", above[..., 1, 2:4], tip) + above[..., 1, 4] * voltage
    return np.asarray(-on_base)
