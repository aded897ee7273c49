"""``accuracy`` without a model named: the cheapest model that is known to meet it answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tactgen.validation.models.comparison import Choice
    from tactgen.validation.scene.scene import Scene


def under_contract(
    scene: Scene, origins: Mapping[str, str], announce: Callable[[str], None]
) -> tuple[Scene, Choice | None]:
    """Scene with the models that the accuracy asks for, and why.

    Unchanged, and None, where models are named or no accuracy is.

    Raises InputError if no model is known to meet the accuracy.
    """
    if "accuracy" not in origins or "models" in origins:
        return scene, None
    from tactgen.validation.models.comparison import choose

    choice = choose(scene, scene.quantities, announce)
    return scene.model_copy(update={"models": choice.models}), choice
