"""The stress run: what it finds of the transfer matrix; magnets that cannot be."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.fem.magnetics.axisymmetric_field import solve_field
from tactgen.fem.magnetics.axisymmetric_space import discretise
from tactgen.fem.magnetics.problem_3d import MagneticSolid
from tactgen.geometry.device.magnetisation import MagnetisationCurve, linear
from tactgen.geometry.reluctance.section_grid import Region, graded_grid
from tactgen.geometry.reluctance.team20 import Team20Meshing, team20_mesh, team20_source
from tactgen.validation.evidence import stress_beam as beam
from tactgen.validation.evidence.error_maps import error_map, write_maps
from tactgen.validation.evidence.judgement import REFUSALS, Family, rows, run_parts
from tactgen.validation.evidence.stress import RULE


@pytest.fixture(scope="module")
def few():
    """Let quick runs of the transfer-matrix model's part take a few points over its ranges."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(beam, "_QUICK", (7, 2))
        patch.setattr(beam, "_NEAR_CUT_OFF", (0.0, 1e-14))
        patch.setattr(beam, "_QUALITIES", (1.0, 1e9))
        yield


@pytest.fixture(scope="module")
def found(few):
    """Return the rows of such a run by the first word of their names."""
    made = {}
    for title, judge in beam.FAMILIES.items():
        family = Family(title)
        judge(family, True)
        (row,) = rows(family.answers, RULE)
        made[title.partition(":")[0]] = row, family.answers
    return made


def test_every_family_holds(found):
    """Within its bounds; joining n pieces costs n³ roundings at most."""
    assert {row.verdict for name, (row, _) in found.items() if "natural" not in name} == {"holds"}


def test_natural_frequencies_from_slender_to_all_shear(found):
    """Each within its rounding; only free beams at φ beyond use are refused."""
    row, answers = found["natural frequencies"]
    assert row.verdict == "holds or says why not"
    # three modes at five φ and three ends, less those of the free beam at 1e8 and 1e16
    assert row.count == 3 * (5 * 3 - 2)
    assert all("lost in rounding" in one.refusal for one in answers if one.refusal)


def test_into_a_resonance(found):
    """Down to the last bit the bound is right, and then is large."""
    worst = max(found["resonance"][1], key=lambda one: one.error)
    assert worst.error > 1e-8
    assert worst.bar < 100 * worst.error


@pytest.mark.parametrize("lossy", [True, False])
def test_the_naive_formulas_fail(few, lossy):
    """The paper's matrix A has no digit left in a long beam, and too few near 0 Hz."""
    table = error_map(lossy, quick=True)
    # above the cut-off, 860 kHz, no wave grows any more
    high = table.naive[-1, (table.frequencies > 1e3) & (table.frequencies < 8e5)]
    low = table.naive[table.lengths < 1e-3][:, (table.frequencies > 0) & (table.frequencies < 1)]
    assert high.size
    assert (high > 0.1).all()
    assert low.size
    assert (low > 1e-10).all()
    assert (table.error < 1e-10).all()


def test_maps_are_written(few, own_store, tmp_path):
    """As a table and as a figure each."""
    files = write_maps(tmp_path, quick=True)
    assert [file.suffix for file in files] == [".csv", ".svg"] * 2
    assert all(file.stat().st_size for file in files)


@pytest.mark.heavy
@pytest.mark.parametrize("part", ["tmm", "lateral", "solid", "magnetics", "machine"])
@pytest.mark.parametrize("quick", [True, False])
def test_no_family_fails(part, quick):
    """All models over their whole ranges."""
    (found,) = run_parts("stress", [part], 1, lambda _: None, quick=quick)
    assert [(row.quantity, row.worst) for row in found.rows if not row.holds] == []


def upside_down():
    curve = MagnetisationCurve(np.array([0.0, 1.0]), np.array([0.0, -1e6]), -1e6)
    parts = (
        Region("core", (0.0, 2e-3), (0.0, 5e-3), curve),
        Region("coil", (2.5e-3, 4e-3), (1e-3, 4e-3), turns=100.0),
    )
    solve_field(discretise(graded_grid(parts, 0.1), 2), np.ones(1))


def hexahedra():
    mesh = replace(team20_mesh(Team20Meshing(scale=4.0)), kind="hexahedron")
    MagneticSolid(mesh, {}, team20_source)


IMPOSSIBLE = {
    "µr below 1": lambda: linear(0.5),
    "µr nan": lambda: linear(float("nan")),
    "H falling with B": upside_down,
    "hexahedra": hexahedra,
}


@pytest.mark.parametrize("what", IMPOSSIBLE)
def test_nothing_impossible_is_answered(what):
    """Each of them ends in one sentence."""
    with pytest.raises(REFUSALS) as refused:
        IMPOSSIBLE[what]()
    assert str(refused.value).strip()
    assert "\n" not in str(refused.value)
