"""The report's section on the voltage at the detection threshold (the paper's Fig 17)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.tmm.beam.port_quantities import driven_ceramic
from tactgen.tmm.beam.transfer_matrix import multiport
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import in_series, respond
from tactgen.tmm.ports.readout import ELECTRICAL
from tactgen.validation.catalogue.detection import (
    DISPLAY_THRESHOLD,
    HIGHEST_SUBJECT,
    LITERATURE_BOUND,
    STATED_VOLTAGES,
)
from tactgen.validation.catalogue.quantities import REASONS, voltage_limits
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections.length import drawn
from tactgen.validation.report.sections.section import Context
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.figures import BLUE, GREEN, GREY, ORANGE, new_figure, panels, svg
from tactgen.validation.studies.design_statements import LOADS
from tactgen.validation.studies.excitation_voltage import (
    CASES,
    WIRINGS,
    Case,
    PerVolt,
    VoltageStudy,
    loaded,
    voltage_study,
)

#: One style per wiring and load, in every plot of voltages.
VOLTAGE_STYLE: dict[Case, dict[str, Any]] = {
    ("parallel", "loaded"): {"color": BLUE, "linestyle": "-"},
    ("parallel", "free"): {"color": BLUE, "linestyle": "--"},
    ("series", "loaded"): {"color": ORANGE, "linestyle": "-"},
    ("series", "free"): {"color": ORANGE, "linestyle": "--"},
}


def section(scene: Scene, announce: Callable[[str], None]) -> dict[str, Any] | None:
    """Section of the report; None for an actuator that does not move."""
    if scene.piezo.d31 == 0.0:
        return None
    announce("excitation voltage")
    study = voltage_study(scene)
    kind = loaded(scene).load.kind
    loads = {"loaded": LOADS[kind], "free": "free tip"}
    return {
        "study": study,
        "findings": findings(study),
        "cases": CASES,
        "loads": loads,
        "finger": kind == "finger",
        "threshold": DISPLAY_THRESHOLD,
        "bound": LITERATURE_BOUND,
        "highest": HIGHEST_SUBJECT,
        "plot": voltage_plot(study.frequencies, study.voltages, loads),
    }


def findings(study: VoltageStudy) -> tuple[str, ...]:
    """Findings of the comparison, as sentences."""
    found = []
    wide = study.stated[-1]
    lowest, most = wide.paper.voltages
    for wiring in WIRINGS:
        ratios = [r for s in study.stated if (r := s.ratio((wiring, "loaded"))) is not None]
        highest = wide.model[wiring, "loaded"][1]
        found.append(
            f"Loaded and wired in {wiring}, the model needs {min(ratios):.2g} to {max(ratios):.2g} "
            f"times the single voltages stated up to 250 Hz, and up to {highest:.3g} V between "
            f"250 and 1000 Hz, where {lowest:g} to {most:g} V were enough."
        )
        if max(ratios) < 1.0 < highest / most:
            found.append(
                f"In {wiring} wiring it thus moves too much per volt at low frequency and too "
                "little towards 1000 Hz: no constant factor, be it wiring, amplifier, d31 or a "
                "threshold higher throughout, mends both."
            )
    found += [_of_load(moved) for moved in study.moved]
    between = DISPLAY_THRESHOLD.at(np.array([study.implied_at]))[0]
    found.append(
        f"Between the stated points the threshold is itself in doubt. At {study.implied_at:g} Hz "
        f"it is interpolated as {1e6 * between:.2g} µm; the stated voltage there, times the "
        "paper's own displacement per volt interpolated in the same way, is "
        f"{1e6 * study.implied:.2g} µm."
    )
    return tuple(found)


def _of_load(moved: PerVolt) -> str:
    """Load that would reconcile model and paper at one frequency."""
    at = f"At {moved.frequency:g} Hz"
    parts = [
        f"{_as_large(factor)} ({wiring})"
        for wiring, factor in moved.load_factor.items()
        if factor is not None
    ]
    if not parts:
        return f"{at} no load of that phase would: even the free tip moves less than the paper's."
    return f"{at} a load {' or '.join(parts)} would give the paper's displacement per volt."


def _as_large(factor: float) -> str:
    times = f"{factor:.2g}"
    return "just as large" if times == "1" else f"{times} times as large"


def voltage_plot(
    frequencies: Floats, voltages: Mapping[Case, Floats], loads: Mapping[str, str]
) -> str:
    """Plot the voltage at the detection threshold beside the paper's.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    voltages : dict of (wiring, "loaded" or "free") to (n,) array
        V.
    loads : dict
        Title of each load.
    """
    figure = new_figure(9.0, 6.4)
    axes = figure.subplot_mosaic([["voltage"], ["threshold"]], height_ratios=(1.7, 1.0))
    axis = axes["voltage"]
    for case, values in voltages.items():
        wiring, load = case
        axis.plot(frequencies, values, lw=1.8, label=f"{wiring}, {loads[load]}",
                  **VOLTAGE_STYLE[case])  # fmt: skip
    for stated in STATED_VOLTAGES:
        low, high = stated.frequencies
        if low == high:
            axis.plot(low, stated.voltages[0], "ks", clip_on=False)
        else:
            axis.fill_between([low, high], *stated.voltages, color="black", alpha=0.15)
    axis.plot([], [], "ks", label="paper, mean of subjects (grey: its range)")
    axis.plot(HIGHEST_SUBJECT.frequencies[0], HIGHEST_SUBJECT.voltages[0], "k+", ms=9,
              label="paper, highest of all subjects")  # fmt: skip
    axis.set(xscale="log", yscale="log", xlim=(frequencies[0], frequencies[-1]))
    axis.set_ylabel("voltage amplitude (V)")
    axis.legend(frameon=False, fontsize=8, ncols=2, loc="lower center")
    _threshold(axes["threshold"], frequencies)
    return drawn(figure)


def _threshold(axis: Any, frequencies: Floats) -> None:
    axis.plot(frequencies, 1e6 * DISPLAY_THRESHOLD.at(frequencies), "k--", lw=1.4,
              label="interpolated")  # fmt: skip
    points = np.array([(p.frequency, p.amplitude) for p in DISPLAY_THRESHOLD.points]).T
    axis.plot(points[0], 1e6 * points[1], "k^", clip_on=False, label="in the text (display, 50 g)")
    bound = LITERATURE_BOUND
    axis.hlines(1e6 * bound.amplitude, bound.frequency, frequencies[-1], color=GREY,
                label="literature: below this above 100 Hz")  # fmt: skip
    axis.set(xscale="log", yscale="log", xlim=(frequencies[0], frequencies[-1]))
    axis.set_xlabel("frequency (Hz)")
    axis.set_ylabel("threshold (µm)")
    axis.legend(frameon=False, fontsize=8)


def limits_plot(frequencies: Floats, limits: Mapping[str, Floats], voltage: float) -> str:
    """Plot the voltage at which each limit is reached, one column per load.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    limits : mapping of str to (3, n) array
        Title of each load case, and the limits (V) in the order of
        :data:`validation.catalogue.safe_drive.REASONS`.
    voltage : float
        The scene's drive (V).
    """
    figure, axes = panels(10.0, 3.6, ncols=len(limits), sharey=True, squeeze=False)
    for axis, (title, found) in zip(axes[0], limits.items(), strict=True):
        for reason, curve, colour in zip(REASONS, found, (ORANGE, BLUE, GREEN), strict=True):
            axis.plot(frequencies, curve, color=colour, label=reason)
        axis.fill_between(frequencies, found.min(axis=0), color=BLUE, alpha=0.08, linewidth=0.0)
        axis.axhline(voltage, color="black", linewidth=0.8, linestyle=":", label="this scene")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_title(title)
        axis.set_xlabel("frequency (Hz)")
    axes[0][0].set_ylabel("drive voltage, peak (V)")
    axes[0][0].legend(frameon=False)
    return svg(figure)


#: Frequencies added to the scene's: a peak lies between two of them.
_POINTS = 800


def drive_limits_section(study: Study) -> Context | None:
    """Limits under the scene's load and with a free tip, None for layers not plain."""
    scene = study.scene
    asked = np.asarray(scene.frequency, dtype=float)
    low = max(float(asked.min()), 1e-3 * float(asked.max()))
    if not float(asked.max()) > low:
        return None
    frequencies = np.geomspace(low, float(asked.max()), _POINTS)
    cases = {"free tip": Ends(scene.ends.base)}
    if scene.load.kind != "none":
        cases = {"under the load": scene.ends, **cases}
    port = multiport(scene.device, scene.support, scene.beam, frequencies)
    port = in_series(port) if scene.bimorph.wiring == "series" else port
    found, rows = {}, []
    for title, ends in cases.items():
        response = respond(attach(port, ends), {ELECTRICAL: 1.0})
        driven = driven_ceramic(scene.device, scene.beam, ends, frequencies, response)
        if np.isnan(driven.stress).any():
            return None
        found[title] = voltage_limits(driven, scene.limits)
        at = np.unravel_index(int(np.argmin(found[title])), found[title].shape)
        rows.append(
            {
                "load": title,
                "voltage": float(found[title][at]),
                "frequency": float(frequencies[at[1]]),
                "reason": REASONS[int(at[0])],
                "stress": float(driven.stress.max()) * abs(scene.drive.voltage),
                "stress_at": float(frequencies[int(driven.stress.argmax())]),
            }
        )
    picture = limits_plot(frequencies, found, abs(scene.drive.voltage))
    return {"rows": rows, "picture": picture, "limits": scene.limits}
