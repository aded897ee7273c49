"""Shared by all tests: one thread each, a fixed hypothesis profile, a store of their own."""

import gc
import json
import os
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis.internal.conjecture import providers

# the workers of pytest-xdist are the parallelism: with two threads in each of two they wait for
# one another, and small systems take up to eight times the processor time
os.environ.setdefault("OMP_NUM_THREADS", "1")

# what is imported stays: looking for cycles in it takes a fifth of the time of collecting tests
gc.disable()

#: Folders and files that take longest, which begin first: no worker is left alone with one.
LONGEST = (
    "report", "test_identification", "test_length_design", "evidence/test_rows",
    "test_stages", "test_declared_inputs", "test_three_d", "test_axisymmetric", "test_stress",
    "test_bench", "test_bridge", "test_tets", "test_cad", "test_identify",
    "test_design", "test_fields", "test_solid",
    "test_error_bars", "reluctance", "bimorph",
)  # fmt: skip

settings.register_profile(
    "fixed", derandomize=True, database=None, deadline=None, max_examples=30, print_blob=False
)
settings.load_profile("fixed")
# else constants of whichever modules a process has loaded are tried as well, others in each run
providers._get_local_constants = lambda: providers._local_constants


def pytest_collection_modifyitems(items):
    """Put what takes longest first; the order within a file stays."""

    def place(item):
        path = item.path.relative_to(Path(__file__).parent).as_posix()
        return next((n for n, part in enumerate(LONGEST) if part in path), len(LONGEST))

    items.sort(key=place)


def pytest_collection_finish():
    """Look for cycles from here on, but seldom, and not among what was imported."""
    gc.freeze()
    gc.set_threshold(50_000)
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def shared_store(tmp_path_factory):
    """Give the run a store of its own: what one test solved, the others read; nothing older."""
    base = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:  # the workers' folders are side by side in one
        base = base.parent
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTGEN_CACHE", str(base / "store"))
        for name in ("TACTGEN_CACHE_LIMIT", "TACTGEN_THREADS"):  # what somebody set for own work
            patch.delenv(name, raising=False)
        yield


#: Variables by which the terminal, or a server that runs the tests, asks for colours.
COLOURS = ("FORCE_COLOR", "NO_COLOR", "TERM", "TTY_COMPATIBLE", "TTY_INTERACTIVE")


@pytest.fixture(scope="session", autouse=True)
def plain_terminal():
    """Break lines where every terminal does, and colour nothing, wherever the tests are run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "80")
        for name in COLOURS:
            patch.delenv(name, raising=False)
        yield


@pytest.fixture
def own_store(tmp_path, monkeypatch):
    """Give one test a store of its own, since it changes code or counts what is computed."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "own store"))
    return tmp_path / "own store"


@pytest.fixture(scope="session")
def few_bricks():
    """Return two divisions of the solid, far coarser than any answer needs."""
    from tactgen.geometry.bimorph.bricks import BrickMeshing

    plain = {"tip": 1.0, "longest": 20.0, "pieces": (2.0, 4.0), "richness": 3.0}
    return (
        BrickMeshing((2, 2, 2), smallest=1.0, **plain),
        BrickMeshing((2, 2, 3), smallest=0.5, **plain),
    )


@pytest.fixture
def coarse_bricks(monkeypatch, few_bricks):
    """Divide the solid into few bricks: for tests of what runs and when.

    Keys in the store do not know: who asks for this has a store of its own.
    """
    from tactgen.validation.models.bimorph import solid

    monkeypatch.setattr(solid, "LEVELS", few_bricks)


@pytest.fixture
def coarse_solid(request):
    """Divide the solid coarsely, with a store for it, where it is the model that is asked.

    What holds whatever the mesh is as true there.
    """
    if request.node.callspec.params.get("model") == "solid":
        request.getfixturevalue("own_store")
        request.getfixturevalue("coarse_bricks")


@pytest.fixture(scope="session")
def state_space():
    """Return the stored 60-digit state-space solution of the paper's bimorph."""
    path = Path(__file__).parent / "data" / "bimorph_state_space.json"
    return json.loads(path.read_text(encoding="utf-8"))
