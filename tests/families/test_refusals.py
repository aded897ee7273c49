"""What a program made wrong is refused where it is seen: meshes, stored values, steps, pages."""

import itertools
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import sparse

from tactgen.fem.solvers.linear_solver import SolverError
from tactgen.fem.solvers.newton import Factors, minimise
from tactgen.geometry.bimorph.tets import _refuse_too_thin
from tactgen.geometry.errors import InputError, MeshError
from tactgen.geometry.meshing.mesh import check_areas, check_volumes
from tactgen.geometry.store.values import from_bytes, storable, to_bytes
from tactgen.tmm.generator.transient import step as newton
from tactgen.validation.studies import measured_data

#: A straight tetrahedron of ten nodes, its volume 1/6 and its slanted face.
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
POINTS = np.concatenate([CORNERS, [CORNERS[list(edge)].mean(axis=0) for edge in EDGES]])
CELL = np.arange(10)[None]


@pytest.mark.parametrize(
    ("moved", "volume", "message"),
    [
        (None, 1.0 / 6.0, ""),
        (None, 1.001 / 6.0, r"volume of shim is 0\.166667 mm\^3 in the mesh but 0\.166833"),
        (None, 0.999 / 6.0, r"volume of shim .* \(\+0\.1 %\)"),
        ((4, [0.0, 0.6, 0.6]), 1.0 / 6.0, "folds over"),
    ],
)
def test_cells_that_fold_or_do_not_add_up(moved, volume, message):
    """A node between two others that is far off, and CAD volumes that are a thousandth off."""
    points = POINTS.copy()
    if moved:
        points[moved[0]] = moved[1]
    if not message:
        check_volumes(points, CELL, np.array([0]), {"shim": volume}, {"shim"})
        return
    with pytest.raises(MeshError, match=message):
        check_volumes(points, CELL, np.array([0]), {"shim": volume}, {"shim"})


def test_a_face_that_its_triangles_do_not_fill():
    """CAD says 1 % more than the mesh has."""
    triangle, place = np.array([[0, 1, 2, 4, 5, 6]]), np.array([0])
    face = SimpleNamespace(sides=frozenset({"shim", "air"}), area=0.5)
    check_areas(POINTS, triangle, place, [face])
    face.area = 0.505
    with pytest.raises(MeshError, match="area between air and shim"):
        check_areas(POINTS, triangle, place, [face])


def test_features_too_thin_to_mesh():
    """As a share of the whole device, not in metres."""
    device = SimpleNamespace(points=np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0]]))
    _refuse_too_thin(device, 1.0)
    with pytest.raises(MeshError, match=r"thinnest feature, 1e-06 um, .* device of 5 mm"):
        _refuse_too_thin(device, 1e-9)


def test_values_that_cannot_be_stored_or_hold_more_than_was():
    """A class is known by its name, so a second one of it would be read as the first."""

    @dataclass(frozen=True)
    class OnlyHere:
        length: float

    storable(OnlyHere)
    for kind in (OnlyHere, int):
        with pytest.raises(TypeError, match="no dataclass, or a second one"):
            storable(kind)
    content = to_bytes(np.arange(3.0))
    assert from_bytes(content).tolist() == [0.0, 1.0, 2.0]
    with pytest.raises(ValueError, match="bytes left over"):
        from_bytes(content + b"1")


def test_an_energy_that_falls_no_way():
    """Where its Hessian's factors point uphill, or nowhere; a diagonal tells before them."""
    energy = SimpleNamespace(
        gradient=lambda x: x, hessian=lambda x: sparse.eye(2), scale=lambda x: float(x @ x)
    )
    for share, held in itertools.product((-1.0, np.nan), (False, True)):
        uphill = SimpleNamespace(
            held=held, update=lambda matrix: None, solve=lambda g, by=share: by * g
        )
        with pytest.raises(SolverError, match="convex"):
            minimise(energy, np.ones(2), uphill)
    with pytest.raises(SolverError, match="convex"):
        Factors().update(sparse.diags_array([1.0, 0.0]))


@pytest.mark.parametrize("rows", [[[0.0, 1.0], [1.0, 2.0]], [[1.0, 2.0], [2.0, 1.0]]])
def test_a_step_over_which_a_pull_beats_inertia(rows):
    """Elimination without pivots is told by the sign of the diagonal, first or later."""
    assert newton._solved([[2.0, 1.0], [1.0, 2.0]], [3.0, 3.0]) == [1.0, 1.0]
    with pytest.raises(newton.StepTooLongError, match="pulls beat"):
        newton._solved(rows, [1.0, 1.0])


def test_a_measured_curve_of_too_many_points(tmp_path, monkeypatch):
    """As many as may be are read."""
    path = tmp_path / "curve.csv"
    path.write_text("frequency [Hz],velocity [m/s]\n" + "".join(f"{n},1\n" for n in range(1, 7)))
    monkeypatch.setattr(measured_data, "_MOST", 6)
    assert measured_data.read_measured(path).frequencies.size == 6
    monkeypatch.setattr(measured_data, "_MOST", 5)
    with pytest.raises(InputError, match="holds 6 points; thin it to at most 5"):
        measured_data.read_measured(path)
