"""The rod below a bimorph on its contact: rigid, joined to the base, nothing but motion in it."""

import pytest

from tactgen.validation.scene.scene import load_scene
from tactgen.validation.show.gather import gather
from tactgen.validation.show.moving import standing
from tactgen.validation.show.viewer import payload


@pytest.fixture(scope="module")
def seen():
    """Return the scene, the bimorph alone, and the bimorph on its rod."""
    scene, _ = load_scene("generator", ["models=tmm", "modes=2"])
    (alone,) = gather(scene, ("tmm",), (100.0,), "edges")
    return scene, alone, standing(scene, alone)


def test_the_page_knows_what_has_no_field_inside(seen):
    _, alone, whole = seen
    rigid = [r["name"] for r in payload([whole])["results"][0]["regions"] if r["rigid"]]
    assert rigid == ["rod", "coil"]
    assert not any(r["rigid"] for r in payload([alone])["results"][0]["regions"])
    paper, _ = load_scene("paper", ["models=tmm"])
    assert standing(paper, alone) is alone
