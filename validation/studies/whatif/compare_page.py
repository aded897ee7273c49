"""A comparison as one self-contained page: tables, curves, devices side by side."""

from __future__ import annotations

import html
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.geometry.formats import prefixed
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.figures import BLUE, ORANGE, panels, plain_numbers, svg
from tactgen.validation.show.page import inline, plain_page, table
from tactgen.validation.studies.whatif.compare import (
    ANSWERS,
    INPUTS,
    NOTHING_SHARED,
    AnswerDifference,
    Key,
    Side,
)

#: File of the page.
FILE = "compare.html"
#: Most curves of one quantity that are drawn.
_CURVES = 6
#: Height of the taller of two devices on the page (rem).
_TALLEST = 26.0


def write_page(
    folder: Path,
    sides: tuple[Side, ...],
    inputs: list[tuple[str, str, str]],
    answers: list[AnswerDifference],
    solids: Callable[[Scene], dict[str, Any]],
) -> Path:
    """Write the page, whole or not at all; `solids` gives the CAD solids of a scene by name."""
    first, second = sides
    parts = [f"<p>A is {html.escape(first.name)}, B is {html.escape(second.name)}.</p>"]
    parts += ["<h2>Input that differs</h2>", table(INPUTS, inputs) if inputs else "<p>None.</p>"]
    parts.append("<h2>Answers, where they differ most</h2>")
    rows = [d.cells for d in answers]
    parts.append(table(ANSWERS, rows) if rows else f"<p>{NOTHING_SHARED}.</p>")
    parts.append(
        "<p>A change is covered if it is no larger than both error bars together. The bars are "
        "numerical: how far a number is from the same model solved exactly.</p>"
    )
    picture = _curves(sides)
    if picture:
        parts += ["<h2>Curves</h2>", f"<figure>{picture}</figure>"]
    parts += _devices(sides, inputs, solids)
    title = f"Comparison of {first.name} and {second.name}"
    return write_text(folder / FILE, plain_page(title, parts))


def _curves(sides: tuple[Side, ...]) -> str:
    """Curves over frequency, or over the first numeric axis; nothing if there are none."""
    found: dict[str, dict[str, tuple[list[tuple[float, float]], ...]]] = {}
    labels: dict[str, tuple[str, str]] = {}
    for number, side in enumerate(sides):
        for key, value in side.numbers.items():
            place = _place(key)
            if place is not None and (key.frequency or not np.isnan(value.value)):
                along, x, curve = place
                labels[key.quantity] = along, value.unit
                both = found.setdefault(key.quantity, {}).setdefault(curve, ([], []))
                both[number].append((x, abs(value.value)))
    found = {q: {c: v for c, v in of.items() if max(map(len, v)) > 1} for q, of in found.items()}
    found = {q: of for q, of in found.items() if of}
    if not found:
        return ""
    figure, grid = panels(8.0, 3.0 * len(found), nrows=len(found), squeeze=False)
    for axis, (quantity, curves) in zip(grid[:, 0], found.items(), strict=True):
        sizes = np.array([y for both in curves.values() for line in both for _, y in line])
        along, unit = labels[quantity]
        scale, unit = prefixed(float(sizes.max()), unit)
        for curve, both in list(curves.items())[:_CURVES]:
            for points, colour, name in zip(both, (BLUE, ORANGE), "AB", strict=True):
                line = np.array(sorted(points)).reshape(-1, 2)
                axis.plot(line[:, 0], scale * line[:, 1], "--" if name == "B" else "-",
                          color=colour, linewidth=1.2, label=f"{name} {curve}")  # fmt: skip
        axis.set_ylabel(f"{quantity.replace('_', ' ')} ({unit})")
        axis.set_xlabel(along)
        if sizes.min() > 0.0 and sizes.max() > 30.0 * sizes.min():
            axis.set_yscale("log")
            plain_numbers(axis.yaxis)
        axis.legend(fontsize=8)
    return svg(figure)


def _place(key: Key) -> tuple[str, float, str] | None:
    """Heading and value of a number's abscissa, and its curve: model, index, all other axes."""
    rest = dict(key.point)
    if key.frequency:
        along, x = "frequency (Hz)", float(key.frequency)
    else:
        numeric = [heading for heading, value in key.point if _is_number(value)]
        if not numeric:
            return None
        along = numeric[0]
        x = float(rest.pop(along))
    index = (f"no. {key.number}",) if key.number else ()
    return along, x, " ".join((key.model, *index, *rest.values()))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _devices(
    sides: tuple[Side, ...],
    inputs: list[tuple[str, str, str]],
    solids: Callable[[Scene], dict[str, Any]],
) -> list[str]:
    """Pictures of both devices, if a dimension of them differs and they can be drawn.

    They have one scale: what is longer looks longer.
    """
    from tactgen.validation.show.pictures import solids_pictures

    shapes = ("bimorph.", "rod.", "coil.", "sleeve.", "support.kind", "gap", "glue.")
    if not any(key.startswith(shapes) for key, *_ in inputs):
        return []
    try:
        pictures = solids_pictures([solids(side.scene) for side in sides])
    except InputError as error:  # profiles have no CAD solids; a library may be missing
        return [f"<p>No picture of the devices: {html.escape(str(error))}</p>"]
    heights = [int.from_bytes(png[20:24], "big") for png in pictures]  # as a PNG states it
    figures = "".join(
        f'<figure><img alt="device {name}" src="{inline(png)}" '
        f'style="height:{_TALLEST * height / max(heights):.2f}rem">'
        f"<figcaption>{name}: {html.escape(side.name)}</figcaption></figure>"
        for png, height, name, side in zip(pictures, heights, "AB", sides, strict=True)
    )
    return ["<h2>Devices, at one scale</h2>", f'<div class="pair">{figures}</div>']
