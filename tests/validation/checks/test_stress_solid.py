"""The stress run of the solid: each family holds its bounds, or says why it has no answer."""

from types import SimpleNamespace

import numpy as np
import pytest
from approved import described

from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.validation.checks.stress import Asked, solid, solid_answers, solid_exact

EXACT = (
    solid_exact.scaling_row,
    solid_exact.uniform_section_row,
    solid_exact.slender_row,
    solid_exact.one_element_row,
    solid_exact.distorted_row,
    # by default reduction is tried at peaks and dips (tests/fem/bimorph/reduction/test_krylov.py)
    pytest.param(solid_answers.resonance_row, marks=pytest.mark.heavy),
)


@pytest.mark.parametrize("family", EXACT, ids=lambda f: f.__name__)
def test_exact_families_hold(family, every_point, monkeypatch, approved_line):
    """Scaling laws, patch tests and the slender limit, far beyond the device.

    At L/h = 1e4 rounding hides the stiffness of bending: a sentence, no number.
    """
    points = every_point(monkeypatch, least=0.0)
    row = family(True)
    assert row.verdict in ("holds", "holds or says why not"), (row.worst, row.refusals)
    assert row.points > 0
    assert len(row.refusals) == (family is solid_exact.slender_row)
    head = f"{row.family} | {row.what} | {row.points} | {row.verdict} | {row.refusals}"
    approved_line(" | ".join([head, *points]))


def test_what_the_whole_families_ask(every_point, monkeypatch, approved):
    """Each body with its ceramic, and what it is held against, on made-up ports."""
    asked, ports = [], np.diag([2.0, 3.0, 5.0, 7.0, 11.0])
    ports[2, 3] = ports[3, 2] = 1.3
    ports[2:4, 4] = ports[4, 2:4] = 0.7, -0.4
    system = SimpleNamespace(spurious_stiffness=1e-3, potentials=4)

    def assemble(device, mesh, *, lossy, ceramic, uniform_field=False):
        changed = {k: v for k, v in device.model_dump(exclude_defaults=True).items() if v}
        bricks = isinstance(mesh, Bricks)
        body = [a.breaks for a in mesh.axes] if bricks else [*np.sort(mesh.points, axis=0).T]
        made_of = [ceramic.density, ceramic.s[0, :3], ceramic.d[[0, 2]], ceramic.eps_t[2]]
        told = described([lossy, uniform_field, changed, *made_of, *body])
        asked.append(" ".join(told.split()))
        return system

    monkeypatch.setattr(solid_exact, "assemble", assemble)
    modes = [SimpleNamespace(frequency=17.0)]
    monkeypatch.setattr(solid_exact, "natural_modes", lambda *_: modes)
    found = SimpleNamespace(stiffness=np.array([ports]))
    monkeypatch.setattr(solid_exact, "static_multiport", lambda _: found)
    points = every_point(monkeypatch, exactly=True)
    for family in EXACT[:-1]:
        family(False)
    approved("\n".join([*points, *asked]))


@pytest.mark.heavy
def test_full_run():
    """No family of the full run fails."""
    found = solid.run(Asked(quick=False))
    assert [row.family for row in found.rows if row.verdict == "fails"] == []
