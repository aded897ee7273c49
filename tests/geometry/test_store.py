"""The store: what comes back is what was put in, or it is computed anew; nothing in between."""

import hashlib
import importlib.metadata
import os
import random
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.geometry.store import store
from tactgen.geometry.store import values as sources
from tactgen.geometry.store.store import Damaged, read_entry, sealed, write_entry
from tactgen.geometry.store.values import fingerprint, from_bytes, storable, to_bytes

#: Some module to be made of.
CODE = ("tactgen.geometry.arrays",)
ROOT = Path(store.__file__).parents[2]


@storable
@dataclass(frozen=True)
class Sample:
    name: str
    values: np.ndarray
    inner: tuple[object, ...] = ()


@dataclass(frozen=True)
class Undeclared:
    value: int


VALUE = Sample("a", np.arange(6.0).reshape(2, 3), (Sample("b", np.zeros((0, 3))), 1, 2.0, None))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A store of one test's own, which has said nothing yet."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "store"))
    monkeypatch.setattr(store, "_said", set())
    return tmp_path / "store"


def same(a, b):
    if isinstance(a, np.ndarray):
        return (a.dtype, a.shape) == (b.dtype, b.shape) and a.tobytes() == b.tobytes()
    if isinstance(a, Sample):
        return type(b) is Sample and same(list(vars(a).values()), list(vars(b).values()))
    if isinstance(a, tuple | list):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return isinstance(b, dict) and same(list(a.items()), list(b.items()))
    return type(a) is type(b) and repr(a) == repr(b)


@pytest.mark.parametrize(
    "value",
    [
        None, True, 0, -(10**30), 0.1, -0.0, float("nan"), float("inf"), "µ\n", 1 - 2j, (), [],
        (1, (2,), [3]), {"a": 1, (1, 2): {}}, np.float64(0.1), np.int32(3), np.array(1.5),
        np.array([1 + 2j]), np.array([True]), np.array(["rod", "µ"]), np.zeros((2, 0, 3)),
        np.arange(12).reshape(3, 4).T, VALUE,
    ],
    ids=repr,
)  # fmt: skip
def test_values_come_back_bit_for_bit(value):
    """Every kind of value, types included."""
    assert same(value, from_bytes(to_bytes(value)))


@pytest.mark.parametrize(
    "value",
    [Undeclared(1), object(), {1, 2}, np.longdouble(1), np.zeros(2, np.clongdouble),
     np.array([object()]), print],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
def test_what_cannot_be_stored_is_refused(value):
    """Long double has other bytes elsewhere; objects would need code to come back."""
    with pytest.raises(TypeError):
        to_bytes(value)


def test_only_declared_classes_are_read():
    """A class of which the reader knows nothing, or with other fields, is no value."""
    known = to_bytes(Sample("a", np.zeros(1)))
    for unknown in (known.replace(b"Sample", b"Popen!"), known.replace(b'"inner"', b'"outer"')):
        assert len(unknown) == len(known)
        with pytest.raises(ValueError, match=r"Popen!|other fields"):
            from_bytes(unknown)


def test_fingerprints_tell_values_apart():
    """Type, order, shape and content count; equal content is equal."""
    values = [
        1, 1.0, "1", True, None, (1,), [1], ((1,),), (1, 2), {"a": 1, "b": 2}, {"b": 2, "a": 1},
        np.zeros(2), np.zeros((2, 1)), np.zeros(2, int), Sample("a", np.zeros(2)), Undeclared(1),
    ]  # fmt: skip
    found = [fingerprint(value) for value in values]
    assert len(set(found)) == len(values)
    assert fingerprint(("a", "bc")) != fingerprint(("ab", "c"))
    assert fingerprint(np.arange(6).reshape(2, 3).T) == fingerprint(
        np.array([[0, 3], [1, 4], [2, 5]])
    )
    with pytest.raises(TypeError, match="cannot be stored"):
        fingerprint(object())


def counted(calls, value=VALUE):
    def work():
        calls.append(1)
        return value

    return work


def test_a_value_is_computed_once(folder):
    """Other inputs or other code are another value."""
    calls = []
    for _ in range(2):
        assert same(store.cached_result("sample", (1,), CODE, counted(calls)), VALUE)
    assert len(calls) == 1
    store.cached_result("sample", (2,), CODE, counted(calls))
    store.cached_result("sample", (1,), ("tactgen.geometry.units",), counted(calls))
    store.cached_result("sample", (1,), CODE, counted(calls), serves=lambda _: False)
    assert len(calls) == 4
    assert store.holdings()["sample"].entries == 3
    assert {path.suffix for path in folder.iterdir()} == {".kept"}  # no claim, no draft


def swapped(content, at):
    return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]


def as_folder(path):
    path.unlink()
    path.mkdir()


def as_pipe(path):
    path.unlink()
    os.mkfifo(path)


def rewritten(change):
    return lambda path: path.write_bytes(change(path.read_bytes()))


def resealed(value):
    """A whole file, checksum and all, whose value is another."""
    return lambda path: path.write_bytes(sealed(Path("sample-of another name"), value))


def with_header(text):
    """A whole file of a broken description."""

    def damage(path):
        content = len(text).to_bytes(8, "little") + text
        digest = hashlib.sha256(content).digest()
        path.write_bytes(store.MAGIC + digest + content)

    return damage


DAMAGES = {
    "empty": rewritten(lambda _: b""),
    "a byte more": rewritten(lambda c: c + b"\0"),
    "another entry's file": resealed(VALUE),
    "no name": with_header(b"[[1, 2, 3], []]"),
    "an array too few": with_header(b'[["tuple", "n", ["array", 0]], []]'),
    "an array too long": with_header(b'[["tuple", "n", ["array", 0]], [["<f8", [9000000]]]]'),
    "an array of objects": with_header(b'[["tuple", "n", ["array", 0]], [["|O", [1]]]]'),
    "deep nesting": with_header(b"[" * 100_000),
    "a folder": as_folder,
    "a pipe": as_pipe,
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_damaged_file_is_never_trusted(folder, damage, capsys):
    """It is computed again, said once, and repaired where a file can take the name."""
    calls = []
    store.cached_result("sample", (1,), CODE, counted(calls))
    (path,) = folder.glob("sample-*")
    damage(path)
    for _ in range(2):
        assert same(store.cached_result("sample", (1,), CODE, counted(calls)), VALUE)
    said = capsys.readouterr().err
    assert said.count("is not used (") == 1
    assert len(calls) == (2 if path.is_file() else 3)
    assert path.is_dir() or same(read_entry(path), VALUE)


def test_every_single_bit_counts(folder):
    """No flipped bit of a file is read as a value."""
    path = folder / "sample-1.kept"
    write_entry(path, sealed(path, (1, "a", np.ones(1))))
    content = path.read_bytes()
    for at in range(len(content)):
        path.write_bytes(swapped(content, at))
        with pytest.raises(Damaged):
            read_entry(path)


def raising(error):
    def fail(*_):
        raise error

    return fail


OBSTACLES = {
    "file exists": lambda folder, _: folder.write_text(""),
    "no space left on device": lambda _, patch: patch.setattr(
        Path, "write_bytes", raising(OSError(28, "No space left on device"))
    ),
    "odd": lambda _, patch: patch.setattr(store, "_make_room", raising(OSError("odd"))),
}


@pytest.mark.parametrize("reason", OBSTACLES)
def test_what_cannot_be_kept_is_said_once(folder, reason, monkeypatch, capsys):
    """The run goes on."""
    OBSTACLES[reason](folder, monkeypatch)
    calls = []
    for inputs in ((1,), (2,), (1,)):
        assert same(store.cached_result("sample", inputs, CODE, counted(calls)), VALUE)
    assert len(calls) == 3
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"results are not kept for the next run ({reason}); set" in said.lower()


def test_without_a_home_nothing_is_kept(tmp_path, monkeypatch, capsys):
    """A user whom the system does not know: said once, and nothing is put where one stands."""
    monkeypatch.delenv("TACTGEN_CACHE", raising=False)
    monkeypatch.setattr(store, "_said", set())
    monkeypatch.setattr(Path, "home", raising(RuntimeError("Could not determine home directory.")))
    monkeypatch.chdir(tmp_path)
    calls = []
    for _ in range(2):
        assert same(store.cached_result("sample", (1,), CODE, counted(calls)), VALUE)
    assert len(calls) == 2
    assert capsys.readouterr().err.count("not kept for the next run") == 1
    assert not list(tmp_path.iterdir())
    assert store.holdings() == {}


def test_least_recently_used_goes_first(folder, monkeypatch):
    """Over the limit, what was not read for longest is removed."""
    value = np.zeros(1000)
    monkeypatch.setenv("TACTGEN_CACHE_LIMIT", "110 kB")  # thirteen of 8 kB
    store.cached_result("sample", (-1,), CODE, lambda: value)
    fits = 110_000 // next(folder.glob("sample-*")).stat().st_size
    for number in range(fits - 1):
        store.cached_result("sample", (number,), CODE, lambda: value)
        time.sleep(0.002)
    calls = []
    store.cached_result("sample", (-1,), CODE, counted(calls))  # read again: now the youngest
    store.cached_result("sample", ("one more",), CODE, lambda: value)
    store.cached_result("sample", (-1,), CODE, counted(calls))
    assert calls == []
    store.cached_result("sample", (0,), CODE, counted(calls))
    assert calls == [1]
    assert sum(held.size for held in store.holdings().values()) <= 110_000


def test_what_is_larger_than_the_store_is_not_kept(folder, monkeypatch, capsys):
    """And said."""
    monkeypatch.setenv("TACTGEN_CACHE_LIMIT", "1 kB")
    assert store.cached_result("sample", (1,), CODE, lambda: np.zeros(1000)).size == 1000
    assert "sample" not in store.holdings()
    assert "TACTGEN_CACHE_LIMIT" in capsys.readouterr().err


def test_limit_has_a_unit(monkeypatch):
    """Decimal units, as disks are sold; what is no size is refused with the remedy."""
    for text, size in (("", 5e9), ("1.5 GB", 1.5e9), ("20kB", 2e4), ("0 B", 0)):
        monkeypatch.setenv("TACTGEN_CACHE_LIMIT", text)
        assert store.size_limit() == size
    for text in ("5", "-1 GB", "nan GB", "5 GB or so"):
        monkeypatch.setenv("TACTGEN_CACHE_LIMIT", text)
        with pytest.raises(InputError, match=r"TACTGEN_CACHE_LIMIT = .* such as 5 GB"):
            store.size_limit()


def test_clear_leaves_nothing_of_ours(folder):
    """Entries, drafts and claims go; files of others stay."""
    store.cached_result("sample", (1,), CODE, lambda: VALUE)
    for name in (".draft.kept", "sample-1.claim", "notes.txt"):
        (folder / name).write_text("")
    assert store.clear().entries == 1
    assert [path.name for path in folder.iterdir()] == ["notes.txt"]


def test_threads_compute_once(folder):
    """And what is waited for is said."""
    calls, said, found = [], [], []
    started, all_wait = threading.Event(), threading.Event()

    def work():
        calls.append(1)
        started.set()
        all_wait.wait(60.0)
        return VALUE

    def announce(sentence):
        said.append(sentence)
        if len(said) == 7:
            all_wait.set()

    def ask():
        found.append(store.cached_result("sample", (1,), CODE, work, announce=announce))

    # where one keeps what the next waits for, none of them may keep the tests
    threads = [threading.Thread(target=ask, daemon=True) for _ in range(8)]
    threads[0].start()
    assert started.wait(60.0)
    for thread in threads[1:]:
        thread.start()
    for thread in threads:
        thread.join(60.0)
        assert not thread.is_alive()
    assert len(calls) == 1
    assert all(same(value, VALUE) for value in found)
    assert said == ["sample: waiting for another run"] * 7


def test_failed_work_leaves_no_claim(folder):
    """The next one may try."""
    with pytest.raises(ZeroDivisionError):
        store.cached_result("sample", (1,), CODE, raising(ZeroDivisionError))
    assert same(store.cached_result("sample", (1,), CODE, lambda: VALUE), VALUE)


#: Computes values that need one another, slowly, and notes each computation.
WORKER = """
import sys, time
import numpy as np
from tactgen.geometry.store.store import cached_result
log, rounds, pause = open(sys.argv[1], "a"), int(sys.argv[2]), float(sys.argv[3])

def value(number):
    def work():
        below = value(number - 1) if number % 3 else np.zeros(20_000)
        time.sleep(pause)
        print(number, file=log, flush=True)
        return below + number
    return cached_result("chain", (number,), ("tactgen.geometry.arrays",), work)

print("ready", flush=True)
for number in range(rounds):
    assert value(number)[0] == sum(range(number - number % 3, number + 1)), number
"""


def start(log, rounds, pause):
    arguments = [sys.executable, "-c", WORKER, str(log), str(rounds), str(pause)]
    return subprocess.Popen(arguments, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def test_two_processes_compute_once(folder, tmp_path):
    """Both get all values, nested ones too, and each is computed by one of them."""
    both = [start(tmp_path / "log", 12, 0.01) for _ in range(2)]
    for process in both:
        _, said = process.communicate(timeout=60)
        assert (process.returncode, said) == (0, b"")
    done = (tmp_path / "log").read_text().split()
    assert sorted(map(int, done)) == list(range(12))


@pytest.mark.parametrize(
    "kills", [2, pytest.param(50, marks=pytest.mark.heavy)], ids=lambda kills: f"{kills} kills"
)
def test_killed_at_any_moment(folder, tmp_path, kills):
    """After kill -9 at random moments no file is damaged, and the next run goes on from there."""
    chance, log = random.Random(kills), tmp_path / "log"
    log.touch()
    for _ in range(kills):
        enough = log.read_bytes().count(b"\n") + chance.randint(2, 9)
        process = start(log, 10_000, 0.0)
        while log.read_bytes().count(b"\n") < enough and process.poll() is None:
            time.sleep(0.001)  # a loaded machine needs longer for as many values
        time.sleep(chance.uniform(0.0, 0.01))
        process.send_signal(signal.SIGKILL)
        _, said = process.communicate(timeout=60)
        assert (process.returncode, said) == (-signal.SIGKILL, b"")
    kept = list(folder.glob("chain-*.kept"))
    assert len(kept) > kills
    for path in kept:
        read_entry(path)
    finished = {int(line) for line in log.read_text().split()}
    last = start(log, 50, 0.0)
    _, said = last.communicate(timeout=60)
    assert (last.returncode, said) == (0, b"")
    assert len(finished) >= len(kept)


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A small project in place of this one."""
    for package in ("geometry", "fem"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").write_text("")
    monkeypatch.setattr(sources, "_ROOT", tmp_path)
    forget()
    yield tmp_path
    forget()


def forget():
    for cached in (sources._source, sources._imported, sources._read, sources.source_digest):
        cached.cache_clear()


def digest(*names):
    forget()
    return sources.source_digest(names)


def test_code_counts_with_all_that_it_imports(project):
    """Through functions and packages; not what is not imported."""
    place = project / "fem"
    (place / "solid.py").write_text(
        "from __future__ import annotations\nfrom typing import TYPE_CHECKING\n"
        "if TYPE_CHECKING:\n    from tactgen.fem import types_only\n"
        "import numpy\ndef f():\n    from tactgen.fem.near import thing\n"
    )
    (place / "near.py").write_text("import tactgen.fem.far as far\n")
    for name in ("far", "types_only", "stranger"):
        (place / f"{name}.py").write_text("x = 1\n")
    before = digest("tactgen.fem.solid")
    assert digest("tactgen.fem.solid") == before
    for name, counts in (
        ("solid", True), ("near", True), ("far", True), ("__init__", True),
        ("types_only", True), ("stranger", False),
    ):  # fmt: skip
        path = place / f"{name}.py"
        text = path.read_text()
        path.write_text(text + "# changed\n")
        assert (digest("tactgen.fem.solid") != before) is counts, name
        assert digest("tactgen.fem") != digest("tactgen.fem.solid")
        path.write_text(text)
        assert digest("tactgen.fem.solid") == before


def test_a_module_that_moved_is_not_hashed_as_nothing(project):
    """A name without a source is a defect, and so is a package without one."""
    for name in ("tactgen.fem.gone", "tactgen.fem.gone.too", "numpy", "nowhere"):
        with pytest.raises(LookupError, match="no source"):
            digest(name)


def test_versions_are_those_that_the_metadata_say():
    """Read off the folders' names; a library that is missing is named as that."""
    for said, library in zip(store.library_versions(), store._LIBRARIES, strict=True):
        try:
            assert said == f"{library} {importlib.metadata.version(library)}"
        except importlib.metadata.PackageNotFoundError:
            assert said == f"no {library}"
