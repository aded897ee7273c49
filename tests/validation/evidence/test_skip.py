"""The measurement of what is skipped can fail: each fault that it looks for is found."""

import pytest

from tactgen.validation.evidence import bench_skip as skip

CASE = skip.Case("made up", "j1", (), ("cadquery",), "piezo only", ("solid.ports",))


def said(**changed):
    plain = {"watched": ["skfem"], "computed": [], "answers": [1.0]}
    return {**plain, **changed}


@pytest.mark.parametrize(
    ("warm", "fault"),
    [
        (said(), ""),
        (said(watched=["cadquery"]), "made up imports cadquery"),
        (said(computed=["solid.ports"]), "made up computes solid.ports again"),
        (said(answers=[1.0 + 2e-16]), "made up answers otherwise when warm"),
    ],
)
def test_faults_are_found(warm, fault):
    assert skip._faults(CASE, said(), warm) == ([fault] if fault else [])


def test_a_changed_density_must_be_computed():
    """Taking over what was solved with another density would be a wrong answer."""
    density = next(case for case in skip.CASES if case.after and not case.reused)
    assert skip._faults(density, said(), said(computed=["solid.ports"])) == []
    (fault,) = skip._faults(density, said(), said())
    assert "answered with the old one" in fault


def test_a_process_of_its_own_tells_what_it_did(tmp_path):
    """The transfer-matrix case: no heavy library, one stage, all others skipped."""
    case = skip.CASES[0]
    found = skip.solved(case, tmp_path)
    assert found["computed"] == ["tmm.ports"]
    assert not set(case.absent) & set(found["watched"])
    assert found["skipped"] > 30


@pytest.mark.heavy
def test_nothing_needless_is_done():
    """All scenes, cold and warm."""
    found = skip.run(False, lambda _: None)
    assert found.targets[0].met, found.targets[0].how
    assert len(found.timings) == 2 * len(skip.CASES)
