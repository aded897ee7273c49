"""Skipped work of a scene: modules, stages and processor time, cold and warm.

Each scene is solved in a process of its own, with an empty store and again with the full one.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactgen.validation.evidence.bench import Bench, Target, Timing

#: Heavy libraries (pyvista brings matplotlib along), and the rooms of the other actuator and of
#: the fields.
_WATCHED = (
    "cadquery", "vtkmodules", "pyvista", "skfem", "scipy.sparse", "matplotlib", "meshio",
    "pytetwild", "tactgen.fem.piezo", "tactgen.fem.beam", "tactgen.fem.magnetics",
    "tactgen.tmm.beam", "tactgen.tmm.reluctance",
)  # fmt: skip
#: Processor time of a warm answer by a field, per that of a closed form: both are mostly imports.
_WARM = 2.0

_SOLVE = """
import json, sys, time
asked = json.load(sys.stdin)
from tactgen.validation.scene.load import load_scene
from tactgen.validation.engine.solve import as_json, solve
scene, _ = load_scene(asked["scene"], asked["overrides"])
if asked["picture"]:
    from tactgen.validation.show.export import scene_solids
    from tactgen.validation.show.pictures import solids_picture
    size = len(solids_picture(scene_solids(scene)))
    told = {"answers": [size], "computed": [], "asked": [], "skipped": 0}
else:
    solution = solve(scene)
    told = {
        "answers": as_json(solution)["quantities"], "computed": sorted(solution.stages.computed),
        "asked": sorted(solution.stages.seconds), "skipped": len(solution.plan.skipped),
    }
    for quantity in told["answers"]:
        del quantity["seconds"]
modules = sorted(sys.modules)
print(json.dumps({
    **told, "modules": len(modules),
    "watched": [n for n in asked["watched"]
                if any(m == n or m.startswith(n + ".") for m in modules)],
    "seconds": time.process_time(),
}))
"""


@dataclass(frozen=True)
class Case:
    """A scene of the measurement."""

    #: What it is, and the built-in scene
    name: str
    scene: str
    overrides: tuple[str, ...]  #: As for ``--set``
    absent: tuple[str, ...] = ()  #: Libraries and rooms that it must not import
    after: str = ""  #: Case whose store it finds, of which one thing is changed; empty if none
    reused: tuple[str, ...] = ()  #: Stages that it must take over from `after`
    picture: bool = False  #: Whether only a picture of the solids is asked for


_FIELDS = ("cadquery", "vtkmodules", "skfem", "matplotlib", "pytetwild", "tactgen.fem.piezo")
_MAGNETIC = ("tactgen.fem.magnetics", "tactgen.tmm.reluctance")
_LATERAL = ("tactgen.fem.piezo", "tactgen.fem.beam")
_SOLID = ("models=solid", "quantities=tip_displacement", "mesh.level=2", "frequency=10,100")
_PORTS = ("solid.ports",)

#: Scenes, those that others start from first.
CASES = (
    Case("TMM only", "paper", ("models=tmm", "quantities=tip_displacement", "frequency=100"),
         (*_FIELDS, "scipy.sparse", *_MAGNETIC)),
    Case("lumped only", "paper", ("models=lumped", "quantities=capacitance_free"),
         (*_FIELDS, "scipy.sparse", *_MAGNETIC)),
    Case("statics only", "j1", ("models=solid", "quantities=static_tip_displacement",
         "mesh.level=2"), ("cadquery", "vtkmodules", "matplotlib", *_MAGNETIC)),
    Case("modes only", "j1", ("models=solid", "quantities=short_circuit_frequencies",
         "mesh.level=2", "modes=2"), ("cadquery", "vtkmodules", "matplotlib", *_MAGNETIC)),
    Case("one frequency", "prototype", ("models=beam", "quantities=tip_velocity",
         "frequency=500"), ("cadquery", "vtkmodules", "matplotlib", *_MAGNETIC)),
    Case("one length", "prototype", ("models=tmm", "quantities=short_circuit_frequencies",
         "bimorph.length=15mm"), (*_FIELDS, *_MAGNETIC)),
    Case("piezo only", "j1", _SOLID, ("cadquery", "vtkmodules", "matplotlib", *_MAGNETIC)),
    Case("magnetics only", "reluctance", ("models=network", "quantities=magnetic_force"),
         ("cadquery", "vtkmodules", "matplotlib", *_LATERAL)),
    Case("changed load", "j1", (*_SOLID, "load.kind=finger"), (*_MAGNETIC,),
         "piezo only", _PORTS),
    Case("changed voltage", "j1", (*_SOLID, "drive.voltage=2 V"), (*_MAGNETIC,),
         "piezo only", _PORTS),
    Case("changed support", "j1", (*_SOLID, "support.rotational_stiffness=0.1 N*m/rad"),
         (*_MAGNETIC,), "piezo only", _PORTS),
    Case("changed density", "j1", (*_SOLID, "piezo.density=7800 kg/m^3"), (*_MAGNETIC,),
         "piezo only"),
    Case("unchanged", "j1", _SOLID, ("skfem", *_MAGNETIC), "piezo only", _PORTS),
    Case("picture only", "paper", ("models=tmm",),
         ("skfem", "pytetwild", *_LATERAL, *_MAGNETIC), picture=True),
)  # fmt: skip


def run(quick: bool, announce: Callable[[str], None]) -> Bench:
    """Measure all scenes; quick: those without a field solution."""
    picked = [c for c in CASES if not quick or not (c.scene == "j1" or c.picture)]
    timings: list[Timing] = []
    faults: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        for case in picked:
            announce(f"skip: {case.name}")
            alone = solved(case, Path(folder) / f"cold {case.name}")
            store = Path(folder) / (f"cold {case.after}" if case.after else f"cold {case.name}")
            again = solved(case, store)
            for path, found in (("cold", alone), ("warm", again)):
                timings.append(_timing(case, path, found, alone))
            faults += _faults(case, alone, again)
    warm = [
        t.cost
        for t in timings
        if t.path == "warm" and t.values["reused"] and not t.values["computed"]
    ]
    closed = next(t.cost for t in timings if t.path == "cold")
    targets = [
        Target("scenes that do what they need not, or answer otherwise when warm", 0.0,
               float(len(faults)), "", True, "; ".join(faults) or "each in a process of its own"),
    ]  # fmt: skip
    if warm:
        targets.append(Target("processor time of the slowest answer that is wholly kept, per that "
                              f"of {timings[0].case}", _WARM, max(warm) / closed, "", True,
                              "imports and all"))  # fmt: skip
    conditions = "processor time of the whole process, imports and all; cold: an empty store"
    return Bench("skip", conditions, tuple(timings), tuple(targets),
                 sum(t.cost for t in timings))  # fmt: skip


def solved(case: Case, store: Path) -> dict[str, Any]:
    """Report of a process that solves the case with this store."""
    asked = {
        "scene": case.scene, "overrides": case.overrides, "picture": case.picture,
        "watched": _WATCHED,
    }  # fmt: skip
    environment = {**os.environ, "TACTGEN_CACHE": str(store), "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", _SOLVE], input=json.dumps(asked), capture_output=True, text=True,
        env=environment, check=True,
    )  # fmt: skip
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def _timing(case: Case, path: str, found: Mapping[str, Any], cold: Mapping[str, Any]) -> Timing:
    """Timing of one scene, cold or warm."""
    reused = sorted(set(found["asked"]) - set(found["computed"]))
    error = float(found["answers"] != cold["answers"])
    values: dict[str, str | float] = {
        "scene": case.name, "store": path, "processor_seconds": found["seconds"],
        "modules": found["modules"], "watched": " ".join(found["watched"]),
        "computed": " ".join(found["computed"]), "reused": " ".join(reused),
        "skipped": found["skipped"], "error": error,
    }  # fmt: skip
    return Timing(path, case.name, found["seconds"], error, values)


def _faults(case: Case, cold: Mapping[str, Any], warm: Mapping[str, Any]) -> list[str]:
    """Unneeded work of a case, in words."""
    found = [
        f"{case.name} imports {name}"
        for name in case.absent
        if name in cold["watched"] or name in warm["watched"]
    ]
    found += [
        f"{case.name} computes {stage} again" for stage in case.reused if stage in warm["computed"]
    ]
    if case.name == "changed density" and not set(_PORTS) <= set(warm["computed"]):
        found.append("a changed density is answered with the old one")
    if warm["answers"] != cold["answers"]:
        found.append(f"{case.name} answers otherwise when warm")
    return found
