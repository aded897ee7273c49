"""Report sections on beam against solid, support and material."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.geometry.device.parameters import Piezo
from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.models.difference import (
    CAPACITANCE,
    DEFLECTION,
    FIRST_FREQUENCY,
    HEADLINE,
    Step,
    Values,
    beam_to_solid,
    beam_values,
    clamp_to_rod,
    on_rod,
)
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections.bimorph_figures import breakdown_plot, support_plot
from tactgen.validation.report.sections.section import Context
from tactgen.validation.scene.scene import Scene

#: The material beside the scene's own: one whose whole tensor is published, or the paper's.
_OTHER = {"M1876": "PZT-5H"}
#: Headline quantities in tables and figures, with title and unit.
COLUMNS = (
    (DEFLECTION, "static deflection per volt", "m"),
    (FIRST_FREQUENCY, "first frequency", "Hz"),
    (CAPACITANCE, "free capacitance", "F"),
)
_TITLES = {key: title for key, title, _ in COLUMNS}


def bridge_section(study: Study) -> Context:
    """Steps from beam to solid of the scene's material and, unless quick, another."""
    steps = study.steps
    if not steps:
        return {"bridge": None}
    scene = study.scene
    found = [_one_material(scene.piezo.material, steps)]
    if not study.quick:
        name = _OTHER.get(scene.piezo.material, "M1876")
        study.announce(f"breakdown for {name}")
        other = scene.model_copy(update={"piezo": Piezo(material=name)})
        found.append(_one_material(name, beam_to_solid(other, study.announce)))
    return {"bridge": found, "columns": COLUMNS, "replaced": replaced_constants(scene)}


def _one_material(name: str, steps: list[Step]) -> dict[str, Any]:
    first, last = steps[0].values, steps[-1].values
    return {
        "material": name,
        "steps": steps,
        "plot": breakdown_plot(steps, _TITLES, "the solid"),
        "off": [first[key] / last[key] - 1.0 for key, _, _ in COLUMNS],
    }


def replaced_constants(scene: Scene) -> list[str]:
    """Keys of the ceramic's constants that are not the library's."""
    library = Piezo(material=scene.piezo.material)
    changed = (
        n for n in type(library).model_fields if getattr(scene.piezo, n) != getattr(library, n)
    )
    return [f"piezo.{name}" for name in changed]


def holding_section(study: Study) -> Context | None:
    """Steps from a clamp to the rod, and the support's stiffness."""
    if study.quick or not study.asks_field or study.scene.piezo.d31 == 0.0:
        return None
    from tactgen.geometry.device.checks import check_fit, check_plain_layers

    device = on_rod(study.scene)
    try:
        check_plain_layers(device.device)
        check_fit(device.device, device.support)
    except InputError as error:
        return {"refused": str(error)}
    steps = clamp_to_rod(study.scene, study.announce, field=_in_rod(study))
    return {
        "refused": "",
        "columns": COLUMNS,
        "chain": steps,
        "beam_to_rod": beam_values(device),
        "plot": breakdown_plot(steps, _TITLES, f"the last step, {steps[-1].name}"),
        **_support(study),
    }


def _in_rod(study: Study) -> Values | None:
    """Headline numbers of the field model that the study itself has in the rod, tip free."""
    scene, solution = study.scene, study.solution
    models = [m for m in solution.models_of("bimorph") if MODELS[m].theory == "solid"]
    if scene.support.kind != "rod" or scene.load.kind not in ("none", "finger") or not models:
        return None
    found = {}
    for name in HEADLINE:
        q = solution.by_model(name).get(models[-1])
        if q is None:
            return None
        first = q.value if q.classes is None else q.value[q.classes.index("bending_x")]
        found[name] = float(first)
    return found


def _support(study: Study) -> dict[str, Any]:
    """Stiffness of tab, glue and rod, and the tab that the fitted springs stand for."""
    from tactgen.validation.models.bimorph.rod_joint import (
        GLUE_MODULI,
        TAB_LENGTHS,
        fitted_springs,
        frequency_on,
        joint_by_beam,
        tab_by_beam,
        tab_by_bricks,
        tab_for,
    )

    scene, target = study.scene, float(study.scene.support.rotational_stiffness)
    tabs = tab_by_bricks(scene, TAB_LENGTHS, study.announce)
    joint = joint_by_beam(scene, scene.glue.youngs_modulus)
    wholes = [tab + joint.moved_up(at) for at, tab in zip(TAB_LENGTHS, tabs, strict=True)]
    turned = joint.matrix[1, 1]
    lengths, bending = np.array(TAB_LENGTHS), tab_by_beam(scene, 1.0).rotational_stiffness
    rotations = np.array([tab.matrix[1, 1] for tab in tabs])
    best = {
        "beam, tab alone": bending / target,
        "solid, tab alone": tab_for(tabs, target),
        "solid, tab in glue and rod": tab_for(tabs, target, turned),
    }
    curves = dict(zip(best, (lengths / bending, rotations, rotations + turned), strict=True))
    return {
        "target": target,
        "tabs": [
            (at, tab_by_beam(scene, at) if at else None, tab, whole, frequency_on(scene, whole))
            for at, tab, whole in zip(TAB_LENGTHS, tabs, wholes, strict=True)
        ],
        "on_springs": frequency_on(scene, fitted_springs(scene)),
        "glue": [
            (modulus, b.matrix[1, 1], tab_for(tabs, target, b.matrix[1, 1]))
            for modulus in sorted({*GLUE_MODULI, scene.glue.youngs_modulus})
            for b in [joint_by_beam(scene, modulus)]
        ],
        "by_beam": best["beam, tab alone"],
        "alone": best["solid, tab alone"],
        "in_rod": best["solid, tab in glue and rod"],
        "support_plot": support_plot(lengths, curves, 1.0 / target, best),
    }


def material_section(study: Study) -> Context | None:
    """Effect of the assumed constants of the full tensor."""
    if study.quick or not study.asks_field or study.scene.piezo.d31 == 0.0:
        return None
    from tactgen.validation.models.bimorph.rod_joint import material_effects

    scene = study.scene
    if scene.support.kind == "rod":
        support = scene.support.model_copy(update={"kind": "clamped"})
        scene = scene.model_copy(update={"support": support})
    rows = material_effects(scene, study.announce)
    solved = [row for row in rows if row.values is not None]
    return {"rows": rows, "first": solved[0].values, "solved": solved}
