"""Units at the edge: text such as ``"20 mm"`` becomes an SI float, or a clear refusal.

Python callers may pass plain floats, which are SI.  A scene (validated with the
context ``{"units_required": True}``) must write the unit of everything that has one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, ValidationInfo

if TYPE_CHECKING:
    import pint


class SI(float):
    """A number known to be in SI units already, such as a library value."""


@cache
def _registry() -> pint.UnitRegistry[Any]:
    import pint  # costs 0.2 s with its definitions: only when text has to be read

    return pint.UnitRegistry()


@dataclass(frozen=True)
class Unit:
    """One kind of physical quantity: its SI unit, and what a scene may write for it.

    Parameters
    ----------
    si : str
        SI unit, as pint reads it (``""`` for a pure number).
    kind : str
        The word used in messages, e.g. ``"length"``.
    example : str
        A value that would be accepted, used in messages.
    above, at_least, below : float or None
        Bounds in SI units.
    """

    si: str
    kind: str
    example: str
    above: float | None = None
    at_least: float | None = None
    below: float | None = None

    def __call__(self, value: Any, info: ValidationInfo) -> float:
        """Return `value` in SI units.

        Raises
        ------
        ValueError
            With a sentence that names the remedy.
        """
        if isinstance(value, str):
            number = self._parse(value)
        elif isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f'is not a {self.kind}; write for example "{self.example}"')
        else:
            strict = (info.context or {}).get("units_required") and not isinstance(value, SI)
            if self.si and strict:
                raise ValueError(
                    f'has no unit; a {self.kind} needs one, for example "{self.example}"'
                )
            number = float(value)
        return self._in_range(number)

    def _parse(self, text: str) -> float:
        import pint

        registry = _registry()
        try:
            quantity = registry.Quantity(text)
            magnitude = float(quantity.magnitude)
        except pint.UndefinedUnitError as error:
            names = " ".join(str(name) for name in error.unit_names)
            raise ValueError(
                f'has the unknown unit "{names}"; write for example "{self.example}"'
            ) from None
        except Exception:
            # pint's parser raises whatever Python's tokenizer does on malformed text
            raise ValueError(
                f'cannot be read as a {self.kind}; write for example "{self.example}"'
            ) from None
        if quantity.unitless and self.si and not quantity.is_compatible_with(self.si):
            raise ValueError(f'has no unit; a {self.kind} needs one, for example "{self.example}"')
        if quantity.unitless and self.si == "rad":
            return magnitude
        if not quantity.is_compatible_with(self.si):
            raise ValueError(
                f'has the unit "{quantity.units:~}", which is not a {self.kind}; '
                f'write for example "{self.example}"'
            )
        return float(quantity.to(self.si).magnitude)

    def _in_range(self, number: float) -> float:
        unit = f" {self.si}" if self.si else ""
        remedy = f'; write for example "{self.example}"'
        if not math.isfinite(number):
            raise ValueError(f"must be a finite {self.kind}{remedy}")
        if self.above is not None and number <= self.above:
            raise ValueError(f"must be greater than {self.above:g}{unit}{remedy}")
        if self.at_least is not None and number < self.at_least:
            raise ValueError(f"must be at least {self.at_least:g}{unit}{remedy}")
        if self.below is not None and number >= self.below:
            raise ValueError(f"must be less than {self.below:g}{unit}{remedy}")
        return number


def _quantity(unit: Unit) -> Any:
    return Annotated[float, BeforeValidator(unit), unit]


Length = _quantity(Unit("m", "length", "20 mm", above=0.0))
LengthOrZero = _quantity(Unit("m", "length", "20 mm", at_least=0.0))
Position = _quantity(Unit("m", "position", "0.3 mm"))
Density = _quantity(Unit("kg/m**3", "density", "7900 kg/m^3", above=0.0))
Modulus = _quantity(Unit("Pa", "modulus", "140 GPa", above=0.0))
Compliance = _quantity(Unit("1/Pa", "elastic compliance", "15.8e-12 m^2/N", above=0.0))
PiezoConstant = _quantity(Unit("m/V", "piezoelectric constant", "-385 pC/N"))
RotationalStiffness = _quantity(
    Unit("N*m/rad", "rotational stiffness", "0.24 N*m/rad", at_least=0.0)
)
LateralStiffness = _quantity(Unit("N/m", "stiffness", "3e6 N/m", at_least=0.0))
RotationalDamping = _quantity(
    Unit("N*m*s/rad", "rotational damping", "4.46e-6 N*m*s/rad", at_least=0.0)
)
LateralDamping = _quantity(Unit("N*s/m", "damping coefficient", "0.5 N*s/m", at_least=0.0))
RotationalInertia = _quantity(Unit("kg*m**2", "rotational inertia", "1e-12 kg*m^2", at_least=0.0))
Mass = _quantity(Unit("kg", "mass", "10 mg", at_least=0.0))
Voltage = _quantity(Unit("V", "voltage", "50 V"))
Current = _quantity(Unit("A", "current", "130 mA"))
Duration = _quantity(Unit("s", "time", "600 s", above=0.0))
Frequency = _quantity(Unit("Hz", "frequency", "500 Hz", at_least=0.0))
RelativePermittivity = _quantity(Unit("", "relative permittivity", "6000", above=1.0))
QualityFactor = _quantity(Unit("", "quality factor", "60", above=0.0))
LossTangent = _quantity(Unit("", "loss tangent", "0.03", at_least=0.0))
PoissonRatio = _quantity(Unit("", "Poisson ratio", "0.3", above=-1.0, below=0.5))
PositiveNumber = _quantity(Unit("", "number", "0.8333", above=0.0))
RelativeError = _quantity(Unit("", "relative accuracy", "1e-3", above=0.0, below=1.0))
