"""The mesher's process: it stays for the next mesh, and its troubles end in one sentence."""

import numpy as np
import pytest

from tactgen.geometry.errors import MeshError
from tactgen.geometry.meshing.tetwild import mesher as run
from tactgen.geometry.meshing.tetwild.mesher import Mesher

#: Stands for fTetWild: gives back what it got and the number of its process, or gets into trouble.
_PRETENDER = """
import os, sys, time
import numpy as np
while source := sys.stdin.readline().rstrip("\\n"):
    target, _ = (sys.stdin.readline().rstrip("\\n") for _ in range(2))
    with np.load(source) as given:
        points, trouble = given["points"], str(given["trouble"])
    if trouble.startswith("waits for "):
        while not os.path.exists(trouble.removeprefix("waits for ")):
            time.sleep(0.01)
    if trouble == "dies":
        sys.exit("no room left in the envelope")
    np.savez(target, points=points, tets=np.full((1, 4), os.getpid()))
    print(1.5, flush=True)
"""

#: Stands for the library: works for ever on one triangle, and is done at once with two.
_ENDLESS = """
def tetrahedralize(points, triangles, **_):
    while len(triangles) == 1:
        pass
    return points, triangles
"""


@pytest.fixture
def pretender(tmp_path, monkeypatch):
    worker = tmp_path / "worker.py"
    worker.write_text(_PRETENDER)
    monkeypatch.setattr(run, "_WORKER", worker)


def job(trouble="", offset=0.0):
    return {"points": np.full((2, 3), offset), "trouble": np.array(trouble)}


def test_one_process_makes_one_mesh_after_another(pretender):
    """Each gets its own answer from the same process, which is gone afterwards."""
    with Mesher() as mesher:
        answers = [mesher.mesh(job(offset=float(k)), 30.0) for k in range(3)]
        process, folder = mesher._process, mesher._folder.name
    assert [points[0, 0] for points, _ in answers] == [0.0, 1.0, 2.0]
    assert {int(tets[0, 0]) for _, tets in answers} == {process.pid}
    assert process.returncode is not None
    assert mesher.spent == 4.5
    with pytest.raises(FileNotFoundError):
        open(folder)  # noqa: PTH123, SIM115


def test_a_process_that_dies_says_so_and_the_next_mesh_has_a_new_one(pretender):
    """Its last words are given on."""
    with Mesher() as mesher:
        with pytest.raises(MeshError, match=r"fTetWild failed \(no room left in the envelope\)"):
            mesher.mesh(job("dies"), 30.0)
        points, _ = mesher.mesh(job(offset=5.0), 30.0)
    assert points[0, 0] == 5.0


def test_work_without_end_is_ended_by_the_processor_time_it_took(tmp_path, monkeypatch):
    """However busy the machine: a process that waits loses none.  The next mesh is made."""
    library = tmp_path / "pytetwild"
    library.mkdir()
    (library / "__init__.py").touch()
    (library / "pytetwild.py").write_text(_ENDLESS)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    arrays = {"points": np.eye(3), "settings": np.array("{}")}
    with Mesher() as mesher:
        words = r"not done after 0\.2 s of processor time; raise the time limit"
        with pytest.raises(MeshError, match=words):
            mesher.mesh({**arrays, "triangles": np.zeros((1, 3), int)}, 0.2)
        assert mesher.spent == 0.2
        points, _ = mesher.mesh({**arrays, "triangles": np.zeros((2, 3), int)}, 30.0)
        assert 0.2 <= mesher.spent < 10.0
    np.testing.assert_array_equal(points, np.eye(3))


def test_a_block_that_meshes_nothing_starts_nothing(pretender):
    """Meshes that are all in the store cost no process."""
    with Mesher() as mesher:
        pass
    assert mesher._process is None


def test_the_caller_does_something_while_a_mesh_is_made(pretender, tmp_path):
    """A mesh that is not done before the caller's work is; with the next mesh nothing is done."""
    called = []

    def work():
        called.append("once")
        (tmp_path / "done").touch()

    with Mesher() as mesher:
        mesher.meanwhile = work
        for k in range(2):
            points, _ = mesher.mesh(job(f"waits for {tmp_path / 'done'}", float(k)), 30.0)
            assert points[0, 0] == k
    assert called == ["once"]
