"""When two texts say the same: words exactly, numbers to `NEAR`, and marked ones to their mark.

Libraries sum in another order on another processor.  What is left of cancellation, bars that are
differences, and counts of steps then come out otherwise; in an approved text such a number wears a
mark before it (`MARKS`).  Marks are set by running tests as other processors would
(``tests/elsewhere.py``), not by hand.
"""

import re
from difflib import SequenceMatcher, unified_diff

#: Numbers count as the same that differ by this part: seven digits are written, closed forms and
#: small systems come out alike to 1e-9 with other libraries, and what iterates ends at 1e-8.
NEAR = 1e-6
#: Rounding: numbers below this (SI units), bars of less than this part of their number, or said to
#: be this part of it.
TINY, TINY_PART = 1e-13, 1e-9
#: What is smaller than this part of the largest of its row is compared like that part: components
#: that are left of cancellation have fewer digits.
SMALL = 1e-2
#: What a mark lets pass: two digits are left, the size is left, nothing is left of a number.
MARKS = {
    "≈": lambda a, b: abs(a - b) <= 1e-2 * max(abs(a), abs(b)),
    "~": lambda a, b: 0.1 * abs(a) <= abs(b) <= 10.0 * abs(a) and a * b > 0.0,
    "?": lambda a, b: True,
}
#: What two processors must have in common for a mark: some ten times what it then lets pass.
_SEEN = {
    "≈": lambda a, b: abs(a - b) <= 1e-3 * max(abs(a), abs(b)),
    "~": lambda a, b: abs(a) <= 3.0 * abs(b) <= 9.0 * abs(a) and a * b > 0.0,
    "?": lambda a, b: True,
}

#: A mark, a sign that follows no word, digits.
_NUMBER = re.compile(
    rf"([{''.join(MARKS)}]?(?:(?<![\w.)\]%°])[-+])?"
    r"(?<![A-Za-z_\d.])\d+(?:\.\d+)?(?:e[-+]?\d+)?)"
)
#: What parts the columns of a table.
_GAP = re.compile(r"(?<=\S) {2,}")
#: A number of one or two digits that small: a size of rounding.
_OF_ROUNDING = re.compile(r"\d(\.\d)?e-\d\d")


def by_letter(before, after):
    """Return the lines in which two texts differ at all."""
    changed = unified_diff(before.splitlines(), after.splitlines(), lineterm="", n=0)
    return [f"  {line[:200]}" for line in changed if not line.startswith(("---", "+++", "@@"))]


def differences(before, after):
    """Return what differs of a text from the approved one before it, by lines."""
    old, new = before.splitlines(), after.splitlines()
    if len(old) == len(new) and all(map(_alike, old, new)):
        return []
    found = []
    for kind, o, n in _aligned(old, new):
        if kind != "equal":
            found += [f"  - {line[:200]}" for line in o] + [f"  + {line[:200]}" for line in n]
        else:
            found += [_around(a, b) for a, b in zip(o, n, strict=True) if not _alike(a, b)]
    return found


def with_marks(before, after):
    """Return a text with the marks of the one before it, in the lines that have its words."""
    found = []
    for kind, o, n in _aligned(before.splitlines(), after.splitlines()):
        found += map(_with_marks, o, n) if kind == "equal" else n
    return "\n".join([*found, ""])


def loosened(before, after):
    """Return the approved text with marks for what another processor says, or None: other words."""
    old, new = before.splitlines(), after.splitlines()
    if list(map(_words, old)) != list(map(_words, new)):
        return None
    return "\n".join([*map(_loosened, old, new), ""])


def _aligned(old, new):
    """Yield pieces of two lists of lines, "equal" where the words are."""
    words = [list(map(_words, lines)) for lines in (old, new)]
    for kind, a, b, c, d in SequenceMatcher(None, *words, autojunk=False).get_opcodes():
        yield kind, old[a:b], new[c:d]


def _words(line):
    """Return a line without its numbers, and how wide they make the columns of a table."""
    return "\0".join(_GAP.sub("  ", words.rstrip(" ")) for words in _NUMBER.split(line)[::2])


def _read(number):
    """Return a number's mark and its value."""
    mark = number[0] if number[0] in MARKS else ""
    return mark, float(number[len(mark) :])


def _alike(old, new):
    """Return whether two lines say the same."""
    return old == new or (_words(old) == _words(new) and all(_same(old, new)))


def _same(old, new):
    """Yield for each number of two lines of the same words whether it is the same."""
    pieces, others = _NUMBER.split(old), _NUMBER.split(new)
    last = 0.0
    for at, row in zip(range(1, len(pieces), 2), _largest_of_rows(pieces), strict=True):
        (mark, a), (_, b) = _read(pieces[at]), _read(others[at])
        if mark:
            yield MARKS[mark](a, b)
        else:
            largest, below = max(abs(a), abs(b)), TINY
            if "±" in pieces[at - 1]:
                below = max(TINY, TINY_PART * abs(last))
            rounding = _OF_ROUNDING.fullmatch(pieces[at].lstrip("+-"))
            if rounding or pieces[at + 1].startswith((" %", " relative")):
                below = 10.0 * TINY_PART
            yield largest < below or abs(a - b) <= NEAR * max(largest, SMALL * row)
        last = a


def _largest_of_rows(pieces):
    """Return for each number of a line the largest of the row in brackets that it stands in."""
    found, row, inside = [], [0.0], False
    for before, number in zip(pieces[::2], pieces[1::2], strict=False):
        if "[" in before or "]" in before:
            row, inside = [0.0], before.rfind("[") > before.rfind("]")
        if inside:
            row.append(abs(_read(number)[1]))
        found.append(row)  # it grows to its end
    return [max(row) for row in found]


def _with_marks(old, new):
    """Return a line with the marks of another of the same words."""
    pieces, others = _NUMBER.split(old), _NUMBER.split(new)
    for at in range(1, len(pieces), 2):
        others[at] = _read(pieces[at])[0] + others[at]
    return "".join(others)


def _loosened(old, new):
    """Return an approved line, each number marked that another line of its words has not."""
    if _alike(old, new):
        return old
    pieces, others = _NUMBER.split(old), _NUMBER.split(new)
    for at, same in zip(range(1, len(pieces), 2), _same(old, new), strict=True):
        if not same:
            (mark, a), (_, b) = _read(pieces[at]), _read(others[at])
            looser = list(MARKS)[list(MARKS).index(mark) + 1 if mark else 0 :]
            pieces[at] = next(m for m in looser if _SEEN[m](a, b)) + pieces[at][len(mark) :]
    return "".join(pieces)


def _around(old, new):
    """Return both lines from a little before the first place where they differ."""
    at = next((i for i, (a, b) in enumerate(zip(old, new, strict=False)) if a != b), 0)
    begin = max(0, at - 60)
    return f"  - …{old[begin : at + 60]}\n  + …{new[begin : at + 60]}"
