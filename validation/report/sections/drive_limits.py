"""The report's section on what the lateral actuator may be driven with."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.ends import Ends
from tactgen.tmm.beam.port_quantities import driven_ceramic
from tactgen.tmm.beam.transfer_matrix import multiport
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import in_series, respond
from tactgen.tmm.ports.readout import ELECTRICAL
from tactgen.validation.catalogue.quantities import REASONS, voltage_limits
from tactgen.validation.report.sections.section import Context
from tactgen.validation.report.study import Study
from tactgen.validation.show.figures import BLUE, GREEN, ORANGE, panels, svg


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
