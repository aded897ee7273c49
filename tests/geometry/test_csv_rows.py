"""CSV files as tables: what is a file at all, how wide its lines are, what is a number."""

import os

import pytest

from tactgen.geometry.csv_tables import csv_rows, heading, plain_number, read_columns
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import Unit


@pytest.mark.parametrize(
    ("cell", "value"),
    [("1", 1.0), ("-0.5e-3", -5e-4), (".5", 0.5), ("+2.", 2.0), ("1_0", None), ("1,0", None),
     ("nan", None), ("inf", None), ("1e999", None), ("٣", None), ("0x10", None), ("", None),
     ("1 0", None)],
)  # fmt: skip
def test_numbers_are_those_that_other_programs_write(cell, value):
    """Python's own reading takes 1_0 for ten and digits of any script."""
    assert plain_number(cell) == value


def test_lines_wider_than_the_header_are_refused(tmp_path):
    """A decimal comma makes two cells of one; fewer cells pass only where that is allowed."""
    path, known = tmp_path / "a.csv", {"a": Unit("", "number", "1")}

    def read(text, *, others):
        path.write_text(text)
        return read_columns(path, "a.csv", known, "a", ("a",), others=others)

    for header in ("a,b", "b,a"):
        with pytest.raises(InputError, match=r"line 3 has 4 cells .* header has 2 .*; fill"):
            read(f"{header}\n0,0\n1,5,100,2\n", others=True)
    assert read("a,b\n0\n", others=True).columns["a"].tolist() == [0.0]
    with pytest.raises(InputError, match="the cell is empty"):
        read("b,a\n0\n", others=True)
    with pytest.raises(InputError, match="has 2 cells"):
        read("a\n0,1\n", others=False)


def test_what_is_no_file_is_not_read(tmp_path):
    """A pipe without a writer, a device without an end, a folder, a file too large: at once."""
    os.mkfifo(tmp_path / "pipe")
    with (tmp_path / "large").open("wb") as file:
        file.truncate(10**12)  # takes no room on the disk
    for name, words in (
        (tmp_path / "pipe", "a pipe or a device"), ("/dev/zero", "a pipe or a device"),
        (tmp_path, "a folder"), (tmp_path / "large", "larger than 20 mb"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=rf"cannot be read \(it is {words}.*\); mend it"):
            csv_rows(name, str(name), "mend it")


@pytest.mark.parametrize(
    ("text", "name", "unit"),
    [
        ("Tip Voltage (V) ", "tip_voltage", "V"),
        ("frequency [ Hz ]", "frequency", "Hz"),
        ("phase", "phase", ""),
        ("force (N", "", ""),
        ("force (N) at the tip", "", ""),
    ],
)
def test_what_a_heading_says(text, name, unit):
    """A name and a unit in either kind of brackets; nothing of what is something else."""
    assert heading(text) == (name, unit)
