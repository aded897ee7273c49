"""Shared by tests of what holds for every model: a solid that costs little."""

import pytest


@pytest.fixture
def coarse_solid(request):
    """Divide the solid coarsely, with a store for it, where it is the model that is asked.

    What holds whatever the mesh is as true there.
    """
    if request.node.callspec.params.get("model") == "solid":
        request.getfixturevalue("own_store")
        request.getfixturevalue("coarse_bricks")
