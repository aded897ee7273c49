"""From the transfer-matrix model to the solid, and from a clamp to the generator, in steps."""

from tactgen.validation.models.bimorph.beam_values import Steps
from tactgen.validation.models.bimorph.bridge.assumptions import bridge
from tactgen.validation.models.bimorph.bridge.rung import Rung

__all__ = ["Rung", "Steps", "bridge"]
