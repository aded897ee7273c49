"""Every quantity by name: what solve, sensitivity, identify, design and report all read."""

from __future__ import annotations

from tactgen.validation.catalogue import bimorph, display, generator, reluctance
from tactgen.validation.catalogue.needs import Actuator
from tactgen.validation.catalogue.row import QuantityRow

QUANTITIES: dict[str, QuantityRow] = {
    q.name: q for q in (*bimorph.ROWS, *reluctance.ROWS, *generator.ROWS, *display.ROWS)
}


def quantities_of(actuator: Actuator) -> tuple[str, ...]:
    """Return the names of an actuator's quantities."""
    return tuple(name for name, row in QUANTITIES.items() if row.actuator == actuator)


def measurable() -> dict[str, QuantityRow]:
    """Return the quantities that can be measured as a response, by the column's name."""
    return {row.curve.kind: row for row in QUANTITIES.values() if row.curve is not None}
