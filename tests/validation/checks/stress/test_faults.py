"""Commands under bad circumstances: a few by default, all of them and more often when heavy."""

import random
import subprocess
from types import SimpleNamespace

import pytest
from approved import described
from scipy.io import netcdf_file

from tactgen.validation.book.book import write_book
from tactgen.validation.checks.stress import Asked
from tactgen.validation.checks.stress.faults import commands as by_commands
from tactgen.validation.checks.stress.faults import run as faults
from tactgen.validation.checks.stress.faults.commands import (
    HEAVY,
    LIGHT,
    Command,
    Ended,
    before_us,
    half_written,
)
from tactgen.validation.checks.stress.result import answered
from tactgen.validation.command_line.cli import commands

#: Commands that neither write nor compute.
IDLE = {"completion", "scenes"}


@pytest.fixture(scope="module")
def trials(tmp_path_factory):
    """The quickest command that writes; the heavy test has those that keep and compute."""
    return faults.Trials(LIGHT[:1], tmp_path_factory.mktemp("faults"), seed=1)


def test_every_command_is_put_to_the_test():
    """Whoever adds a command names a cheap run of it."""
    assert {command.arguments[0] for command in (*LIGHT, *HEAVY)} | IDLE == set(commands())


@pytest.mark.parametrize(("end", "signals"), [(0, [9, 9]), (15, [15, 9])])
def test_what_does_not_end_is_killed_and_counts_as_endless(monkeypatch, end, signals):
    """Whether it was asked to end or took too long; none is left behind."""
    sent, waited = [], []

    def communicate(timeout=None):
        waited.append(timeout)
        if timeout is not None:
            raise subprocess.TimeoutExpired("tactgen", timeout)
        return "", ""

    monkeypatch.setattr(by_commands.os, "killpg", lambda pid, number: sent.append((pid, number)))
    process = SimpleNamespace(pid=7, communicate=communicate, returncode=-9)
    assert by_commands.finish(process, after=0.5, end=end) == Ended(124, "", "endless")
    assert sent == [(7, number) for number in signals]
    assert waited == [0.5, by_commands.ENDLESS, None]


def test_what_ends_only_when_killed_is_endless_unless_it_was_to_be_ended(monkeypatch):
    def ended():
        outcomes = iter([subprocess.TimeoutExpired("tactgen", 1.0), ("said", "")])

        def communicate(timeout=None):
            outcome = next(outcomes)
            if isinstance(outcome, Exception):
                raise outcome
            return outcome

        return SimpleNamespace(pid=7, communicate=communicate, returncode=-2)

    monkeypatch.setattr(by_commands.os, "killpg", lambda *_: None)
    assert by_commands.finish(ended()) == Ended(124, "said", "endless")
    assert by_commands.finish(ended(), after=0.5, end=2) == Ended(-2, "said", "")


def test_a_command_that_is_ended_while_python_loads_ended_by_its_signal(monkeypatch, tmp_path):
    """Its words are not ours to judge."""
    judged = []
    trials = SimpleNamespace(
        commands=LIGHT[:1], place=lambda: None, chance=random.Random(1),
        seconds={LIGHT[0].name: 1.0},
        judge=lambda command, around, done, codes: judged.append((done, codes)) or "",
    )  # fmt: skip
    monkeypatch.setattr(faults, "begin", lambda *_: None)
    loading = Ended(1, "", "KeyboardInterrupt\n")
    monkeypatch.setattr(faults, "finish", lambda *_, **__: loading)
    row = faults.interrupted(trials, 1)
    ((done, codes),) = judged
    assert done == Ended(-2, "", "")
    assert (done.code in codes, row.points) == (True, 1)


@pytest.mark.parametrize("family", [faults.killed, faults.interrupted])
def test_ended_at_some_moment(trials, family):
    """Nothing half-written, words of ours, and the same command again is right."""
    row = family(trials, 1)
    assert row.verdict == "holds", row.worst


@pytest.mark.parametrize(("family", "count"), [(faults.no_room, 2), (faults.read_only, 1)])
def test_no_room_is_one_sentence(trials, family, count):
    """Files that cannot grow, folders that take none: refused, nothing left."""
    row = family(trials)
    assert row.verdict == "holds or says why not", row.worst
    assert len(row.refusals) == count
    assert all("cannot be written" in words for words in row.refusals)


@pytest.mark.parametrize("code", [0, 2, 1])
def test_all_circumstances_are_tried(trials, monkeypatch, every_point, approved, code):
    """Each family: how often a command is begun, with what, and what is said of how it ended."""
    seen, points = [], every_point(monkeypatch, exactly=True)

    def begun(command, around, **streams):
        seen.append((command.name, around.limit, around.variables, around.store, [*streams]))

    ended = Ended(code, "", "tactgen: no room\n" if code == 2 else "")
    monkeypatch.setattr(faults, "begin", begun)
    monkeypatch.setattr(faults, "finish", lambda *_, **__: ended)
    monkeypatch.setattr(trials, "compared", lambda *_: "")
    monkeypatch.setattr(trials, "chance", random.Random(1))
    monkeypatch.setattr(trials, "seconds", {LIGHT[0].name: 1.0})
    found = []
    for family in faults._families(quick=True):
        seen.clear()
        row = family(trials)
        tries = [(*said[:3], str(said[3]).startswith("/proc"), said[4]) for said in seen]
        found += [row, *dict.fromkeys(map(str, tries)), len(tries)]
    approved(described([*found, *points]))
    often = [family(trials).points for family in faults._families(quick=False)[:4]]
    assert often == [60, 30, 30, 30]


def test_entries_are_spoilt_in_every_way(trials, tmp_path, monkeypatch, approved):
    """A bit of each flipped, cut to half, emptied, or with another's content; then run again."""
    for name in "abc":
        (tmp_path / f"{name}.kept").write_bytes(name.encode() * 5)
    (tmp_path / "beside.claim").write_bytes(b"as it was")
    seen = []

    def again(command, around):
        seen.append({p.name: p.read_bytes().hex() for p in sorted(around.store.iterdir())})
        return ""

    monkeypatch.setitem(trials.stores, LIGHT[0].name, tmp_path)
    monkeypatch.setattr(trials, "again", again)
    monkeypatch.setattr(trials, "chance", random.Random(4))
    row = faults.corrupted(trials, 12)
    assert (row.points, row.verdict) == (12, "holds")
    approved(described(seen))


@pytest.mark.parametrize(
    ("name", "content", "whole"),
    [
        ("a.json", b'{"a": 1}', True), ("a.json", b'{"a": ', False), ("a.csv", b"1,2\n3", False),
        ("a.html", b"<html></html>\n", True), ("a.html", b"<html>", False),
        ("a.svg", b"<svg></svg>", True), ("a.svg", b"<svg>", False), ("a.toml", b"a = ", False),
        ("a.step", b"ISO-10303-21;", False), ("a.nc", b"", False),
        ("a.glb", b"glTF\x02\0\0\0\x0c\0\0\0", True), ("a.glb", b"glTF\x02\0\0\0\x0d\0\0\0", False),
        ("a.npz", b"PK\x03\x04", False), ("a.fmu", b"PK\x03\x04", False),
        (".tactgen-0-1-x.json", b"{", True),
    ],
)  # fmt: skip
def test_half_files_are_found(tmp_path, name, content, whole):
    """By how each format ends; drafts have no name of ours yet."""
    (tmp_path / name).write_bytes(content)
    assert half_written(tmp_path) == ([] if whole else [name])


def test_half_a_table_is_found(tmp_path):
    """Of a netCDF file every share that is not all of it."""
    whole = tmp_path / "a.nc"
    with netcdf_file(whole, "w") as file:
        file.createDimension("t", 9)
        file.createVariable("force", "f8", ("t",))[:] = 1.0
    content = whole.read_bytes()
    assert half_written(tmp_path) == []
    for size in range(1, len(content), 7):
        whole.write_bytes(content[:size])
        assert half_written(tmp_path) == ["a.nc"]


@pytest.mark.parametrize(
    ("done", "wrong"),
    [
        (Ended(2, "", "tactgen: no room\n"), ""),
        (Ended(2, "", ""), "said"),
        (Ended(1, "", "tactgen: no room\n"), "ended with 1"),
        (Ended(2, "", "Traceback (most recent call last):\n"), "said"),
        (Ended(124, "", "endless"), "ended with 124"),
    ],
)
def test_what_counts_as_wrong(trials, tmp_path, monkeypatch, done, wrong):
    """Codes that are not allowed, words that are not ours, hanging, half files."""
    monkeypatch.setattr(trials, "again", lambda *_: "")
    command, around = Command("c", ()), trials.place()
    assert trials.judge(command, around, done, (0, 2))[: len(wrong) or 1] == wrong
    (around.out / "a.json").write_text("{", encoding="utf-8")
    if not wrong:
        assert trials.judge(command, around, done, (0, 2)) == "half-written: a.json"


@pytest.mark.parametrize(
    ("where", "before"), [("frozen importlib._bootstrap", True), ("tactgen/__main__.py", False)]
)
def test_python_interrupted_as_it_starts_is_not_us(where, before):
    """A command of a tenth of a second is met there one time in some."""
    words = f'Traceback (most recent call last):\n  File "{where}"\nKeyboardInterrupt\n'
    assert before_us(Ended(1, "", words)) == before
    assert not before_us(Ended(130, "", words))


def test_the_book_shows_what_was_found(own_store, tmp_path):
    """The table of the last run with this code, or that there was none."""
    page = write_book([], tmp_path, lambda _: None).read_text(encoding="utf-8")
    assert "Not run with this code" in page
    row = answered("faults: killed", "60 runs", [], ["no room"])
    faults.keep_rows((row,), quick=True)
    page = write_book([], tmp_path, lambda _: None).read_text(encoding="utf-8")
    assert "60 runs" in page
    assert "holds or says why not" in page


def test_a_run_takes_every_family_and_is_kept(own_store, monkeypatch):
    """Light commands if quick, else all; each family is said once it is known."""
    begun, said = [], []

    def row(name):
        return lambda trials: answered(name, trials, [], [])

    monkeypatch.setattr(faults, "Trials", lambda *given: begun.append(given) or "trials")
    monkeypatch.setattr(faults, "_families", lambda quick: (row("one"), row(f"quick {quick}")))
    found = [faults.run(Asked(quick, 7, said.append)) for quick in (True, False)]
    assert [commands for commands, *_ in begun] == [LIGHT, (*LIGHT, *HEAVY)]
    assert not any(folder.exists() for _, folder, _ in begun)
    assert said[:5] == [
        "faults: undisturbed runs", "faults: more", "one", "faults: more", "quick True",
    ]  # fmt: skip
    assert {seed for *_, seed in begun} == {7}
    assert [(r.family, r.what) for r in found[1].rows] == [
        ("one", "trials"), ("quick False", "trials"),
    ]  # fmt: skip
    assert (found[0].part, found[0].maps, found[0].approaches) == ("faults", (), ())
    assert repr(faults.kept_rows()) == repr(found[1].rows)  # the full run counts first
    faults.keep_rows(found[1].rows[:1], quick=False)
    assert len(faults.kept_rows()) == 1


@pytest.mark.heavy
@pytest.mark.parametrize("quick", [True, False])
def test_no_fault_does_harm(quick, own_store):
    """All faults, on light commands and on all that write."""
    found = faults.run(Asked(quick))
    assert [(row.family, row.worst) for row in found.rows if row.verdict == "fails"] == []
