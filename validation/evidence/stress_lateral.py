"""The lateral actuator's models driven to extremes, each held against a second one.

Lumped and beam elements against the exact spans of the transfer matrix, which itself is held
against 80 digits elsewhere; tetrahedra of the CAD solids against bricks; the reduced basis of a
family of bimorphs against the bricks of its members.
"""

from __future__ import annotations

import time
from functools import partial

import numpy as np

from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.stress import (
    REFUSALS,
    Asked,
    Families,
    Family,
    Row,
    Stress,
    answered,
)
from tactgen.validation.evidence.stress_driven import Pair, Sweep, decades
from tactgen.validation.scene.scene import load_scene

_STATEMENT = (
    "Each answer agrees with the second model's within the bars of both, of a family and of a "
    "response 19 of 20 and none by three bars; what cannot be answered is refused in one sentence."
)
_FREE = ("load.kind=none",)
_STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
_LUMPED = Pair("lumped", "tmm", _STATIC, "prototype", form=1e-6)
_BEAM = Pair(
    "beam", "tmm", (*_STATIC, "short_circuit_frequencies", "tip_displacement", "admittance"),
    "prototype",
)  # fmt: skip
_CAD = Pair("cad", "solid", ("static_tip_displacement", "capacitance_free"), "j1")

_LENGTH = Sweep(
    "length", "1 µm to 10 m", tuple(decades("bimorph.length", "m", -6, 1)), quick=(0, 3, 4, -1)
)
_SHIM = Sweep(
    "shim over ceramic", "shim 1e-3 to 1e3 times as thick, at 0.77 mm in all",
    tuple(
        (
            f"shim/piezo 1e{power}",
            (
                f"bimorph.piezo_thickness={0.77 / (2.0 + 10.0**power):.9g} mm",
                f"bimorph.shim_thickness={10.0**power * 0.77 / (2.0 + 10.0**power):.9g} mm",
            ),
        )
        for power in range(-3, 4)
    ),
)  # fmt: skip
_SUPPORT = Sweep(
    "support stiffness", "rotational spring 1e-9 to 1e6 N m/rad",
    tuple(decades("support.rotational_stiffness", "N*m/rad", -9, 6, "support.kind=spring")),
)  # fmt: skip
_MASS = Sweep(
    "tip mass", "1 pg to 1 kg", tuple(decades("load.mass", "kg", -15, 0, "load.kind=mass"))
)
_QUALITY = Sweep(
    "quality factor", "10 to 1e9, tan δ its inverse",
    tuple(
        (f"Q 1e{p}", (f"piezo.quality_factor=1e{p}", f"piezo.loss_tangent=1e-{p}", *_FREE))
        for p in range(1, 10, 2)
    ),
)  # fmt: skip
_FREQUENCY = Sweep("frequency", "1 µHz to 1 GHz", tuple(decades("frequency", "Hz", -6, 9, *_FREE)))
_TAPER = Sweep(
    "taper", "tip 1 to 1e-4 times as wide as the base",
    tuple(
        (f"tip/base 1e-{p}", (f"bimorph.width_profile=0 mm: 2 mm, 14 mm: {2.0 * 10.0**-p:g} mm",))
        for p in range(5)
    ),
)  # fmt: skip
_CAD_LENGTH = Sweep(
    "length", "0.5 to 100 mm",
    tuple(
        (f"{length} mm", (f"bimorph.length={length} mm", "mesh.level=2"))
        for length in (0.5, 5, 100)
    ),
    quick=(0,),
)  # fmt: skip
_CAD_SHIM = Sweep("shim over ceramic", "shim 1e-2 to 1e2 times as thick", tuple(
    (where, (*overrides, "mesh.level=2")) for where, overrides in _SHIM.points[1:6:2]
), quick=())  # fmt: skip


def run(asked: Asked) -> Stress:
    """Run all families: seconds if quick, else some minutes."""
    started = time.perf_counter()
    rows = asked.rows("lateral", _families(asked.quick))
    return Stress("lateral", _STATEMENT, rows, (), (), time.perf_counter() - started)


def _families(quick: bool) -> Families:
    general = (_LENGTH, _SHIM, _SUPPORT, _MASS, _TAPER)
    families = {
        f"{pair.judged} against {pair.witness}, {sweep.family}": partial(pair.row, sweep)
        for pair, sweeps in (
            (_LUMPED, general),
            (_BEAM, (*general, _QUALITY, _FREQUENCY)),
            (_CAD, (_CAD_LENGTH, _CAD_SHIM)),
        )
        for sweep in sweeps
    }
    if quick:
        return families
    return {**families, "reduced basis against the bricks of its members": lambda _: family_row()}


def family_row() -> Row:
    """Let a reduced basis span lengths from stout to slender; ask it at its ends and between."""
    from tactgen.validation.models.bimorph.family.solid_family import solid_family
    from tactgen.validation.models.bimorph.family.values import family_values

    names = ("static_tip_displacement", "capacitance_free", "short_circuit_frequencies")
    scene, _ = load_scene("j1", ["accuracy=5e-3", "modes=2"])
    family, low, high = Family(), 4e-3, 60e-3
    basis = solid_family(scene, {"bimorph.length": (low, high)}, names)
    lengths = np.geomspace(low, high, 5)
    found = family_values(scene, basis, {"bimorph.length": lengths}, names)
    for number, length in enumerate(lengths):
        member, _ = load_scene(
            "j1", ["accuracy=5e-3", "modes=2", f"bimorph.length={1e3 * length:.12g} mm"]
        )
        single = solve(member, ("solid",), names)
        for name in names:
            alone = single.get(name, "solid")
            values, bars = found[name].value[number], found[name].error[number]
            size = np.abs(alone.value)
            errors = np.ravel(np.abs(values - alone.value) / size)
            bounds = np.ravel((bars + alone.error) / size)
            at = int(np.argmax(errors / bounds))
            where = f"{1e3 * length:.3g} mm, {name}"
            family.add(where, float(errors[at]), float(bounds[at]))
    for outside in (0.99 * low, 1.01 * high):
        try:
            family_values(scene, basis, {"bimorph.length": np.array([outside])}, names[:1])
            family.add(f"{outside:g} m, outside", np.inf, 0.0)
        except REFUSALS as error:
            family.refuse(error)
    return answered(
        "reduced basis: range", "lengths 4 to 60 mm by one basis, and just outside",
        family.points, family.refusals,
    )  # fmt: skip
