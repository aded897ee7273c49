"""A comparison as one self-contained page: tables, curves, devices side by side."""

from __future__ import annotations

import html
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.geometry.formats import percent, prefixed
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.figures import BLUE, ORANGE, panels, plain_numbers, svg
from tactgen.validation.show.page import inline, plain_page, table
from tactgen.validation.studies.whatif.compare import (
    NOTHING_SHARED,
    AnswerDifference,
    InputDifference,
    Key,
    Side,
    format_number,
    place,
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
    inputs: list[InputDifference],
    answers: list[AnswerDifference],
    solids: Callable[[Scene], dict[str, Any]],
) -> Path:
    """Write the page, whole or not at all; `solids` gives the CAD solids of a scene by name."""
    first, second = sides
    parts = [f"<p>A is {html.escape(first.name)}, B is {html.escape(second.name)}.</p>"]
    parts.append("<h2>Input that differs</h2>")
    parts.append(
        table(("key", "A", "B"), [(i.key, i.first or "-", i.second or "-") for i in inputs])
        if inputs else "<p>None.</p>"
    )  # fmt: skip
    parts.append("<h2>Answers, where they differ most</h2>")
    parts.append(table(
        ("quantity", "model", "at", "A", "B", "change", "bars"),
        [(d.quantity, d.model, place(d.key), format_number(d.first), format_number(d.second),
          percent(d.relative), d.verdict) for d in answers],
    ) if answers else f"<p>{NOTHING_SHARED}.</p>")  # fmt: skip
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
    found: dict[str, dict[tuple[str, ...], list[list[tuple[float, float]]]]] = {}
    units: dict[str, str] = {}
    for number, side in enumerate(sides):
        for key, value in side.numbers.items():
            abscissa = _abscissa(key)
            if abscissa is None or (np.isnan(value.value) and not key.frequency):
                continue
            units[key.quantity] = value.unit
            lines = found.setdefault(key.quantity, {}).setdefault(_curve(key), [[], []])
            lines[number].append((abscissa, abs(value.value)))
    found = {q: {c: v for c, v in by.items() if max(map(len, v)) > 1} for q, by in found.items()}
    found = {q: by for q, by in found.items() if by}
    if not found:
        return ""
    figure, grid = panels(8.0, 3.0 * len(found), nrows=len(found), squeeze=False)
    for axis, (quantity, curves) in zip(grid[:, 0], found.items(), strict=True):
        sizes = np.array([y for both in curves.values() for line in both for _, y in line])
        scale, unit = prefixed(float(sizes.max()), units[quantity])
        for label, both in list(curves.items())[:_CURVES]:
            for points, colour, name, style in zip(
                both, (BLUE, ORANGE), "AB", ("-", "--"), strict=True
            ):
                line = np.array(sorted(points)).reshape(-1, 2)
                axis.plot(line[:, 0], scale * line[:, 1], style, color=colour, linewidth=1.2,
                          label=" ".join((name, *label)))  # fmt: skip
        axis.set_ylabel(f"{quantity.replace('_', ' ')} ({unit})")
        axis.set_xlabel(_along(sides, quantity))
        if sizes.min() > 0.0 and sizes.max() > 30.0 * sizes.min():
            axis.set_yscale("log")
            plain_numbers(axis.yaxis)
        axis.legend(fontsize=8)
    return svg(figure)


def _along(sides: tuple[Side, ...], quantity: str) -> str:
    """Abscissa of a quantity's curves: frequency, or the first numeric axis."""
    for key in (key for side in sides for key in side.numbers if key.quantity == quantity):
        if key.frequency:
            return "frequency (Hz)"
        numeric = _numeric(key)
        if numeric is not None:
            return key.point[numeric][0]
    return ""


def _abscissa(key: Key) -> float | None:
    if key.frequency:
        return float(key.frequency)
    numeric = _numeric(key)
    return None if numeric is None else float(key.point[numeric][1])


def _curve(key: Key) -> tuple[str, ...]:
    """Identity of a curve: model, index, and all axes but the abscissa."""
    rest = list(key.point)
    numeric = None if key.frequency else _numeric(key)
    if numeric is not None:
        del rest[numeric]
    index = (f"no. {key.number}",) if key.number else ()
    return (key.model, *index, *(value for _, value in rest))


def _numeric(key: Key) -> int | None:
    """First numeric axis of a point."""
    for axis, (_, value) in enumerate(key.point):
        try:
            float(value)
        except ValueError:
            continue
        return axis
    return None


def _devices(
    sides: tuple[Side, ...],
    inputs: list[InputDifference],
    solids: Callable[[Scene], dict[str, Any]],
) -> list[str]:
    """Pictures of both devices, if a dimension of them differs and they can be drawn.

    They have one scale: what is longer looks longer.
    """
    from tactgen.validation.show.pictures import solids_pictures

    shapes = ("bimorph.", "rod.", "coil.", "sleeve.", "support.kind", "gap", "glue.")
    if not any(i.key.startswith(shapes) for i in inputs):
        return []
    try:
        pictures = solids_pictures([solids(side.scene) for side in sides])
    except InputError as error:  # profiles have no CAD solids; a library may be missing
        return [f"<p>No picture of the devices: {html.escape(str(error))}</p>"]
    heights = [_pixels_high(png) for png in pictures]
    figures = "".join(
        f'<figure><img alt="device {name}" src="{inline(png)}" '
        f'style="height:{_TALLEST * height / max(heights):.2f}rem">'
        f"<figcaption>{name}: {html.escape(side.name)}</figcaption></figure>"
        for png, height, name, side in zip(pictures, heights, "AB", sides, strict=True)
    )
    return ["<h2>Devices, at one scale</h2>", f'<div class="pair">{figures}</div>']


def _pixels_high(png: bytes) -> int:
    """Picture's height, which a PNG states in bytes 20 to 23."""
    return int.from_bytes(png[20:24], "big")
