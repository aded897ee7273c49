"""Modes over the length: the quantities' numbers, the solved shapes, and what lies between."""

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.fields.gather import Request, gather
from tactgen.validation.fields.lengths import length_range
from tactgen.validation.fields.over_length import lagrange_weights
from tactgen.validation.scene.scene import load_scene

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
        assert apart <= mode.bar[k] + q.uncertainty[place]
        seen += 1
    assert seen >= len(q.value) - 2  # those that some length has not among its lowest


def test_a_row_over_the_length():
    """The transfer matrix: every length its own closed form; shapes between five to 0.2 %."""
    scene, _ = load_scene("j1", ["models=tmm", "modes=2"])
    found = length_range(scene, "tmm", ENDS, known=4)
    check(scene, "tmm", found)
    assert found.missed < 2e-3  # of a polynomial of degree 4 over a range of 1 to 1.7
    assert found.points[:, :, 2].max(axis=1) == pytest.approx(found.solved)
    # a length of the polynomials' own is the solution there
    (own,) = gather(at(scene, float(found.solved[1])), ["tmm"], Request((), "edges"))
    state = own.state("mode 2, short circuit")
    shape = np.tensordot(
        lagrange_weights(found.solved, float(found.solved[1])), found.modes[1].shapes, 1
    )
    sign = np.sign(np.vdot(shape, np.real(state.fields["displacement"])))
    assert sign * shape == pytest.approx(np.real(state.fields["displacement"]), abs=1e-12)


@pytest.mark.heavy
def test_the_solid_over_the_length():
    """The certified basis; shapes of bricks whose division changes with the length."""
    scene, _ = load_scene("j1", ["models=solid", "modes=3", "accuracy=0.01"])
    found = length_range(scene, "solid", ENDS, known=11)
    check(scene, "solid", found)
    assert found.missed < 1e-2  # what shapes on a coarse division may be off by


def test_what_is_refused():
    scene, _ = load_scene("j1", ["models=tmm"])
    with pytest.raises(InputError, match="--lengths runs from 25 mm to 15 mm; begin below"):
        length_range(scene, "tmm", ENDS[::-1])


def test_weights_reproduce_polynomials():
    nodes = np.array([1.0, 2.0, 4.0, 5.0])
    assert lagrange_weights(nodes, 3.0) @ nodes**3 == pytest.approx(27.0)
    assert lagrange_weights(nodes, 2.0) == pytest.approx([0.0, 1.0, 0.0, 0.0])
