"""Compliance of the shim's tab, glue and rod that hold the ceramic at its lower edge.

A support gives way by w and ψ under the force F and the moment M that the bimorph passes on,
[w, ψ] = S [F, M].  The tip of a supported solid follows its root by R = [[1, −L], [0, 1]] over the
ceramic's length L, so against the same solid clamped in all layers

    S = R⁻¹ (C_supported − C_clamped) R⁻ᵀ,

which contains that the ceramic's lower end is free.  Glue and rod add their compliance as beams.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import Piece, beam_pieces
from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.sections import section
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.models.difference import SolidCase, Values, clamped, on_rod, solid_values
from tactgen.validation.scene.scene import Scene

#: Free lengths of the tab (m) for which the bricks are solved.
TAB_LENGTHS = (0.0, 0.4e-3, 0.8e-3, 1.2e-3, 1.6e-3, 2.4e-3)
#: Ceramic's length in widths for the root alone; its upper end is then far away.
_WIDTHS = 4.0


@dataclass(frozen=True)
class SupportCompliance:
    """Compliance (2, 2) of a support: w (m) and ψ (rad) per force (N) and moment (N m)."""

    matrix: Floats

    @property
    def rotational_stiffness(self) -> float:
        """Moment per rotation, no force (N m/rad): the meaning of the paper's c_s."""
        return float(1.0 / self.matrix[1, 1])


def support_compliance(
    supported: Multiport, reference: Multiport, length: float
) -> SupportCompliance:
    """Compliance from D(0) of a supported and of a clamped bimorph of one length (m)."""
    back = np.array([[1.0, length], [0.0, 1.0]])  # from the tip down to [w, ψ] at the root
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
    scene: Scene, lengths: Sequence[float], announce: Callable[[str], None], *, level: int
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
        held: Literal["shim", "layers"] = "shim" if length == 0.0 else "layers"
        case = SolidCase(clamped(alone, length), held=held, level=level)
        supported = static_multiport(case.assembled())
        tabs.append(support_compliance(supported, reference, root))
    return tabs


def joint_by_beam(scene: Scene, glue_modulus: float) -> SupportCompliance:
    """Compliance at the slot's mouth by beams: the tab in glue of a modulus (Pa), and the rod."""
    device = on_rod(scene)
    glue = device.glue.model_copy(update={"youngs_modulus": glue_modulus})
    device = device.model_copy(update={"glue": glue})
    row: list[Element] = []
    for piece in beam_pieces(device.device, device.support):
        if piece.section in ("bond", "cylinder"):
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


#: Permittivity with which the paper's d31 and s11 give a coupling beyond known ceramics.
_LOW_EPS33 = 3400.0


#: Soft ceramics that differ most in what the reduced constants do not fix.
_REST = ("PZT-5H", "PZT-5A")


def choices(ceramic: Piezoceramic) -> Iterator[tuple[str, Piezoceramic]]:
    """Yield names and full materials, the assumed one first."""
    yield "as it stands", ceramic
    reduced = ceramic.reduced()
    # all that the reduced constants do not fix; M1876 is PZT-5H by ratio already
    same = {ceramic.name, "M1876", *(("PZT-5H",) if ceramic.name == "M1876" else ())}
    for name in _REST:
        if name not in same:
            yield f"rest by ratio to {name}", LIBRARY[name].with_values(**reduced)
    for factor in (0.9, 1.1):  # k33 of soft PZT: 0.68 to 0.78
        yield f"d33 x {factor:g}", _with_d(ceramic, factor, 1.0)
    yield "d15 = 0", _with_d(ceramic, 1.0, 0.0)  # no shear piezoelectricity: an extreme
    # in the plane, where d31 = d32 acts; isotropic-like ceramics to PZT-4
    for ratio in (0.25, 0.40):
        yield f"-s12/s11 = {ratio:g}", _with_s12(ceramic, ratio)
    for factor in (0.9, 1.1):  # thickness against length
        yield f"s13 x {factor:g}", _scaled(ceramic, (0, 2), factor)
    yield "s33 x 1.1", _scaled(ceramic, (2, 2), 1.1)  # compliance through the thickness
    # permittivity, eps11 and d33 by ratio: here the reduced set itself changes
    spread = ceramic.spreads.get("eps33")
    for eps33 in (_LOW_EPS33, spread.low, spread.high) if spread else ():
        yield f"eps33 = {eps33:g}", ceramic.with_values(**{**reduced, "eps33": eps33})
    yield "d33 = 0", _with_d(ceramic, 0.0, 1.0)  # no constants but those that the paper gives
    d = ceramic.d.copy()
    d[2, :2] *= 2.0
    yield "d31 x 2", replace(ceramic, d=d)  # more coupling than there is field


def material_effects(
    scene: Scene, announce: Callable[[str], None], *, level: int
) -> dict[str, Values]:
    """Solid's values on the scene's support by choice of its tensor, the possible ones alone."""
    found = {}
    for name, ceramic in choices(scene.piezo.ceramic()):
        try:
            ceramic.check_admissible()
        except InputError:
            continue
        announce(f"material: {name}")
        found[name] = solid_values(SolidCase(scene, ceramic, level=level))
    return found


def _with_d(ceramic: Piezoceramic, d33: float, d15: float) -> Piezoceramic:
    d = ceramic.d.copy()
    d[2, 2] *= d33
    d[0, 4] *= d15
    d[1, 3] *= d15
    return replace(ceramic, d=d)


def _with_s12(ceramic: Piezoceramic, ratio: float) -> Piezoceramic:
    s = ceramic.s.copy()
    s[0, 1] = s[1, 0] = -ratio * s[0, 0]
    s[5, 5] = 2.0 * (s[0, 0] - s[0, 1])
    return replace(ceramic, s=s)


def _scaled(ceramic: Piezoceramic, place: tuple[int, int], factor: float) -> Piezoceramic:
    """Ceramic with s13 (and its equals) or s33 scaled."""
    s = ceramic.s.copy()
    places = {place, place[::-1]} | ({(1, 2), (2, 1)} if place == (0, 2) else set())
    for i, j in places:
        s[i, j] *= factor
    return replace(ceramic, s=s)
