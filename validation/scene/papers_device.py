"""Whether a scene is about the paper's actuator, to which the paper's own numbers belong."""

from __future__ import annotations

from tactgen.geometry.device.parameters import Bimorph, Piezo, Shim
from tactgen.validation.scene.scene import Scene

#: What the paper varies or does not say: its two lengths, and how the layers are wired.
_FREE = {"length", "wiring", "poling", "tab_length"}


def is_papers_bimorph(scene: Scene) -> bool:
    """Return whether layers, section and materials are the paper's; the length may be any."""
    own, papers = (b.model_dump(exclude=_FREE) for b in (scene.bimorph, Bimorph()))
    return own == papers and (scene.piezo, scene.shim) == (Piezo(), Shim())
