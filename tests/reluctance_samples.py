"""Samples of actuators whose flux linkage, force and co-energy are known in closed form."""

import numpy as np

from tactgen.tmm.reluctance.coenergy_map import Samples

#: A linear actuator: λ = C i/(g + G0).
C, G0 = 2e-6, 0.1e-3
#: A pull that is largest at 2/BEND and changes its sign at 3/BEND, and what is beside the gap (H).
BEND, LEAKAGE = 8.0, 0.05


def linear_samples(currents, gaps):
    i, g = (v.astype(float) for v in np.broadcast_arrays(currents[:, None], gaps[None]))
    linkage = C * i / (g + G0)
    return Samples(currents, gaps, linkage, 0.5 * linkage**2 / C, 0.5 * i * linkage, C / (g + G0))


def falling_samples(currents, gaps):
    """W' = C (i²/2 − b i³/6)/(g + G0) + L i²/2: only flux linkage increases with the current."""
    i, width = currents[:, None], gaps + G0
    shape = i**2 / 2.0 - BEND * i**3 / 6.0
    return Samples(
        currents, gaps, C * (i - BEND * i**2 / 2.0) / width + LEAKAGE * i, C * shape / width**2,
        C * shape / width + LEAKAGE * i**2 / 2.0, C * (1.0 - BEND * i) / width + LEAKAGE,
    )  # fmt: skip
