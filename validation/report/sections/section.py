"""Interface of a report section."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tactgen.validation.report.report_data import Study

#: What a template shows, by name.
Context = dict[str, Any]


@dataclass(frozen=True)
class Section:
    """One section: its anchor (also the template's name), its title, its contents.

    A section whose function returns None is left out; numbers and contents follow.
    """

    id: str
    title: str
    context: Callable[[Study], Context | None]
