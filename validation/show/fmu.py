"""The generator as an FMI 2.0 co-simulation unit: C sources, and a Linux binary if it can be.

Inputs are held over a communication step, which is cut into steps of at most `step` seconds.  The
sources are this project's own; the functions' names and types are those of the FMI standard 2.0.4.
"""

from __future__ import annotations

import platform
import shutil
import subprocess
import tempfile
import uuid
import zipfile
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.tmm.generator.transient.machine import BORE, Machine
from tactgen.tmm.generator.transient.system import RoughPoint
from tactgen.tmm.reluctance.coenergy_map import CoenergyCells
from tactgen.validation.show.page import asset

_MODEL = "generator"
#: Step inside (s) unless the importer sets another.
_STEP = 1e-6
#: Name, unit, causality and meaning, by value reference; the C source has the same order.
_VARIABLES = (
    ("voltage", "V", "input", "across the bimorph"),
    ("coil", "", "input", "current (A) or voltage (V) of the coil"),
    ("step", "s", "parameter", "longest step inside"),
    ("rod_lift", "m", "output", "lift of the rod, 0 on top"),
    ("lateral_tip", "m", "output", "lateral motion of the tip"),
    ("head_tilt", "rad", "output", "tilt of the rod's head"),
    ("coil_current", "A", "output", "in the winding"),
    ("flux_linkage", "Wb", "output", "of the winding"),
    ("magnetic_pull", "N", "output", "on the rod, downwards"),
    ("charge", "C", "output", "on the bimorph"),
    ("energy", "J", "output", "stored"),
    ("imbalance", "J", "output", "energy less works and losses of the steps: rounding"),
)
_FLAGS = ("-O2", "-std=c99", "-fPIC", "-shared", "-fvisibility=hidden")


def write_fmu(path: str | Path, machine: Machine, scene: str) -> bool:
    """Write the unit, whole or not at all, and return whether it holds a Linux binary.

    Raises InputError if the file cannot be written, or the C compiler fails.
    """
    header = _header(machine)
    guid = str(uuid.uuid5(uuid.NAMESPACE_URL, header))
    header += f'#define GUID "{guid}"\n'
    source = asset("generator.c")
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    linux = compiler is not None and platform.system() == "Linux" and platform.machine() == "x86_64"
    with (
        written_whole(path) as temporary,
        zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as unit,
    ):
        unit.writestr("modelDescription.xml", _description(machine, guid, scene))
        unit.writestr("sources/generator.c", source)
        unit.writestr("sources/model.h", header)
        if linux and compiler is not None:
            unit.writestr(f"binaries/linux64/{_MODEL}.so", _compiled(compiler, source, header))
    return linux


def _compiled(compiler: str, source: str, header: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        for name, text in (("generator.c", source), ("model.h", header)):
            draft = work / name
            draft.write_text(text, encoding="utf-8")
        target = work / f"{_MODEL}.so"
        done = subprocess.run(
            [compiler, *_FLAGS, "-o", str(target), str(work / "generator.c"), "-lm"],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise InputError(
                f"the C compiler {compiler} fails ({done.stderr.strip()[:200]}); mend it, or take "
                "it off the path to export sources only"
            )
        subprocess.run(["strip", str(target)], capture_output=True, check=False)
        return target.read_bytes()


def _header(machine: Machine) -> str:
    """Numbers of one device as C."""
    system = machine.system
    if any(element.name == BORE for element in system.elements):
        raise InputError(
            "guide.clearance above 0 has no co-simulation unit yet; set guide.clearance = 0 mm"
        )
    if any(friction.element is None for friction in system.frictions):
        raise InputError(
            "guide.friction above 0 has no co-simulation unit yet; set guide.friction = 0 N"
        )
    coil, (upper, lower) = system.coil, system.elements
    assert coil is not None
    cells, law, below = coil.coenergy, upper.law, lower.law
    assert isinstance(cells, CoenergyCells)
    assert isinstance(law, RoughPoint)
    assert isinstance(below, RoughPoint)
    friction = system.frictions[0]
    numbers = {
        "GAP_OFFSET": cells.gap_offset,
        "RIM_LOAD": law.load,
        "STROKE": -lower.offset,
        "FRICTION": friction.coefficient,
        "CREEP": friction.speed,
        "GAP": coil.gap,
        "WIDTH": coil.width,
        "RESISTANCE": coil.resistance,
        "CAPACITANCE": system.capacitance,
        "STEP": _STEP,
    }
    arrays = {
        "DECAY": np.array([law.decay_length, below.decay_length]),
        "RELAXATION": np.array([law.relaxation_time, below.relaxation_time]),
        "MASS": system.mass,
        "DAMPING": system.damping,
        "STIFFNESS": system.stiffness,
        "LOAD": system.load,
        "COUPLING": system.coupling,
        "REST": machine.rest,
        "TIP": system.outputs["lateral_tip"].row,
        "RIM": upper.direction[:, 2],
        "CURRENT_BREAKS": np.array(cells.current_breaks),
        "WIDTH_BREAKS": np.array(cells.width_breaks),
        "COEFFICIENTS": np.array(cells.coefficients),
    }
    rows, columns = np.shape(cells.coefficients)[:2]
    counts = {
        "N": system.mass.shape[0],
        "POINTS": upper.direction.shape[0],
        "ROWS": rows,
        "COLS": columns,
        "BY_VOLTAGE": int(coil.source == "voltage"),
    }
    lines = [f"#define {name} {value}" for name, value in counts.items()]
    lines += [f"#define {name} ({float(value)!r})" for name, value in numbers.items()]
    lines += [_array(name, values) for name, values in arrays.items()]
    return "\n".join(lines) + "\n"


def _array(name: str, values: Floats) -> str:
    flat = np.asarray(values, dtype=float).ravel().tolist()
    return f"static const double {name}[{len(flat)}] = {{{','.join(map(repr, flat))}}};"


def _description(machine: Machine, guid: str, scene: str) -> str:
    """Model description in XML."""
    coil = machine.system.coil
    assert coil is not None
    units = {unit for _, unit, _, _ in _VARIABLES if unit} | {"A", "V"}
    scalars, outputs = [], []
    for reference, (name, stated, causality, meaning) in enumerate(_VARIABLES):
        unit = stated or ("A" if coil.source == "current" else "V")
        kind = {
            "input": 'causality="input" variability="continuous"',
            "parameter": 'causality="parameter" variability="tunable" initial="exact"',
            "output": 'causality="output" variability="continuous" initial="calculated"',
        }[causality]
        start = {"input": ' start="0"', "parameter": f' start="{_STEP!r}"'}.get(causality, "")
        scalars.append(
            f'<ScalarVariable name="{name}" valueReference="{reference}" {kind} '
            f'description={quoteattr(meaning)}><Real unit="{unit}"{start}/></ScalarVariable>'
        )
        if causality == "output":
            outputs.append(f'<Unknown index="{reference + 1}"/>')
    head = (
        f'<fmiModelDescription fmiVersion="2.0" modelName="{_MODEL}" guid="{guid}" '
        f"description={quoteattr(f'tactile generator of the scene {scene}')} "
        'generationTool="tactgen" numberOfEventIndicators="0">'
    )
    slave = (
        f'<CoSimulation modelIdentifier="{_MODEL}" '
        'canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true">'
        '<SourceFiles><File name="generator.c"/></SourceFiles></CoSimulation>'
    )
    structure = (
        f"<ModelStructure><Outputs>{''.join(outputs)}</Outputs>"
        f"<InitialUnknowns>{''.join(outputs)}</InitialUnknowns></ModelStructure>"
    )
    lines = (
        '<?xml version="1.0" encoding="UTF-8"?>',
        head,
        slave,
        "<UnitDefinitions>",
        *(f'<Unit name="{unit}"/>' for unit in sorted(units)),
        "</UnitDefinitions>",
        '<DefaultExperiment startTime="0" stopTime="0.03"/>',
        "<ModelVariables>",
        *scalars,
        "</ModelVariables>",
        structure,
        "</fmiModelDescription>",
    )
    return "\n".join(lines)
