"""Rows of the 3D co-energy map, kept on disk one by one: an interrupted map goes on where it was.

A row is all currents at one gap.  Never a reason to fail: what cannot be read is solved
again, what cannot be written is not kept.
"""

from __future__ import annotations

import contextlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fem.reluctance.three_d.actuator import SolidPoint, SolidValues, solve_row
from geometry.arrays import Floats
from geometry.device.parameters import Device
from geometry.errors import InputError
from geometry.files import written_whole
from geometry.meshing.mesh_cache import cache_folder
from geometry.reluctance.sector_tets import Sector


def kept_row(
    key: str, device: Device, gap: float, currents: Floats, sector: Sector
) -> tuple[SolidPoint, ...]:
    """Return the points of a row, from disk if they are there.

    Parameters
    ----------
    key : str
        Stands for the device and all currents and gaps of the map.
    device, gap, currents, sector
        As for :func:`fem.reluctance.three_d.actuator.solve_row`.
    """
    file = cache_folder() / f"coenergy-{key}-{gap * 1e9:.0f}nm.json"
    kept = _read(file)
    if kept is not None and [point.current for point in kept] == currents.tolist():
        return kept
    row = solve_row(device, gap, currents, sector)
    with contextlib.suppress(InputError, OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(file) as draft:
            draft.write_text(json.dumps([asdict(point) for point in row]), encoding="utf-8")
    return row


def _read(file: Path) -> tuple[SolidPoint, ...] | None:
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        return tuple(_point(entry) for entry in found)
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _point(entry: dict[str, Any]) -> SolidPoint:
    vector, scalar = (
        SolidValues(**{**entry[name], "forces": tuple(entry[name]["forces"])})
        for name in ("vector", "scalar")
    )
    return SolidPoint(entry["current"], entry["gap"], vector, scalar)
