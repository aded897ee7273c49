"""What a waveform says of itself is what its values do."""

import itertools
import math

import numpy as np
import pytest

from tactgen.tmm.generator.transient.waveform import Chirp, Sampled, Sine, Square, Step

#: Each with the time over which it changes smoothly.
WAVES = [
    (Step(-3.0), math.inf),
    (Step(-3.0, 0.2, 0.7), math.inf),
    (Sine(-2.0, 5.0, 0.3, 0.1), 0.2),
    (Square(1.0, 4.0, -2.0, 0.3), math.inf),
    (Square(-3.0, 4.0, 2.0, 0.3), math.inf),
    (Chirp(-2.0, 2.0, 8.0, 0.6), 0.125),
    (Chirp(2.0, 8.0, 2.0, 0.6), 0.125),
    (Sampled((0.0, 0.4, 0.4, 0.9), (1.0, -2.0, 0.5, 1.5)), math.inf),
]


@pytest.mark.parametrize(("wave", "shortest"), WAVES)
def test_peak_and_shortest_time(wave, shortest):
    """The peak is the largest size over time; 2e-4 is what 5,000 times leave of a crest."""
    ends = [0.0, *wave.breaks(1.0), 1.0]
    sizes = [
        abs(wave.value(time, 0.5 * (low + high)))
        for low, high in itertools.pairwise(ends)
        for time in np.linspace(low, high, 5000 // len(ends))
    ]
    assert max(sizes) == pytest.approx(wave.peak, rel=2e-4)
    assert wave.shortest == shortest


def test_samples_are_held_before_the_first_and_after_the_last():
    """Between them the straight line, a time at a jump by the side it is asked for."""
    wave = Sampled((0.1, 0.5, 0.5, 0.6), (2.0, -1.0, 3.0, 4.0))
    asked = [(0.0, 0.05), (0.2, 0.3), (0.5, 0.4), (0.5, 0.55), (0.7, 0.7)]
    found = [wave.value(time, inside) for time, inside in asked]
    assert found == pytest.approx([2.0, 1.25, -1.0, 3.0, 4.0], rel=1e-14)
    assert wave.breaks(2.0) == (0.1, 0.5, 0.6)


def test_steps_squares_and_chirps_are_where_they_say():
    square = Square(0.12, 100.0, duty=0.3, start=1e-3)
    assert square.breaks(0.02) == pytest.approx((1e-3, 4e-3, 11e-3, 14e-3))
    assert [square.value(4e-3, t) for t in (3.9e-3, 4.1e-3)] == [0.12, 0.0]
    assert [Step(2.0, 1.0, 3.0).value(1.0, t) for t in (0.9, 1.1)] == [0.0, 2.0]
    assert Step(3.0).breaks(1.0) == ()
    chirp = Chirp(1.0, 10.0, 30.0, 2.0)
    rate = (chirp.value(1.0 + 1e-7, 1.0) - chirp.value(1.0 - 1e-7, 1.0)) / 2e-7
    # half way the frequency is the mean of both, and 15 turns are done
    assert rate == pytest.approx(2.0 * math.pi * 20.0, rel=1e-6)
