"""The report's section on the voltage at the detection threshold (the paper's Fig 17)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tactgen.validation.catalogue.detection import (
    DISPLAY_THRESHOLD,
    HIGHEST_SUBJECT,
    LITERATURE_BOUND,
)
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.design.excitation_voltage import (
    CASES,
    WIRINGS,
    PerVolt,
    VoltageStudy,
    loaded,
    voltage_study,
)
from tactgen.validation.studies.design.wording import LOADS


def section(scene: Scene, announce: Callable[[str], None]) -> dict[str, Any] | None:
    """Return what the report shows of it; None for an actuator that does not move."""
    if scene.piezo.d31 == 0.0:
        return None
    from tactgen.validation.studies.design.plots import voltage_plot

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
    """Return what the comparison says, in sentences made from its numbers."""
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
    """Return what load would reconcile model and paper at one frequency."""
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
