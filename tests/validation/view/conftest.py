"""Shared by the tests of what is seen: one small scene's fields."""

import pytest

from tactgen.validation.fields.gather import Request, gather
from tactgen.validation.scene.scene import load_scene


@pytest.fixture(scope="session")
def seen():
    """Return the fields of a clamped bimorph by two models, with one driven state."""
    scene, _ = load_scene("j1", ["mesh.level=1", "modes=3", "models=solid,tmm"])
    return gather(scene, ["solid", "tmm"], Request((900.0,), "edges"))
