"""Random devices, and one scene's answers held against another's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.coverage import Judged
from tactgen.validation.scene.scene import Scene

#: Draws after which no device is looked for any more: of those drawn here no more than one in two
#: is refused, so it is the model that refuses all.
MOST_DRAWS = 200

_Drawn = TypeVar("_Drawn")


def accepted(attempt: Callable[[], _Drawn]) -> _Drawn:
    """Return what `attempt`, which draws a device anew each time, gives for the first that fits.

    Raises
    ------
    InputError
        If so many are refused that it must be the model's fault.
    """
    refusals = []
    for _ in range(MOST_DRAWS):
        try:
            return attempt()
        except InputError as refusal:
            refusals.append(refusal)
    raise InputError(
        f"all {MOST_DRAWS} random devices were refused; judge another part with --only until the "
        f"model is mended, which says of the last: {refusals[-1]}"
    )


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number even on a logarithmic scale."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def drawn_bimorph(
    rng: np.random.Generator, *, length: float | None = None, layer: float | None = None
) -> list[str]:
    """Return the overrides of a random bimorph, by default 5 to 60 mm long and slender."""
    layer = between(rng, 0.05, 0.5) if layer is None else layer
    length = between(rng, 15.0, 120.0) * 3.0 * layer if length is None else length
    frequencies = sorted(between(rng, 10.0, 3000.0) for _ in range(3))
    return [
        f"bimorph.length={length:.6g}mm",
        f"bimorph.width={between(rng, 0.5, 5.0):.4g}mm",
        f"bimorph.piezo_thickness={layer:.4g}mm",
        f"bimorph.shim_thickness={layer * between(rng, 0.3, 2.0):.4g}mm",
        f"piezo.material={rng.choice(['M1876', 'PZT-5H', 'PZT-5A'])}",
        f"support.kind={rng.choice(['clamped', 'spring'])}",
        "frequency=" + ",".join(f"{f:.5g}Hz" for f in frequencies),
    ]


def compared(
    judged: tuple[Scene, str], better: tuple[Scene, str], quantities: Sequence[str], where: str
) -> list[Judged]:
    """Return the answers of a scene by a model against a better scene's or model's."""
    values, right = (
        {q.name: q for q in solve(scene, [model], quantities).quantities}
        for scene, model in (judged, better)
    )
    found = []
    for name, quantity in values.items():
        size = np.abs(np.ravel(right[name].value))
        error = np.abs(np.ravel(quantity.value) - np.ravel(right[name].value)) / size
        bar = np.ravel(quantity.error) / size
        several = error.size > 1
        found += [
            Judged(where, f"{name} {i + 1}" if several else name, float(e), float(b))
            for i, (e, b) in enumerate(zip(error, bar, strict=True))
        ]
    return found
