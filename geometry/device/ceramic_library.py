"""The piezoceramics that scenes choose from by name: full tensors and where they come from."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.ceramic_constants import completed, read_constants
from tactgen.geometry.device.materials import EPS0, PRINTED, Own, Piezoceramic, Spread
from tactgen.geometry.synonyms import folded

#: How far a ceramic of the trade may lie from its data sheet.  APC International states as
#: standard tolerances: capacitance and d33 20 %, frequency 5 %, of which the compliance is the
#: square; the other three are assumed.
CERAMICS = {
    "s11": Own("compliance of a ceramic (makers: frequency ± 5 %)", 0.10),
    "s55": Own("compliance of a ceramic (makers: frequency ± 5 %)", 0.10),
    "d31": Own("d of a ceramic (makers: d33 ± 20 %)", 0.20),
    "eps33": Own("permittivity of a ceramic (makers: capacitance ± 20 %)", 0.20),
    "density": Own("density of a ceramic", 0.02),
    "quality_factor": Own("Q of a ceramic", 0.30),
    "loss_tangent": Own("loss of a ceramic", 0.30),
}


def _transversely_isotropic(s11: float, s12: float, s13: float, s33: float, s44: float) -> Floats:
    s = np.zeros((6, 6))
    s[:3, :3] = [[s11, s12, s13], [s12, s11, s13], [s13, s13, s33]]
    s[3, 3] = s[4, 4] = s44
    s[5, 5] = 2.0 * (s11 - s12)
    return s


def _strain_constants(d31: float, d33: float, d15: float) -> Floats:
    d = np.zeros((3, 6))
    d[2, :3] = d31, d31, d33
    d[0, 4] = d[1, 3] = d15
    return d


def _pzt_5h() -> Piezoceramic:
    """PZT-5H from its usual stiffness-form constants (c66 follows from c11, c12)."""
    c = np.zeros((6, 6))
    c[:3, :3] = np.array([[127.2, 80.2, 84.7], [80.2, 127.2, 84.7], [84.7, 84.7, 117.4]]) * 1e9
    c[3, 3] = c[4, 4] = 23.0e9
    c[5, 5] = 23.5e9
    e = _strain_constants(-6.62, 23.24, 17.03)
    s = np.linalg.inv(c)
    d = e @ s
    eps_s = np.diag([1704.0, 1704.0, 1433.0]) * EPS0
    return Piezoceramic(
        name="PZT-5H",
        s=s,
        d=d,
        eps_t=eps_s + d @ c @ d.T,
        density=7500.0,
        quality_factor=65.0,
        loss_tangent=0.02,
        origin="PZT-5H, published full tensor (c, e, eps at constant strain)",
    )


class _Tensors(NamedTuple):
    """A ceramic of which all constants are published: pm²/N, pC/N, relative permittivities."""

    s: tuple[float, ...]  #: s11, s12, s13, s33, s44 at constant field
    d: tuple[float, ...]  #: d31, d33, d15
    eps: tuple[float, float]  #: eps11, eps33 at constant stress
    density: float
    quality_factor: float
    loss_tangent: float
    origin: str


_TENSORS = {
    "PZT-5A": _Tensors(
        (16.4, -5.74, -7.22, 18.8, 47.5), (-171, 374, 584), (1730, 1700), 7750.0, 75.0, 0.02,
        "PZT-5A, Berlincourt's constants as used in IEEE Std 176",
    ),
    "PZT-4": _Tensors(
        (12.3, -4.05, -5.31, 15.5, 39.0), (-123, 289, 496), (1475, 1300), 7500.0, 500.0, 0.004,
        "PZT-4 (hard), Jaffe, Cook and Jaffe, Piezoelectric Ceramics (1971)",
    ),
    "PZT-8": _Tensors(
        (11.5, -3.7, -4.8, 13.5, 31.9), (-97, 225, 330), (1290, 1000), 7600.0, 1000.0, 0.004,
        "PZT-8 (hard), makers' tables of the Navy type III ceramic",
    ),
    "PIC255": _Tensors(
        (15.90, -5.675, -7.376, 20.97, 44.92), (-174, 393, 535), (1649, 1749), 7800.0, 80.0, 0.02,
        "PIC255, PI Ceramic's table of coefficients for simulation",
    ),
    "Pz26": _Tensors(
        (13.0, -4.35, -7.05, 19.6, 33.2), (-128, 328, 327), (1190, 1300), 7700.0, 1000.0, 0.003,
        "Pz26 (hard), Ferroperm's full matrix data",
    ),
    "Pz27": _Tensors(
        (17.0, -6.60, -8.61, 23.2, 43.5), (-170, 425, 506), (1800, 1800), 7700.0, 80.0, 0.017,
        "Pz27, Ferroperm's full matrix data",
    ),
    "Pz29": _Tensors(
        (17.0, -5.78, -8.79, 22.9, 54.1), (-243, 574, 724), (2440, 2870), 7450.0, 90.0, 0.019,
        "Pz29, Ferroperm's full matrix data",
    ),
}  # fmt: skip


def _published(name: str) -> Piezoceramic:
    of = _TENSORS[name]
    # read as decimal, so that no digit is rounded twice
    s, d = ([float(f"{value}e-12") for value in values] for values in (of.s, of.d))
    eps11, eps33 = of.eps
    return Piezoceramic(
        name=name,
        s=_transversely_isotropic(*s),
        d=_strain_constants(*d),
        eps_t=np.diag([eps11, eps11, eps33]) * EPS0,
        density=of.density,
        quality_factor=of.quality_factor,
        loss_tangent=of.loss_tangent,
        origin=of.origin,
    )


def _m1876() -> Piezoceramic:
    """M1876: the paper's three constants, the rest a soft PZT by ratio to PZT-5H."""
    assumed = "assumed: typical of soft PZT with this d31 (no M1876 data sheet is public)"
    ceramic = _pzt_5h().with_values(
        s11=15.8e-12,
        s55=57.8e-12,
        d31=-385e-12,
        eps33=6000.0,
        density=7900.0,
        quality_factor=60.0,
        loss_tangent=0.03,
    )
    return replace(
        ceramic,
        name="M1876",
        origin="assumed: PZT-5H scaled to the paper's s11, s55 and d31",
        stated={
            "s11": "paper table 2",
            "s55": "paper table 2",
            "d31": "paper table 2",
            "eps33": assumed,
            "density": assumed,
            "quality_factor": assumed,
            "loss_tangent": assumed,
        },
        spreads={
            "s11": Spread(15.75e-12, 15.85e-12, PRINTED, absolute=True),
            "s55": Spread(57.75e-12, 57.85e-12, PRINTED, absolute=True),
            "d31": Spread(-385.5e-12, -384.5e-12, PRINTED, absolute=True),
            "eps33": Spread(5300.0, 6500.0, "tables of soft PZT with d31 of -350 to -405 pC/N"),
            "density": Spread(7700.0, 8000.0, "tables of soft PZT, and a margin"),
            "quality_factor": Spread(50.0, 80.0, "tables of soft PZT, 55 to 75, and a margin"),
            "loss_tangent": Spread(0.02, 0.035, "tables of soft PZT"),
        },
    )


def _pvdf() -> Piezoceramic:
    """Polyvinylidene fluoride, drawn along 1: d31 and d33 have the signs opposite to a ceramic's.

    The maker prints Young's modulus, d31, d33, permittivity, density and dielectric loss.
    """
    maker = "Measurement Specialties, Piezo Film Sensors Technical Manual, table 1"
    assumed = (
        "assumed: isotropic in elasticity, Poisson's ratio 0.35; drawn films have Q of 10 to 20"
    )
    young, poisson = 3e9, 0.35
    d = _strain_constants(23e-12, -33e-12, 0.0)
    d[2, 1] = 3e-12  # assumed: across the draw an order smaller
    shear = 2.0 * (1.0 + poisson) / young
    return Piezoceramic(
        name="PVDF",
        s=_transversely_isotropic(
            1.0 / young, -poisson / young, -poisson / young, 1.0 / young, shear
        ),
        d=d,
        eps_t=12.5 * EPS0 * np.eye(3),
        density=1780.0,
        quality_factor=15.0,
        loss_tangent=0.02,
        origin=maker,
        stated={"s55": assumed, "quality_factor": assumed},
        spreads={
            "s11": Spread(1 / 4e9, 1 / 2e9, f"{maker}: 2 to 4 GPa"),
            "s55": Spread(2.7 / 4e9, 2.7 / 2e9, "assumed: as far as Young's modulus"),
            "d31": Spread(18e-12, 28e-12, "assumed: a film's d31 ± 20 %"),
            "eps33": Spread(12.0, 13.0, f"{maker}: 12 to 13"),
            "density": Spread(1750.0, 1800.0, "assumed: density of a film"),
            "quality_factor": Spread(10.0, 20.0, "assumed: drawn films"),
            "loss_tangent": Spread(0.015, 0.025, "assumed: loss of a film"),
        },
    )


_APC = "APC International, Physical and Piezoelectric Properties of APC Materials (2017)"
_CTS = "CTS, PZT5A & 5H Materials Technical Data"
_NCE = "Noliac, Piezo Ceramics (2012)"


class _Grade(NamedTuple):
    """A maker's ceramic: what gives the rest by ratio, and what the data sheet prints.

    Of constants that depend on each other, an independent set: k33 and not d33, since it was
    measured by resonance as the moduli were.
    """

    rest: Callable[[], Piezoceramic]
    printed: str
    density: float
    quality_factor: float
    loss_tangent: float
    source: str


_GRADES: dict[str, _Grade] = {
    "APC 840": _Grade(
        partial(_published, "PZT-4"),
        "Y11 80 GPa; Y33 68 GPa; d31 -125 pC/N; k33 0.72; d15 480 pC/N; k15 0.70; eps33 1275",
        7600.0, 500.0, 0.006, _APC,
    ),
    "APC 841": _Grade(
        partial(_published, "PZT-4"),
        "Y11 76 GPa; Y33 63 GPa; d31 -109 pC/N; k33 0.68; d15 450 pC/N; k15 0.67; eps33 1375",
        7600.0, 1400.0, 0.004, _APC,
    ),
    "APC 850": _Grade(
        partial(_published, "PZT-5A"),
        "Y11 63 GPa; Y33 54 GPa; d31 -175 pC/N; k33 0.72; d15 590 pC/N; k15 0.68; eps33 1900",
        7600.0, 80.0, 0.02, _APC,
    ),
    "APC 854": _Grade(
        _pzt_5h,
        "Y11 60 GPa; Y33 52 GPa; d31 -260 pC/N; d15 625 pC/N; eps33 2750",
        7600.0, 70.0, 0.02, _APC,  # its k33 of 0.68 would need a d33 of 465 pC/N, not 600
    ),
    "APC 855": _Grade(
        _pzt_5h,
        "Y11 59 GPa; Y33 51 GPa; d31 -276 pC/N; k33 0.76; d15 720 pC/N; k15 0.66; eps33 3300",
        7600.0, 65.0, 0.025, _APC,
    ),
    "APC 880": _Grade(
        partial(_published, "PZT-8"),
        "Y11 90 GPa; Y33 72 GPa; d31 -95 pC/N; k33 0.62; d15 330 pC/N; k15 0.55; eps33 1050",
        7600.0, 1000.0, 0.004, _APC,
    ),
    "CTS 3195HD": _Grade(
        partial(_published, "PZT-5A"),
        "s11 16.2e-12 m^2/N; s33 18.6e-12 m^2/N; d31 -190 pC/N; k33 0.72; k15 0.59; eps33 1900",
        7800.0, 80.0, 0.018, _CTS,
    ),
    "CTS 3203HD": _Grade(
        _pzt_5h,
        "Y11 62 GPa; Y33 49 GPa; d31 -320 pC/N; k33 0.75; k15 0.78; eps33 3800",
        7870.0, 30.0, 0.020, _CTS,
    ),
    "NCE51": _Grade(
        partial(_published, "PZT-5A"),
        "s11 16e-12 m^2/N; s33 19e-12 m^2/N; d31 -195 pC/N; k33 0.72; eps33 1850",
        7800.0, 80.0, 0.019, _NCE,
    ),
}  # fmt: skip


def _grade(name: str) -> Piezoceramic:
    rest, printed, density, quality, loss, source = _GRADES[name]
    base = rest()
    by_ratio = f"assumed: by ratio to {base.name}"
    return replace(
        completed(base, read_constants(printed)), name=name, density=density,
        quality_factor=quality, loss_tangent=loss, origin=source,
        stated={} if "k15" in printed else {"s55": by_ratio},
    )  # fmt: skip


class _Library(Mapping[str, Piezoceramic]):
    """Materials by name, each made when it is first asked for."""

    def __init__(self, makers: dict[str, Callable[[], Piezoceramic]]) -> None:
        self._makers, self._made = makers, dict[str, Piezoceramic]()

    def __getitem__(self, name: str) -> Piezoceramic:
        if name not in self._made:
            self._made[name] = self._makers[name]()
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._makers)

    def __len__(self) -> int:
        return len(self._makers)


#: Library of piezoelectric materials by name.
LIBRARY = _Library({
    "M1876": _m1876, "PZT-5H": _pzt_5h,
    **{name: partial(_published, name) for name in _TENSORS},
    **{name: partial(_grade, name) for name in _GRADES}, "PVDF": _pvdf,
})  # fmt: skip
#: Types of the US Navy (MIL-STD-1376) that makers translate into these names.
_NAVY = {"I": "PZT-4", "II": "PZT-5A", "III": "PZT-8", "V": "APC 854", "VI": "PZT-5H"}


def library_name(text: str) -> str | None:
    """Library's name of a ceramic written in any case, with or without - and space.

    ``Navy II`` and ``Navy type II`` are names, too.
    """
    names = {folded(name): name for name in LIBRARY}
    for numeral, name in _NAVY.items():
        names.update({folded(f"Navy{between}{numeral}"): name for between in ("", "type")})
    return names.get(folded(text))
