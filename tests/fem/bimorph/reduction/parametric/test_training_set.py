"""The largest bound is found without looking everywhere, and none is overlooked."""

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.training_set import TrainingSet

COUNT = 100


class Bounds:
    """Bounds that change, and how many of them were worked out."""

    def __init__(self):
        self.values = np.random.default_rng(0).uniform(1.0, 2.0, COUNT)
        self.looked_at = 0

    def __call__(self, points):
        self.looked_at += points.size
        return self.values[points]


def test_the_worst_point_is_found_where_bounds_were_large():
    bounds = Bounds()
    points = TrainingSet.over(COUNT, bounds)
    assert points.worst(0.1) == (bounds.values.max(), bounds.values.argmax())
    assert bounds.looked_at == COUNT
    bounds.values[bounds.values.argmax()] = 0.5  # the member that was asked
    bounds.values *= 0.9
    points.forget()
    assert points.worst(0.1) == (bounds.values.max(), bounds.values.argmax())
    assert bounds.looked_at < 1.5 * COUNT


def test_a_bound_that_grew_is_not_overlooked_at_the_end():
    bounds = Bounds()
    points = TrainingSet.over(COUNT, bounds)
    smallest = int(bounds.values.argmin())
    points.worst(0.1)
    bounds.values[:] = 0.05
    bounds.values[smallest] = 0.3
    points.forget()
    assert points.worst(0.1) == (0.3, smallest)


def test_one_point_is_worked_out_once_until_the_basis_grows():
    bounds = Bounds()
    points = TrainingSet.over(COUNT, bounds)
    assert points.at(7) == points.at(7) == bounds.values[7]
    assert bounds.looked_at == 1
    points.forget()
    points.at(7)
    assert bounds.looked_at == 2
