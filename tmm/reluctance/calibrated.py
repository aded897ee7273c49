"""The reluctance network with its known differences from the field taken off.

A factor on the co-energy, e^P(x), of ratios x of the dimensions, of the current and of the gap,
fitted once to axisymmetric fields of random actuators (:mod:`validation.evidence`).  Flux
linkage and force are its slopes, so they stay consistent:

    W' = e^P W,  λ = ∂W'/∂i = e^P (λ₀ + W P_i),  F = −∂W'/∂g = e^P (F₀ − W P_g).

Beyond the range of the fit P is that at its end, and goes on with its slope in the gap, and in the
ampere turns upwards, as far as twice the end; the errors are larger by a factor that such actuators
showed.  The coefficients come from finite elements: this is no witness of its own.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.tmm.chebyshev import Products
from tactgen.tmm.reluctance.magnetic_circuit import pole_area

#: Coefficients and errors, as ``tactgen calibrate`` writes them.
FILE = Path(__file__).with_name("calibration.json")
#: Ratios in order, for people.
GROUPS = (
    "gap", "ampere turns", "shaft radius", "wall of the sleeve",
    "collar over the coil", "head thickness", "coil length", "gap at the flange",
    "flange thickness", "sleeve radius", "step between head and sleeve", "steel at 1 kA/m",
    "steel at 10 kA/m",
)  # fmt: skip
_GAP, _TURNS = 0, 1
#: Fields (A/m) at which the curve of a steel is read.
_FIELDS = (1e3, 1e4)
#: Share of W'/g, and of λ/i, that the error of a slope is never small beside.
_CANCELS = 0.1
#: Step of the current for the incremental inductance, relative.
_STEP = 1e-3
#: Logarithm of how far beyond the range P goes on with its slope.
_FURTHER = np.log(2.0)


class State(NamedTuple):
    """Values of one actuator at n points, arrays (n,): N, Wb, J, H."""

    force: Floats
    flux_linkage: Floats
    coenergy: Floats
    incremental_inductance: Floats


#: Names of the values that it corrects, in order.
VALUES = State._fields


@dataclass(frozen=True)
class Fit:
    """Coefficients over a range of groups."""

    products: Products  #: Of t terms
    coefficients: Floats  #: (t,) Of P
    errors: Floats  #: (1 + 2 g, 4) Of the logarithms of the errors of :data:`VALUES`
    beyond: float = 1.0  #: Factor on the errors beyond the range, up to twice its ends

    def outside(self, at: Floats) -> list[str]:
        """Ratios (g,) beyond the range; few ampere turns do not count, as the steel is linear."""
        return [
            GROUPS[n] for n in self.products.outside(at)
            if n != _TURNS or (at[n] > self.products.high[n] and self.products.powers[:, n].any())
        ]  # fmt: skip

    def potential(self, at: Floats) -> tuple[Floats, Floats, Floats]:
        """P (n,) at ratios (n, g), and its slopes by those of the gap and the ampere turns."""
        ends = np.clip(at, self.products.low, self.products.high)
        found, slopes = self.products(ends) @ self.coefficients, []
        for variable in (_GAP, _TURNS):
            past = (at - ends)[:, variable]
            followed = np.clip(past, 0.0 if variable == _TURNS else -_FURTHER, _FURTHER)
            slope = self.products.slope(ends, variable) @ self.coefficients
            found = found + slope * followed
            slopes.append(np.where(past == followed, slope, 0.0))
        return found, slopes[0], slopes[1]

    def bend(self, at: Floats) -> Floats:
        """Second derivative (n,) of P by the ampere turns' ratio."""
        own, step = at[:, _TURNS], _STEP
        low, high = self.products.low[_TURNS], self.products.high[_TURNS] + _FURTHER
        within = (own >= low) & (own <= high)
        less, more = np.clip(own - step, low, high), np.clip(own + step, low, high)
        below, above = at.copy(), at.copy()
        below[:, _TURNS], above[:, _TURNS] = less, more
        change = self.potential(above)[2] - self.potential(below)[2]
        return np.where(within, change / np.where(more > less, more - less, 1.0), 0.0)


def _widening(fit: Fit, at: Floats) -> float:
    """Factor on the errors at ratios (g,): as often as the end of the range is doubled.

    Of ratios that are no logarithms a difference of ln 2 counts as much.
    """
    outside = [GROUPS.index(name) for name in fit.outside(at)]
    ends = np.clip(at, fit.products.low, fit.products.high)
    farthest = np.abs(at - ends)[outside].max(initial=0.0) / np.log(2.0)
    return float(fit.beyond ** max(1.0, farthest)) if outside else 1.0


@cache
def calibration() -> dict[str, Fit]:
    """Fits that are shipped, for straight magnetisation curves and for saturating ones."""
    record = json.loads(FILE.read_text(encoding="utf-8"))
    return {
        kind: Fit(
            Products(*(np.array(record[kind][name]) for name in ("low", "high", "powers"))),
            np.array(record[kind]["coefficients"]),
            np.array(record[kind]["errors"]),
            record[kind]["beyond"],
        )
        for kind in ("straight", "saturating")
    }


def sizes(state: State, current: Floats, gap: Floats) -> Floats:
    """Sizes (4, n) that errors of :data:`VALUES` are shares of, at currents and gaps (n,).

    A force that is small beside W'/g, since its parts cancel, has no error smaller for it, nor has
    an incremental inductance that is small beside λ/i.  Without a current all sizes are 0 but that
    of the incremental inductance.
    """
    force = np.abs(state.force) + _CANCELS * np.abs(state.coenergy) / gap
    linkage = np.abs(state.flux_linkage)
    slope = np.abs(state.incremental_inductance) + _CANCELS * linkage / _size(current)
    return np.stack([force, linkage, np.abs(state.coenergy), slope])


def _size(current: Floats) -> Floats:
    return np.maximum(np.abs(current), 1e-12)


def is_straight(device: Device) -> bool:
    """Whether the steel has a constant permeability."""
    return device.steel.curve == "linear"


def groups(device: Device, current: Floats, gap: Floats) -> Floats:
    """Ratios (n, 13) at currents and gaps (n,); see :data:`GROUPS`."""
    rod, coil, sleeve = device.rod, device.coil, device.sleeve
    r = rod.head_radius
    curve = magnetisation_curve(device.steel)
    at = np.array([np.interp(field, curve.field, curve.flux_density) for field in _FIELDS])
    # flux density in the shaft if the ampere turns had to cross a gap of the head's radius
    flux = MU0 * coil.turns * _size(current) / r * pole_area(device)
    density = flux / (np.pi * rod.radius**2 * at[-1])
    collar = (sleeve.inner_radius - sleeve.collar_radius) * sleeve.collar_thickness
    fixed = (
        rod.radius / r, np.log((sleeve.outer_radius - sleeve.inner_radius) / r),
        np.sqrt(max(collar, 0.0)) / r, np.log(rod.head_thickness / r), np.log(coil.length / r),
        np.log((sleeve.inner_radius - rod.flange_radius) / r), np.log(rod.flange_thickness / r),
        sleeve.outer_radius / r,
    )  # fmt: skip
    step = np.abs(sleeve.outer_radius - r)
    steel = np.log(at)
    columns = [np.log(gap / r), np.log(density), *fixed, step / (step + gap), *steel]
    return np.column_stack([np.broadcast_to(one, np.shape(gap)) for one in columns])


def fit_of(device: Device) -> Fit:
    """Fit that is shipped for a device's steel."""
    return calibration()["straight" if is_straight(device) else "saturating"]


def corrected(
    device: Device, current: Floats, gap: Floats, network: State, known: Fit | None = None
) -> tuple[State, Floats]:
    """Values of a network with the known differences from the field taken off.

    Parameters
    ----------
    current, gap : (n,) array
        A and m.
    network : State
        What the network gives there.

    Returns
    -------
    State
        Expected of the axisymmetric field.
    (4, n) array
        Errors of :data:`VALUES`, as shares of :func:`sizes`.
    """
    fit = known or fit_of(device)
    at = groups(device, current, gap)
    potential, in_gap, in_turns = fit.potential(at)
    factor, size = np.exp(potential), _size(current)
    by_gap, by_current = in_gap / gap, np.sign(current) * in_turns / size
    bend = (fit.bend(at) - in_turns) / size**2
    energy, linkage = network.coenergy, network.flux_linkage
    found = State(
        factor * (network.force - energy * by_gap),
        factor * (linkage + energy * by_current),
        factor * energy,
        factor * (
            network.incremental_inductance + 2.0 * linkage * by_current
            + energy * (bend + by_current**2)
        ),
    )  # fmt: skip
    wider = [_widening(fit, one) for one in at]
    return found, np.exp(fit.products.quadratic(at) @ fit.errors).T * wider
