"""What values are drawn from: seeded, and the same for one key whatever else is drawn."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats

#: Distributions by name, with what their two numbers are.
DISTRIBUTIONS = {
    "normal": ("mean", "standard deviation"),
    "lognormal": ("median", "standard deviation of its logarithm"),
    "uniform": ("low", "high"),
    "loguniform": ("low", "high"),
}


@dataclass(frozen=True)
class Distribution:
    """A distribution of one number (SI units); `first` and `second` as in DISTRIBUTIONS."""

    kind: str
    first: float
    second: float

    def draw(self, count: int, seed: int, key: str) -> Floats:
        """Return `count` independent values.

        The first of more draws are those of fewer, and another axis changes nothing, so a study
        can grow.
        """
        random = np.random.default_rng([seed, zlib.crc32(key.encode())])
        match self.kind:
            case "normal":
                return np.asarray(random.normal(self.first, self.second, count))
            case "lognormal":
                return np.asarray(self.first * np.exp(random.normal(0.0, self.second, count)))
            case "loguniform":
                ends = np.log(self.first), np.log(self.second)
                return np.asarray(np.exp(random.uniform(*ends, count)))
            case _:
                return np.asarray(random.uniform(self.first, self.second, count))
