"""What really holds the bimorph: the compliance of tab, glue and rod at the ceramic's lower edge.

A support gives way by w and ψ under the force F and the moment M that the bimorph passes on,
[w, ψ] = S [F, M].  S is what the tip of the supported solid gives way more than that of the
solid whose layers are all clamped: with the ceramic's length L the tip follows its root by
R = [[1, −L], [0, 1]], so

    S = R⁻¹ (C_supported − C_clamped) R⁻ᵀ.

It contains what plane sections cannot show: the ceramic's lower end is free where only the
shim is held.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.pieces import Piece, beam_pieces
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.sections import Joint, section
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.models.bimorph.beam_values import beam_row, values_of_row
from tactgen.validation.models.bimorph.bridge.generator import GeneratorChain
from tactgen.validation.models.bimorph.bridge.solid_values import (
    SolidCase,
    solve_static,
    tip_compliance,
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
        """How far below the ceramic's edge force and rotation do not couple (m)."""
        return float(-self.matrix[0, 1] / self.matrix[1, 1])

    @property
    def lateral_stiffness_at_centre(self) -> float:
        """Force per displacement at that point (N/m)."""
        m = self.matrix
        return float(1.0 / (m[0, 0] - m[0, 1] ** 2 / m[1, 1]))

    def uncoupled(self) -> SupportCompliance:
        """Return it without the coupling of force and rotation, as two springs have it."""
        return SupportCompliance(np.diag(np.diag(self.matrix)))

    def moved_up(self, distance: float) -> SupportCompliance:
        """Return the compliance seen at a point that much higher on a rigid arm."""
        arm = _arm(distance)
        return SupportCompliance(arm @ self.matrix @ arm.T)


def support_compliance(
    supported: Multiport, clamped: Multiport, length: float
) -> SupportCompliance:
    """Return S from the static ports of a supported and of a clamped bimorph.

    Parameters
    ----------
    length : float
        Of the ceramic (m), the same in both.
    """
    back = np.linalg.inv(_arm(length))
    more = tip_compliance(supported) - tip_compliance(clamped)
    return SupportCompliance(back @ more @ back.T)


def _arm(length: float) -> Floats:
    """Return how a point `length` above follows [w, ψ]."""
    return np.array([[1.0, -length], [0.0, 1.0]])


def tab_by_beam(scene: Scene, length: float) -> SupportCompliance:
    """Return the compliance of a clamped tab as a beam with shear."""
    shim = section(Piece("shim", length), scene.device, scene.beam, lossy=False)
    over = length / float(np.real(shim.EI))
    lateral = over * length**2 / 3.0 + length / float(np.real(shim.GA))
    return SupportCompliance(
        np.array([[lateral, -0.5 * over * length], [-0.5 * over * length, over]])
    )


def tab_by_bricks(
    scene: Scene, lengths: Sequence[float], announce: Callable[[str], None], *, level: int = 1
) -> list[SupportCompliance]:
    """Return the compliance of the solid's tab, its lower section clamped, for each free length.

    No length is the shim alone held at the ceramic's edge.
    """
    root = _WIDTHS * scene.bimorph.width
    found = []
    reference = solve_static(_root_case(scene, root, 0.0, level))
    for length in lengths:
        announce(f"support: a tab of {1e3 * length:g} mm")
        port = solve_static(_root_case(scene, root, length, level, shim_only=True))
        found.append(support_compliance(port, reference, root))
    return found


def _root_case(
    scene: Scene, ceramic: float, tab: float, level: int, *, shim_only: bool = False
) -> SolidCase:
    bimorph = scene.bimorph.model_copy(
        update={"length": ceramic, "tab_length": tab, "bare_below": 0.0, "bare_above": 0.0}
    )
    # whatever holds the scene's own bimorph: here the tab alone is meant
    clamped = scene.support.model_copy(update={"kind": "clamped"})
    changed = scene.model_copy(update={"bimorph": bimorph, "support": clamped})
    held = "shim" if shim_only and tab == 0.0 else "layers"
    return SolidCase(changed, held=held, level=level)  # type: ignore[arg-type]


@dataclass(frozen=True)
class SupportStudy:
    """The support of one scene's bimorph by the solid.

    Attributes
    ----------
    scene : Scene
        Whose tab, glue and rod are meant.
    lengths : (n,) array
        Free lengths of the tab (m).
    tabs : list of SupportCompliance
        Of the clamped tab for each.
    joint : SupportCompliance or None
        Of slot, glue and rod at the slot's mouth; None if that was not solved.
    free_tab : float
        Free length of the tab in the generator (m).
    """

    scene: Scene
    lengths: Floats
    tabs: list[SupportCompliance]
    joint: SupportCompliance | None
    free_tab: float

    @property
    def target(self) -> float:
        """The fitted rotational stiffness (N m/rad)."""
        return float(self.scene.support.rotational_stiffness)

    def at(self, length: float, *, in_rod: bool) -> SupportCompliance:
        """Return S for a free tab length (m), clamped below or in the rod."""
        matrices = np.array([tab.matrix for tab in self.tabs]).reshape(-1, 4).T
        # over the length the entries are cubics, as those of a beam
        tab = np.array([np.polyval(np.polyfit(self.lengths, m, 3), length) for m in matrices])
        matrix: Floats = tab.reshape(2, 2)
        if in_rod and self.joint is not None:
            matrix = matrix + self.joint.moved_up(length).matrix
        return SupportCompliance(matrix)

    def tab_for(self, stiffness: float, *, joint: float = 0.0) -> float:
        """Return the free tab length (m) for a rotational stiffness (N m/rad), nan if none.

        `joint` is the rotation per moment (rad/(N m)) of what holds the tab.
        """
        rotations = np.array([tab.matrix[1, 1] for tab in self.tabs])
        wanted = 1.0 / stiffness - joint
        if not rotations.min() <= wanted <= rotations.max():
            return float("nan")
        return float(np.interp(wanted, rotations, self.lengths))


def frequency_on(scene: Scene, support: SupportCompliance) -> float:
    """Return the first frequency (Hz) of the scene's beam bimorph on a support without mass."""
    clamped = {"support": scene.support.model_copy(update={"kind": "clamped"})}
    bimorph = {"bimorph": scene.bimorph.model_copy(update={"tab_length": 0.0})}
    alone = scene.model_copy(update=clamped | bimorph)
    row = [(Joint(support.matrix), 0.0), *beam_row(alone)]
    return values_of_row(alone, row).first_frequency


def fitted_springs(scene: Scene) -> SupportCompliance:
    """Return the compliance of the scene's two springs, as the paper fits them."""
    support = scene.support
    stiffness = np.array([support.lateral_stiffness, support.rotational_stiffness])
    return SupportCompliance(np.diag(1.0 / stiffness))


def tab_for_frequency(study: SupportStudy, *, in_rod: bool) -> float:
    """Return the free tab length (m) on which the bimorph has its frequency on the springs.

    nan if none of the lengths studied has it.
    """
    wanted = frequency_on(study.scene, fitted_springs(study.scene))
    found = [frequency_on(study.scene, study.at(at, in_rod=in_rod)) for at in study.lengths]
    if not found[-1] <= wanted <= found[0]:
        return float("nan")
    return float(np.interp(-wanted, -np.array(found), study.lengths))


def support_study(
    scene: Scene, announce: Callable[[str], None], chain: GeneratorChain | None = None
) -> SupportStudy:
    """Study the scene's support.

    Parameters
    ----------
    chain : GeneratorChain, optional
        The solids of the generator; without it the tab alone is studied.
    """
    free = chain.free_tab if chain else float("nan")
    alone = SupportStudy(
        scene, np.array(TAB_LENGTHS), tab_by_bricks(scene, TAB_LENGTHS, announce), None, free
    )
    if chain is None:
        return alone
    return replace(alone, joint=joint_by_solids(chain)["whole"])


def joint_by_solids(chain: GeneratorChain) -> dict[str, SupportCompliance]:
    """Return the compliance at the slot's mouth, whole and by its causes, on one mesh.

    ``faces``: a rigid slot holds the tab by its faces and not by its section, which no beam
    knows; ``glue``; ``rod``.
    """
    steps = {
        "whole": (chain.on_rod, chain.at_mouth),
        "faces": (chain.in_rigid_slot, chain.at_mouth),
        "glue": (chain.on_glue, chain.in_rigid_slot),
        "rod": (chain.on_rod, chain.on_glue),
    }
    length, down = chain.scene.bimorph.length, -chain.free_tab
    return {
        name: support_compliance(softer.static, stiffer.static, length).moved_up(down)
        for name, (softer, stiffer) in steps.items()
    }


def joint_by_beam(chain: GeneratorChain, glue_modulus: float, *, rod: bool) -> SupportCompliance:
    """Return the beam models' joint at the slot's mouth for a glue modulus (Pa).

    The tab on its foundation of glue; with `rod` also the rod below, as a stepped beam.
    """
    glue = chain.device.glue.model_copy(update={"youngs_modulus": glue_modulus})
    scene = chain.device.model_copy(update={"glue": glue})
    row: list[Element] = []
    for piece in beam_pieces(scene.device, scene.support):
        if piece.section == "bond" or (rod and piece.section == "cylinder"):
            row += transfer_matrix.elements(
                piece, scene.device, scene.beam, lossy=False, segments=1
            )
    return SupportCompliance(tip_compliance(transfer_matrix.chain(row, np.zeros(1))))
