"""The stress run of the solid: each family holds its bounds, or says why it has no answer."""

import pytest

from tactgen.validation.evidence import stress_solid as solid
from tactgen.validation.evidence.stress import PartRequest


@pytest.mark.heavy
def test_full_run():
    """No family of the full run fails."""
    found = solid.run(PartRequest(quick=False))
    assert [row.family for row in found.rows if row.verdict == "fails"] == []
