"""The verification report: one self-contained page, written for an engineer who was not there.

Gathers; every number comes from :mod:`validation.solve`, :mod:`validation.checks` or
:mod:`validation.bridge`, every picture from :mod:`validation.pictures`.
"""

from __future__ import annotations

import base64
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata, resources
from pathlib import Path
from typing import Any

import numpy as np

from geometry.arrays import Complex
from geometry.files import written_whole
from tmm.lumped import EquivalentCircuit
from tmm.multiport import passivity_margin, reciprocity_error
from tmm.terminations import outside_finger_range
from validation import plots
from validation.audit import AT, audit
from validation.checks import CHECKS, Outcome, run_check
from validation.comparison import UNEXPLAINED, compare
from validation.files import writable_folder
from validation.formats import filters
from validation.models import LumpedModel
from validation.parameter_list import parameter_rows
from validation.quantities import QUANTITIES
from validation.scene import Scene
from validation.solve import Solution, solve

#: Lengths of the paper's study (section 4, Fig 9), in metres.
STUDY_LENGTHS = np.array([20e-3, 25e-3, 30e-3, 35e-3, 40e-3])
#: Detection thresholds that the paper's text states (section 6, Fig 17): Hz, m.
THRESHOLDS = ((10.0, 2e-6), (250.0, 0.2e-6), (1000.0, 1e-6))
#: Points of the frequency response in the report.
_PLOT_POINTS = 400
_PACKAGES = ("numpy", "scipy", "scikit-fem", "cadquery", "pytetwild", "pyvista", "mkl")


#: Asymmetry and negative dissipation (relative) that condensing a field model may leave by
#: rounding; a wrong sign or a missing term shows at order one.
INVARIANT_TOLERANCE = 1e-6


@dataclass(frozen=True)
class LoadCase:
    """A load under which all models' responses are plotted."""

    name: str
    title: str
    solution: Solution

    def curve(self, model: str) -> Complex:
        """Return the tip displacement (n,); nan where the load model does not reach."""
        values = self.solution.get("tip_displacement", model).value
        outside = outside_finger_range(
            self.solution.scene.load, np.asarray(self.solution.scene.frequency)
        )
        return np.where(outside, np.nan, values)

    def summary(self, model: str) -> dict[str, float]:
        """Return largest and first displacement (m), where (Hz), and the widest bar."""
        q = self.solution.get("tip_displacement", model)
        size = np.abs(self.curve(model))
        at = int(np.nanargmax(size))
        known = np.isfinite(size) & (size > 0.0)
        first = int(np.flatnonzero(known)[0]) if known.any() else 0
        frequency = np.asarray(self.solution.scene.frequency)
        return {
            "largest": float(size[at]),
            "at": float(frequency[at]),
            "first": float(size[first]),
            "first_at": float(frequency[first]),
            "bar": float(np.max(q.uncertainty[known] / size[known], initial=0.0)),
        }


def write_report(
    scene: Scene,
    origins: dict[str, str],
    out: Path,
    quick: bool,
    announce: Callable[[str], None],
) -> Path:
    """Write ``index.html`` into `out` and return its path.

    Raises
    ------
    InputError
        If the folder cannot be written or the scene cannot be solved.
    """
    writable_folder(out)
    started = time.perf_counter()
    asked = scene.accuracy
    scene = _prepared(scene, quick)
    solution = solve(scene, announce=announce)
    page = _page(scene, origins, solution, (quick, asked), announce, started)
    target = out / "index.html"
    with written_whole(target) as temporary:
        temporary.write_text(page, encoding="utf-8")
    return target


def _prepared(scene: Scene, quick: bool) -> Scene:
    """Return the scene with all quantities, a sweep dense enough to plot, coarser if quick."""
    low, high = min(scene.frequency), max(scene.frequency)
    changes: dict[str, Any] = {"quantities": tuple(QUANTITIES)}
    if low < high and len(scene.frequency) < _PLOT_POINTS:
        spaced = np.geomspace if 0.0 < 30.0 * low < high else np.linspace
        changes["frequency"] = (low, *spaced(low, high, _PLOT_POINTS)[1:-1].tolist(), high)
    if quick:
        changes["accuracy"] = max(scene.accuracy, 3e-3)
    return scene.model_copy(update=changes)


def _page(
    scene: Scene,
    origins: dict[str, str],
    solution: Solution,
    version: tuple[bool, float],
    announce: Callable[[str], None],
    started: float,
) -> str:
    """Render the page; `version` is whether it is quick, and the accuracy first asked for."""
    from jinja2 import Environment, StrictUndefined

    quick, asked = version
    cases = _load_cases(scene, solution, announce)
    outcomes = _outcomes(quick, announce)
    rows = parameter_rows(scene, origins)
    crossing = _bridge(scene, solution, announce)
    compared = compare(solution, crossing["rungs"] if crossing else None)
    accuracy = [
        c.uncertainty <= scene.accuracy * abs(c.value) for c in (r.cells[-1] for r in compared)
    ]
    context = {
        "scene": scene,
        "quick": quick,
        "solution": solution,
        "comparison": compared,
        "widest": max(
            (c.uncertainty / abs(c.value) for row in compared for c in row.cells if c.value),
            default=0.0,
        ),
        "farthest": max((abs(c.difference) for row in compared for c in row.cells), default=0.0),
        "modes": _modes(solution, announce),
        "pictures": _pictures(scene, solution, announce),
        "response": _response(scene, cases),
        "cases": cases,
        "study": _length_study(scene, announce),
        "bridge": crossing,
        "asked": asked,
        "missed": accuracy.count(False),
        "circuit": _circuit(solution),
        "invariants": _invariants(solution),
        "invariant_tolerance": INVARIANT_TOLERANCE,
        "unexplained": UNEXPLAINED,
        "audit": audit(scene),
        "audit_at": AT,
        "tet": _tet_check(scene, solution, quick, announce),
        "outcomes": outcomes,
        "counts": {
            s: sum(o.status == s for o in outcomes) for s in ("pass", "differs, explained", "fail")
        },
        "parameters": [row for row in rows if row.key.split(".")[0] in _shown_groups(scene)],
        "versions": _versions(),
        "machine": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "seconds": time.perf_counter() - started,
        "date": time.strftime("%Y-%m-%d"),
    }
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters.update(filters())
    template = (resources.files("validation") / "templates" / "report.html").read_text("utf-8")
    return environment.from_string(template).render(context)


def _shown_groups(scene: Scene) -> set[str]:
    """Return the parameter groups that this scene's models read."""
    groups = {"bimorph", "piezo", "shim", "support", "load", "drive", "beam"}
    return groups | (
        {"glue", "rod", "coil", "sleeve", "gap"} if scene.support.kind == "rod" else set()
    )


def _load_cases(
    scene: Scene, solution: Solution, announce: Callable[[str], None]
) -> list[LoadCase]:
    """Return the scene's response and, without new field solutions, that of the free tip."""
    titles = {
        "finger": "under the finger",
        "none": "free tip",
        "mass": "with the tip mass",
        "spring_damper": "on spring and damper",
    }
    cases = [LoadCase(scene.load.kind, titles[scene.load.kind], solution)]
    other = "none" if scene.load.kind != "none" else "finger"
    announce(f"response: {titles[other]}")
    changed = scene.model_copy(update={"load": scene.load.model_copy(update={"kind": other})})
    again = solve(changed, quantities=("tip_displacement",), reuse=solution)
    cases.append(LoadCase(other, titles[other], again))
    return cases


def _response(scene: Scene, cases: list[LoadCase]) -> str:
    curves = {case.name: {m: case.curve(m) for m in case.solution.models} for case in cases}
    return plots.response_plot(
        np.asarray(scene.frequency), curves, {case.name: case.title for case in cases}
    )


def _outcomes(quick: bool, announce: Callable[[str], None]) -> list[Outcome]:
    found = []
    for check in CHECKS:
        if quick and check.heavy:
            continue
        announce(f"check {check.id}")
        found.append(run_check(check))
    return found


def _circuit(solution: Solution) -> EquivalentCircuit | None:
    model = solution.models.get("lumped")
    return model.circuit() if isinstance(model, LumpedModel) else None


def _invariants(solution: Solution) -> list[dict[str, Any]]:
    """Return how reciprocal and how passive each model's five ports are over the sweep."""
    found = []
    for name, model in solution.models.items():
        port = model.ports().fine
        found.append(
            {
                "model": name,
                "reciprocity": (asymmetry := float(reciprocity_error(port).max())),
                "passivity": (margin := float(passivity_margin(port).min())),
                "holds": asymmetry < INVARIANT_TOLERANCE and margin > -INVARIANT_TOLERANCE,
            }
        )
    return found


def _modes(solution: Solution, announce: Callable[[str], None]) -> list[dict[str, Any]]:
    """Return the first four solid modes with their pictures."""
    from scipy.spatial import cKDTree

    from validation.models import SolidModel
    from validation.pictures import mode_picture

    solid = solution.models.get("solid")
    if not isinstance(solid, SolidModel):
        return []
    mesh, system = solid.meshes()[0], solid.systems()[0]
    at_points = cKDTree(system.nodes).query(mesh.points)[1]
    found = []
    for number, mode in enumerate(solid.shapes()[0][:4], start=1):
        announce(f"picture of mode {number}")
        picture = mode_picture(mesh, mode.displacement[at_points])
        found.append({"number": number, "mode": mode, "png": _inline(picture)})
    return found


def _pictures(
    scene: Scene, solution: Solution, announce: Callable[[str], None]
) -> list[dict[str, str]]:
    from validation.export import scene_solids
    from validation.models import SolidModel
    from validation.pictures import mesh_picture, solids_picture

    announce("picture of the geometry")
    found = [{"caption": "CAD solids", "png": _inline(solids_picture(scene_solids(scene)))}]
    solid = solution.models.get("solid")
    if isinstance(solid, SolidModel):
        announce("picture of the mesh")
        mesh = solid.meshes()[0]
        caption = f"mesh of the solid model: {mesh.cells.shape[0]} {_KIND[mesh.kind]}"
        found.append({"caption": caption, "png": _inline(mesh_picture(mesh))})
        found.append(
            {
                "caption": "the same at its held end",
                "png": _inline(mesh_picture(mesh, close_up=True)),
            }
        )
    return found


_KIND = {
    "hexahedron": "hexahedra with 20 nodes",
    "tetra": "tetrahedra with 10 nodes",
    "tetra10": "curved tetrahedra with 10 nodes",
}


def _length_study(scene: Scene, announce: Callable[[str], None]) -> dict[str, Any]:
    """Return the loaded deflection for the paper's lengths, 50 V, by TMM (its Fig 9)."""
    announce("length study")
    frequencies = tuple(np.geomspace(10.0, 1000.0, 400).tolist())
    curves, rows = [], []
    for length in STUDY_LENGTHS:
        changed = scene.model_copy(
            update={
                "bimorph": scene.bimorph.model_copy(update={"length": float(length)}),
                "load": scene.load.model_copy(update={"kind": "finger"}),
                "drive": scene.drive.model_copy(update={"voltage": 50.0}),
                "frequency": frequencies,
            }
        )
        values = np.abs(solve(changed, ("tmm",), ("tip_displacement",)).quantities[0].value)
        curves.append(values)
        lowest = int(np.argmin(values))
        minimum, at = _refined_minimum(changed, lowest)
        margins = [np.interp(f, frequencies, values) / level for f, level in THRESHOLDS]
        rows.append(
            {
                "length": float(length),
                "start": float(values[0]),
                "minimum": minimum,
                "at": at,
                "at_edge": lowest in (0, len(frequencies) - 1),
                "margins": [float(margin) for margin in margins],
            }
        )
    plot = plots.length_plot(np.array(frequencies), STUDY_LENGTHS, np.array(curves), THRESHOLDS)
    return {"plot": plot, "rows": rows, "thresholds": THRESHOLDS}


def _refined_minimum(scene: Scene, lowest: int) -> tuple[float, float]:
    """Return the smallest deflection (m) near a point of the sweep, and its frequency (Hz)."""
    inside = (
        scene.frequency[max(lowest - 1, 0)],
        scene.frequency[min(lowest + 1, len(scene.frequency) - 1)],
    )
    fine = np.linspace(*inside, 400)
    closer = scene.model_copy(update={"frequency": tuple(fine.tolist())})
    values = np.abs(solve(closer, ("tmm",), ("tip_displacement",)).quantities[0].value)
    at = int(np.argmin(values))
    return float(values[at]), float(fine[at])


def _bridge(
    scene: Scene, solution: Solution, announce: Callable[[str], None]
) -> dict[str, Any] | None:
    """Return the bridge from TMM to the solid, for a bimorph without a rod."""
    from validation.models import SolidModel

    solid = solution.models.get("solid")
    if not isinstance(solid, SolidModel) or scene.support.kind == "rod" or scene.piezo.d31 == 0.0:
        return None
    from validation.bridge import bridge

    rungs = bridge(scene, solid, announce)
    return {"rungs": rungs, "plot": plots.bridge_plot(rungs)}


def _tet_check(
    scene: Scene, solution: Solution, quick: bool, announce: Callable[[str], None]
) -> dict[str, Any] | None:
    """Return the solid on a tetwild mesh beside the structured one."""
    from validation.models import SolidModel
    from validation.solid_meshes import uses_tetrahedra

    solid = solution.models.get("solid")
    if quick or not isinstance(solid, SolidModel) or uses_tetrahedra(scene):
        return None
    announce("solid on a tetwild mesh")
    mesh = scene.mesh.model_copy(update={"kind": "tetwild"})
    names = ("static_tip_displacement", "short_circuit_frequencies", "capacitance_free")
    other = solve(scene.model_copy(update={"mesh": mesh}), ("solid",), names, announce)
    model = other.models["solid"]
    assert isinstance(model, SolidModel)
    from validation.pictures import mesh_picture

    return {
        "rows": compare(other),
        "reference": {row.quantity: row.cells[-1] for row in compare(solution)},
        "cells": model.meshes()[0].cells.shape[0],
        "png": _inline(mesh_picture(model.meshes()[0], close_up=True)),
    }


def _versions() -> dict[str, str]:
    from fem.linear_solver import available_solver

    found = {"tactgen": metadata.version("tactgen"), "linear solver": available_solver()}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found


def _inline(png: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")
