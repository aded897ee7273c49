"""Rod and tip over time, the phases behind them, as inline SVG."""

from __future__ import annotations

from tactgen.validation.models.generator.phases import phases
from tactgen.validation.models.generator.transient import Simulation
from tactgen.validation.view.figures import AMBER, BLUE, GREEN, GREY, ORANGE, SKY, panels, svg

_SHADES = {"held": SKY, "rising": AMBER, "pressed": GREY, "falling": GREEN}


def time_plot(found: Simulation) -> str:
    """Plot lift, lateral tip, coil current and stop forces over time; phases as background."""
    run, outputs = found.answer.run, found.answer.outputs
    figure, axes = panels(9.0, 7.0, nrows=4, sharex=True)
    time = 1e3 * run.time
    for axis, values, label, colour in (
        (axes[0], 1e6 * outputs["rod_lift"], "rod (µm)", ORANGE),
        (axes[1], 1e6 * outputs["lateral_tip"], "tip, lateral (µm)", BLUE),
        (axes[2], 1e3 * run.current, "coil current (mA)", GREEN),
    ):
        axis.plot(time, values, color=colour, linewidth=1.0)
        axis.set_ylabel(label)
    for name, colour in (("upper_stop", ORANGE), ("lower_stop", BLUE)):
        force = 1e3 * found.stop_force[name]
        axes[3].plot(time, force, color=colour, linewidth=1.0, label=name.replace("_", " "))
    axes[3].set_yscale("symlog", linthresh=100.0)
    axes[3].set_ylabel("force (mN)")
    axes[3].set_xlabel("time (ms)")
    axes[3].legend(fontsize=8)
    for phase in phases(found):
        for axis in axes[:2]:
            axis.axvspan(
                1e3 * phase.start, 1e3 * phase.end, color=_SHADES[phase.name], alpha=0.15, lw=0
            )
        axes[0].text(
            0.5e3 * (phase.start + phase.end), 0.9, phase.name,
            transform=axes[0].get_xaxis_transform(), ha="center", fontsize=7, clip_on=True,
        )  # fmt: skip
    axes[0].margins(y=0.15)
    return svg(figure)
