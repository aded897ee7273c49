"""The CAD solids on tetrahedra: cadquery's shapes, fTetWild's mesh, scikit-fem's elements.

Shares with the bricks of the model solid the equations and nothing of mesh or assembly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tactgen.geometry.device.checks import check_plain_layers
from tactgen.validation.engine.stages import Stages
from tactgen.validation.models.bimorph.lowest_modes import MeshModes
from tactgen.validation.models.bimorph.two_meshes import TwoMeshModel
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.piezo.system import SolidSystem
    from tactgen.validation.models.bimorph.adaptive_meshes import AdaptedPair


class CadModel(TwoMeshModel):
    """The bimorph alone, or glued into its rod, on tetrahedra refined for its accuracy."""

    name = "cad"

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse what the CAD solids do not know: profiles, bare ends, glue between layers."""
        check_plain_layers(scene.device)

    def __init__(self, scene: Scene, stages: Stages) -> None:
        super().__init__(scene, stages)
        self._ahead: list[tuple[SolidSystem, MeshModes]] = []

    def make_pair(self) -> AdaptedPair:
        """Return the last mesh of the refinement, and an earlier one to judge it by."""
        # an answer from the store needs none of what makes meshes
        from tactgen.validation.models.bimorph.adaptive_meshes import adapted_pair, level_limits

        pair = adapted_pair(self.scene, *level_limits(self.scene), self._look_ahead)
        # the systems of all other meshes are let go
        self._ahead = [found for found in self._ahead if found[0] is pair.coarse.system]
        return pair

    def coarse_modes(self, system: SolidSystem) -> MeshModes:
        """Return what modes follow from on a mesh that judges another; found before, perhaps."""
        ahead = (modes for of, modes in self._ahead if of is system)
        return next(ahead, None) or super().coarse_modes(system)

    def _look_ahead(self, system: SolidSystem) -> None:
        if self.will_run("modal"):
            self._ahead.append((system, super().coarse_modes(system)))
