"""The choices of a full tensor keep the reduced set."""

import pytest

from tactgen.geometry.device.material_library import LIBRARY
from tactgen.validation.models.bimorph.rod_joint import choices

#: Choices that change the reduced set, as their names say.
CHANGES = ("eps33", "d31")


@pytest.mark.parametrize("name", sorted(LIBRARY))
def test_choices_keep_the_reduced_set(name):
    """All that a one-dimensional model knows stays, unless the row says otherwise."""
    ceramic = LIBRARY[name]
    rows = list(choices(ceramic))
    assert len({row[0] for row in rows}) == len(rows) >= 10
    for label, changed in rows:
        if not label.startswith(CHANGES):
            assert changed.reduced() == pytest.approx(ceramic.reduced(), rel=1e-14)
