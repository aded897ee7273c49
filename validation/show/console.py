"""Where tables are printed."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console


def console(wide: int) -> Console:
    """Standard output: as wide as the terminal, of so many columns where it is none."""
    from rich.console import Console

    return Console(width=None if sys.stdout.isatty() else wide)
