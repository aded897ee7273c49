"""What commands say with ``--json``: records as values that JSON knows, on standard output."""

from __future__ import annotations

import json
import math
from dataclasses import fields, is_dataclass
from typing import Any


def print_json(value: Any) -> None:
    """Print a record in one line, alone on standard output."""
    print(json.dumps(plain(value), allow_nan=False))


def plain(value: Any) -> Any:
    """Return dataclasses as objects, arrays as lists; numbers that are not finite as null."""
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if hasattr(value, "tolist"):  # arrays and NumPy's numbers
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
