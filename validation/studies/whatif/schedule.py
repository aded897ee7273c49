"""In which order questions are worked on: what several need is computed first, and once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from tactgen.validation.studies.whatif.answers import Question

#: Most questions that one worker takes at a time: short enough for progress to be seen.
_MOST = 32


@dataclass(frozen=True)
class Batch:
    """Questions for one worker, one after another.

    Attributes
    ----------
    numbers : tuple of int
        Places of the questions in the list that was scheduled.
    after : frozenset of int
        Places of the batches that must be done before, since they compute what is shared.
    """

    numbers: tuple[int, ...]
    after: frozenset[int]


def schedule(questions: Iterable[Question]) -> list[Batch]:
    """Return batches, each after those that it waits for.

    Questions with the same kept stages, such as one geometry under several loads, go to one
    worker, since all but the first cost little; of a stage that several batches share the first
    of them is waited for.
    """
    groups: dict[tuple[str, tuple[str, ...]], list[int]] = {}
    for number, asked in enumerate(questions):
        groups.setdefault((asked.model, asked.shared), []).append(number)
    batches: list[Batch] = []
    first: dict[str, int] = {}
    for (_, shared), numbers in groups.items():
        for start in range(0, len(numbers), _MOST):
            place = len(batches)
            after = {first.setdefault(key, place) for key in shared} - {place}
            batches.append(Batch(tuple(numbers[start : start + _MOST]), frozenset(after)))
    return batches
