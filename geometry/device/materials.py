"""Elastic and piezoelectric materials, in the axes of the device.

Piezoceramics are stated in the IEEE 176 frame (poled along 3).  The device's
axes are x = poling direction, y = width, z = length, so tensors are turned on the
way out: (x, y, z) = (3, 2, 1).  Voigt order is that of the axes in use:
xx, yy, zz, yz, xz, xy.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats, Numbers
from tactgen.geometry.errors import InputError

#: Vacuum permittivity (F/m), CODATA 2018.
EPS0 = 8.8541878128e-12

#: Voigt positions in the device's axes of the IEEE components 11, 22, 33, 23, 13, 12:
#: 1 -> z, 2 -> y, 3 -> x turns (11 22 33 23 13 12) into (zz yy xx xy xz yz).
_VOIGT = np.array([2, 1, 0, 5, 4, 3])
_AXES = np.array([2, 1, 0])


#: Reason of a range that only says how a value was printed.
PRINTED = "half a unit of the last digit printed"


class Spread(NamedTuple):
    """The range (SI) in which a value may lie, every place in it alike, and why that range.

    An `absolute` one, such as a tolerance of cutting, is as wide for any value; others keep
    their proportion.
    """

    low: float
    high: float
    reason: str
    absolute: bool = False

    @property
    def whose(self) -> str:
        """Whose range it is, in a word: stated by the scene, printed, assumed, or of tables."""
        if self.reason.startswith("stated"):
            return "stated"
        if self.reason == PRINTED:
            return "printed"
        return "assumed" if "assumed" in self.reason else "tables"

    def moved(self, usual: float, value: float) -> Spread:
        """Range of `value` where this is that of `usual`.

        An absolute range that would reach 0 says nothing about so small a value, and goes
        in proportion as well.
        """
        if value == usual:
            return self
        reason = self.reason
        if self.absolute:
            low, high = value + (self.low - usual), value + (self.high - usual)
            if low * high > 0.0:
                return self._replace(low=low, high=high)
            reason += ", in proportion for so small a value"
        else:
            reason += "; said of the usual value, in proportion"
        low, high = sorted((self.low * value / usual, self.high * value / usual))
        return Spread(low, high, reason, self.absolute)


class Own(NamedTuple):
    """Assumed spread of a number of which only the kind is known."""

    kind: str
    share: float

    def around(self, value: float) -> Spread:
        """Assumed range of a value; its reason says that it is assumed."""
        low, high = sorted((value * (1.0 - self.share), value * (1.0 + self.share)))
        return Spread(low, high, f"assumed: {self.kind} ± {100.0 * self.share:g} %")


def lossy_modulus(modulus: Any, loss_factor: Any, *, lossy: bool) -> Any:
    """Modulus with structural damping, E (1 + jη) for e^{+jΩt}; as it is if lossless.

    η is the energy lost per radian over the largest stored: 1/Q of a body of this material
    alone (ISO 6721-1).
    """
    return modulus * (1.0 + 1j * loss_factor) if lossy and np.any(loss_factor) else modulus


def lossy_coupling(d: Any, loss_tangent: Any, *, lossy: bool) -> Any:
    """Piezoelectric constants d (1 − j tan θ) for e^{+jΩt}; as they are if lossless."""
    return d * (1.0 - 1j * loss_tangent) if lossy and np.any(loss_tangent) else d


@dataclass(frozen=True)
class PiezoTensors:
    """Constitutive tensors in the device's axes, poled along +x.

    T = c S − eᵀ E,  D = e S + ε E, with engineering shear strains.
    """

    c: Numbers  #: (6, 6) Stiffness at constant field (Pa)
    e: Numbers  #: (3, 6) Piezoelectric stress constants (C/m²)
    eps: Numbers  #: (3, 3) Permittivity at constant strain (F/m)


@dataclass(frozen=True, eq=False)
class Piezoceramic:
    """A poled ceramic (class 6mm) or drawn polymer (mm2), compliance form, IEEE 176 frame."""

    name: str
    s: Floats  #: (6, 6) Compliance at constant field (m²/N)
    d: Floats  #: (3, 6) Piezoelectric strain constants (m/V)
    eps_t: Floats  #: (3, 3) Permittivity at constant stress (F/m)
    #: Mass density (kg/m³), mechanical Q, dielectric tan δ
    density: float
    quality_factor: float
    loss_tangent: float
    origin: str
    stated: dict[str, str] = field(default_factory=dict)
    spreads: dict[str, Spread] = field(default_factory=dict)
    coupling_loss: float = 0.0  #: Loss tangent of d

    def reduced(self) -> dict[str, float]:
        """Constants that a one-dimensional model uses (SI, eps33 relative)."""
        return {
            "s11": float(self.s[0, 0]),
            "s55": float(self.s[4, 4]),
            "d31": float(self.d[2, 0]),
            "eps33": float(self.eps_t[2, 2]) / EPS0,
            "density": self.density,
            "quality_factor": self.quality_factor,
            "loss_tangent": self.loss_tangent,
        }

    @property
    def isotropic_across(self) -> bool:
        """Whether both directions across the poling are alike, as in a ceramic."""
        s, d = self.s, self.d
        alike = [s[0, 0], s[0, 2], s[3, 3], d[2, 0], self.eps_t[0, 0]]
        others = [s[1, 1], s[1, 2], s[4, 4], d[2, 1], self.eps_t[1, 1]]
        return bool(np.allclose(alike, others, rtol=1e-9, atol=0.0))

    def sources(self) -> dict[str, str]:
        """Source of each reduced constant."""
        return {name: self.stated.get(name, self.origin) for name in self.reduced()}

    def with_values(
        self,
        *,
        s11: float,
        s55: float,
        d31: float,
        eps33: float,
        density: float,
        quality_factor: float,
        loss_tangent: float,
        coupling_loss: float = 0.0,
        coupling_growth: float = 1.0,
    ) -> Piezoceramic:
        """The ceramic with the reduced constants replaced exactly.

        The constants that a reduced set does not contain follow from this ceramic's by
        ratio: compliances with s11, s44 with s55, eps11 with eps33, d32 with d31, d33 and d15
        so that the coupling factors k33 and k15 stay, or become `coupling_growth` times as large.
        With unchanged values the tensors are unchanged; with d31 = 0 the ceramic is passive.
        """
        s = self.s * (s11 / self.s[0, 0])
        s[3, 3], s[4, 4] = s55 * (self.s[3, 3] / self.s[4, 4]), s55
        eps_t = self.eps_t * (eps33 * EPS0 / self.eps_t[2, 2])
        d = np.zeros((3, 6))
        d[2, 0] = d31
        d[2, 1] = d31 * (self.d[2, 1] / self.d[2, 0] if self.d[2, 0] else 1.0)
        kept = coupling_growth * self.d if d31 != 0.0 else d
        stiffer = np.sqrt(s[2, 2] / self.s[2, 2] * eps_t[2, 2] / self.eps_t[2, 2])
        d[2, 2] = kept[2, 2] * stiffer
        shear = np.sqrt(s55 / self.s[4, 4] * eps_t[0, 0] / self.eps_t[0, 0])
        d[0, 4], d[1, 3] = kept[0, 4] * shear, kept[1, 3] * shear
        return replace(
            self,
            s=s,
            d=d,
            eps_t=eps_t,
            density=density,
            quality_factor=quality_factor,
            loss_tangent=loss_tangent,
            coupling_loss=coupling_loss,
        )

    def along(self, share: float) -> Piezoceramic:
        """Ceramic poled along axis 1 by interdigitated electrodes, as one poled along axis 3.

        The voltage U makes a field U/pitch along the poling, the same all over (between fingers;
        what is under them is left out).  A layer of this thickness with U across it does the same
        when its elastic axes are turned, d3j become those of the true axes and the field is scaled:
        d times `share`, thickness over pitch, and permittivity times its square.
        """
        turned = [2, 1, 0, 5, 4, 3]
        d = np.zeros((3, 6))
        d[2] = share * self.d[2, turned]
        return replace(
            self, s=self.s[np.ix_(turned, turned)], d=d,
            eps_t=share**2 * np.diag(self.eps_t.diagonal()[[1, 1, 2]]),
        )  # fmt: skip

    def tensors(self, *, lossy: bool = False) -> PiezoTensors:
        """Stiffness-form tensors in the device's axes, poled along +x.

        Losses (time factor e^{+jΩt}): all compliances divided by (1 + j/Q), permittivity
        at constant stress times (1 − j tan δ), d times one minus j its own loss tangent.

        Raises InputError if stiffness or clamped permittivity is not positive definite.
        """
        self.check_admissible()
        stiffening = 1.0 + 1j / self.quality_factor if lossy else 1.0
        permittivity = 1.0 - 1j * self.loss_tangent if lossy else 1.0
        d = lossy_coupling(self.d, self.coupling_loss, lossy=lossy)
        c = np.linalg.inv(self.s) * stiffening
        e = d @ c
        eps = self.eps_t * permittivity - d @ c @ d.T
        c, e, eps = (
            np.asarray(turned)
            for turned in (c[np.ix_(_VOIGT, _VOIGT)], e[np.ix_(_AXES, _VOIGT)], eps[::-1, ::-1])
        )
        return PiezoTensors(c=c, e=e, eps=eps)

    def check_lengthwise(self) -> None:
        """Refuse s11, d31 and eps33 that no passive material has, whatever its other constants.

        Raises InputError if k31 is not below 1.
        """
        squared = self.d[2, 0] ** 2 / (self.s[0, 0] * self.eps_t[2, 2])
        if squared >= 1.0:
            raise InputError(
                f"piezo.d31 = {self.d[2, 0]:.4g} m/V with piezo.eps33 = "
                f"{self.eps_t[2, 2] / EPS0:.4g} and piezo.s11 = {self.s[0, 0]:.4g} m^2/N stores "
                f"negative energy (k31 = {np.sqrt(squared):.3g} must be below 1); change one of "
                "them"
            )

    def check_passive(self) -> None:
        """Refuse a loss of d that would give energy to a bender.

        Raises InputError if the losses of s11, d31 and eps33 together are negative for some motion.
        """
        squared = self.d[2, 0] ** 2 / (self.s[0, 0] * self.eps_t[2, 2])
        others = self.loss_tangent / self.quality_factor
        if self.coupling_loss**2 * squared > others * (1.0 + 1e-9):
            raise InputError(
                f"piezo.coupling_loss = {self.coupling_loss:.3g} is more than "
                f"{np.sqrt(others / squared):.2g}, beyond which the ceramic would give energy, as "
                f"piezo.loss_tangent = {self.loss_tangent:.3g} and piezo.quality_factor = "
                f"{self.quality_factor:.3g} lose too little; make it smaller, or let s11 and eps33 "
                "lose more (piezo.field_growth_s11, piezo.field_growth_eps33)"
            )

    def check_admissible(self) -> None:
        """Refuse constants that no passive material has.

        Raises InputError if stiffness or clamped permittivity is not positive definite, in a
        sentence that names the constants which contradict each other.
        """
        if np.linalg.eigvalsh(self.s).min() <= 0.0:
            raise InputError(
                f"piezo.s11 = {self.s[0, 0]:.4g} m^2/N and piezo.s55 = {self.s[4, 4]:.4g} m^2/N "
                f"do not give a positive definite stiffness ({self._compliance_clash()}); "
                "change one of them"
            )
        clamped = self.eps_t - self.d @ np.linalg.inv(self.s) @ self.d.T
        if np.linalg.eigvalsh(clamped).min() <= 0.0:
            raise InputError(
                f"piezo.d31 = {self.d[2, 0]:.4g} m/V with piezo.eps33 = "
                f"{self.eps_t[2, 2] / EPS0:.4g} and piezo.s11 = {self.s[0, 0]:.4g} m^2/N stores "
                f"negative energy (clamped permittivity not positive: {self._field_clash()}); "
                f"{self._sign_hint()}raise piezo.eps33, state d33 and what else is known in "
                "piezo.constants, or set piezo.d31 = 0 m/V for a passive ceramic"
            )

    def _sign_hint(self) -> str:
        """Remedy for a size that was taken for a value, as data sheets print it."""
        if self.d[2, 0] > 0.0:
            return "write d31 with a minus, as that of poled ceramics is negative, or "
        return ""

    def _compliance_clash(self) -> str:
        """Say which compliances contradict each other."""
        s = self.s
        for i in range(6):
            if s[i, i] <= 0.0:
                return f"s{i + 1}{i + 1} = {s[i, i]:.4g} m^2/N is not positive"
        for i, j in ((0, 1), (0, 2)):
            if s[i, j] ** 2 >= s[i, i] * s[j, j]:
                return (
                    f"|s{i + 1}{j + 1}| = {abs(s[i, j]):.4g} m^2/N is not below the root of "
                    f"s{i + 1}{i + 1} s{j + 1}{j + 1}"
                )
        return "2 s13^2 is not below s33 (s11 + s12)"

    def _field_clash(self) -> str:
        """Say which constants take more energy out of the field than there is in it.

        Clamping first the two directions across the poling and then the third,
        ε33^S = ε33 − 2 d31²/(s11 + s12) − c33 (d33 − d*)², d* = −2 d31 c13/c33.
        """
        s, d, eps = self.s, self.d, self.eps_t
        if d[0, 4] ** 2 >= s[4, 4] * eps[0, 0]:
            return (
                f"d15 = {d[0, 4]:.4g} m/V makes k15 = {d[0, 4] / np.sqrt(s[4, 4] * eps[0, 0]):.3g}"
            )
        if not self.isotropic_across:  # the formulas below are those of a ceramic
            return "eps33, eps11 or eps22 at constant strain would be negative"
        planar = 2.0 * d[2, 0] ** 2 / (s[0, 0] + s[0, 1])
        if planar >= eps[2, 2]:
            return (
                f"d31 alone makes the planar coupling factor {np.sqrt(planar / eps[2, 2]):.3g}, "
                "which must be below 1"
            )
        c = np.linalg.inv(s)
        middle = -2.0 * d[2, 0] * c[0, 2] / c[2, 2]
        reach = np.sqrt((eps[2, 2] - planar) / c[2, 2])
        clamped = eps[2, 2] - planar - c[2, 2] * (d[2, 2] - middle) ** 2
        return (
            f"eps33 at constant strain would be {clamped / EPS0:.4g}, since with this d31 only "
            f"d33 between {middle - reach:.4g} and {middle + reach:.4g} m/V is possible and it is "
            f"{d[2, 2]:.4g} m/V"
        )


def orthotropic_stiffness(
    axial_modulus: float, transverse_modulus: float, shear_modulus: float, poisson_ratio: float
) -> Floats:
    """(6, 6) stiffness (Pa) of a transversely isotropic solid with its axis along z.

    Poisson's ratio is the same along and across the axis; with equal moduli and
    ``shear_modulus = E / (2 (1 + nu))`` the solid is isotropic.

    Raises InputError if the constants do not give a positive definite stiffness.
    """
    nu = poisson_ratio
    s = np.zeros((6, 6))
    across, along = 1.0 / transverse_modulus, 1.0 / axial_modulus
    s[0, 0] = s[1, 1] = across
    s[2, 2] = along
    s[0, 1] = s[1, 0] = -nu * across
    s[0, 2] = s[2, 0] = s[1, 2] = s[2, 1] = -nu * along
    s[3, 3] = s[4, 4] = 1.0 / shear_modulus
    s[5, 5] = 2.0 * (1.0 + nu) * across
    if np.linalg.eigvalsh(s).min() <= 0.0:
        raise InputError(
            f"shim.transverse_modulus = {transverse_modulus:.4g} Pa with shim.youngs_modulus = "
            f"{axial_modulus:.4g} Pa and shim.poisson_ratio = {nu:g} does not give a positive "
            "definite stiffness; lower the transverse modulus or the Poisson ratio"
        )
    return np.asarray(np.linalg.inv(s))


def isotropic_stiffness(youngs_modulus: float, poisson_ratio: float) -> Floats:
    """(6, 6) stiffness (Pa) of an isotropic solid."""
    shear = youngs_modulus / (2.0 * (1.0 + poisson_ratio))
    return orthotropic_stiffness(youngs_modulus, youngs_modulus, shear, poisson_ratio)
