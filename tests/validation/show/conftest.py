"""Shared by the tests of what is seen: one small scene's fields."""

import pytest

from tactgen.validation.models.bimorph import solid
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.gather import gather


@pytest.fixture(scope="session")
def seen(tmp_path_factory, few_bricks):
    """Return the fields of a clamped bimorph by two models, with one driven state.

    On few bricks, with a store of their own whose keys do not know.
    """
    scene, _ = load_scene("j1", ["mesh.level=1", "modes=3", "models=solid,tmm"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("seen")))
        patch.setattr(solid, "LEVELS", few_bricks)
        return gather(scene, ["solid", "tmm"], (900.0,), "edges")
