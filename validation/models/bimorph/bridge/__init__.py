"""From the transfer-matrix model to the solid, and from a clamp to the generator, in steps."""

from validation.models.bimorph.bridge.assumptions import bridge
from validation.models.bimorph.bridge.rung import Rung, Steps

__all__ = ["Rung", "Steps", "bridge"]
