"""Coefficients that ``tactgen calibrate`` fits, as shipped, and what widens their errors."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.chebyshev import Products

#: Coefficients, their ranges and their errors, as ``tactgen calibrate`` writes them: of the bimorph
#: of piezo, shim and piezo, and of listed layers.
FILE, LISTED_FILE = (Path(__file__).with_name(f"calibration{of}.json") for of in ("", "_laminate"))
#: Share of a range by which its rounded ends may be off.
_ROUNDED = 1e-3
#: Number of :func:`tmm.beam.calibrated_section.step_sizes`.
STEP_SIZES = 8
#: What the six factors act on, in order; see
#: :class:`tmm.beam.calibrated_section.SectionFactors`.
FACTORS = ("stiffness", "root", "shear", "coupling", "root_coupling", "capacitance")
#: What an error is known of, in order: the tip's displacement per force and per voltage, the free
#: capacitance, natural frequencies of bending in x, and the coupling factor of the first mode.
ERRORS = ("compliance", "deflection", "capacitance", "f1", "f2", "f3", "coupling_factor")


@dataclass(frozen=True)
class Fit:
    """Coefficients over a range of groups."""

    products: Products  #: Polynomials in all groups
    clamp: Products  #: The same, each of which times each size of a clamp's effects is a term
    factors: Floats  #: (t, 6) Coefficients of the logarithms of :data:`FACTORS`
    ratios: Floats  #: (t, 3) The same of the ratios of frequencies
    errors: Floats  #: (1 + 2 g, 7) Of the logarithms of :data:`ERRORS`

    def terms(self, at: Floats, sizes: Floats) -> Floats:
        """Terms (..., t) at groups (..., g) and sizes (..., a)."""
        held = sizes[..., :, None] * self.clamp(at)[..., None, :]
        flat = held.reshape(*held.shape[:-2], -1)
        return np.concatenate([self.products(at), flat], axis=-1)


@dataclass(frozen=True)
class Widening:
    """Factors on :data:`ERRORS`, at least 1, over a range of sizes of the pieces."""

    low: Floats  #: (g,) Range of the sizes; those beyond count as its end
    high: Floats
    logarithms: Floats  #: (1 + g, 7) Of the factors: constant, and by size from −1 to 1

    def terms(self, sizes: Floats) -> Floats:
        """1 and sizes (..., 1 + g) over the range."""
        unit = np.clip(self._unit(sizes), -1.0, 1.0)
        return np.concatenate([np.ones_like(unit[..., :1]), unit], axis=-1)

    def outside(self, sizes: Floats) -> bool:
        """Whether one of the sizes (g,) that differ at all is beyond the range."""
        beyond = (np.abs(self._unit(sizes)) > 1.0 + _ROUNDED) & (self.high > self.low)
        return bool(beyond.any())

    def _unit(self, sizes: Floats) -> Floats:
        span = np.where(self.high > self.low, self.high - self.low, 1.0)
        return np.asarray(2.0 * (sizes - self.low) / span - 1.0)

    def __call__(self, sizes: Floats) -> Floats:
        """Factors (..., 7) at sizes (..., g)."""
        return np.asarray(np.maximum(np.exp(self.terms(sizes) @ self.logarithms), 1.0))


@dataclass(frozen=True)
class Calibration:
    """A fit, and what widens its errors."""

    fit: Fit
    #: By property that the fit does not know, such as a tab, and of ratios beyond its range; of
    #: others, such as a taper, no error is known
    beyond: dict[str, Widening]


def calibration_from(record: dict[str, Any]) -> Calibration:
    """Calibration as read from a file."""
    one = record["fit"]
    fit = Fit(
        Products(*(np.array(one[name]) for name in ("low", "high", "powers"))),
        Products(*(np.array(one[name]) for name in ("low", "high", "clamp"))),
        *(np.array(one[name]) for name in ("factors", "ratios", "errors")),
    )
    beyond = {
        name: Widening(*(np.array(of[key]) for key in ("low", "high", "logarithms")))
        for name, of in record["beyond"].items()
    }
    return Calibration(fit, beyond)


@cache
def calibration(*, listed: bool) -> Calibration:
    """Calibration that is shipped, of listed layers or of piezo, shim and piezo."""
    file = LISTED_FILE if listed else FILE
    return calibration_from(json.loads(file.read_text(encoding="utf-8")))
