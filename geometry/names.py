"""Names as people write them: in any case, with or without hyphens, and with slips of the pen."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

#: Longest name (characters) for which the nearest known one is looked for.
_LONGEST = 100


def folded(name: str) -> str:
    """Return a name without case, hyphens, underscores and spaces, to compare it with others."""
    return "".join(c for c in name.casefold() if c not in " -_")


def nearest(name: str, known: Iterable[str]) -> str:
    """Return `` (did you mean "…"?)`` for a misspelt name, or nothing."""
    known = tuple(known)
    if len(name) > _LONGEST:  # no slip of the pen; comparing takes its square in time
        return ""
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    if not close and "." in name:
        tails = {k.rsplit(".", 1)[-1]: k for k in known}
        close = [tails[t] for t in difflib.get_close_matches(name.rsplit(".", 1)[-1], tails, n=1)]
    if not close:
        plain = {folded(k): k for k in known}
        close = [plain[f] for f in difflib.get_close_matches(folded(name), plain, n=1, cutoff=0.6)]
    return f' (did you mean "{close[0]}"?)' if close else ""
