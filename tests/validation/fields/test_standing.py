"""The rod below a bimorph on its contact: rigid, joined to the base, nothing but motion in it."""

import numpy as np
import pytest
from approved import described

from tactgen.validation.fields.gather import Request, gather
from tactgen.validation.fields.result import MODE_SIZE
from tactgen.validation.fields.standing import standing
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.view.page.shown import payload


@pytest.fixture(scope="module")
def seen():
    """Return the scene, the bimorph alone, and the bimorph on its rod."""
    scene, _ = load_scene("generator", ["models=tmm", "modes=2"])
    (alone,) = gather(scene, ("tmm",), Request((100.0,), "edges"))
    return scene, alone, standing(scene, alone)


def test_the_rod_moves_as_a_rigid_body_with_the_base(seen, approved):
    """Where it touches the base as the base does; no length in it changes, to first order."""
    _, alone, whole = seen
    count = len(alone.mesh.points)
    assert whole.rigid == ("rod", "coil")
    points = whole.mesh.points[count:]
    assert points[:, 2].max() == pytest.approx(0.0, abs=1e-12)
    assert points[:, 2].min() < -5e-3
    between = points - points[0]
    for before, state in zip(alone.states, whole.states, strict=True):
        moved = np.asarray(state.fields["displacement"])
        base = alone.mesh.points[:, 2] < 1e-9
        turned = np.polyfit(alone.mesh.points[base, 0], moved[:count][base, 2], 1)[0]
        assert abs(turned) > 0.0
        top = points[:, 2] > -1e-12
        np.testing.assert_allclose(moved[count:][top, 2], turned * points[top, 0], atol=1e-18)
        stretched = np.einsum("ni,ni->n", between, moved[count:] - moved[count])
        assert np.abs(stretched).max() < 1e-12 * np.abs(moved).max() * np.abs(between).max()
        assert not np.asarray(state.fields["potential"])[count:].any()
        ratio = moved[:count] / np.where(moved[:count], before.fields["displacement"], 1.0)
        assert np.ptp(np.abs(ratio[moved[:count] != 0.0])) < 1e-9
        if state.kind == "mode":
            assert np.linalg.norm(moved, axis=1).max() == pytest.approx(MODE_SIZE)
            assert state.tip / before.tip == pytest.approx(np.abs(ratio).max())
        else:
            assert state.tip == before.tip
    approved(
        described(
            [
                whole.mesh.points,
                whole.mesh.regions,
                [np.abs(s.fields["displacement"]) for s in whole.states],
            ]
        )
    )


def test_the_page_knows_what_has_no_field_inside(seen):
    _, alone, whole = seen
    rigid = [r["name"] for r in payload([whole])["results"][0]["regions"] if r["rigid"]]
    assert rigid == ["rod", "coil"]
    assert not any(r["rigid"] for r in payload([alone])["results"][0]["regions"])
    paper, _ = load_scene("paper", ["models=tmm"])
    assert standing(paper, alone) is alone
