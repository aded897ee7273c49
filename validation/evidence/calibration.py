"""``tactgen calibrate``: known differences of quick models from detailed ones, fitted anew.

Random devices are solved by both, in several processes; each is cached by itself, so a run that was
stopped goes on.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from tactgen.geometry.files import write_text
from tactgen.geometry.formats import share
from tactgen.geometry.operating_system import core_count
from tactgen.tmm.beam import calibration_fit as beam
from tactgen.tmm.reluctance import calibrated as network
from tactgen.validation.evidence.judgement import cached_by_code

Announce = Callable[[str], None]
#: Name and record of a calibration.
Part = tuple[str, dict[str, Any]]


def table(found: Sequence[Part]) -> str:
    """Errors that calibrations leave, as lines of text."""
    lines = []
    for _, record in found:
        for kind, part in record.items():
            if not isinstance(part, dict) or "evidence" not in part:
                continue
            head = f"{kind}: {record['devices']} devices, seed {record['seed']}"
            lines.append(f"{head}; errors on devices not fitted to")
            lines.append(
                f"  {'error of':24} {'devices':>7} {'median':>8} {'95 %':>8} {'largest':>8} "
                f"{'covered':>8} {'stated/error':>12}"
            )
            for name, row in part["evidence"]["errors"].items():
                shares = [share(row[key]) for key in ("median", "covers_95_percent", "largest")]
                lines.append(
                    f"  {name:24} {row['devices']:>7} {shares[0]:>8} {shares[1]:>8} "
                    f"{shares[2]:>8} {share(row['covered']):>8} {row['stated_over_error']:>12.2g}"
                )
    return "\n".join(lines)


def _bimorph(announce: Announce, *, listed: bool = False) -> dict[str, Any]:
    from tactgen.validation.evidence import calibration_bimorph as part

    name, count, unusual = (
        ("laminate", part.LAMINATES, part.UNUSUAL_LISTED)
        if listed
        else ("bimorph", part.DEVICES, part.UNUSUAL)
    )
    solved = partial(_observed, announce, name, part.observe, part.SEED)
    observed = solved("solid", ("", listed), count)
    those = {what: solved(f"solid with {what}", (what, listed), part.EACH) for what in unusual}
    return part.calibrate(observed, those, announce)


def _reluctance(announce: Announce) -> dict[str, Any]:
    from tactgen.validation.evidence import calibration_reluctance as part

    solved = partial(_observed, announce, "reluctance", part.observe, part.SEED)
    observed = solved("field", (1.0,), part.DEVICES)
    beyond = solved("field beyond the range", (part.WIDER,), part.BEYOND)
    return part.calibrate(observed, beyond, announce)


#: Calibrations by name: what makes each, and the file of the package that holds it.
PARTS: dict[str, tuple[Callable[[Announce], dict[str, Any]], Path]] = {
    "bimorph": (_bimorph, beam.FILE),
    "laminate": (partial(_bimorph, listed=True), beam.LISTED_FILE),
    "reluctance": (_reluctance, network.FILE),
}


def _observed(
    announce: Announce, name: str, observe: Callable[..., Any], seed: int,
    words: str, of: tuple[object, ...], count: int,
) -> list[Any]:  # fmt: skip
    """Random devices by number, on all cores; `of` is what `observe` is told besides."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    found, one = [], partial(_cached, name, observe, seed, of)
    with ProcessPoolExecutor(core_count(), mp_context=get_context("spawn")) as pool:
        for number, device in enumerate(pool.map(one, range(count), chunksize=8)):
            announce(f"calibration: {words} {number + 1} of {count}")
            found.append(device)
    return found


def _cached(
    name: str, observe: Callable[..., Any], seed: int, of: tuple[object, ...], number: int
) -> Any:
    work = partial(observe, seed, number, *of)
    return cached_by_code("calibration", (name, seed, number, of), observe.__module__, work)


def shipped() -> dict[str, dict[str, Any]]:
    """Calibrations that are in use, by name."""
    return {name: json.loads(path.read_text(encoding="utf-8")) for name, (_, path) in PARTS.items()}


def run(names: Sequence[str], announce: Announce) -> list[Part]:
    """Calibrations by name."""
    return [(name, PARTS[name][0](announce)) for name in names]


def write(found: Sequence[Part], out: Path) -> list[Path]:
    """Write each calibration to a file of a folder, whole or not at all; return the files."""
    return [_written(out / f"{name}.json", record) for name, record in found]


def install(found: Sequence[Part]) -> list[Path]:
    """Write calibrations into the package; return the files.

    Raises InputError if the package cannot be written to.
    """
    return [_written(PARTS[name][1], record) for name, record in found]


def _written(path: Path, record: dict[str, Any]) -> Path:
    return write_text(path, json.dumps(record, separators=(",", ":")) + "\n")
