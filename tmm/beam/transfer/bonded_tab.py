"""The shim's tab glued into the rod's slot, as an elastic joint between head and tab.

The tab is a Timoshenko beam that stands on its bond lines.  Relative to the head, which is
rigid over the depth of the slot, its displacement v = w − w_head and rotation θ obey

    F' = k_w v,   M' = F + k_r θ,   F = GA (v' + θ),   M = EI θ',

the equations of a vibrating beam with −k_w for m Ω² and −k_r for ρI Ω².  The bond lines'
stiffness per length: on the two faces the glue is squeezed or pulled between stiff walls
(E' = E (1 − ν)/((1 + ν)(1 − 2ν)), no strain along the wall) and sheared along z; on the two
narrow sides it is sheared; below the tab's end it is sheared and squeezed.

Left out: the mass of tab and glue inside the slot (the head is counted as solid), and the
head's own deformation around the slot.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactgen.geometry.bimorph.pieces import Piece
from tactgen.geometry.device.materials import lossy_modulus
from tactgen.geometry.device.parameters import Beam, Device
from tactgen.tmm.beam.section.section import Constant, Joint, section
from tactgen.tmm.beam.transfer.timoshenko import dynamic_stiffness


def bonded_tab(piece: Piece, device: Device, beam: Beam, *, lossy: bool = False) -> Joint:
    """Return the joint that a piece of section ``bond`` is to what stands above the slot.

    Analytic in all parameters, which may be arrays (n,); `lossy` switches the losses of glue
    and tab on.
    """
    glue, tab = device.glue, device.bimorph
    b, h, t = tab.width, tab.shim_thickness, glue.thickness
    modulus = lossy_modulus(glue.youngs_modulus, glue.loss_factor, lossy=lossy)
    shear = modulus / (2.0 * (1.0 + glue.poisson_ratio))
    nu = glue.poisson_ratio
    squeezed = modulus * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
    lateral = 2.0 * (squeezed * b + shear * h) / t
    rotational = 2.0 * shear * (b * h**2 / 4.0 + h**3 / 12.0) / t
    shim = section(Piece("shim", piece.length), device, beam, lossy=lossy)
    # complex: roots of negative numbers are meant
    founded = dynamic_stiffness(
        replace(shim, m=-lateral + 0j, rhoI=-rotational + 0j), piece.length, np.ones(())
    )
    low, across, high = founded[..., :2, :2], founded[..., :2, 2:4], founded[..., 2:4, 2:4]
    end = _diagonal(shear * b * h / t, squeezed * b * h**3 / (12.0 * t))
    stiffness = high - np.swapaxes(across, -1, -2) @ np.linalg.solve(low + end, across)
    compliance = np.linalg.inv(stiffness)
    given = (lateral, rotational, shim.EI, shim.GA, piece.length)
    return Joint(compliance if any(np.iscomplexobj(v) for v in given) else compliance.real)


def _diagonal(first: Constant, second: Constant) -> Constant:
    """Return diagonal matrices (..., 2, 2)."""
    return np.stack(np.broadcast_arrays(first, second), axis=-1)[..., None] * np.eye(2)
