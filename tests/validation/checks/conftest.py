"""What a row of the stress run asks: every point of it, not only the worst that its table shows."""

import math

import pytest

from tactgen.validation.checks.stress import result

#: A condition beyond this is rounding itself: next to a pole.
ILL = 1e5


@pytest.fixture(scope="session")
def every_point():
    """Return what notes each point that is judged from now on as a line, given a monkeypatch.

    Bounds below `least` are told where the method states them, for a condition; what a model makes
    of its rounding is another elsewhere.  Made-up answers are told `exactly`.
    """

    def noted(patch, least=1e-8, *, exactly=False):
        found, share = [], result._over

        def over(points):
            for point in points:
                whole = f"{point.where}: {point.error:.7g} ± {point.bound:.7g}"
                found.append(whole if exactly else _told(point, least))
            return share(points)

        patch.setattr(result, "_over", over)
        return found

    return noted


def _told(point, least):
    """Return where, an error that is more than rounding, and what it may be."""
    if point.condition > ILL:
        return f"{point.where}: ill-conditioned"
    error = f"{point.error:.1e}" if point.error > 1e-6 else "rounding"
    stated = point.bound >= least or not math.isnan(point.condition)
    return f"{point.where}: {error} ± {f'{point.bound:.1e}' if stated else 'rounding'}"
