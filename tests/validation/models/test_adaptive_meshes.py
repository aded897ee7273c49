"""Meshes refined for a goal: sizes from errors, slender elements, the loop itself."""

import numpy as np
import pytest

from tactgen.geometry.cad.tessellation import tessellate
from tactgen.geometry.meshing.mesh import Mesh, smallest_dihedral_angles, tet_volumes
from tactgen.geometry.meshing.structured_tets import box_tetrahedra
from tactgen.geometry.meshing.tetwild import mesher as ftetwild
from tactgen.geometry.meshing.tetwild.conform import conform
from tactgen.geometry.meshing.tetwild.mesher import sizing_at_points, sizing_for
from tactgen.geometry.store.values import fingerprint
from tactgen.validation.models.bimorph.adaptive_meshes import adapted_pair
from tactgen.validation.scene.load import load_scene


def uniform_box(n=6):
    planes = np.linspace(0.0, 1e-3, n + 1)
    return box_tetrahedra(planes, planes, planes, np.zeros((n, n, n), dtype=int), ("shim",))


def test_number_of_elements_is_limited_and_rounding_makes_no_other_mesh():
    """What would need more elements than allowed is not asked for.  Sizes are rounded, so that
    their name in the cache is the same from run to run."""
    mesh = uniform_box()
    errors = np.random.default_rng(1).uniform(1.0, 9.0, len(mesh.cells))

    def sizing(errors, share=0.5, most=1e9, shortest=0.0):
        return sizing_for(mesh, errors, share * errors.sum(), shortest=shortest, most=most)

    few = 2.0 * len(mesh.cells)
    assert sizing(errors, 0.05).lengths[0] < sizing(errors, 0.05, few).lengths[0]
    assert sizing(errors, shortest=1e-3).lengths.min() > 0.98e-3
    noise = 1.0 + 1e-10 * np.random.default_rng(2).uniform(-1.0, 1.0, errors.size)
    first, second, other = (
        fingerprint(sizing(of)) for of in (errors, errors * noise, errors[::-1])
    )
    assert first == second
    assert first != other


def test_sizing_field_covers_the_box_and_keeps_the_lengths():
    """Tetrahedra of positive volume fill the whole box; given lengths stay, outside they grow."""
    points = uniform_box().points * 1e3
    lengths = np.full(len(points), 0.1)
    field = sizing_at_points(points, points, lengths)
    volumes = tet_volumes(field.points[field.tets])
    assert volumes.min() > 0.0
    assert volumes.sum() == pytest.approx(np.prod(np.ptp(field.points, axis=0)), rel=1e-6)
    assert np.array_equal(field.lengths[: len(points)], lengths)
    assert field.lengths[len(points) :].min() > 0.1
    assert (field.points.min(axis=0) < -0.2).all()
    assert (field.points.max(axis=0) > 1.2).all()


@pytest.fixture
def box_in_a_box():
    """A cube of 2 mm, and a raw mesh around it whose grid planes are its faces."""
    import cadquery as cq  # here, since every worker collects every file

    solids = {"shim": cq.Workplane().box(2.0, 2.0, 2.0).val()}
    planes = np.linspace(-1.5, 1.5, 7)
    mesh = box_tetrahedra(planes, planes, planes, np.zeros((6, 6, 6), dtype=int), ("any",))
    return solids, tessellate(solids, deflection=0.02), mesh.points.copy(), mesh.cells


@pytest.mark.parametrize("flat", ["edge", "outside", "inside"])
def test_a_flat_tetrahedron_is_cured(box_in_a_box, flat):
    """The middle of an edge, next to a corner that has to stay, slides along the faces it lies
    on; a sliver on a face is taken out of it or given room: nothing is lost.

    The sliver's point is nearer to the face than the mesher's slack, so one of the four tetrahedra
    around it has no room between it and the face.
    """
    solids, surface, raw, tets = box_in_a_box
    if flat == "edge":
        raw[np.linalg.norm(raw - [1.0, 1.0, 0.5], axis=1) < 1e-9] = [1.0, 1.0, 0.999]
    else:
        side, middles = (1.0 if flat == "outside" else -1.0), raw[tets].mean(axis=1)
        on_face = (np.abs(raw[tets][:, :, 0] - 1.0) < 1e-9).sum(axis=1) == 3
        within = (np.abs(middles[:, 1:]) < 0.9).all(axis=1) & (side * (middles[:, 0] - 1.0) > 0.0)
        cell = int(np.flatnonzero(on_face & within)[0])
        corners = raw[tets[cell]]
        foot = corners[np.abs(corners[:, 0] - 1.0) < 1e-9].mean(axis=0)
        four = np.repeat(tets[cell][None], 4, axis=0)  # in the place of the one with the point
        four[np.arange(4), np.arange(4)] = len(raw)
        raw = np.vstack([raw, foot + side * np.array([1e-4, 0.0, 0.0])])
        tets = np.vstack([np.delete(tets, cell, axis=0), four])
    mesh = conform(raw, tets, solids, surface, 0.01, {}, curved=True)
    corners = mesh.points[mesh.cells]
    assert smallest_dihedral_angles(corners).min() > 3.0
    assert tet_volumes(corners).sum() == pytest.approx(8e-9, rel=1e-12)
    on_edge = (np.abs(mesh.points[:, :2] - 1e-3) < 1e-15).all(axis=1)
    assert flat != "edge" or np.count_nonzero(on_edge) == 5  # still on both faces


@pytest.fixture(scope="module")
def pair():
    return adapted_pair(load_scene("j1")[0], 2e-2)


def bars(pair):
    """Value and error bar of each goal, as the solid model takes them from the pair."""
    for name, goal in pair.fine.goals.items():
        apart = abs(goal.value - pair.coarse.goals[name].value)
        if name.startswith("bending"):
            yield name, goal.value, pair.mode_factors[0] * apart
        else:
            share = pair.static_share * abs(goal.value)
            yield name, goal.value, pair.static_factor * apart + share


def test_loop_meets_its_accuracy_and_the_bars_hold(pair):
    """On job J1 the bars end within the accuracy, and cover the known answer."""
    relative = [bar / abs(value) for _, value, bar in bars(pair)]
    assert max(relative) == pytest.approx(pair.largest_bar, rel=1e-12)
    assert pair.largest_bar <= 2e-2
    assert pair.coarse.system.size < pair.fine.system.size < 60_000
    # four public codes agree on these: to 1e-5, and frequencies to 3e-5
    known = {"tip_displacement": -6.7582e-7, "bending_1": 1065.96, "bending_2": 6642.85}
    for name, value, bar in bars(pair):
        if name in known:
            assert abs(value - known[name]) <= bar + 3e-5 * abs(value), name


def test_stopped_study_goes_on_from_the_cache(pair, monkeypatch):
    """The same study again needs no mesher and ends on the identical meshes."""
    monkeypatch.setattr(ftetwild, "_WORKER", "no mesher here")
    again = adapted_pair(load_scene("j1")[0], 2e-2)
    assert isinstance(again.fine.mesh, Mesh)
    assert np.array_equal(again.fine.mesh.points, pair.fine.mesh.points)
    assert np.array_equal(again.fine.mesh.cells, pair.fine.mesh.cells)


@pytest.mark.heavy
def test_bars_of_the_generator_cover_finer_meshes():
    """Bimorph in its rod: bars of two meshes cover the values of a pair four times as exact."""
    scene, _ = load_scene("bimorph_on_rod")
    loose, tight = (adapted_pair(scene, accuracy) for accuracy in (4e-2, 1e-2))
    better = {name: (value, bar) for name, value, bar in bars(tight)}
    for name, value, bar in bars(loose):
        closer, own = better[name]
        assert abs(value - closer) <= bar + own, name
