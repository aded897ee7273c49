"""What all tests of benchmarks on made-up measurements compare."""

import re

import pytest
from approved import page_text

from tactgen.validation.bench.output import print_bench, write_bench

#: How long a run took, and with what.
_PASSING = re.compile(r"\(\d+ s\)|numpy [\d.]+, \w+")
_BOXES = r"[─-╿]+"


@pytest.fixture
def told(approved, capsys, tmp_path, undrawn):
    """Return what compares all that people get of a run: its tables, file and curves."""

    def compare(found):
        capsys.readouterr()
        print_bench([found])
        folder = tmp_path / "told"
        folder.mkdir()
        table, plot = (path.read_text(encoding="utf-8") for path in write_bench([found], folder))
        lines = (
            " ".join(re.sub(_BOXES, "|", s).split()) for s in capsys.readouterr().out.splitlines()
        )
        words = _PASSING.sub("…", "\n".join(line for line in lines if line.strip("| ")))
        approved("\n".join([words, table, page_text(plot)]))

    return compare
