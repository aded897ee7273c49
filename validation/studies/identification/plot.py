"""The picture of an identification: data, fit, its band, and what is left over."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text, written_whole
from tactgen.geometry.units import quoted
from tactgen.validation.studies.identification.curve_model import curve_model
from tactgen.validation.studies.identification.estimates import Identification
from tactgen.validation.view.figures import BLUE, GREY, ORANGE, panels, svg
from tactgen.validation.view.formats import engineering

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DATA: dict[str, Any] = {
    "color": BLUE, "linestyle": "none", "marker": "o", "markersize": 3.0,
    "markerfacecolor": "none", "markeredgewidth": 0.8,
}  # fmt: skip
_FIT: dict[str, Any] = {"color": ORANGE, "linewidth": 1.8}
_START: dict[str, Any] = {"color": GREY, "linewidth": 1.2, "linestyle": "--"}
_BAND: dict[str, Any] = {"color": ORANGE, "alpha": 0.35, "linewidth": 0.0}
#: Points of the smooth curves, and points above which markers become an image.
_SMOOTH, _MANY = 600, 3000


def checked_plot_name(name: str) -> Path:
    """Return where a plot goes.

    Raises
    ------
    InputError
        If the name says no format that is known.
    """
    path = Path(name)
    if path.suffix.lower() not in (".svg", ".png"):
        raise InputError(
            f"--plot {quoted(name)} does not end in .svg or .png; choose one of the two"
        )
    return path


def write_plot(found: Identification, path: Path) -> Path:
    """Write the picture as SVG or PNG, by the file's suffix.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    figure = draw(found)
    if path.suffix.lower() == ".svg":
        return write_text(path, svg(figure))
    with written_whole(path) as temporary:
        figure.savefig(temporary, format="png", dpi=150)
    return path


def draw(found: Identification) -> Figure:
    """Return the figure: magnitude and, if measured, phase, each above its residuals."""
    columns = 2 if found.curve.has_phase else 1
    figure, axes = panels(
        6.0 + 5.0 * (columns - 1),
        6.0,
        nrows=2,
        ncols=columns,
        sharex=True,
        squeeze=False,
        gridspec_kw={"height_ratios": [2.0, 1.0]},
    )
    _draw_curves(axes[0], found)
    fitted, left = np.abs(found.fitted), found.residuals
    level = {
        "relative": found.level / np.sqrt(found.curve.relative_weight),
        "constant": found.level / np.sqrt(found.curve.relative_weight) / fitted,
        "stated": np.ones(1) if found.curve.error is None else found.curve.error / fitted,
    }[found.noise]
    _draw_residuals(
        axes[1][0], found, 100.0 * np.expm1(left.real), 100.0 * found.band.real, 100.0 * level
    )
    axes[1][0].set_ylabel("data/fit − 1 (%)")
    if columns == 2:
        degrees = np.rad2deg(1.0)
        _draw_residuals(
            axes[1][1], found, degrees * left.imag, degrees * found.band.imag, degrees * level
        )
        axes[1][1].set_ylabel("phase, data − fit (°)")
    for axis in axes[1]:
        axis.set_xlabel("frequency (Hz)")
    f = found.curve.frequencies
    for axis in axes.ravel():
        # as the measurement was spaced: each point then has its own place
        if np.median(f) < 0.25 * (f[0] + f[-1]):
            axis.set_xscale("log")
    figure.suptitle(_title(found), fontsize=10)
    return figure


def _title(found: Identification) -> str:
    values = [
        f"{e.parameter.symbol} = {e.parameter.unit.show(float(f'{e.value:.4g}'))}"
        for e in found.estimates
    ]
    name = f"{Path(found.curve.source).name}, scene {found.scene.name}"
    width = 120 if found.curve.has_phase else 70
    text = "\n".join(fill(line, width) for line in (name, ",  ".join(values)))
    return text.replace("$", r"\$")  # not a formula


def _draw_curves(axes: Any, found: Identification) -> None:
    curve = found.curve
    low, high = float(curve.frequencies[0]), float(curve.frequencies[-1])
    spaced = (np.geomspace(low, high, _SMOOTH), np.linspace(low, high, _SMOOTH))
    f = np.unique(np.clip(np.concatenate(spaced), low, high))  # geomspace rounds its ends
    quantity, none = curve.quantity.name, np.zeros(0)
    before, after = (curve_model(s, quantity, f, ())(none) for s in (found.start, found.scene))
    factor, unit = _shown(np.abs(after), curve.unit)
    many = curve.frequencies.size > _MANY
    axes[0].plot(f, factor * np.abs(before), label="start", **_START)
    axes[0].plot(
        curve.frequencies, factor * np.abs(curve.values), label="data", rasterized=many, **_DATA
    )
    axes[0].plot(f, factor * np.abs(after), label="fit", **_FIT)
    axes[0].set_yscale("log")
    axes[0].set_ylabel(f"{curve.kind} ({unit})")
    axes[0].legend(frameon=False, loc="best")
    if curve.has_phase:
        fitted = np.rad2deg(np.unwrap(np.angle(after)))
        # the data lie on the fit's branch: its phase plus what is left over
        at_data = np.interp(curve.frequencies, f, fitted)
        wrapped = np.rad2deg(np.angle(curve.values * np.exp(-1j * np.deg2rad(at_data))))
        start = np.rad2deg(np.angle(before * np.exp(-1j * np.deg2rad(fitted))))
        axes[1].plot(f, fitted + start, **_START)
        axes[1].plot(curve.frequencies, at_data + wrapped, rasterized=many, **_DATA)
        axes[1].plot(f, fitted, **_FIT)
        axes[1].set_ylabel("phase against the voltage (°)")


def _shown(values: Floats, unit: str) -> tuple[float, str]:
    """Return the factor and the prefixed unit in which the largest value is 1 to 1000."""
    largest = float(values.max())
    shown, prefixed = engineering(largest, unit, 12).split(" ")
    return float(shown) / largest, prefixed


def _draw_residuals(
    axis: Axes, found: Identification, left: Floats, band: Floats, level: Floats
) -> None:
    f = found.curve.frequencies
    axis.plot(f, left, rasterized=f.size > _MANY, **_DATA)
    axis.fill_between(f, -band, band, label="95 % band of the fit", **_BAND)
    axis.axhline(0.0, **_FIT)
    for sign in (-1.0, 1.0):
        label = "noise (1 σ)" if sign > 0.0 else None
        axis.plot(f, sign * level, color="#555555", linewidth=0.9, linestyle=":", label=label)
    # constant noise dwarfs small values: show where most points are
    reach = max(4.0 * float(np.median(np.abs(left))), 1.3 * float(np.median(level)), 1e-9)
    axis.set_ylim(-1.6 * reach, 1.6 * reach)
    axis.legend(loc="upper left", ncols=2, fontsize="small", edgecolor="none", framealpha=0.85)
