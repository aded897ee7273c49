"""What of a plan is kept already, and how long the rest took when it last ran here."""

from __future__ import annotations

from dataclasses import dataclass

from tactgen.geometry.store.store import is_kept
from tactgen.validation.catalogue.models import stage_code
from tactgen.validation.engine.costs import recorded
from tactgen.validation.engine.plan import Plan


@dataclass(frozen=True)
class Prospect:
    """One stage of a plan: whether its result is kept, and the seconds recorded, if any are."""

    kept: bool
    seconds: float | None


def stage_prospects(plan: Plan) -> dict[str, Prospect]:
    """Return the prospects of a plan's stages, by name.

    Costs are those of the last run on this machine, of whatever scene: an order of magnitude.
    """
    costs, code = recorded(), stage_code()
    return {
        stage: Prospect(
            stage in code and is_kept(stage, (key,), code[stage]),
            costs.get(stage),
        )
        for stage, key in plan.keys.items()
    }  # fmt: skip


def total(prospects: dict[str, Prospect]) -> float:
    """Return the seconds of all that is not kept and of which a cost is recorded."""
    return sum(p.seconds for p in prospects.values() if not p.kept and p.seconds is not None)
