"""The figure of what the lateral actuator may be driven with."""

from __future__ import annotations

from collections.abc import Mapping

from tactgen.geometry.arrays import Floats
from tactgen.validation.catalogue.quantities import REASONS
from tactgen.validation.view.figures import BLUE, GREEN, ORANGE, panels, svg


def limits_plot(frequencies: Floats, limits: Mapping[str, Floats], voltage: float) -> str:
    """Plot the voltage at which each limit is reached, one column per load.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    limits : mapping of str to (3, n) array
        Title of each load case, and the limits (V) in the order of
        :data:`validation.catalogue.quantities.REASONS`.
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
