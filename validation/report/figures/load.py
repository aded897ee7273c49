"""The figure of what the tip touches, and of what it takes."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.device.load_table import LoadTable
from tactgen.validation.view.figures import BLUE, GREY, ORANGE, panels, svg


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
