"""What a bridge follows, by the solid on bricks or on a given mesh; and its section and ends.

Far from its ends every section of a uniform bimorph does the same.  Two lengths of it give
these constants without the ends, which both have in common: from one length to the other
the rotation of the tip grows by κ ΔL per volt and by ΔL/EI per moment, the charge by what
the added length takes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import static_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.system import SolidSystem
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bimorph_bricks import LEVELS, BrickParts, bimorph_bricks
from tactgen.geometry.bimorph.bricks import Bricks, Held
from tactgen.geometry.bimorph.rod_bricks import ROD_LEVELS, rod_parts
from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.tmm.beam.sections import Section, section
from tactgen.tmm.ports.multiport import Multiport, hold, respond
from tactgen.validation.models.bimorph.beam_values import Values, bimorph_piece, values_from
from tactgen.validation.scene.scene import Scene


@dataclass(frozen=True)
class SolidCase:
    """A solid to be solved: a scene, and what differs from its device.

    Attributes
    ----------
    scene : Scene
        Device, support and load.
    ceramic : Piezoceramic or None
        Full material in place of the scene's.
    uniform_field : bool
        Potential linear through each layer.
    held : {"layers", "shim"}
        Part of the lowest section that the base is.
    level : int
        Index of the division into bricks.
    mesh : Mesh, Bricks or None
        To be solved on in place of the bimorph's own bricks, on the rod of these with the rod's.
    """

    scene: Scene
    ceramic: Piezoceramic | None = None
    uniform_field: bool = False
    held: Held = "layers"
    level: int = 1
    mesh: Mesh | Bricks | None = None

    def bricks(self) -> Mesh | Bricks | BrickParts:
        """Return what it is solved on."""
        if self.mesh is not None:
            return self.mesh
        if self.scene.support.kind == "rod":
            return rod_parts(self.scene.device, ROD_LEVELS[self.level])
        return bimorph_bricks(self.scene.device, LEVELS[self.level], self.held)

    @cached_property
    def lossless(self) -> SolidSystem:
        """The lossless system, assembled once for all who ask this very value."""
        return self.system(lossy=False)

    def system(self, *, lossy: bool) -> SolidSystem:
        """Return it assembled."""
        return assemble(
            self.scene.device,
            self.bricks(),
            lossy=lossy,
            ceramic=self.ceramic,
            uniform_field=self.uniform_field,
        )

    def shortened(self, share: float) -> SolidCase:
        """Return the same with the ceramic's length times `share`."""
        bimorph = self.scene.bimorph
        shorter = bimorph.model_copy(update={"length": share * bimorph.length})
        return replace(self, scene=self.scene.model_copy(update={"bimorph": shorter}))


@dataclass(frozen=True)
class SolvedSolid:
    """Values on the scene's support, and the static ports."""

    values: Values
    static: Multiport


def solve_solid(case: SolidCase) -> SolvedSolid:
    """Solve a solid: statics and the first bending modes from one factorisation."""
    scene = case.scene
    system = case.lossless
    static = static_multiport(system)
    # a whole body also bends the other way, twists and stretches
    count = 1 if system.motion == "bending_x" else 4
    short, opened = (
        next(
            mode.frequency
            for mode in natural_modes(system, scene.ends, count, open_circuit=circuit)
            if mode.kind == "bending_x"
        )
        for circuit in (False, True)
    )
    return SolvedSolid(values_from(scene, static, short, opened), static)


def tip_compliance(static: Multiport) -> Floats:
    """Return [w, ψ] of the tip (2, 2) per force (N) and moment (N m), base held."""
    return np.linalg.inv(static.block("w_tip", "psi_tip").stiffness[0].real)


def far_section(case: SolidCase, longer: Multiport) -> Section:
    """Return the section constants of a solid far from its ends.

    `longer` is D(0) of `case`; half its length is solved here.  Shear stiffness, mass and
    rotary inertia stay the beam model's.
    """
    shorter = solve_static(case.shortened(0.5))
    added = 0.5 * case.scene.bimorph.length
    turned, charge = (a - b for a, b in zip(_per_volt(longer), _per_volt(shorter), strict=True))
    bent = tip_compliance(longer)[1, 1] - tip_compliance(shorter)[1, 1]
    stiffness = float(added / bent)
    moment = float(turned / added * stiffness)
    scene = case.scene
    return replace(
        section(bimorph_piece(scene), scene.device, scene.beam, lossy=False),
        EI=stiffness,
        K=moment,
        C=float(charge / added - moment**2 / stiffness),
    )


def solve_static(case: SolidCase) -> Multiport:
    """Return D(0) of a solid."""
    return static_multiport(case.lossless)


def _per_volt(static: Multiport) -> tuple[float, float]:
    """Return the tip's rotation (rad/V) and the charge (C/V), base held, tip free."""
    response = respond(hold(static, "w_base", "psi_base"), {"voltage": 1.0})
    return float(response.motion["psi_tip"][0].real), float(response.effort["voltage"][0].real)
