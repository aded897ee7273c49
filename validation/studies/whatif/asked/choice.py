"""Which models and quantities a study asks when none are named."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS, all_given, gives
from tactgen.validation.catalogue.quantities import QUANTITIES, quantities_of
from tactgen.validation.scene.files import choices
from tactgen.validation.studies.whatif.asked.statement import Statement

#: Quick, and exact within their theories: of what the first gives it, of the rest the second.
_USUAL = ("tmm", "network")


def names_models(values: dict[str, Any], models: Sequence[str] | None, before: Statement) -> bool:
    """Return whether options, the study that is gone on with, or the scene name a model."""
    return bool(models or values.get("models") or (before.models and not before.by_accuracy))


def chosen(
    values: dict[str, Any],
    models: Sequence[str] | None,
    quantities: Sequence[str] | None,
    before: Statement,
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return models and quantities by name.

    As the options say; else as the study says that is gone on with, or the scene; else the
    headline quantities of the lateral actuator, by the quick model that is exact within its
    theory.

    Raises
    ------
    InputError
        For an unknown name, or models that give none of the quantities.
    """
    earlier = () if before.by_accuracy else before.models
    stated_models = models or earlier or values.get("models")
    stated_quantities = quantities or before.quantities or values.get("quantities")
    by_name = _names(stated_models, tuple(MODELS), "model", "models") if stated_models else ()
    if stated_quantities:
        wanted = _names(stated_quantities, tuple(QUANTITIES), "quantity", "quantities")
        if wanted == tuple(QUANTITIES):
            wanted = all_given(by_name or _USUAL)
        elif by_name:
            wanted = tuple(q for q in wanted if any(gives(m, q) for m in by_name)) or wanted
    else:
        actuators = {MODELS[m].actuator for m in by_name} or {"bimorph"}
        wanted = tuple(
            q for actuator in ("bimorph", "reluctance") if actuator in actuators
            for q in quantities_of(actuator) if QUANTITIES[q].headline
        )  # fmt: skip
    if not by_name:
        by_name = tuple(dict.fromkeys(m for q in wanted for m in _USUAL if gives(m, q)))
    idle = [m for m in by_name if not any(gives(m, q) for q in wanted)]
    if idle:
        raise InputError(
            f"model {idle[0]} gives none of {', '.join(wanted)}; leave it out, or ask for "
            f"something that it gives, such as {all_given((idle[0],))[0]}"
        )
    return by_name, wanted


def _names(stated: Any, known: tuple[str, ...], kind: str, key: str) -> tuple[str, ...]:
    return choices(",".join(stated) if not isinstance(stated, str) else stated, known, kind, key)
