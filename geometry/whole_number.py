"""A check of whole numbers that refuses with a remedy."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class WholeNumber:
    """A validator of whole numbers in a range, with a remedy in its refusal."""

    least: int
    most: int
    example: str

    def __call__(self, value: Any) -> int:
        """Return `value` as an integer.

        Raises
        ------
        ValueError
            With a sentence that names the range.
        """
        text = str(value).strip() if isinstance(value, str | int | float) else ""
        # 3.0 is what some programs write for 3
        found = re.fullmatch(r"([+-]?[0-9]{1,9})(\.0*)?", text)
        number = int(found[1]) if found else self.least - 1
        if not self.least <= number <= self.most:
            raise ValueError(
                f"is not a whole number from {self.least} to {self.most}; "
                f"write for example {self.example}"
            )
        return number
