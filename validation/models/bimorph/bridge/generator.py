"""From a bimorph clamped in all its layers to the bimorph in the rod, one change at a time.

What holds the bimorph in a real generator is its shim's tab, glued into a slot of the rod.
Here the solid goes there in steps; beside each stands what the beam models make of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from tactgen.geometry.bimorph.pieces import beam_pieces
from tactgen.geometry.bimorph.rod_bricks import ROD_LEVELS, rod_bricks
from tactgen.geometry.device.parameters import Glue, Rod
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.scattering import Element
from tactgen.validation.engine.error_bars import ROD_FACTOR
from tactgen.validation.models.bimorph.beam_values import Values, beam_values, values_of_row
from tactgen.validation.models.bimorph.bridge.rung import Rung
from tactgen.validation.models.bimorph.bridge.solid_values import (
    SolidCase,
    SolvedSolid,
    solve_solid,
)
from tactgen.validation.scene.scene import Scene

#: Tab of a scene that has none (m): that of the built-in scene ``bimorph_on_rod``.
USUAL_TAB = 2e-3
#: Moduli of glue and rod are raised by this for what counts as rigid.
_RIGID = 1e3
#: Electrode margins at either end (m), and glue between the layers (m), of the two branches.
MARGIN, BOND = 0.5e-3, 20e-6


@dataclass(frozen=True)
class GeneratorChain:
    """The solids between a clamped bimorph and the generator; each is solved at most once.

    Attributes
    ----------
    scene : Scene
        Whose bimorph and rod are meant; its support and load do not count.
    announce : callable
        Told what is being solved.
    level : int
        Index of the division into bricks where there is no rod.
    rod_level : int
        The same in the rod.
    """

    scene: Scene
    announce: Callable[[str], None]
    level: int = 2
    rod_level: int = 1

    @property
    def device(self) -> Scene:
        """The scene in the rod, free of load, with a tab."""
        tab = self.scene.bimorph.tab_length or USUAL_TAB
        return _on(_with(self.scene, tab_length=tab), "rod")

    @property
    def free_tab(self) -> float:
        """Length of the tab between slot and ceramic (m)."""
        return self.device.device.ceramic_base

    @cached_property
    def clamped(self) -> SolvedSolid:
        """All layers clamped."""
        return self._bricks("all layers clamped", self.clamped_scene)

    @property
    def clamped_scene(self) -> Scene:
        """The bimorph alone, its lowest section clamped."""
        return _on(_with(self.scene, tab_length=0.0), "clamped")

    @property
    def tab_scene(self) -> Scene:
        """The bimorph on its free tab, clamped below."""
        return _on(_with(self.scene, tab_length=self.free_tab), "clamped")

    @cached_property
    def by_shim(self) -> SolvedSolid:
        """The shim alone clamped, at the ceramic's lower edge."""
        self.announce("bridge: clamped by the shim")
        return solve_solid(SolidCase(self.clamped_scene, held="shim", level=self.level))

    @cached_property
    def on_tab(self) -> SolvedSolid:
        """The free tab, clamped below."""
        return self._bricks("clamped by the tab", self.tab_scene)

    @cached_property
    def bar(self) -> float:
        """Largest relative error bar of deflection, frequency and capacitance in the rod."""
        self.announce("bridge: coarser bricks of the generator")
        coarse = self._solved_in_rod(self.device, self.rod_level - 1).values
        apart = coarse.step_from(self.on_rod.values)
        return ROD_FACTOR * max(
            abs(apart.deflection), abs(apart.first_frequency), abs(apart.capacitance)
        )

    @cached_property
    def at_mouth(self) -> SolvedSolid:
        """The tab held by its section at the mouth of its slot, on the bricks of the rod."""
        return self._in_rod("held at the slot's mouth", glue=_RIGID, rod=_RIGID, filled=True)

    @cached_property
    def in_rigid_slot(self) -> SolvedSolid:
        """The tab in its slot, glue and rod rigid."""
        return self._in_rod("rigid slot", glue=_RIGID, rod=_RIGID)

    @cached_property
    def on_glue(self) -> SolvedSolid:
        """The tab in its glue, the rod rigid."""
        return self._in_rod("glue", glue=1.0, rod=_RIGID)

    @cached_property
    def on_rod(self) -> SolvedSolid:
        """The generator."""
        return self._in_rod("elastic rod", glue=1.0, rod=1.0)

    def rungs(self) -> list[Rung]:
        """Return the steps."""
        return _chained(self._steps(), "beam model")

    def pairs(self) -> list[tuple[str, Values, Values]]:
        """Return name, beam model's values and solid's values from the clamp to the rod."""
        steps = self._steps()
        return [(name, by_beam, solved.values) for name, _, solved, by_beam in steps]

    def _steps(self) -> list[tuple[str, str, SolvedSolid, Values]]:
        clamped, tab = beam_values(self.clamped_scene), beam_values(self.tab_scene)
        glue, rod = (values_of_row(self.device, row) for row in self._rod_rows())
        return [
            ("all layers clamped", "", self.clamped, clamped),
            (
                "the shim alone clamped",
                "the ceramic's lower end is free; the shim must pass the moment on by shear",
                self.by_shim,
                clamped,
            ),
            (
                f"a tab of {1e3 * self.free_tab:.2f} mm",
                "the shim goes on below the ceramic, its lower section clamped",
                self.on_tab,
                tab,
            ),
            (
                "bricks of the rod",
                "the same device on the bricks of all: what both divisions are off",
                self.at_mouth,
                tab,
            ),
            (
                "the tab in a slot",
                "glue and rod rigid: the tab is held by its faces, its section is not",
                self.in_rigid_slot,
                tab,
            ),
            ("glue", "the bond line as soft as it is", self.on_glue, glue),
            ("elastic rod", "the rod bends, held at its lower face", self.on_rod, rod),
        ]

    @property
    def beam_values(self) -> Values:
        """What the beam models make of the generator."""
        return values_of_row(self.device, self._rod_rows()[1])

    def branches(self) -> list[Rung]:
        """Return what two things that the paper does not tell would change on a clamp."""
        start = self.clamped_scene
        margins = _with(start, bare_below=MARGIN, bare_above=MARGIN)
        bonded = _with(start, glue_thickness=BOND)
        found = [("all layers clamped", "", self.clamped, beam_values(start))]
        rungs = []
        for name, what, scene in (
            (
                f"electrode margins of {1e3 * MARGIN:g} mm",
                "no electrode at either end of the ceramic",
                margins,
            ),
            (
                f"glue of {1e6 * BOND:g} µm between the layers",
                "epoxy between shim and ceramic, which also moves the ceramic outwards",
                bonded,
            ),
        ):
            solved = self._bricks(name, scene)
            step = (name, what, solved, beam_values(scene))
            rungs += _chained([*found, step], "beam model")[1:]
        return rungs

    def _rod_rows(self) -> tuple[list[Element], list[Element]]:
        """Return the beam models' rows on a rigid and on the elastic rod."""
        scene = self.device
        parts = [
            (
                piece,
                transfer_matrix.elements(
                    piece, scene.device, scene.beam, lossy=False, segments=transfer_matrix.SEGMENTS
                ),
            )
            for piece in beam_pieces(scene.device, scene.support)
        ]
        rigid = [e for piece, row in parts for e in row if piece.section != "cylinder"]
        return rigid, [e for _, row in parts for e in row]

    def _bricks(self, name: str, scene: Scene) -> SolvedSolid:
        self.announce(f"bridge: {name}")
        return solve_solid(SolidCase(scene, level=self.level))

    def _in_rod(self, name: str, *, glue: float, rod: float, filled: bool = False) -> SolvedSolid:
        self.announce(f"bridge: {name}")
        scene = self.device
        stiffer = {
            "glue": _stiffer(scene.glue, glue),
            "rod": _stiffer(scene.rod, rod),
        }
        return self._solved_in_rod(scene.model_copy(update=stiffer), self.rod_level, filled=filled)

    def _solved_in_rod(self, scene: Scene, level: int, *, filled: bool = False) -> SolvedSolid:
        bricks = rod_bricks(scene.device, ROD_LEVELS[level], filled=filled)
        return solve_solid(SolidCase(scene, mesh=bricks))


def _chained(steps: list[tuple[str, str, SolvedSolid, Values]], theory: str) -> list[Rung]:
    """Return rungs from (name, what, solid, beam model's values)."""
    rungs: list[Rung] = []
    before: Values | None = None
    for name, what, solved, by_beam in steps:
        if before is None:
            rungs.append(Rung(name, what, solved.values))
        else:
            step = solved.values.step_from(rungs[-1].values)
            rungs.append(Rung(name, what, solved.values, step, by_beam.step_from(before), theory))
        before = by_beam
    return rungs


def _with(scene: Scene, **bimorph: float) -> Scene:
    return scene.model_copy(update={"bimorph": scene.bimorph.model_copy(update=bimorph)})


def _on(scene: Scene, kind: str) -> Scene:
    """Return the scene on another support, its tip free."""
    support = scene.support.model_copy(update={"kind": kind})
    load = scene.load.model_copy(update={"kind": "none"})
    return scene.model_copy(update={"support": support, "load": load})


def _stiffer(group: Glue | Rod, factor: float) -> Glue | Rod:
    return group.model_copy(update={"youngs_modulus": factor * group.youngs_modulus})
