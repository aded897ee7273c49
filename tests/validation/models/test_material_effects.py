"""The choices of a full tensor: the reduced set kept, the impossible ones refused with a reason."""

import numpy as np
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
    for label, why, changed in rows:
        assert why
        if not label.startswith(CHANGES):
            assert changed.reduced() == pytest.approx(ceramic.reduced(), rel=1e-14)


#: Entries of s and d that a name speaks of (from 0).
ENTRIES = {"d33": ("d", 2, 2), "d15": ("d", 0, 4), "d31": ("d", 2, 0), "s13": ("s", 0, 2),
           "s33": ("s", 2, 2)}  # fmt: skip


@pytest.mark.parametrize("name", sorted(LIBRARY))
def test_choices_do_what_their_names_say(name):
    """The entry named is scaled, no other one; what is poled along z looks alike all around it."""
    ceramic = LIBRARY[name]
    for label, _, changed in choices(ceramic):
        s, d, eps = changed.s, changed.d, changed.eps_t
        for here, there in (
            (d[0, 4], d[1, 3]), (d[2, 0], d[2, 1]), (eps[0, 0], eps[1, 1]), (s[0, 0], s[1, 1]),
            (s[0, 2], s[1, 2]), (s[3, 3], s[4, 4]), (s[5, 5], 2.0 * (s[0, 0] - s[0, 1])),
        ):  # fmt: skip
            assert here == pytest.approx(there, rel=1e-12), label
        assert s == pytest.approx(s.T, rel=1e-12)
        entry, _, factor = label.partition(" x " if " x " in label else " = ")
        if entry in ENTRIES:
            which, i, j = ENTRIES[entry]
            usual = {"s": ceramic.s, "d": ceramic.d}
            assert {"s": s, "d": d}[which][i, j] == pytest.approx(
                float(factor) * usual[which][i, j]
            )
            alike = {(i, j), (j, i), (1, 2), (2, 1)} if entry == "s13" else {(i, j), (1, 3), (2, 1)}
            for key, tensor in (("s", s), ("d", d)):
                moved = {tuple(at) for at in np.argwhere(tensor != usual[key]).tolist()}
                assert moved <= (alike if key == which else set()), label
        elif entry == "-s12/s11":
            assert -s[0, 1] / s[0, 0] == pytest.approx(float(factor), rel=1e-12)


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
    for label, _, changed in choices(LIBRARY[name]):
        try:
            changed.check_admissible()
        except InputError:
            refused.add(label)
    assert refused == impossible
