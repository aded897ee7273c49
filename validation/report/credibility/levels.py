"""One factor of credibility: criteria from level 1 to 4, and the level that the met ones earn.

The scale is that of NASA-STD-7009 (2008, and 7009A of 2016), appendix on the assessment of
credibility: 0 is insufficient evidence, 4 the most that can be asked for.  A level is earned
only with all below it.  The standard leaves it to people what counts as evidence; here each
criterion says what of the report it is computed from.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Criterion:
    """What one level asks for, and what was found.

    Attributes
    ----------
    asked, found : str
        The requirement and the finding, a sentence each.
    met : bool
        Whether the finding is enough.
    remedy : str
        What would meet it.
    rows : tuple of str
        Rows of this report, or of the verification book, that the finding rests on.
    """

    asked: str
    found: str
    met: bool
    remedy: str
    rows: tuple[str, ...] = ()


@dataclass(frozen=True)
class Factor:
    """A factor with its criteria for the levels 1, 2, and so on."""

    name: str
    criteria: tuple[Criterion, ...]

    @property
    def level(self) -> int:
        """The level of the last criterion before the first that is not met."""
        unmet = [n for n, criterion in enumerate(self.criteria) if not criterion.met]
        return unmet[0] if unmet else len(self.criteria)

    @property
    def next(self) -> Criterion | None:
        """What the next level asks for; None at the end of the criteria."""
        return self.criteria[self.level] if self.level < len(self.criteria) else None


def overall(factors: tuple[Factor, ...]) -> int:
    """Return the level of the whole: that of its weakest factor."""
    return min(factor.level for factor in factors)
