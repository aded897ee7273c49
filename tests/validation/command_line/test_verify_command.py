"""``tactgen verify``: rows with a verdict, an exit code that tells, bad groups refused."""

import json
from dataclasses import replace

import pytest

from tactgen.validation.command_line.cli import main
from tactgen.validation.evidence.cases import bimorph

KEPT = ("TMM-5", "FIN-1", "PAP-2", "SOL-3")
FEW = tuple(
    replace(case, rows=tuple(row for row in case.rows if row.id in KEPT)) for case in bimorph.CASES
)
ONE = FEW[0].rows[0]
FIELDS = {
    "id", "group", "tier", "requirement", "measured", "reference", "source", "tolerance",
    "reason", "verdict",
}  # fmt: skip


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(bimorph, "CASES", FEW)


def run(capsys, *arguments):
    code = main(["verify", *arguments])
    out, err = capsys.readouterr()
    return code, out, err


def test_rows_carry_what_a_reader_needs(few, capsys):
    """JSON rows are complete, a known difference is explained, a heavy row is skipped."""
    code, out, err = run(capsys, "--only", "bimorph", "--json")
    rows = {row["id"]: row for row in json.loads(out)["rows"]}
    assert (code, err) == (0, "")
    assert all(set(row) >= FIELDS for row in rows.values())
    verdicts = {name: row["verdict"] for name, row in rows.items()}
    assert verdicts == {
        "TMM-5": "pass", "FIN-1": "pass", "PAP-2": "explained", "SOL-3": "skipped",
    }  # fmt: skip
    assert rows["SOL-3"]["measured"] is None
    assert rows["PAP-2"]["explained"]


def test_a_failure_is_the_exit_code(monkeypatch, capsys):
    """One row off by more than its tolerance: exit code 1, and the table says which."""
    wrong = replace(ONE, id="OFF-1", measure=lambda: 2.0 * ONE.reference)
    monkeypatch.setattr(bimorph, "CASES", (replace(FEW[0], rows=(wrong,)),))
    code, out, _ = run(capsys, "--only", "bimorph")
    assert code == 1
    assert "OFF-1     fail" in out
    assert out.splitlines()[-1] == "0 pass, 0 explained, 1 fail, 0 skipped"


def test_unknown_group_is_refused(capsys):
    """One sentence that names what is known."""
    code, out, err = run(capsys, "--only", "bimorf")
    assert (code, out) == (2, "")
    assert 'did you mean "bimorph"' in err
