"""Modes over the length: the quantities' numbers, the solved shapes, and what lies between."""

import numpy as np
import pytest
from scipy.interpolate import BarycentricInterpolator

from tactgen.geometry.meshing.structured_tets import box_tetrahedra
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show import lengths
from tactgen.validation.show.gather import gather
from tactgen.validation.show.lengths import _turned_like, carrier, length_range

ENDS = 15e-3, 25e-3


def at(scene, length):
    bimorph = scene.bimorph.model_copy(update={"length": length})
    return scene.model_copy(update={"bimorph": bimorph})


def check(scene, model, found):
    """Frequencies are those of a single answer to both bars; shapes that of a solution."""
    k = found.lengths.size // 2 + 1
    length = float(found.lengths[k])
    one = solve(at(scene, length), (model,), ("short_circuit_frequencies",))
    q = one.get("short_circuit_frequencies", model)
    seen = 0
    for mode in found.modes:
        if mode.circuit == "open" or not np.isfinite(mode.frequency[k]):
            continue
        place = [n for n, kind in enumerate(q.classes) if kind == mode.motion][mode.place]
        apart = abs(mode.frequency[k] - q.value[place])
        assert apart <= mode.error[k] + q.error[place]
        seen += 1
    assert seen >= len(q.value) - 2  # those that some length has not among its lowest


def test_what_is_missed_is_measured_between_the_nodes(monkeypatch):
    """The largest distance from a solution there, of any mode, over that mode's size."""
    monkeypatch.setattr(lengths, "_SOLVED", 3)
    scene, _ = load_scene("j1", ["models=tmm", "modes=1"])
    found = length_range(scene, "tmm", ENDS, known=2)
    middle = found.solved.size // 2
    between = float(found.solved[middle : middle + 2].mean())
    more = at(scene, between).model_copy(update={"modes": scene.modes + 2})
    (more,) = gather(more, ["tmm"], (), "edges")
    missed = []
    for mode in found.modes:
        alike = [s for s in more.states if s.circuit == mode.circuit and s.motion == mode.motion]
        shape = np.real(alike[mode.place].fields["displacement"])
        read = BarycentricInterpolator(found.solved, mode.shapes)(between)
        read *= np.sign(np.vdot(read, shape))
        missed.append(np.abs(read - shape).max() / np.abs(shape).max())
    assert max(missed) == pytest.approx(found.missed, rel=1e-9)


def test_stations_of_two_divisions_correspond_by_their_height():
    """Other cells, other lengths: what is cubic along a column comes over exactly."""
    x, y = np.array([0.0, 1.0, 3.0]), np.array([-1.0, 1.0])

    def mesh(length, stations):
        z = length * np.linspace(0.0, 1.0, stations) ** 2
        region = np.broadcast_to(np.array([0, 1])[:, None, None], (2, 1, stations - 1))
        return box_tetrahedra(x, y, z, region, ("one", "other"))

    base, longer = mesh(2.0, 6), mesh(3.0, 9)
    carry, stretched = carrier(base, longer), base.points * [1.0, 1.0, 1.5]
    assert carry(longer.points) == pytest.approx(stretched)

    def field(p, length):
        share = p[:, 2] / length
        return np.stack([share**3 + p[:, 0], share**2 * p[:, 1], 1.0 - share], axis=1)

    assert carry(field(longer.points, 3.0)) == pytest.approx(field(base.points, 2.0))
    # through three stations goes no more than a parabola
    few, parabola = mesh(3.0, 3), [1.0, 1.0, 0.5]
    carried = carrier(base, few)(few.points**2 * parabola)
    assert carried == pytest.approx(stretched**2 * parabola)
    same = mesh(3.0, 6)
    assert carrier(base, same)(same.points) == pytest.approx(stretched)
    assert carrier(base, same)(base.points) == pytest.approx(base.points)


@pytest.mark.heavy
def test_the_solid_over_the_length():
    """The surrogate; shapes of bricks whose division changes with the length."""
    scene, _ = load_scene("j1", ["models=solid", "modes=3", "accuracy=0.01"])
    found = length_range(scene, "solid", ENDS, known=11)
    check(scene, "solid", found)
    assert found.missed < 1e-2  # what shapes on a coarse division may be off by


def test_a_shape_is_turned_like_the_first_whatever_its_size():
    """Shapes are micrometres."""
    first = np.array([[1e-6, 0.0, 0.0], [2e-6, 0.0, -1e-6]])
    for size in (1.0, -1.0, 1e-3, -1e-3):
        np.testing.assert_array_equal(_turned_like(first, size * first), abs(size) * first)
