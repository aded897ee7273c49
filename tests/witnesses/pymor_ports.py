"""The clamped bimorph's matrices reduced as a pyMOR user would: tangential Hermite interpolation.

Second-order model (s² M + K) x = B u, y = C x + D u, all of it at once by SOBHIReductor: two-sided,
at imaginary points, one input and one output at a time.
"""

from __future__ import annotations

from typing import Any, TypedDict

import numpy as np


class Job(TypedDict):
    """Sparse matrices of M and K and dense B, C, D in a file; points and frequencies (Hz)."""

    file: str
    points: list[float]
    frequencies: list[float]


class Answer(TypedDict):
    """C (s² M + K)⁻¹ B + D for each frequency, real and imaginary parts apart."""

    real: list[Any]
    imaginary: list[Any]
    order: int


def run(job: Job) -> Answer:
    """Reduce, and respond; called alone in a process."""
    from pymor.core.logger import set_log_levels
    from pymor.models.iosys import SecondOrderModel
    from pymor.reductors.interpolation import SOBHIReductor
    from scipy import sparse

    set_log_levels({"pymor": "ERROR"})
    with np.load(job["file"]) as held:
        mass, stiffness = (
            sparse.csc_matrix(
                (held[f"{name}_data"], held[f"{name}_indices"], held[f"{name}_indptr"])
            )
            for name in ("mass", "stiffness")
        )
        inputs, outputs, through = held["inputs"], held["outputs"], held["through"]
    none = sparse.csc_matrix(mass.shape)
    whole = SecondOrderModel.from_matrices(mass, none, stiffness, inputs, outputs, D=through)
    upper = [2j * np.pi * f for f in job["points"] for _ in range(inputs.shape[1])]
    one = np.tile(np.eye(inputs.shape[1]), (len(job["points"]), 1))
    sigma = np.array([*upper, *np.conj(upper)])
    both = np.vstack([one, one])
    small = SOBHIReductor(whole).reduce(sigma, both, both)
    found = np.array([small.transfer_function.eval_tf(2j * np.pi * f) for f in job["frequencies"]])
    return Answer(real=found.real.tolist(), imaginary=found.imag.tolist(), order=small.order)
