"""Compliance of the shim's tab, glue and rod that hold the ceramic at its lower edge.

A support gives way by w and ψ under the force F and the moment M that the bimorph passes on,
[w, ψ] = S [F, M].  The tip of a supported solid follows its root by R = [[1, −L], [0, 1]] over the
ceramic's length L, so against the same solid clamped in all layers

    S = R⁻¹ (C_supported − C_clamped) R⁻ᵀ,

which contains that the ceramic's lower end is free.  Glue and rod add their compliance as beams.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.pieces import Piece, beam_pieces
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.sections import Joint, section
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.models.difference import (
    FIRST_FREQUENCY,
    SolidCase,
    beam_row,
    clamped,
    on_rod,
    row_values,
)
from tactgen.validation.scene.scene import Scene

#: Free lengths of the tab (m) for which the bricks are solved.
TAB_LENGTHS = (0.0, 0.4e-3, 0.8e-3, 1.2e-3, 1.6e-3, 2.4e-3)
#: Glue moduli (Pa): from a soft to a filled adhesive.
GLUE_MODULI = (1e9, 3e9, 10e9)
#: Ceramic's length in widths for the root alone; its upper end is then far away.
_WIDTHS = 4.0


@dataclass(frozen=True)
class SupportCompliance:
    """Compliance (2, 2) of a support: w (m) and ψ (rad) per force (N) and moment (N m)."""

    matrix: Floats

    def __add__(self, other: SupportCompliance) -> SupportCompliance:
        return SupportCompliance(self.matrix + other.matrix)

    @property
    def rotational_stiffness(self) -> float:
        """Moment per rotation, no force (N m/rad): the meaning of the paper's c_s."""
        return float(1.0 / self.matrix[1, 1])

    @property
    def lateral_stiffness(self) -> float:
        """Force per displacement at the ceramic's edge, no moment (N/m): the paper's c_sl."""
        return float(1.0 / self.matrix[0, 0])

    @property
    def centre(self) -> float:
        """Depth below the ceramic's edge where force and rotation do not couple (m)."""
        return float(-self.matrix[0, 1] / self.matrix[1, 1])

    @property
    def lateral_stiffness_at_centre(self) -> float:
        """Force per displacement at that point (N/m)."""
        m = self.matrix
        return float(1.0 / (m[0, 0] - m[0, 1] ** 2 / m[1, 1]))

    def moved_up(self, distance: float) -> SupportCompliance:
        """Compliance seen at a point higher by `distance` (m) on a rigid arm."""
        arm = _arm(distance)
        return SupportCompliance(arm @ self.matrix @ arm.T)


def _arm(length: float) -> Floats:
    """How a point `length` (m) above follows [w, ψ]."""
    return np.array([[1.0, -length], [0.0, 1.0]])


def support_compliance(
    supported: Multiport, reference: Multiport, length: float
) -> SupportCompliance:
    """Compliance from D(0) of a supported and of a clamped bimorph of one length (m)."""
    back = np.linalg.inv(_arm(length))
    more = _tip_compliance(supported) - _tip_compliance(reference)
    return SupportCompliance(back @ more @ back.T)


def _tip_compliance(static: Multiport) -> Floats:
    """[w, ψ] of the tip (2, 2) per force (N) and moment (N m), base held."""
    return np.linalg.inv(static.block("w_tip", "psi_tip").stiffness[0].real)


def tab_by_beam(scene: Scene, length: float) -> SupportCompliance:
    """Compliance of a clamped tab (m) as a beam with shear."""
    shim = section(Piece("shim", length), scene.device, scene.beam, lossy=False)
    over = length / float(np.real(shim.EI))
    lateral = over * length**2 / 3.0 + length / float(np.real(shim.GA))
    return SupportCompliance(
        np.array([[lateral, -0.5 * over * length], [-0.5 * over * length, over]])
    )


def tab_by_bricks(
    scene: Scene, lengths: Sequence[float], announce: Callable[[str], None], *, level: int = 1
) -> list[SupportCompliance]:
    """Compliance of the solid's tab of each free length (m), its lower section clamped.

    No length is the shim alone held at the ceramic's edge.
    """
    from tactgen.fem.piezo.ports import static_multiport

    root = _WIDTHS * scene.bimorph.width
    plain = {"length": root, "bare_below": 0.0, "bare_above": 0.0}
    alone = scene.model_copy(update={"bimorph": scene.bimorph.model_copy(update=plain)})
    reference = static_multiport(SolidCase(clamped(alone), level=level).assembled())
    tabs = []
    for length in lengths:
        announce(f"support: a tab of {1e3 * length:g} mm")
        case = SolidCase(
            clamped(alone, length), held="shim" if length == 0.0 else "layers", level=level
        )
        supported = static_multiport(case.assembled())
        tabs.append(support_compliance(supported, reference, root))
    return tabs


def joint_by_beam(scene: Scene, glue_modulus: float, *, rod: bool = True) -> SupportCompliance:
    """Compliance at the slot's mouth by beams: the tab in glue of a modulus (Pa), and the rod."""
    device = on_rod(scene)
    glue = device.glue.model_copy(update={"youngs_modulus": glue_modulus})
    device = device.model_copy(update={"glue": glue})
    row: list[Element] = []
    for piece in beam_pieces(device.device, device.support):
        if piece.section == "bond" or (rod and piece.section == "cylinder"):
            row += transfer_matrix.elements(
                piece, device.device, device.beam, lossy=False, segments=1
            )
    return SupportCompliance(_tip_compliance(transfer_matrix.chain(row, np.zeros(1))))


def tab_for(tabs: Sequence[SupportCompliance], stiffness: float, joint: float = 0.0) -> float:
    """Free tab length (m) of a rotational stiffness (N m/rad), nan if none of `TAB_LENGTHS`.

    `joint` is the rotation per moment (rad/(N m)) of what holds the tab.
    """
    rotations = np.array([tab.matrix[1, 1] for tab in tabs])
    wanted = 1.0 / stiffness - joint
    if not rotations.min() <= wanted <= rotations.max():
        return float("nan")
    return float(np.interp(wanted, rotations, TAB_LENGTHS))


def frequency_on(scene: Scene, support: SupportCompliance) -> float:
    """First frequency (Hz) of the scene's beam bimorph on a support without mass."""
    alone = clamped(scene)
    row = [(Joint(support.matrix), 0.0), *beam_row(alone)]
    return row_values(alone, row)[FIRST_FREQUENCY]


def fitted_springs(scene: Scene) -> SupportCompliance:
    """Compliance of the scene's two springs, as the paper fits them."""
    support = scene.support
    stiffness = np.array([support.lateral_stiffness, support.rotational_stiffness])
    return SupportCompliance(np.diag(1.0 / stiffness))
