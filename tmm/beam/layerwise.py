"""Layerwise theory of a cantilever: each layer stretches and shears on its own, all deflect alike.

The displacement along z is a cubic through each layer and continuous, u(x, z) = Σ φᵢ(x) uᵢ(z); the
deflection w(z) is common (narrow beam).  The shear force Q gives w′, and the rest is diagonal in
modes of slip: uₖ″ − κₖ² uₖ = gₖ Q.  Two of them have κ = 0, stretching and bending, and are beam
theory.  The others decay from the ends; they matter where a core is soft.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Legendre
from numpy.polynomial.legendre import leggauss, legvander

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import StackLayer, bimorph_stack
from tactgen.geometry.device.bimorph import Piezo
from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.beam.sections import Section, moduli

#: κ times a length below which limits take the place of hyperbolic functions: within 1e-6.
_SLOW = 1e-3
#: The same above which cosh is out of range; its reciprocal is then 0.
_FAST = 300.0
#: Thickness of a layer, as a share of the whole, that is as good as none.
_THINNEST = 1e-9


@dataclass(frozen=True)
class LayerwiseBeam:
    """Modes of slip of a section."""

    rigidity: float  #: ∫ G dA (N)
    decay: Floats  #: (k,) κ (1/m); the first two are 0
    #: (k,) Source of each mode per shear force, per moment on the tip, and per voltage; the second
    #: is also the mean rotation of the tip's face per unit of the mode
    by_force: Floats
    by_moment: Floats
    by_voltage: Floats

    @property
    def shear(self) -> float:
        """Slope per shear force (1/N) far from the ends, by shear alone."""
        slips = self.by_force[2:] / self.decay[2:]
        return float(1.0 / self.rigidity + slips @ slips)

    @property
    def bending(self) -> float:
        """Curvature per moment (1/(N m²)) far from the ends."""
        return float(self.by_force[:2] @ self.by_force[:2])

    @property
    def shear_correction(self) -> float:
        """Factor by which ∫ G dA is to be multiplied in beam theory."""
        return 1.0 / (self.rigidity * self.shear)

    def statics(self, length: float) -> Floats:
        """Motion (5,) of the tip of a cantilever, its base held in all layers.

        Displacement per force (m/N), rotation per force (rad/N) and per moment (rad/(N m)),
        displacement (m/V) and rotation (rad/V) per voltage.  The signs are those of the modes: only
        ratios to :meth:`beam_statics` are used.
        """
        slow, x = self.decay * length < _SLOW, np.maximum(self.decay * length, _SLOW)
        once = length * np.where(slow, 1.0, np.tanh(x) / x)
        decayed = (1.0 - 1.0 / np.cosh(np.minimum(x, _FAST))) / x**2
        twice = length**2 * np.where(slow, 0.5, decayed)
        thrice = length**3 * np.where(slow, 1.0 / 3.0, (1.0 - np.tanh(x) / x) / x**2)
        return self._moved(length / self.rigidity, once, twice, thrice)

    def beam_statics(self, length: float) -> Floats:
        """The same (5,) by beam theory."""
        at = np.array([1.0, 1.0, *np.zeros(self.decay.size - 2)])
        slide = length * self.shear
        return self._moved(slide, length * at, length**2 / 2.0 * at, length**3 / 3.0 * at)

    def _moved(self, slide: float, once: Floats, twice: Floats, thrice: Floats) -> Floats:
        force, turn, volt = self.by_force, self.by_moment, self.by_voltage
        return np.array([
            slide + force**2 @ thrice, force * turn @ twice, turn**2 @ once,
            force * volt @ twice, turn * volt @ once,
        ])  # fmt: skip

    def flexibility(self, wavenumber: Floats) -> Floats:
        """Slope per shear force (n,) in 1/N that varies along z with wavenumbers (n,) in 1/m."""
        each = self.by_force**2 / (self.decay**2 + wavenumber[:, None] ** 2)
        return np.asarray(1.0 / self.rigidity + each.sum(axis=1))


def layerwise_beam(device: Device, *, varying_field: bool = False) -> LayerwiseBeam:
    """Modes of slip of the length that the ceramics cover.

    With `varying_field` the field varies through each ceramic, its mean being that of the voltage:
    strain that varies through the ceramic then meets its stiffness at constant charge.
    """
    layers = counted(bimorph_stack(device))
    found = slip_modes(layers, device.bimorph.width, varying_field=varying_field)
    sources = found.slip / found.rigidity, found.turn / found.inertia, found.volt
    by_force, by_moment, by_voltage = (of @ found.shapes for of in sources)
    return LayerwiseBeam(found.rigidity, found.decay, by_force, by_moment, by_voltage)


class SlipModes(NamedTuple):
    """Modes of slip of some layers; n unknowns: the faces', then two of each layer."""

    faces: Floats  #: (l + 1,) Positions of the l layers' faces along x (m)
    decay: Floats  #: (n,) κ (1/m), ascending; the first two are 0
    shapes: Floats  #: (n, n) Displacement along z of each mode (column)
    forces: Floats  #: (n, n) Force on each unknown per slope along z of each mode
    #: (n,) Force on each unknown per slope of the whole (N), by the faces' rotation (m³), and
    #: per voltage (N/V)
    slip: Floats
    turn: Floats
    volt: Floats
    rigidity: float  #: ∫ G dA (N)
    inertia: float  #: ∫ x² dA (m⁴)


def counted(layers: Sequence[StackLayer]) -> list[StackLayer]:
    """Layers less those that are as good as none."""
    thinnest = _THINNEST * (layers[-1].high - layers[0].low)
    return [layer for layer in layers if layer.thickness > thinnest]


def slip_modes(layers: Sequence[StackLayer], width: float, *, varying_field: bool) -> SlipModes:
    """Modes of slip of layers that touch; `width` (m) is that of the bimorph."""
    count, (at, weights, shape, slope) = len(layers), _cubics()
    size = 3 * count + 1
    strain, shear = np.zeros((size, size)), np.zeros((size, size))
    slip, turn, volt = np.zeros((3, size))
    rigidity = inertia = 0.0
    for i, layer in enumerate(layers):
        young, rigid = moduli(layer.material, lossy=False)
        wide, t = width * layer.share, layer.thickness
        x, area = layer.low + at * t, wide * t * weights
        own = [i, i + 1, count + 1 + 2 * i, count + 2 + 2 * i]
        strain[np.ix_(own, own)] += young * (shape * area) @ shape.T
        shear[np.ix_(own, own)] += rigid * (slope / t * area) @ slope.T / t
        slip[own] += rigid * slope @ area / t
        turn[own] += shape @ (area * x)
        inertia += area @ x**2
        rigidity += rigid * wide * t
        if isinstance(layer.material, Piezo):
            mean = shape @ weights if layer.electrodes else np.zeros(4)
            varies = shape - mean[:, None]
            varies_here = varying_field and not layer.uniform
            stiffer = varies_here * _at_constant_charge(layer.material)
            strain[np.ix_(own, own)] += stiffer * young * (varies * area) @ varies.T
            field = layer.hot * layer.poling / t if layer.electrodes else 0.0
            volt[own] += young * layer.material.d31 * field * shape @ area
    squares, modes = eigenpairs(shear - np.outer(slip, slip) / rigidity, strain)
    squares[:2] = 0.0  # but for rounding
    faces = np.array([layers[0].low, *(layer.high for layer in layers)])
    return SlipModes(
        faces, np.sqrt(squares), modes, strain @ modes, slip, turn, volt, float(rigidity),
        float(inertia),
    )  # fmt: skip


def eigenpairs(matrix: Floats, mass: Floats) -> tuple[Floats, Floats]:
    """Ascending eigenvalues (n,) of both symmetric matrices (n, n), and vectors of unit mass."""
    root = np.linalg.inv(np.linalg.cholesky(mass))  # in numpy, as scipy takes long to import
    values, vectors = np.linalg.eigh(root @ matrix @ root.T)
    return values, root.T @ vectors


def _at_constant_charge(of: Piezo) -> float:
    """Relative rise k²/(1 − k²) of Young's modulus along z at a constant charge."""
    squared = of.d31**2 / (of.s11 * of.eps33 * EPS0)
    return float(squared / (1.0 - squared))


@cache
def _cubics() -> tuple[Floats, Floats, Floats, Floats]:
    """Gauss points and weights (4,) over 0 to 1, and four cubics and their slopes (4, 4) there.

    One is 1 at the lower face, one at the upper, two are 0 at both.
    """
    x, weights = leggauss(4)
    one = np.ones(4)
    shape = np.array([0.5 * (1.0 - x), 0.5 * (1.0 + x), x**2 - 1.0, x**3 - x])
    slope = np.array([-one, one, 4.0 * x, 6.0 * x**2 - 2.0])
    return 0.5 * (x + 1.0), 0.5 * weights, shape, slope


# ---- what it adds to beam theory ----

#: Least share of beam theory's deflection per voltage that a factor stands for.
_LEAST = 0.05


class LayerwiseChange(NamedTuple):
    """What layerwise theory adds to beam theory, for a clamped bimorph."""

    #: (6,) Logarithms of factors, see :data:`tmm.beam.calibration_fit.FACTORS`
    factors: Floats
    #: (5,) Frequencies (Hz), and logarithms of the ratio of the beam's with these factors to them
    frequencies: Floats
    ratios: Floats
    #: (5,) Relative change of :meth:`LayerwiseBeam.statics`
    statics: Floats


def layerwise_change(device: Device, plate: Section, root: float) -> LayerwiseChange:
    """Factors that give a section the statics and the frequencies of layerwise theory.

    The bending stiffness of `plate` takes the place of the narrow beam's; the zone of the length
    `root` (m) next to the clamp has factors of its own.
    """
    length, own = device.bimorph.length, layerwise_beam(device, varying_field=True)
    beam = own.beam_statics(length)  # without coupling 0 per voltage
    ratio = np.divide(own.statics(length), beam, out=np.ones(beam.size), where=beam != 0.0)
    # the zone at the clamp and the shear take what the tip moves less per force
    bend, slide = length**3 / 3.0 / plate.EI, length / plate.GA
    beyond = bend * (1.0 - root / length) ** 3
    less = float((ratio[0] * (bend + slide) - beyond) / (bend + slide - beyond))
    factors = np.array([1.0, less, less, max(ratio[3], _LEAST), 1.0, 1.0])
    return LayerwiseChange(
        np.log(factors), *_frequencies(own, plate, length, root, less), ratio - 1.0
    )


#: Frequencies that are asked for; polynomials of the shear force, and waves that they are made of:
#: within 1e-4 of the fifth frequency.
_MODES, _FORCES, _WAVES = 5, 11, 64


def _frequencies(
    own: LayerwiseBeam, plate: Section, length: float, root: float, less: float
) -> tuple[Floats, Floats]:
    """First frequencies (5,) in Hz by layerwise theory, and logarithms of the beam's over them.

    Ritz's method on the shear force Q of a cantilever: q = −Q′ is its inertia, and the slope that
    a sine of Q makes is a sine, so that layerwise theory is diagonal in them.
    """
    waves, forces, shears, bends, inertia, *_ = _cantilever()
    k = waves / length
    slopes = own.flexibility(k) + (1.0 / plate.EI - own.bending) / k**2 - 1.0 / own.rigidity
    root_bends = bends + (less - 1.0) * _root_bends(root / length)
    layered, beam = (
        eigenpairs(flexible, inertia)[0][: -_MODES - 1 : -1]
        for flexible in (
            (forces * slopes) @ forces.T + shears / own.rigidity,
            shears * less / plate.GA + root_bends * length**2 / plate.EI,
        )
    )
    frequencies = 1.0 / (2.0 * np.pi * length * np.sqrt(plate.m * layered))
    return frequencies, 0.5 * np.log(layered / beam)


def frequencies_with_root(near: float, softer: float) -> Floats:
    """Angular frequencies (5,) over √(EI/(m L⁴)) of a cantilever whose root is softer."""
    _, _, _, bends, inertia, *_ = _cantilever()
    flexible = bends + (softer - 1.0) * _root_bends(near)
    return np.asarray(eigenpairs(flexible, inertia)[0][: -_MODES - 1 : -1] ** -0.5)


def _root_bends(near: float) -> Floats:
    """Flexibility (p, p) in bending, over all of it, of a share of a cantilever at its clamp."""
    *_, turned, at, weights = _cantilever()
    moments = turned @ legvander(2.0 * near * at - 1.0, len(turned[0]) - 1).T
    return np.asarray(near * (moments * weights) @ moments.T)


@cache
def _cantilever() -> tuple[Floats, ...]:
    """Wavenumbers (n,), parts (p, n) of the forces in their sines, and matrices (p, p).

    These are of the forces, of their moments and of their slopes, over a length from 0 to 1 whose
    end at 1 is free.  Then the moments' coefficients (p, c), Gauss points and weights.
    """
    free = Legendre([0.5, -0.5], domain=(0.0, 1.0))
    forces = [Legendre.basis(n, domain=(0.0, 1.0)) * free for n in range(_FORCES)]
    moments, slopes = [of.integ(lbnd=1.0) for of in forces], [of.deriv() for of in forces]
    waves = (np.arange(_WAVES) + 0.5) * np.pi
    x, weights = (0.5 * of for of in leggauss(4 * _WAVES))
    x += 0.5
    values = [np.array([one(x) for one in of]) for of in (forces, moments, slopes)]
    sines = np.sqrt(2.0) * np.sin(np.outer(waves, x))
    matrices = ((of * weights) @ of.T for of in values)
    most = max(of.coef.size for of in moments)
    turned = np.array([np.pad(of.coef, (0, most - of.coef.size)) for of in moments])
    at, own = (0.5 * of for of in leggauss(2 * _FORCES))
    return waves, (values[0] * weights) @ sines.T, *matrices, turned, at + 0.5, own
