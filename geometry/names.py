"""Names as people write them: in any case, with or without hyphens, and with slips of the pen."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

#: Longest name (characters) for which the nearest known one is looked for.
_LONGEST = 100
#: How alike (1: the same) a whole name is, a last part that stands for one, and either of a name
#: that is written otherwise: a short part alone says less.
_LIKE, _LIKE_LAST, _LIKE_WRITTEN = 0.5, 0.8, 0.6
#: Names that are suggested at most.
_SHOWN = 3


def folded(name: str) -> str:
    """Name without case, hyphens, underscores and spaces, to compare it with others."""
    return "".join(c for c in name.casefold() if c not in " -_")


def nearest(name: str, known: Iterable[str]) -> str:
    """`` (did you mean "…"?)`` for a misspelt name, or nothing.

    Of dotted names the last part may be all that was written; several may end in it.
    """
    known = tuple(known)
    if len(name) > _LONGEST:  # no slip of the pen; comparing takes its square in time
        return ""
    close = (
        ("." not in name and _of_ending(name, known, cutoff=_LIKE_LAST))
        or difflib.get_close_matches(name, known, n=1, cutoff=_LIKE)
        or _of_ending(name.rsplit(".", 1)[-1], known, cutoff=_LIKE_WRITTEN)
    )
    if not close:
        plain = {folded(k): k for k in known}
        alike = difflib.get_close_matches(folded(name), plain, n=1, cutoff=_LIKE_WRITTEN)
        close = [plain[f] for f in alike]
    if not close:
        return ""
    shown = ", ".join(f'"{k}"' for k in close[:_SHOWN])
    return f" (did you mean {shown}{', …' if len(close) > _SHOWN else ''}?)"


def _of_ending(ending: str, known: tuple[str, ...], *, cutoff: float) -> list[str]:
    """Dotted names whose last part is nearest to `ending`."""
    dotted = [(k, k.rsplit(".", 1)[-1]) for k in known if "." in k]
    close = difflib.get_close_matches(ending, [last for _, last in dotted], n=1, cutoff=cutoff)
    return [k for k, last in dotted if last in close]
