"""Questions to models, and their cached answers."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import cached_result, stored_result
from tactgen.geometry.store.values import source_digest
from tactgen.validation.catalogue.models import MODELS, gives, reading
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.solve import Solution, make_plan, solve
from tactgen.validation.models.classes import model_class
from tactgen.validation.scene.files import one_line
from tactgen.validation.scene.inputs import values_read
from tactgen.validation.scene.load import checked_scene
from tactgen.validation.scene.scene import Scene

#: Of this process, by model: the last solution, whose stages the next question may take over.
_earlier: dict[str, Solution] = {}


@dataclass(frozen=True)
class Question:
    """Question to one model at one point, which its inputs identify, and its answer."""

    model: str  #: Its name
    quantities: tuple[str, ...]  #: Those that the model gives
    inputs: tuple[object, ...]  #: Plain values that stand for all of the scene that is read
    shared: tuple[str, ...]  #: Keys of the stages kept in the store that the answer is made of
    values: dict[str, Any]  #: The scene's at the point, as they would be written

    def recall(self, *, retry: bool = False) -> Answer | None:
        """Answer that is kept, if any; with `retry` only one that did not fail."""
        return stored_result(*self._place, _serving(retry))

    def keep(
        self,
        made: Callable[[], Answer],
        announce: Callable[[str], None] = lambda _: None,
        *,
        retry: bool = False,
    ) -> Answer:
        """Answer that is kept, or else `made` now and kept; failures are answers, too.

        With `retry` an answer that is kept as failed gives way.
        """
        return cached_result(*self._place, made, serves=_serving(retry), announce=announce)

    def solve(self, announce: Callable[[str], None] = lambda _: None) -> Answer:
        """Answer, computed now and not kept."""
        start = time.perf_counter()
        try:
            found = solve(
                checked_scene(self.values), (self.model,), self.quantities, announce,
                reuse=_earlier.get(self.model),
            )  # fmt: skip
        except Exception as error:  # noqa: BLE001  (one point's failure is not the study's)
            return Answer("failed", reason(error), seconds=time.perf_counter() - start)
        _earlier[self.model] = found
        seconds = time.perf_counter() - start
        return Answer("ok", "", found.quantities, found.warnings, seconds)

    @property
    def _place(self) -> tuple[str, tuple[object, ...], tuple[str, ...]]:
        """Identity of its answer in the store: kind, inputs, modules that it is made by."""
        return f"whatif.{self.model}", self.inputs, _made_of(self.model)


def question(
    scene: Scene, model: str, quantities: tuple[str, ...], values: dict[str, Any]
) -> Question:
    """Question to a model at a scene, which has these values.

    Raises InputError if the model cannot take the scene.
    """
    wanted = tuple(name for name in quantities if gives(model, name))
    keys = make_plan(scene, (model,), wanted).keys
    read = values_read(scene, reading(model))
    stored = {f"{model}.{stage}" for stage in MODELS[model].kept}
    shared = tuple(f"{stage} {key}" for stage, key in keys.items() if stage in stored)
    return Question(model, wanted, (keys, read, wanted), shared, values)


def reason(error: Exception) -> str:
    """Reason of a failure, in one sentence."""
    if isinstance(error, InputError):
        return one_line(str(error))
    name = type(error).__name__
    return one_line(f"{name}: {error}" if str(error) else name)


def code_of(model: str) -> str:
    """Hash of the code that a model's answers are made by."""
    return source_digest(_made_of(model))


def _made_of(model: str) -> tuple[str, ...]:
    return (__name__, *model_class(model).code())


def _serving(retry: bool) -> Callable[[Answer], bool]:
    return lambda found: found.status == "ok" or not retry
