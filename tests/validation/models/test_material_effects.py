"""The choices of a full tensor: the reduced set kept, the impossible ones refused with a reason."""

import pytest

from tactgen.geometry.device.material_library import LIBRARY
from tactgen.geometry.errors import InputError
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


@pytest.mark.parametrize(
    ("name", "impossible"),
    [
        ("M1876", {"d33 = 0", "d31 x 2"}),
        ("PZT-5H", {"d33 = 0", "d31 x 2"}),
        ("PZT-5A", {"d31 x 2"}),
    ],
)
def test_only_extremes_are_impossible(name, impossible):
    """What soft PZT shows is possible; twice the d31, or for a strong d31 no d33, is not."""
    refused = set()
    for label, changed in choices(LIBRARY[name]):
        try:
            changed.check_admissible()
        except InputError:
            refused.add(label)
    assert refused == impossible
