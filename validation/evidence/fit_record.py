"""What calibrations have in common: normal equations, errors that cover, what files hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.chebyshev import Products
from tactgen.validation.evidence.judgement import PROMISED

#: Multiples of a stated error at which the share of errors within it is told.
CURVE = (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0)
#: Devices with the largest errors that are named.
_WORST = 10


def evidence(
    names: Sequence[str], left: Floats, stated: Floats, devices: Sequence[Sequence[str]]
) -> dict[str, Any]:
    """Errors (n, k) left on n devices that a fit had not seen, beside those stated.

    By name the median, 95 % and largest error, the share covered and the median of stated over
    left; and the devices whose errors are largest beside those stated.
    """
    rows, ratio = {}, left / stated
    for name, error, bar in zip(names, left.T, stated.T, strict=True):
        known = np.isfinite(error)
        error, bar = error[known], bar[known]
        rows[name] = {
            "devices": int(known.sum()), "median": rounded(np.median(error)),
            "covers_95_percent": rounded(np.quantile(error, PROMISED)),
            "largest": rounded(error.max()), "covered": rounded((error <= bar).mean()),
            "stated_over_error": rounded(np.median(bar / np.maximum(error, 1e-12))),
            "curve": [rounded((error <= times * bar).mean()) for times in CURVE],
        }  # fmt: skip
    worst = np.nanmax(ratio, axis=1)
    order = np.argsort(-worst)[:_WORST]
    return {
        "errors": rows,
        "worst": [
            {
                "device": " ".join(devices[i]), "error_over_stated": rounded(worst[i]),
                "of": names[int(np.nanargmax(ratio[i]))],
                "error": rounded(left[i, int(np.nanargmax(ratio[i]))]),
            }
            for i in order
        ],
    }  # fmt: skip


def solve_normal(rows: Floats, right: Floats, ridge: float, start: Floats | float = 0.0) -> Floats:
    """Step of least squares from `start`, with a ridge relative to the mean diagonal."""
    normal = rows.T @ rows
    own = ridge * np.trace(normal) / len(normal)
    normal[np.diag_indices_from(normal)] += own
    return np.asarray(np.linalg.solve(normal, rows.T @ right - own * start))


def covering(rows: Floats, sizes: Floats, ridge: float, quantile: float) -> Floats:
    """Coefficients (t, k) of logarithms that cover all but a few of sizes (n, k), nan left out.

    By rows (n, t) whose first column is 1, which the ridge leaves free.
    """
    found = np.zeros((rows.shape[1], sizes.shape[1]))
    for k, size in enumerate(sizes.T):
        known = np.isfinite(size)
        a, error = rows[known], size[known]
        normal = a.T @ a + ridge * len(a) * np.diag([0.0] + [1.0] * (a.shape[1] - 1))
        found[:, k] = np.linalg.solve(normal, a.T @ np.log(error))
        found[0, k] += np.log(np.quantile(error / np.exp(a @ found[:, k]), quantile))
    return found


def rounded(values: Any) -> Any:
    """Numbers to five digits, as files hold them: of arrays as lists."""
    return np.vectorize(lambda value: float(f"{float(value):.5g}"))(values).tolist()


def products_record(products: Products) -> dict[str, Any]:
    """Ranges and degrees as files hold them."""
    return {
        "low": products.low.tolist(), "high": products.high.tolist(),
        "powers": products.powers.tolist(),
    }  # fmt: skip
