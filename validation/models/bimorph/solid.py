"""The solid on bricks of high order, the fast reference for the bimorph alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING

from tactgen.geometry.bimorph.bricks import LEVELS, Bricks, bimorph_bricks
from tactgen.geometry.bimorph.segments import bimorph_stack
from tactgen.geometry.device.checks import check_bonded, check_boxes, check_constant_section
from tactgen.geometry.device.parameters import Device, Piezo
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.structured_tets import whole_mesh
from tactgen.geometry.operating_system import memory_size
from tactgen.validation.models.bimorph.mesh_pair import MeshPair, TwoMeshModel
from tactgen.validation.models.model import SURPLUS_FACTOR, SURPLUS_FACTOR_AT_EDGES, Stages
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.piezo.brick_error import MotionEstimator
    from tactgen.fem.piezo.system import SolidSystem


#: Share of the whole thickness below which a ceramic's ends are edges inside the body.
_THIN = 1.0 / 30.0
#: Relative error bar of static deflection, capacitances and first frequencies that each level
#: stays below on the paper's bimorph and on job J1 (tests/validation/engine/test_error_bars.py).
_BRICK_BARS = (1e-1, 8e-4, 2.5e-4, 2e-4, 6e-5)


#: Memory (bytes) for a system of so many unknowns, and with which power of these it grows; layers
#: for which memory is no concern.  Measured on stacks of two, four and eight ceramics.
_MEMORY, _UNKNOWNS, _GROWTH, _FEW_LAYERS = 5.7e9, 59000, 1.35, 8
#: Share of the memory that others leave to it.
_SHARE = 0.8


class SolidModel(TwoMeshModel):
    """The bimorph alone on bricks."""

    name = "solid"

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse scenes beyond the bricks: a rod, profiles, sliding layers."""
        if scene.support.kind == "rod":
            raise InputError(
                'support.kind = "rod": the model solid takes the bimorph without its rod; ask for '
                "--model cad, which takes both"
            )
        check_constant_section(scene.device)
        check_bonded(scene.device)
        _check_memory(scene)

    def warnings(self, quantities: Sequence[str]) -> tuple[str, ...]:
        """Say that the coarsest level is no answer of its own."""
        if self.scene.mesh.level != 1:
            return ()
        sentence = (
            "mesh.level = 1 is 2 for the model solid, whose error bar needs a coarser level than "
            "its own; write mesh.level = 2 to say what it is"
        )
        return (sentence,)

    def make_pair(self) -> BrickPair:
        """Level that the accuracy asks for, and the next coarser one."""
        return brick_pair(self.scene)


@dataclass(frozen=True)
class BrickPair(MeshPair):
    """Bricks of two neighbouring levels; the coarser says how many modes of each class are low.

    The error is estimated by the polynomials of one degree more that the finer ones lack.
    """

    device: Device
    bricks: tuple[Bricks, Bricks]

    @property
    def meshes(self) -> tuple[Bricks, Bricks]:
        """The finer and the coarser bricks."""
        return self.bricks

    @cached_property
    def systems(self) -> tuple[SolidSystem, SolidSystem]:
        """The lossless systems on the finer and the coarser mesh."""
        from tactgen.fem.piezo.solid import assemble

        fine, coarse = (assemble(self.device, mesh, lossy=False) for mesh in self.bricks)
        return fine, coarse

    @cached_property
    def lacking(self) -> Callable[..., MotionEstimator]:
        """Estimator space of each class of motion, also with losses."""
        from tactgen.fem.piezo.brick_error import BrickEstimator

        estimator = cache(partial(BrickEstimator, self.device, self.bricks[0]))
        return cache(lambda motion, lossy=False: estimator(lossy=lossy).of(motion))

    @property
    def static_factor(self) -> float:
        """Error of all answers per difference from the estimate."""
        b = self.device.bimorph
        inside = max(b.tab_length, b.bare_below, b.bare_above, b.tip_extension) > 0.0
        inside |= "glue" in b.own_materials or self.bricks[0].held == "shim"
        inside |= any(extent != (0.0, b.length) for extent in b.layers.extents(b.length))
        inside |= b.stepped
        stack = bimorph_stack(self.device)
        thin = _THIN * sum(of.thickness for of in stack)
        inside |= any(of.thickness < thin for of in stack if isinstance(of.material, Piezo))
        return SURPLUS_FACTOR_AT_EDGES if inside else SURPLUS_FACTOR

    @property
    def method(self) -> str:
        """Origin of the error, for the reader."""
        return (
            f"what polynomials of one degree more make of the residual of {self.systems[0].size} "
            f"unknowns, times {self.static_factor:g}"
        )


def brick_pair(scene: Scene) -> BrickPair:
    """Bricks that the scene asks for, and the next coarser ones."""
    finer = level_for(scene)
    fine, coarse = (bimorph_bricks(scene.device, LEVELS[n]) for n in (finer, finer - 1))
    return BrickPair(scene.device, (fine, coarse))


def _check_memory(scene: Scene) -> None:
    """Refuse so many layers that the machine's memory does not hold their system."""
    layers = scene.bimorph.layers
    if len(layers) <= _FEW_LAYERS:
        return
    unknowns = 4 * int(bimorph_bricks(scene.device, LEVELS[level_for(scene)]).products().sum())
    needed, own = _MEMORY * (unknowns / _UNKNOWNS) ** _GROWTH, memory_size()
    if needed > _SHARE * own:
        raise InputError(
            f"bimorph.layers has {len(layers)} layers, for which the model solid needs some "
            f"{1e-9 * needed:.0f} GB of memory ({unknowns} unknowns) and this machine has "
            f"{1e-9 * own:.0f} GB; ask for --model calibrated, or describe the stack by fewer, "
            "thicker layers at a higher voltage"
        )


def level_for(scene: Scene) -> int:
    """Index (1 to 4) of the finer bricks' level; never the coarsest."""
    if scene.mesh.level:
        return max(scene.mesh.level - 1, 1)
    for index, error in enumerate(_BRICK_BARS):
        if index and error <= scene.accuracy:
            return index
    return len(_BRICK_BARS) - 1


class CadModel(TwoMeshModel):
    """The bimorph alone, or glued into its rod, on tetrahedra refined for its accuracy."""

    name = "cad"

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse scenes beyond the CAD solids: bare ends, glue between plain layers."""
        check_boxes(scene.device, on_rod=scene.support.kind == "rod")
        if any(layer.pitch for layer in scene.bimorph.layers):
            raise InputError(
                f'bimorph.layers = "{scene.bimorph.layers}" has a ceramic poled along, whose '
                "electrodes the model cad does not know; ask for models=lumped,tmm,beam,solid"
            )

    def make_pair(self) -> MeshPair:
        """Last mesh of the refinement, and an earlier one to judge it by."""
        # an answer from the store needs none of what makes meshes
        from tactgen.validation.models.bimorph.adaptive_meshes import adapted_pair, level_limits

        return adapted_pair(self.scene, *level_limits(self.scene))


def mesh_pair(scene: Scene) -> MeshPair:
    """Meshes for pictures and files: bricks if the scene asks for them and can.

    Raises InputError if neither bricks nor tetrahedra know the scene's bimorph.
    """
    on_rod = scene.support.kind == "rod"
    by_cad = on_rod or bool(scene.bimorph.profiles)
    by_cad |= "cad" in scene.models and "solid" not in scene.models
    model: type[TwoMeshModel] = CadModel if by_cad else SolidModel
    model.check(scene)
    return model(scene, Stages({})).make_pair()


def cells_of(mesh: Mesh | Bricks) -> Mesh:
    """Cells to show or to write, of the whole: bricks become eight-cornered ones."""
    return mesh.corner_mesh() if isinstance(mesh, Bricks) else whole_mesh(mesh)
