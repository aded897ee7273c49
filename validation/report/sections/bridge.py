"""The report's sections on why a solid differs from a beam, what holds it, what it is made of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Piezo
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.readout import ModalReadout
from tactgen.validation.catalogue.bimorph import DYNAMIC_STIFFNESS
from tactgen.validation.report.figures.bimorph import bridge_plot, support_plot
from tactgen.validation.report.sections.section import Context
from tactgen.validation.report.study import Study

if TYPE_CHECKING:
    from tactgen.validation.models.bimorph.bridge import Rung
    from tactgen.validation.models.bimorph.bridge.generator import GeneratorChain
    from tactgen.validation.models.bimorph.bridge.stepped import Stepped
    from tactgen.validation.models.bimorph.bridge.width import WidthPoint
    from tactgen.validation.models.bimorph.joint_compliance import SupportCompliance, SupportStudy
    from tactgen.validation.scene.scene import Scene

#: Frequencies at which responses are followed.
_FREQUENCIES = 5
#: The material beside the scene's own: one whose whole tensor is published, or the paper's.
_OTHER = {"M1876": "PZT-5H"}


def bridge_section(study: Study) -> Context:
    """Return the bridge for the scene's material and, unless quick, for another."""
    rungs = study.rungs
    if not rungs:
        return {"bridge": None, "stepped": _stepped(study) if is_stepped(study) else None}
    found = [_one_material(study, study.scene.piezo.material, rungs)]
    if not study.quick:
        from tactgen.validation.models.bimorph.bridge import bridge

        name = _OTHER.get(study.scene.piezo.material, "M1876")
        study.announce(f"bridge for {name}")
        found.append(_one_material(study, name, bridge(_of(study, name), study.announce)))
    return {
        "bridge": found,
        "widths": [] if study.quick else _widths(study),
        "stepped": _stepped(study) if is_stepped(study) else None,
        "replaced": replaced_constants(study.scene),
    }


def is_stepped(study: Study) -> bool:
    """Return whether responses and modes are led to the solid: where rungs are, and in the rod."""
    scene = study.scene
    in_rod = "solid" in scene.models and scene.piezo.d31 != 0.0 and scene.support.kind == "rod"
    return not study.quick and (in_rod or bool(study.rungs))


def _stepped(study: Study) -> dict[str, Any]:
    """Return the bridge of bending modes, and of responses at some of the scene's frequencies.

    The port matrix is left out: all that is shown is read off it.
    """
    from tactgen.validation.models.bimorph.bridge.stepped import bridged, stepped

    every = np.asarray(study.scene.frequency)
    few = every[np.unique(np.linspace(0, every.size - 1, _FREQUENCIES).astype(int))]
    scene = study.scene.model_copy(update={"frequency": tuple(few.tolist())})
    names = [name for name in bridged(scene) if name != DYNAMIC_STIFFNESS.name]
    groups: list[list[Stepped]] = []
    every_row = stepped(scene, names, study.announce, study.solids)
    for found in (one for one in every_row if not one.is_untouched):
        together = next((group for group in groups if found.goes_with(group[0])), None)
        if together is None:
            groups.append([found])
        else:
            together.append(found)
    return {
        "steps": groups[0][0].steps[1:],
        "rows": [row for group in groups if (row := _row(group, few))["lines"]],
        "untouched": [_spoken(one) for one in every_row if one.is_untouched],
    }


def _row(group: list[Stepped], frequencies: Floats) -> dict[str, Any]:
    """Return names of quantities in proportion, and their shares where they have a value."""
    one = group[0]
    at = one.values[-1] if isinstance(one.row.read, ModalReadout) else frequencies
    lines = zip(at, one.shares.T, one.together, strict=True)
    return {
        "names": [_spoken(found) for found in group],
        "lines": [line for line in lines if np.isfinite(line[2])],
    }


def _spoken(one: Stepped) -> str:
    return one.row.name.replace("_", " ")


def replaced_constants(scene: Scene) -> list[str]:
    """Return the keys of the ceramic's constants that are not the library's."""
    library = Piezo(material=scene.piezo.material)
    changed = (
        n for n in type(library).model_fields if getattr(scene.piezo, n) != getattr(library, n)
    )
    return [f"piezo.{name}" for name in changed]


def _widths(study: Study) -> list[WidthPoint]:
    """Return where the section stands between strip and plate; glue is in neither theory."""
    if study.scene.bimorph.glue_thickness > 0.0:
        return []
    from tactgen.validation.models.bimorph.bridge.width import width_study

    study.announce("bridge: sections of other widths")
    return width_study(study.scene)


def _of(study: Study, material: str) -> Scene:
    if material == study.scene.piezo.material:
        return study.scene
    return study.scene.model_copy(update={"piezo": Piezo(material=material)})


def _one_material(study: Study, name: str, rungs: list[Rung]) -> dict[str, Any]:
    from tactgen.validation.models.bimorph.bridge.end_effect import end_effect

    study.announce(f"bridge: ends, {name}")
    return {
        "material": name,
        "rungs": rungs,
        "plot": bridge_plot(rungs, "solid against TMM"),
        "ends": None if study.quick else end_effect(_of(study, name)),
    }


def holding_section(study: Study) -> Context | None:
    """Return the way from a clamp to the rod, and the support's stiffness."""
    chain = study.chain
    if study.quick or chain is None:
        return None
    from tactgen.geometry.device.checks import check_fit, check_plain_layers

    try:
        check_plain_layers(chain.device.device)
        check_fit(chain.device.device, chain.device.support)
    except InputError as error:
        return {"refused": str(error)}
    rungs = chain.rungs()
    return {
        "refused": "",
        "chain": rungs,
        "beam_to_rod": chain.beam_values,
        "branches": chain.branches(),
        "plot": bridge_plot(rungs, "generator against clamp"),
        "free_tab": chain.free_tab,
        "bar": chain.bar,
        **_support(study, chain),
    }


def _support(study: Study, chain: GeneratorChain) -> dict[str, Any]:
    from tactgen.validation.models.bimorph.joint_compliance import (
        GLUE_MODULI,
        fitted_springs,
        frequency_on,
        joint_by_beam,
        joint_by_solids,
        support_study,
        tab_for_frequency,
    )

    scene = study.scene
    found = support_study(scene, study.announce, chain)
    assert found.joint is not None
    target = found.target
    joint = found.joint.matrix[1, 1]
    built = found.at(found.free_tab, in_rod=True)
    in_rod = found.tab_for(target, joint=joint)
    return {
        "support": found,
        "joint": joint_by_solids(chain),
        "tabs": [
            (at, found.at(at, in_rod=False), _beam(scene, at), whole, frequency_on(scene, whole))
            for at in found.lengths
            for whole in [found.at(at, in_rod=True)]
        ],
        "on_springs": frequency_on(scene, fitted_springs(scene)),
        "on_whole": frequency_on(scene, built),
        "uncoupled": frequency_on(scene, built.uncoupled()),
        "same_frequency": tab_for_frequency(found, in_rod=True),
        "in_rod": in_rod,
        "at_in_rod": found.at(in_rod, in_rod=True) if np.isfinite(in_rod) else None,
        "alone": found.tab_for(target),
        "by_beam": _bending_stiffness(scene) / target,
        "glue": [
            (modulus, b.matrix[1, 1], found.tab_for(target, joint=b.matrix[1, 1]))
            for modulus in GLUE_MODULI
            for b in [joint_by_beam(chain, modulus, rod=True)]
        ],
        "support_plot": _support_plot(found, joint),
        "soft_lateral": _lateral_effect(study),
    }


def _beam(scene: Scene, length: float) -> SupportCompliance | None:
    from tactgen.validation.models.bimorph.joint_compliance import tab_by_beam

    return tab_by_beam(scene, length) if length > 0.0 else None


def _bending_stiffness(scene: Scene) -> float:
    """Return EI of the tab (N m²)."""
    from tactgen.validation.models.bimorph.joint_compliance import tab_by_beam

    return tab_by_beam(scene, 1.0).rotational_stiffness


def _support_plot(found: SupportStudy, joint: float) -> str:
    tabs = np.array([tab.matrix[1, 1] for tab in found.tabs])
    bending = _bending_stiffness(found.scene)
    curves = {
        "beam, tab alone": found.lengths / bending,
        "solid, tab alone": tabs,
        "solid, tab, glue and rod": tabs + joint,
    }
    best = {
        "beam, tab alone": bending / found.target,
        "solid, tab alone": found.tab_for(found.target),
        "solid, tab, glue and rod": found.tab_for(found.target, joint=joint),
    }
    return support_plot(found.lengths, curves, 1.0 / found.target, best)


def _lateral_effect(study: Study) -> float:
    """Return what a lateral spring ten times softer does to the sprung beam's frequency."""
    from tactgen.validation.models.bimorph.beam_values import beam_values

    scene, support = study.scene, study.scene.support.model_copy(update={"kind": "spring"})
    softer = support.model_copy(update={"lateral_stiffness": 0.1 * support.lateral_stiffness})
    stiff, soft = (
        beam_values(scene.model_copy(update={"support": kind})) for kind in (support, softer)
    )
    return soft.first_frequency / stiff.first_frequency - 1.0


def material_section(study: Study) -> Context | None:
    """Return what the assumed constants of the full tensor are worth."""
    if study.quick or not study.asks_field or study.scene.piezo.d31 == 0.0:
        return None
    from tactgen.validation.models.bimorph.material_effects import material_effects

    scene = study.scene
    if scene.support.kind == "rod":
        support = scene.support.model_copy(update={"kind": "clamped"})
        scene = scene.model_copy(update={"support": support})
    rows = material_effects(scene, study.announce)
    solved = [row for row in rows if row.values is not None]
    return {"rows": rows, "first": solved[0].values, "solved": solved}
