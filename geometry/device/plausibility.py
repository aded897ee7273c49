"""Expected ranges of material constants, by which slips of units are found.

The ranges are those of commercial materials, from soft PZT to PVDF and from polymers to steel.
A value that lies ten times outside is unusual; most of these have a wrong power of ten.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tactgen.geometry.device.materials import EPS0, Piezoceramic
from tactgen.geometry.units import Unit

#: How far outside its range a value is asked about.
_UNUSUAL = 10.0
#: Powers of ten by which prefixes and units such as g/cm³ or N/mm² differ from SI.
_SLIPS = (3, -3, 6, -6, 9, -9, 12, -12)
#: Values of one constant from different sources agree to this fraction.
_LIKE = 0.15


class Expected(NamedTuple):
    """Range (SI) of a constant's magnitude."""

    low: float
    high: float
    of: str  #: Materials that it covers


_CERAMIC, _METAL, _GLUE = (
    "piezoelectric ceramics and polymers",
    "metals and composites",
    "adhesives",
)
#: By scene key.
EXPECTED = {
    "piezo.s11": Expected(8e-12, 4e-10, _CERAMIC),
    "piezo.s55": Expected(2e-11, 4e-9, _CERAMIC),
    "piezo.d31": Expected(5e-12, 5e-10, _CERAMIC),
    "piezo.eps33": Expected(8.0, 7000.0, _CERAMIC),
    "piezo.density": Expected(1700.0, 8200.0, _CERAMIC),
    "piezo.quality_factor": Expected(10.0, 3000.0, _CERAMIC),
    "shim.youngs_modulus": Expected(1e9, 4.2e11, _METAL),
    "shim.shear_modulus": Expected(3e8, 1.7e11, _METAL),
    "shim.density": Expected(1000.0, 20000.0, _METAL),
    "glue.youngs_modulus": Expected(1e5, 1e10, _GLUE),
    "glue.density": Expected(900.0, 3000.0, _GLUE),
    "rod.youngs_modulus": Expected(5e10, 2.5e11, "metals"),
    "rod.density": Expected(2500.0, 9000.0, "metals"),
    "coil.resistivity": Expected(1.5e-8, 1.5e-6, "conductors"),
    "coil.copper_density": Expected(2500.0, 9000.0, "conductors"),
}


def slip(key: str, value: float, unit: Unit | None) -> str:
    """Question about a value (SI) that lies far outside its expected range, "" of a usual one."""
    expected, size = EXPECTED.get(key), abs(value)
    if expected is None or size == 0.0:
        return ""
    low, high, materials = expected
    if low / _UNUSUAL <= size <= high * _UNUSUAL:
        return ""

    def text(number: float) -> str:
        return unit.show(number) if unit else f"{number:g}"

    factors = (10.0**power for power in _SLIPS)
    meant = next((value * factor for factor in factors if low <= size * factor <= high), None)
    question = f"; did you mean {text(meant)}?" if meant is not None else "; check its unit"
    return (
        f"{key} = {text(value)} is far outside the range of {materials}, {text(low)} to "
        f"{text(high)}{question}"
    )


def clamped_for_free(material: Piezoceramic, eps33: float) -> str:
    """Question about a permittivity that is the library's at constant strain, "" of another."""
    free = float(material.eps_t[2, 2]) / EPS0
    clamped_tensor = material.eps_t - material.d @ np.linalg.inv(material.s) @ material.d.T
    clamped = float(clamped_tensor[2, 2]) / EPS0
    if abs(eps33 / clamped - 1.0) > _LIKE or abs(eps33 / free - 1.0) < _LIKE:
        return ""
    return (
        f"piezo.eps33 = {eps33:g} is near {clamped:.0f}, the permittivity of {material.name} at "
        f"constant strain; piezo.eps33 is that at constant stress, {free:.0f}"
    )
