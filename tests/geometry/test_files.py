"""Files appear whole or not at all, whoever writes them."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tactgen import geometry
from tactgen.geometry import operating_system
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import read_text, written_whole
from tactgen.geometry.store.store import locked, read_entry, sealed, write_entry

PRODUCT = Path(geometry.__file__).parents[1]


def test_the_old_file_stays_until_the_new_one_is_whole(tmp_path):
    """Amid writing a reader still finds the old one; a writer that fails changes nothing."""
    target = tmp_path / "a.csv"
    target.write_text("old", encoding="utf-8")

    def fail():
        with written_whole(target) as draft:
            draft.write_text("half", encoding="utf-8")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert target.read_text(encoding="utf-8") == "old"
    with written_whole(target) as draft:
        assert draft.suffix == target.suffix
        draft.write_text("new", encoding="utf-8")
        assert target.read_text(encoding="utf-8") == "old"
    assert target.read_text(encoding="utf-8") == "new"
    assert list(tmp_path.iterdir()) == [target]


def test_nothing_stays_open(tmp_path):
    """Of files, entries and locks: a study makes more than may be open at once."""

    def use():
        with written_whole(tmp_path / "a.csv") as draft:
            draft.write_text("1", encoding="utf-8")
        assert read_text(tmp_path / "a.csv") == "1"
        with pytest.raises(OSError, match="a folder"):
            read_text(tmp_path)
        write_entry(tmp_path / "one.kept", sealed(tmp_path / "one.kept", 1))
        read_entry(tmp_path / "one.kept")
        with locked(tmp_path / "held.claim", print):
            pass

    use()  # what stays open once may
    before = sorted(Path("/dev/fd").iterdir())
    use()
    assert sorted(Path("/dev/fd").iterdir()) == before


@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
def test_only_files_are_replaced(tmp_path, kind):
    """A device or pipe of that name stays what it is; in a folder that is not there nothing is."""
    target = Path("/dev/null") if kind == "device" else tmp_path / kind
    if kind == "pipe":
        os.mkfifo(target)
    if kind == "folder":
        target.mkdir()
    before = target.stat().st_mode
    with pytest.raises(InputError, match=r"cannot be written \(it is a .*\); choose another name"):
        written_whole(target).__enter__()
    assert target.stat().st_mode == before
    with pytest.raises(InputError, match=r"cannot be written .*; choose"):
        written_whole(tmp_path / "no" / "a.csv").__enter__()


KILLED = """
import os, signal, sys
from tactgen.geometry.files import written_whole
with written_whole(sys.argv[1]) as draft:
    draft.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_a_killed_process_left_is_swept(tmp_path):
    """The next writer into the folder takes it away, but no draft of a process that lives."""
    done = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path / "a.csv")], check=False)
    assert done.returncode == -signal.SIGKILL
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(".tactgen-")
    (tmp_path / ".tactgen-notes").write_text("mine")
    with written_whole(tmp_path / "b.csv") as living, written_whole(tmp_path / "c.csv") as other:
        assert not left.exists()
        assert living.exists()
        other.write_text("c")
        living.write_text("b")
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {".tactgen-notes", "b.csv", "c.csv"}


def test_nothing_is_written_but_drafts():
    """What is written is a draft, in a module that takes it from :func:`written_whole`.

    Only the run that tries what damage does writes into the store's files, in place.
    """
    written = {}
    for package in ("geometry", "tmm", "fem", "validation"):
        for path in (PRODUCT / package).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            written[path.relative_to(PRODUCT).as_posix()] = (
                set(re.findall(r"(\S+)\.write_(?:text|bytes)\(", text)), "written_whole" in text
            )  # fmt: skip
    del written["validation/evidence/faults.py"]
    for path, (names, taken) in written.items():
        assert names <= {"draft", "temporary"}, path
        assert taken or "draft" not in names, path
    assert any(names for names, _ in written.values())


def test_a_process_of_another_user_lives(monkeypatch):
    """It may not be sent a signal, which is answer enough."""

    def refused(process, number):
        raise PermissionError

    monkeypatch.setattr(os, "kill", refused)
    assert operating_system.is_running(1)
