"""Errors of the transfer matrix over frequency and length, beside those of the printed formulas."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.files import write_text
from tactgen.geometry.store.values import storable
from tactgen.tmm.beam.sections import Section
from tactgen.validation.evidence.cases import exact_beam as reference
from tactgen.validation.evidence.cases import textbook_beam
from tactgen.validation.evidence.judgement import cached_by_code
from tactgen.validation.evidence.stress_beam import (
    KINDS,
    attached,
    beam_of,
    compared,
    entry_error,
    exactly,
    finite,
    plane,
)
from tactgen.validation.show.figures import new_figure, svg


@storable
@dataclass(frozen=True)
class ErrorMap:
    """Errors over frequency (Hz) and length (m), each (n_length, n_frequency)."""

    title: str
    frequencies: Floats
    lengths: Floats
    error: Floats
    #: Of the printed formulas; infinite where they overflow, nan if not defined
    naive: Floats


def write_maps(out: Path, *, quick: bool) -> list[Path]:
    """Write a CSV and an SVG of either map, lossy and lossless; return the files."""
    written = []
    for number, lossy in enumerate((True, False), start=1):
        table: ErrorMap = cached_by_code(
            "stress", ("map", lossy, quick), __name__, partial(error_map, lossy, quick=quick)
        )
        stem = f"stress-tmm-map-{number}"
        columns = ("length_m", "frequency_hz", "error", "naive")
        grid = np.meshgrid(table.lengths, table.frequencies, indexing="ij")
        values = np.stack([*grid, table.error, table.naive], axis=-1).reshape(-1, 4)
        written.append(write_csv(out / f"{stem}.csv", columns, values.tolist()))
        written.append(write_text(out / f"{stem}.svg", map_plot(table)))
    return written


def error_map(lossy: bool, *, quick: bool) -> ErrorMap:
    """Errors over length and frequency, and those of the printed formulas."""
    lengths, frequencies = plane(quick)
    beam, (name, ends) = beam_of(lossy=lossy), KINDS[lossy]
    points = [[(beam, l, f, ends) for f in frequencies] for l in lengths]
    ours = np.array([[compared(*at)[0] for at in row] for row in points])
    naive = np.array([[by_printed_formulas(*at) for at in row] for row in points])
    return ErrorMap(name, np.array(frequencies), np.array(lengths), ours, naive)


def by_printed_formulas(beam: Section, length: float, frequency: float, ends: Ends) -> float:
    """The same error of the paper's matrix A; nan at 0 Hz."""
    if not frequency:
        return math.nan
    f, (base, tip) = np.array([frequency]), attached(ends, frequency)
    exact, (w_tip, *_) = exactly(beam, length, frequency, ends)
    a = textbook_beam.transfer(beam, length, f)
    velocity = textbook_beam.response(a, f, base=base, tip=tip)[0, 0]
    return max(
        entry_error(textbook_beam.dynamic_stiffness(beam, length, f)[0], exact),
        finite(reference.relative_error(velocity / (2j * np.pi * frequency), w_tip)),
    )


def map_plot(table: ErrorMap) -> str:
    """Plot errors over frequency and length, ours beside the naive formulas'.

    Colours are decades of relative error; black is no correct digit, overflow or 0/0.
    """
    import matplotlib as mpl
    from matplotlib.ticker import EngFormatter

    figure = new_figure(10.0, 3.4)
    axes = figure.subplots(1, 2, sharey=True)
    colours = mpl.colormaps["viridis"].with_extremes(over="black", bad="black")
    for axis, title, values in zip(
        axes, ("this model", "matrix A"), (table.error, table.naive), strict=True
    ):
        shown = np.log10(np.clip(values, 1e-17, 1e300))
        image = axis.pcolormesh(
            table.frequencies, table.lengths, shown, cmap=colours, vmin=-17.0, vmax=0.0,
            shading="nearest",
        )  # fmt: skip
        axis.set_xscale("symlog", linthresh=table.frequencies[1])  # 0 Hz has a cell, too
        axis.set_yscale("log")
        axis.set_xticks([0.0, *10.0 ** np.arange(-3.0, 7.0, 3.0)])
        axis.xaxis.set_major_formatter(EngFormatter("Hz"))
        axis.yaxis.set_major_formatter(EngFormatter("m"))
        axis.set_title(f"{title}: {table.title}", fontsize="medium")
        axis.set_xlabel("frequency")
    axes[0].set_ylabel("length")
    figure.colorbar(image, ax=axes.tolist(), label="log10 of the relative error", extend="max")
    return svg(figure)
