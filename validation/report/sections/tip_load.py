"""Report section on the load of the tip (the paper's Figs 4 and 6)."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.device.load_table import LoadTable
from tactgen.tmm.ports.elements import tip_stiffness
from tactgen.tmm.ports.loads import (
    FINGER_RANGE,
    MeasuredLaw,
    continued,
    finger_form,
    finger_impedance,
)
from tactgen.validation.catalogue.quantities import LOAD_FORCE, LOAD_POWER
from tactgen.validation.engine.solve import solve
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections.section import Context
from tactgen.validation.show.figures import BLUE, GREY, ORANGE, panels, svg


def load_plot(
    frequencies: Floats, stiffness: Complex, force: Floats, power: Floats, table: LoadTable | None
) -> str:
    """Plot impedance (the paper's Fig 4), stiffness and damping (Fig 6), force and power.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    stiffness : (n,) complex array
        Dynamic stiffness (N/m).
    force, power : (n,) array
        Amplitude of the tip's force on the load (N), mean power into it (W).
    table : LoadTable or None
        Points that were measured.
    """
    omega = 2.0 * np.pi * frequencies
    figure, axes = panels(10.0, 5.6, nrows=2, ncols=3, sharex=True)
    impedance = stiffness / (1j * omega)
    shown = (
        (np.abs(impedance), "|Z| (N s/m)"),
        (stiffness.real, "stiffness Re K (N/m)"),
        (1e3 * force, "force on it (mN)"),
        (np.degrees(np.angle(impedance)), "arg Z (°)"),
        (stiffness.imag / omega, "damping Re Z (N s/m)"),
        (1e6 * power, "mean power into it (µW)"),
    )
    for axis, (values, label), colour in zip(
        axes.ravel(), shown, (BLUE, BLUE, ORANGE) * 2, strict=True
    ):
        axis.plot(frequencies, values, color=colour)
        axis.set_xscale("log")
        axis.set_ylabel(label)
    if table is not None:
        z, k = table.impedance, 2j * np.pi * table.frequencies * table.impedance
        points = {
            (0, 0): np.abs(z),
            (0, 1): k.real,
            (1, 0): np.degrees(np.angle(z)),
            (1, 1): z.real,
        }
        for place, measured in points.items():
            axes[place].plot(
                table.frequencies, measured, ".", color=GREY, markersize=3, label="table"
            )
        axes[0, 0].legend(frameon=False)
    for axis in axes[1]:
        axis.set_xlabel("frequency (Hz)")
    return svg(figure)


#: Points at which a load is drawn, and rows of its table.
_POINTS, _ROWS = 300, 7


def load_section(study: Study) -> Context | None:
    """Load over frequency and its absorbed power; None for a free tip."""
    scene = study.scene
    tip = scene.ends.tip
    if scene.load.kind == "none":
        return None
    asked = [f for f in scene.frequency if f > 0.0]
    if not asked or min(asked) == max(asked):
        return None
    study.announce("what the tip touches")
    frequencies = np.geomspace(min(asked), max(asked), _POINTS)
    stiffness = tip_stiffness(tip, frequencies)
    moved = scene.model_copy(update={"frequency": tuple(frequencies.tolist())})
    taken = solve(moved, ("tmm",), (LOAD_FORCE.name, LOAD_POWER.name))
    force, power = (taken.get(row.name, "tmm").value for row in (LOAD_FORCE, LOAD_POWER))
    table = tip.table if isinstance(tip, MeasuredLaw) else None
    return {
        "kind": scene.load.kind,
        "rows": _rows(frequencies, stiffness, force, power),
        "picture": load_plot(frequencies, stiffness, np.abs(force), power, table),
        "measured": _measured(tip),
        "passive": _passive(scene.load.kind),
    }


def _rows(
    frequencies: Floats, stiffness: Complex, force: Complex, power: Floats
) -> list[dict[str, Any]]:
    picked = np.linspace(0, frequencies.size - 1, _ROWS).round().astype(int)
    omega = 2.0 * np.pi * frequencies
    return [
        {
            "frequency": float(frequencies[i]),
            "impedance": float(abs(stiffness[i]) / omega[i]),
            "phase": float(np.degrees(np.angle(stiffness[i] / (1j * omega[i])))),
            "stiffness": float(stiffness[i].real),
            "damping": float(stiffness[i].imag / omega[i]),
            "force": float(abs(force[i])),
            "power": float(power[i]),
        }
        for i in picked
    ]


def _measured(tip: object) -> Context | None:
    """Fits of a load table: the paper's form; springs, dampers and masses."""
    if not isinstance(tip, MeasuredLaw):
        return None
    form = finger_form(tip.table)
    apart = np.abs(form.impedance(tip.table.frequencies) / tip.table.impedance - 1.0)
    largest, usual = continued(tip.table).misfit
    return {
        "band": tip.table.band,
        "points": tip.table.frequencies.size,
        "p": form.p.tolist(),
        "q": form.q.tolist(),
        "form_largest": float(apart.max()),
        "fit_largest": largest,
        "fit_usual": usual,
        "stands_for_it": bool(tip.fits),
    }


def _passive(kind: str) -> float | None:
    """Distance of the paper's finger from any passive load (rms)."""
    if kind != "finger":
        return None
    at = np.geomspace(*FINGER_RANGE, _POINTS)
    return continued(LoadTable("the finger", at, finger_impedance(at))).misfit[1]
