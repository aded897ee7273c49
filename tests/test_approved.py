"""Approved outputs: what counts as the same, what is told, and that no file is left over."""

import re
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from alike import by_letter, differences, loosened, with_marks
from approved import FOLDER, _kept, _write, described, figure_text, page_text

OLD = "f1 = 440.1234 Hz, 3 rows\nSV-1 passes\nx = 12.3 ± 4.0e-12 mm, 2e-11 %"


@pytest.mark.parametrize(
    ("old", "new", "count"),
    [
        ("440.1234", "440.1236", 0),  # rounding
        ("440.1234", "440.2234", 1),
        ("3 rows", "4 rows", 1),
        ("SV-1", "SV-2", 1),
        ("= 440", "= -440", 1),
        ("3 rows", "  3 rows", 0),  # as columns of a table move
        ("passes", "fails", 2),
        ("4.0e-12", "9.0e-13", 0),  # a bar of rounding
        ("4.0e-12", "4.0e-3", 1),
        ("2e-11 %", "-7.1e-12 %", 0),  # the same as a part
        ("2e-11 %", "7e-2 %", 1),
        ("passes", "passes\nand one line more", 1),
        ("SV-1 passes\n", "", 1),
    ],
)
def test_words_are_exact_and_numbers_near(old, new, count):
    """A line too many, another word or number is told; rounding is not."""
    assert differences(OLD, OLD) == []
    assert len(differences(OLD, OLD.replace(old, new))) == count


def test_small_numbers_of_a_row_have_fewer_digits():
    """Beside 4000 a thousandth may differ by 4e-5 (1e-6 of a hundredth of it), alone it may not."""
    assert differences("a [1, 0.001, 4000] 2", "a [1, 0.00103, 4000] 2") == []
    assert differences("a [1, 0.001, 4000] 2", "a [1, 0.00105, 4000] 2")
    assert differences("a [4000] 0.001", "a [4000] 0.00103")
    assert differences("a 1, 4000, 0.001", "a 1, 4000, 0.00103")


@pytest.mark.parametrize("commit", ["4e7aa6a", "5e36ae96-dirty", "0123456789ab", "12345e67" * 5])
def test_a_commit_passes_however_long_its_name_is(commit):
    """A clone abbreviates as far as its other objects let it."""
    assert page_text(f"<p>Made by commit {commit}.</p>") == "Made by …."


def test_a_value_is_told_to_its_leaves():
    """Fields, keys, arrays, complex numbers; long rows by some of their numbers and their mean."""

    @dataclass(frozen=True)
    class Row:
        name: str
        value: float
        curve: np.ndarray

    told = described({"row": Row("a  b", 1.0 / 3.0, np.arange(100.0)), "z": [1 + 2j, None, True]})
    for wanted in ("row: Row", "name: a b", "value: 0.3333333", "(100,) [0, 24, 49, 74, 99]",
                   "mean 49.5", "1 +2j", "True"):  # fmt: skip
        assert wanted in told
    assert described(SimpleNamespace(a=1)).split() == ["a:", "1"]


def test_a_page_and_a_figure_are_told():
    """A row a line, links and names of pictures, no style; limits, labels and data of axes."""
    from tactgen.validation.view.figures import panels

    page = "<style>p {}</style><h2>A</h2><table><tr><td>1</td><td>2</td></tr></table><img alt='i'>"
    assert page_text(page).splitlines() == ["A", "| 1 | 2", "[alt: i]"]
    assert page_text("<p>On 2026-01-31 in 3.25 s</p>") == "On … in …"
    figure, axis = panels(2.0, 2.0)
    axis.plot([1.0, 2.0], [3.0, 5.0], label="curve")
    axis.set(xlabel="f in Hz", ylim=(0.0, 6.0), yscale="linear")
    axis.legend()
    told = figure_text(figure)
    for wanted in ("x 'f in Hz' linear", "y '' linear [0, 6]", "line 'curve' - None [1, 2] [3, 5]",
                   "legend ['curve']"):  # fmt: skip
        assert wanted in told


def test_no_file_is_left_of_a_test_that_is_gone():
    """Each stands in the folder of its test's file, with the function's name before any "-"."""
    tests = Path(__file__).parent
    sources = defaultdict(str)  # some files in two folders have one name
    for path in tests.rglob("test_*.py"):
        sources[path.stem] += path.read_text(encoding="utf-8")
    for file in FOLDER.rglob("*.txt"):
        function = re.split(r"[-.]", file.name)[0]
        assert f"def {function}(" in sources[file.parent.name], file


@pytest.mark.parametrize("option", ["--approve", "--loosen"])
def test_what_says_the_same_is_not_written_again(option, tmp_path):
    """Rounding makes no diff to review; another number does, or is marked."""
    request = SimpleNamespace(config=SimpleNamespace(getoption=option.__eq__))
    file, kept = tmp_path / "a" / "b.txt", "x 1.0\n"
    _write(file, "", kept)
    for text, wanted in (("x 1.0000001\n", kept), ("x 2\n", {"--approve": "x 2\n"}.get(option))):
        now = _kept(request, kept, text, differences)
        assert now == (wanted or "x ~1.0\n")
        _write(file, kept, now)
        assert file.read_text("utf-8") == now


@pytest.mark.parametrize(
    ("elsewhere", "mark", "passes", "fails"),
    [
        ("33.301", "≈", "33.5", "34.0"),  # two digits are left
        ("35.0", "~", "300", "-33.3"),  # of which size it is
        ("-2e-7", "?", "4", None),  # cancellation: nothing is left
    ],
)
def test_a_number_is_marked_by_what_another_processor_leaves_of_it(elsewhere, mark, passes, fails):
    """It may then differ by some ten times as much; other numbers of the line may not."""
    kept = loosened("a 33.3 of 5\n", f"a {elsewhere} of 5\n")
    assert kept == f"a {mark}33.3 of 5\n"
    assert loosened(kept, f"a {elsewhere} of 5\n") == kept
    assert not differences(kept, f"a {passes} of 5\n")
    assert fails is None or differences(kept, f"a {fails} of 5\n")
    assert differences(kept, f"a {elsewhere} of 6\n")
    assert loosened(kept, f"b {elsewhere} of 5\n") is None


def test_marks_grow_and_stay_when_a_text_is_approved_again():
    """A looser mark takes the place of a narrower one; lines of other words lose theirs."""
    assert loosened("a ≈1.0\n", "a -1.0\n") == "a ?1.0\n"
    assert with_marks("a ?1.0 3\nb ~2\n", "a 7.0 4\nc 2\n") == "a ?7.0 4\nc 2\n"
    assert with_marks("a ?1.0\n", "a #\n") == "a #\n"


def test_by_letter_no_digit_is_rounding():
    """Constants of the packages: a threshold of 1e-12 is no nought."""
    assert by_letter("a = 1e-12\nb = 1\n", "a = 2e-12\nb = 1\n") == ["  -a = 1e-12", "  +a = 2e-12"]
    assert not by_letter("a = 1\n", "a = 1\n")


def test_another_output_fails_and_says_how_to_approve_it(request):
    """With the lines that differ; nothing is written by a failure."""
    compare = request.getfixturevalue("approved")
    if request.config.getoption("--approve"):
        return
    with pytest.raises(pytest.fail.Exception, match=r"(?s)\+ one line.*make approve TESTS=tests/t"):
        compare("one line")
    assert not (FOLDER / "test_approved").exists()
