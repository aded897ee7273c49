"""The normal actuator's field revolved: volumes, flux, symmetry, and lines that carry flux."""

import numpy as np
import pytest

from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.gather import gather
from tactgen.validation.show.magnetic import Section, revolved, section_of
from tactgen.validation.show.viewer import payload


@pytest.fixture(scope="module")
def scene():
    return load_scene("reluctance", ["models=axisymmetric", "accuracy=0.01"])[0]


@pytest.fixture(scope="module")
def opened(scene):
    return gather(scene, ["axisymmetric"], (), "edges")[0]


@pytest.fixture(scope="module")
def field(scene):
    return solve(scene, ["axisymmetric"], ["magnetic_force"]).models["axisymmetric"].field()


def volumes(mesh):
    """Six tetrahedra of every brick."""
    tets = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
    a, b, c, d = mesh.points[mesh.cells[:, tets]].transpose(2, 0, 1, 3)
    return (np.cross(b - a, c - a) * (d - a)).sum(axis=(1, 2)) / 6.0


def test_parts_have_their_volumes(scene, opened):
    """Three quarters of a ring in steps of a sixteenth of π: sin(step)/step of the round one."""
    coil = scene.coil
    ring = np.pi * (coil.outer_radius**2 - coil.inner_radius**2) * coil.length
    step = np.pi / 16.0
    found = volumes(opened.mesh)
    assert (found > 0.0).all()
    of_coil = opened.mesh.region_of_cell == opened.mesh.regions.index("coil")
    assert found[of_coil].sum() == pytest.approx(0.75 * ring * np.sin(step) / step, rel=1e-9)


def test_a_whole_turn_is_closed():
    """Twelve steps around share the first half plane: as many points as steps."""
    places = np.array([[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]])
    square = Section(places, np.array([[0, 1, 2, 3]]), np.array([0]), ("coil",), places, places)
    mesh, turn = revolved(square, np.linspace(0.0, 2.0 * np.pi, 13))
    assert mesh.points.shape == (48, 3)
    assert volumes(mesh).sum() == pytest.approx(12 * np.sin(np.pi / 6) / 2 * 3.0)
    assert turn(places)[12:16, 1] == pytest.approx([1.0, 2.0, 2.0, 1.0])  # a quarter turn on


def test_flux_through_the_shaft_is_that_of_the_lines(scene, field):
    """∫ B_z dA over the shaft in the coil's middle, by the trapezoidal rule."""
    section = section_of(field)
    grid = field.discretisation.grid
    middle = scene.gap - 0.2e-3 - scene.coil.position - 0.5 * scene.coil.length
    at = grid.z[np.abs(grid.z - middle).argmin()]
    rod = np.unique(section.quads[section.part == section.names.index("rod")])
    on = rod[np.abs(section.places[rod, 1] - at) < 1e-12]
    on = on[np.argsort(section.places[on, 0])]
    r, b_z = section.places[on, 0], section.flux_density[on, 1]
    found = np.trapezoid(b_z * 2.0 * np.pi * r, r)
    edge = np.abs(grid.r - r[-1]).argmin()
    line = field.flux_function[edge, np.abs(grid.z - at).argmin()]
    # five pieces over a smooth profile
    assert found == pytest.approx(2.0 * np.pi * line, rel=2e-2)


def test_a_large_result_goes_into_the_page_by_its_surface(opened):
    shown = payload([opened])["results"][0]
    assert shown["cells"] is None
    assert shown["points"]["count"] < 3 * len(opened.mesh.points)
    assert shown["states"][0]["text"].startswith("pull 1")
    assert shown["lines"] is not None
