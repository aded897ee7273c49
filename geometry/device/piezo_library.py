"""The piezoceramics that scenes choose from by name: full tensors and where they come from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.materials import EPS0, PRINTED, Own, Piezoceramic, Spread
from tactgen.geometry.names import folded

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
    """Return PZT-5H from its usual stiffness-form constants (c66 follows from c11, c12)."""
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


def _pzt_5a() -> Piezoceramic:
    return Piezoceramic(
        name="PZT-5A",
        s=_transversely_isotropic(16.4e-12, -5.74e-12, -7.22e-12, 18.8e-12, 47.5e-12),
        d=_strain_constants(-171e-12, 374e-12, 584e-12),
        eps_t=np.diag([1730.0, 1730.0, 1700.0]) * EPS0,
        density=7750.0,
        quality_factor=75.0,
        loss_tangent=0.02,
        origin="PZT-5A, Berlincourt's constants as used in IEEE Std 176",
    )


def _pzt_4() -> Piezoceramic:
    return Piezoceramic(
        name="PZT-4",
        s=_transversely_isotropic(12.3e-12, -4.05e-12, -5.31e-12, 15.5e-12, 39.0e-12),
        d=_strain_constants(-123e-12, 289e-12, 496e-12),
        eps_t=np.diag([1475.0, 1475.0, 1300.0]) * EPS0,
        density=7500.0,
        quality_factor=500.0,
        loss_tangent=0.004,
        origin="PZT-4 (hard), Jaffe, Cook and Jaffe, Piezoelectric Ceramics (1971)",
    )


def _pzt_8() -> Piezoceramic:
    return Piezoceramic(
        name="PZT-8",
        s=_transversely_isotropic(11.5e-12, -3.7e-12, -4.8e-12, 13.5e-12, 31.9e-12),
        d=_strain_constants(-97e-12, 225e-12, 330e-12),
        eps_t=np.diag([1290.0, 1290.0, 1000.0]) * EPS0,
        density=7600.0,
        quality_factor=1000.0,
        loss_tangent=0.004,
        origin="PZT-8 (hard), makers' tables of the Navy type III ceramic",
    )


def _pic255() -> Piezoceramic:
    return Piezoceramic(
        name="PIC255",
        s=_transversely_isotropic(15.90e-12, -5.675e-12, -7.376e-12, 20.97e-12, 44.92e-12),
        d=_strain_constants(-174e-12, 393e-12, 535e-12),
        eps_t=np.diag([1649.0, 1649.0, 1749.0]) * EPS0,
        density=7800.0,
        quality_factor=80.0,
        loss_tangent=0.02,
        origin="PIC255, PI Ceramic's table of coefficients for simulation",
    )


def _pz26() -> Piezoceramic:
    return Piezoceramic(
        name="Pz26",
        s=_transversely_isotropic(13.0e-12, -4.35e-12, -7.05e-12, 19.6e-12, 33.2e-12),
        d=_strain_constants(-128e-12, 328e-12, 327e-12),
        eps_t=np.diag([1190.0, 1190.0, 1300.0]) * EPS0,
        density=7700.0,
        quality_factor=1000.0,
        loss_tangent=0.003,
        origin="Pz26 (hard), Ferroperm's full matrix data",
    )


def _pz27() -> Piezoceramic:
    return Piezoceramic(
        name="Pz27",
        s=_transversely_isotropic(17.0e-12, -6.60e-12, -8.61e-12, 23.2e-12, 43.5e-12),
        d=_strain_constants(-170e-12, 425e-12, 506e-12),
        eps_t=np.diag([1800.0, 1800.0, 1800.0]) * EPS0,
        density=7700.0,
        quality_factor=80.0,
        loss_tangent=0.017,
        origin="Pz27, Ferroperm's full matrix data",
    )


def _pz29() -> Piezoceramic:
    return Piezoceramic(
        name="Pz29",
        s=_transversely_isotropic(17.0e-12, -5.78e-12, -8.79e-12, 22.9e-12, 54.1e-12),
        d=_strain_constants(-243e-12, 574e-12, 724e-12),
        eps_t=np.diag([2440.0, 2440.0, 2870.0]) * EPS0,
        density=7450.0,
        quality_factor=90.0,
        loss_tangent=0.019,
        origin="Pz29, Ferroperm's full matrix data",
    )


def _m1876() -> Piezoceramic:
    """Return M1876: the paper's three constants, the rest a soft PZT by ratio to PZT-5H."""
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


#: Library of piezoceramics by name.
LIBRARY: dict[str, Piezoceramic] = {
    c.name: c
    for c in (
        _m1876(), _pzt_5h(), _pzt_5a(), _pzt_4(), _pzt_8(), _pic255(), _pz26(), _pz27(),
        _pz29(),
    )
}  # fmt: skip

#: Types of the US Navy (MIL-STD-1376) that makers translate into these names.
_NAVY = {"I": "PZT-4", "II": "PZT-5A", "III": "PZT-8", "VI": "PZT-5H"}


def library_name(text: str) -> str | None:
    """Return the library's name of a ceramic written in any case, with or without - and space.

    ``Navy II`` and ``Navy type II`` are names, too.
    """
    names = {folded(name): name for name in LIBRARY}
    for numeral, name in _NAVY.items():
        names.update({folded(f"Navy{between}{numeral}"): name for between in ("", "type")})
    return names.get(folded(text))
