"""What a model can be asked for, and of which actuator; quantities are read off the answers."""

from __future__ import annotations

from typing import Literal, NamedTuple

Need = Literal[
    "static", "modes_short", "modes_open", "harmonic", "magnetic_point", "magnetic_map", "rest",
    "small_signal", "machine_poles", "crosstalk", "spread", "neighbours", "load",
]  # fmt: skip
#: The two, the machine that both make, and many of these side by side.
Actuator = Literal["bimorph", "reluctance", "generator", "display"]


class NeedRow(NamedTuple):
    """An answer: the actuator that it is about, and what it is in words."""

    actuator: Actuator
    words: str


NEEDS: dict[Need, NeedRow] = {
    "static": NeedRow("bimorph", "a static value"),
    "modes_short": NeedRow("bimorph", "short-circuit modes"),
    "modes_open": NeedRow("bimorph", "open-circuit modes"),
    "harmonic": NeedRow("bimorph", "the response at given frequencies"),
    "load": NeedRow("bimorph", "what the tip touches"),
    "magnetic_point": NeedRow("reluctance", "the magnetic circuit at one current and gap"),
    "magnetic_map": NeedRow("reluctance", "the magnetic circuit over the stroke"),
    "rest": NeedRow("reluctance", "where the rod rests"),
    "small_signal": NeedRow("generator", "the machine's response at given frequencies"),
    "machine_poles": NeedRow("generator", "the poles of the rod and its coil"),
    "crosstalk": NeedRow("display", "what one unit moves at the others"),
    "spread": NeedRow("display", "how far the units differ"),
    "neighbours": NeedRow("display", "the field between neighbouring units"),
}
