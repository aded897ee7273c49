"""The bridge from the transfer-matrix model to the solid: one assumption given up at a time.

Each rung changes one thing.  Beside what it changes stands what a closed form predicts for
it (tmm.beam.sections), and what the beam model does with the section that the solid itself
has far from its ends; what neither explains is the work of the ends, see :mod:`.ends`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.sections import Section, energy_shear_correction, laminate_section
from tactgen.validation.models.bimorph.beam_values import Values, beam_values
from tactgen.validation.models.bimorph.bridge.rung import Rung
from tactgen.validation.models.bimorph.bridge.solid_values import (
    SolidCase,
    far_section,
    solve_solid,
)
from tactgen.validation.models.bimorph.solid import level_for
from tactgen.validation.scene.scene import Scene


@dataclass(frozen=True)
class Assumptions:
    """What of the beam theories' assumptions has been given up."""

    varying_field: bool = False
    poling_constants: bool = False
    d32: bool = False
    poisson: bool = False

    def ceramic(self, whole: Piezoceramic) -> Piezoceramic:
        """Return the ceramic with what is assumed away set to nought."""
        s = whole.s if self.poisson else np.diag(np.diag(whole.s))
        d = np.zeros((3, 6))
        d[2, 0] = whole.d[2, 0]
        if self.d32:
            d[2, 1] = whole.d[2, 1]
        if self.poling_constants:
            d[2, 2], d[0, 4], d[1, 3] = whole.d[2, 2], whole.d[0, 4], whole.d[1, 3]
        return replace(whole, s=s, d=d)

    def scene(self, scene: Scene) -> Scene:
        """Return the scene with the shim's Poisson effect on or off, its moduli unchanged."""
        if self.poisson:
            return scene
        shim = scene.shim
        across = shim.transverse_modulus or 2.0 * (1.0 + shim.poisson_ratio) * shim.shear_modulus
        plain = shim.model_copy(update={"poisson_ratio": 0.0, "transverse_modulus": across})
        return scene.model_copy(update={"shim": plain})

    def laminate(self, scene: Scene) -> Section | None:
        """Return the constants of laminate theory, None where it has none."""
        if scene.bimorph.glue_thickness > 0.0:
            return None
        return laminate_section(
            scene.device,
            scene.beam,
            poisson=self.poisson,
            d32=self.d32,
            varying_field=self.varying_field,
        )


@dataclass(frozen=True)
class Change:
    """What a step gives up: its name, what it is, what a closed form says of it."""

    name: str
    what: str
    theory: str
    gives_up: Assumptions


#: In this order every set of constants on the way is one that a material could have.
_CHANGES = (
    Change(
        "three dimensions",
        "a solid whose constants couple only along the beam (no Poisson effect, no d32, d33, d15), "
        "its field uniform through each layer: all that a beam assumes, but for the ends",
        "beam theory with the energy-consistent shear factor: no change",
        Assumptions(),
    ),
    Change(
        "field varies",
        "the potential is free through each layer, so that the field follows the strain",
        "layers stiffened about their own middle by 1/(1 - k31^2)",
        Assumptions(varying_field=True),
    ),
    Change(
        "d33 and d15",
        "the piezoelectric constants that act through the thickness and in shear",
        "no change, as a thin layer has no stress through its thickness",
        Assumptions(varying_field=True, poling_constants=True),
    ),
    Change(
        "d32",
        "the piezoelectric effect across the width",
        "laminate theory of a wide plate",
        Assumptions(varying_field=True, poling_constants=True, d32=True),
    ),
    Change(
        "Poisson's effect",
        "ceramic and shim contract across, which the free side edges allow in part: now the "
        "tensors are the scene's",
        "laminate theory of a wide plate, without side edges",
        Assumptions(varying_field=True, poling_constants=True, d32=True, poisson=True),
    ),
)


@dataclass(frozen=True)
class SolidStep:
    """A solid on the way: what is given up with it, more than one where a set could not exist."""

    passed: tuple[Change, ...]
    case: SolidCase

    @property
    def name(self) -> str:
        """Name of the step."""
        return " and ".join(change.name for change in self.passed)


def bridge(
    scene: Scene,
    announce: Callable[[str], None],
    solids: Sequence[SolidStep] = (),
    *,
    level: int = 1,
    sections: bool = True,
) -> list[Rung]:
    """Return the rungs from TMM to the solid, on the scene's support.

    Parameters
    ----------
    scene : Scene
        With a bimorph whose lower end is the base (no rod).
    solids : sequence of SolidStep, optional
        Those of :func:`solid_steps`, where they are at hand.
    level : int
        Index of the division into bricks, one for all rungs, where they are not.
    sections : bool
        Also work out each solid's own section far from its ends (doubles the work).

    Notes
    -----
    A set of constants that no material could have is passed over, its change made with the
    next.
    """
    consistent = with_energy_shear(scene)
    rungs = _beam_rungs(scene, consistent)
    theory, own = (beam_values(consistent),) * 2
    for solid in solids or solid_steps(scene, level):
        passed, case = solid.passed, solid.case
        announce(f"bridge: {passed[-1].name}")
        found = solve_solid(case)
        laminate = passed[-1].gives_up.laminate(consistent)
        predicted = beam_values(consistent, laminate) if laminate else _unknown()
        far = beam_values(consistent, far_section(case, found.static)) if sections else _unknown()
        rungs.append(
            Rung(
                name=solid.name,
                what="; ".join(c.what for c in passed),
                values=found.values,
                step=found.values.step_from(rungs[-1].values),
                predicted=predicted.step_from(theory),
                theory=passed[-1].theory,
                section=far.step_from(own),
            )
        )
        theory, own = predicted, far
    return rungs


def solid_steps(scene: Scene, level: int | None = None) -> list[SolidStep]:
    """Return the solids on the way, in order; each keeps what it assembles.

    On the rod the first also knows what the rod's hold is in three dimensions.

    Parameters
    ----------
    level : int, optional
        Index of the division into bricks; by default 1, which moves the shares by 0.1 % at most,
        and on the rod, where it would be more, that of the scene's own solid.
    """
    if level is None:
        level = level_for(scene) if scene.support.kind == "rod" else 1
    consistent = with_energy_shear(scene)
    steps: list[SolidStep] = []
    passed: list[Change] = []
    for change in _CHANGES:
        passed.append(change)
        gives_up = change.gives_up
        ceramic = gives_up.ceramic(consistent.piezo.ceramic())
        uniform = not gives_up.varying_field
        # on the rod the solid is joined of parts, whose potential is free
        if _admissible(ceramic) and not (uniform and scene.support.kind == "rod"):
            case = SolidCase(
                gives_up.scene(consistent), ceramic, uniform_field=uniform, level=level
            )
            steps.append(SolidStep(tuple(passed), case))
            passed = []
    return steps


def _beam_rungs(scene: Scene, consistent: Scene) -> list[Rung]:
    start = Rung(
        "TMM",
        "exact Timoshenko beam, uniform field in each layer, shear correction "
        f"{scene.beam.shear_correction:.3f}",
        beam_values(scene),
    )
    values = beam_values(consistent)
    step = values.step_from(start.values)
    shear = Rung(
        "shear factor",
        f"the beam's shear correction by the shear energy of its layers, "
        f"{consistent.beam.shear_correction:.3f}",
        values,
        step,
        predicted=step,
        theory="the same formulas, evaluated",
        section=step,
    )
    return [start, shear]


def with_energy_shear(scene: Scene) -> Scene:
    """Return the scene with the shear correction of the layers' shear energy."""
    factor = energy_shear_correction(scene.device)
    return scene.model_copy(
        update={"beam": scene.beam.model_copy(update={"shear_correction": factor})}
    )


def _admissible(ceramic: Piezoceramic) -> bool:
    try:
        ceramic.check_admissible()
    except InputError:
        return False
    return True


def _unknown() -> Values:
    return Values(*[np.nan] * len(Values._fields))
