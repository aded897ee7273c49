"""Units at the edge: text such as ``"20 mm"`` becomes an SI float, or a clear refusal.

Python callers may pass plain floats, which are SI.  A scene (validated with the
context ``{"units_required": True}``) must write the unit of everything that has one.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, ValidationInfo

if TYPE_CHECKING:
    import pint

#: A number as scenes write it, without its unit.
NUMBER = r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d{1,4})?|nan|inf)"
_NUMBER_AND_UNIT = re.compile(
    rf"\s*(?P<number>{NUMBER})"
    r"(?P<unit>(?:\s+1\s*/|\s*[^\s\d.,;=\[\]{}])[^,;=\[\]{}]*)?\s*",
    re.IGNORECASE | re.ASCII,
)


#: What scenes write most, as SI unit and power of ten: known by heart, since pint and its
#: definitions take longer to load than a closed form takes to answer.
BY_HEART = {
    "": ("", 0), "%": ("", -2), "m": ("m", 0), "mm": ("m", -3), "um": ("m", -6), "µm": ("m", -6),
    "nm": ("m", -9), "V": ("V", 0), "mV": ("V", -3), "kV": ("V", 3), "A": ("A", 0),
    "mA": ("A", -3), "N": ("N", 0), "mN": ("N", -3), "Hz": ("Hz", 0), "kHz": ("Hz", 3),
    "s": ("s", 0), "ms": ("s", -3), "us": ("s", -6), "Pa": ("Pa", 0), "MPa": ("Pa", 6),
    "GPa": ("Pa", 9), "kg": ("kg", 0), "g": ("kg", -3), "mg": ("kg", -6),
    "kg/m^3": ("kg/m**3", 0), "N/m": ("N/m", 0), "N*s/m": ("N*s/m", 0),
    "N*m/rad": ("N*m/rad", 0), "N*m*s/rad": ("N*m*s/rad", 0), "kg*m^2": ("kg*m**2", 0),
    "pC/N": ("m/V", -12), "m^2/N": ("1/Pa", 0), "ohm": ("ohm", 0), "ohm*m": ("ohm*m", 0),
    "kohm": ("ohm", 3), "Mohm": ("ohm", 6), "m/s^2": ("m/s**2", 0), "F": ("F", 0), "uF": ("F", -6),
    "nF": ("F", -9), "pF": ("F", -12), "H": ("H", 0), "mH": ("H", -3), "T": ("T", 0),
    "A/m": ("A/m", 0), "kV/mm": ("V/m", 6), "mm/kV": ("m/V", -6),
    "C/m^2": ("C/m**2", 0), "V*m/N": ("V*m/N", 0),
}  # fmt: skip

#: Units that data sheets mean otherwise than they are defined: no picometre is squared.
_MEANT = {"pm^2/N": ("1/Pa", -12)}

#: Units as data sheets print them, and as they are written here.
AS_PRINTED = {
    "Ohm": "ohm", "kOhm": "kohm", "MOhm": "Mohm", "g/cm3": "g/cm^3", "kg/m3": "kg/m^3",
    "m/s2": "m/s^2", "m2/N": "m^2/N", "m²/N": "m^2/N",
    "pm2/N": "pm^2/N", "pm²/N": "pm^2/N", "Vm/N": "V*m/N", "Nm/rad": "N*m/rad", "Ns/m": "N*s/m",
}  # fmt: skip

#: How the size of a sinusoid is stated, each with the peak amplitude per its number.
AMPLITUDES = {"peak": 1.0, "pp": 0.5, "rms": math.sqrt(2.0)}
_STATED_AS = re.compile(rf"(?P<unit>.*?)\s*(?P<way>{'|'.join(AMPLITUDES)})", re.ASCII)

#: Longest piece of input that a message repeats.
_LONGEST = 60


def quoted(value: Any) -> str:
    """Refused value as a message repeats it: on one line and not too long."""
    try:
        text = f'"{value}"' if isinstance(value, str) else str(value)
    except (ValueError, RecursionError):  # Python does not write out integers of any length
        text = f"this {type(value).__name__}"
    plain = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
    return plain if len(plain) <= _LONGEST else f"{plain[: _LONGEST - 1]}…"


class SI(float):
    """A number known to be in SI units already, such as a library value."""


class OutOfRange(ValueError):
    """Error in an SI number, to follow it in a sentence; `shown` is it with its unit."""

    def __init__(self, what: str, shown: str) -> None:
        super().__init__(what)
        self.shown = shown


@cache
def unit_registry() -> pint.UnitRegistry[Any]:
    """One registry of units."""
    import pint  # costs 0.2 s with its definitions: only when text has to be read

    return pint.UnitRegistry()


@dataclass(frozen=True)
class Unit:
    """Kind of physical quantity: its SI unit, accepted texts and range."""

    si: str  #: SI unit, as pint reads it (``""`` for a pure number)
    kind: str  #: The word used in messages, e.g. ``"length"``
    example: str  #: A value that would be accepted, used in messages
    #: Bounds that the quantity has by its nature, in SI units
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    #: Smallest and largest magnitude that can be meant here, in SI units, far beyond any real
    #: device; a value of 0 is judged by the other bounds alone
    limits: tuple[float, float] | None = None
    shown: str = ""  #: Unit in which values are shown to people, one of `BY_HEART` or ``deg``
    #: Whether it is the amplitude of a sinusoid: the unit may be followed by ``peak``, ``pp`` (peak
    #: to peak) or ``rms``, and the value is the peak
    sinusoid: bool = False

    @property
    def a_kind(self) -> str:
        """Kind with its article."""
        return f"{'an' if self.kind[0] in 'aeiou' else 'a'} {self.kind}"

    @property
    def per_si(self) -> float:
        """Number of units that people see in one SI unit."""
        if self.shown == "deg":
            return 180.0 / math.pi
        return float(f"1e{-BY_HEART[self.shown][1]}")

    def show(self, value: float) -> str:
        """SI value as text in the unit that people write it in."""
        unit = self.shown or self.si
        return f"{value * self.per_si:.10g} {unit}".rstrip()

    def __call__(self, value: Any, info: ValidationInfo) -> float:
        """`value` in SI units.

        Raises ValueError with a sentence that names the remedy.
        """
        if isinstance(value, str):
            number = self.parse(value)
        elif isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f'is not {self.a_kind}; write for example "{self.example}"')
        else:
            strict = (info.context or {}).get("units_required") and not isinstance(value, SI)
            if self.si and strict:
                raise ValueError(
                    f'has no unit; {self.a_kind} needs one, for example "{self.example}"'
                )
            try:
                number = float(value)
            except OverflowError:
                number = math.inf
        # limiting cases, such as no shear or no shim, are open to Python callers
        try:
            return self._in_range(number, limited=bool((info.context or {}).get("units_required")))
        except ValueError as error:
            if isinstance(value, SI):
                raise OutOfRange(str(error), self.show(number)) from None
            raise

    def parse(self, text: str, *, bare: bool = False) -> float:
        """SI value of a text; `bare` takes a number without a unit for SI.

        Raises ValueError with a sentence that names the remedy.
        """
        unreadable = f'cannot be read as {self.a_kind}; write for example "{self.example}"'
        if "±" in text or "+/-" in text:
            raise ValueError(
                f'has a tolerance, and none is read here; write for example "{self.example}"'
            )
        # one number, one unit: pint by itself also computes, drops commas and multiplies lists
        parts = _NUMBER_AND_UNIT.fullmatch(text)
        if parts is None:
            raise ValueError(unreadable)
        number, name = Decimal(parts["number"]), (parts["unit"] or "").strip()
        name = AS_PRINTED.get(name, name)
        if not name and bare:
            return float(number)
        stated = _STATED_AS.fullmatch(name) if self.sinusoid else None
        if stated:
            return AMPLITUDES[stated["way"]] * self.parse(f"{number} {stated['unit']}")
        if name == "g" and self.si == "m/s**2":  # of accelerations, and not of masses
            name = "standard_gravity"
        if not name and self.si:
            raise ValueError(f'has no unit; {self.a_kind} needs one, for example "{self.example}"')
        si, power = BY_HEART.get(name) or _MEANT.get(name, ("unknown", 0))
        if si == self.si:
            return float(number.scaleb(power))
        import pint

        registry = unit_registry()
        try:
            unit = registry.parse_units(f"1{name}" if name.startswith("/") else name)
        except pint.UndefinedUnitError as error:
            names = quoted(" ".join(str(unknown) for unknown in error.unit_names))
            raise ValueError(
                f'has the unknown unit {names}; write for example "{self.example}"'
            ) from None
        except Exception:  # noqa: BLE001
            # pint's parser raises whatever Python's tokenizer does on malformed text
            raise ValueError(unreadable) from None
        # radians count as a pure number; without this, rad/s and rpm would pass as Hz
        angle = "radian" in str(registry.get_root_units(unit)[1]) and "rad" not in self.si
        if angle or not unit.is_compatible_with(self.si):
            raise ValueError(
                f'has the unit "{unit:~}", which is not {self.a_kind}; '
                f'write for example "{self.example}"'
            )
        zero = float(registry.convert(0.0, unit, self.si))
        if zero:  # degrees Celsius
            return float(registry.convert(float(number), unit, self.si))
        scale = float(registry.convert(1.0, unit, self.si))
        power = round(math.log10(scale))
        if math.isclose(scale, 10.0**power, rel_tol=1e-12):
            # shift the decimal point of the text: "0.96 mm" is the same double as 0.96e-3
            return float(number.scaleb(power))
        return float(number) * scale

    def check(self, number: float) -> None:
        """Refuse a number (SI) that a scene cannot have; ValueError as from a call."""
        self._in_range(number, limited=True)

    def _in_range(self, number: float, *, limited: bool) -> float:
        remedy = f'; write for example "{self.example}"'
        if not math.isfinite(number):
            raise ValueError(f"must be a finite {self.kind}{remedy}")
        if self.above is not None and number <= self.above:
            raise ValueError(f"must be greater than {self.show(self.above)}{remedy}")
        if self.at_least is not None and number < self.at_least:
            raise ValueError(f"must be at least {self.show(self.at_least)}{remedy}")
        if self.below is not None and number >= self.below:
            raise ValueError(f"must be less than {self.show(self.below)}{remedy}")
        least, most = self.limits or (0.0, math.inf)
        if limited and number and not least <= abs(number) <= most:
            zero_too = (self.above is None or self.above < 0.0) and (self.at_least or 0.0) <= 0.0
            zero = "0 or " if zero_too else ""
            size = "a magnitude " if self.at_least is None and self.above is None else ""
            low, high = self.show(least), self.show(most)
            raise ValueError(f"must be {zero}{size}from {low} to {high}{remedy}")
        return number


def quantity(unit: Unit) -> Any:
    """Annotation of a number of a kind."""
    return Annotated[float, BeforeValidator(unit), unit]


#: Sizes that a part can have: from a film of ten nanometres to a metre.
_SIZES = (1e-9, 100.0)

Length = quantity(Unit("m", "length", "20 mm", above=0.0, limits=(1e-6, 100.0), shown="mm"))
SmallLength = quantity(Unit("m", "length", "0.2 mm", above=0.0, limits=_SIZES, shown="mm"))
LengthOrZero = quantity(Unit("m", "length", "2 mm", at_least=0.0, limits=_SIZES, shown="mm"))
#: Glue between layers: no thicker than the layers of the thickest bimorphs.
LayerThickness = quantity(
    Unit("m", "thickness of glue", "20 um", at_least=0.0, limits=(1e-9, 1e-3), shown="um")
)
#: Over which the pressure of rough surfaces changes: from a polished to a blasted one.
RoughnessLength = quantity(
    Unit("m", "length of roughness", "0.3 um", above=0.0, limits=(1e-10, 1e-3), shown="um")
)
Position = quantity(Unit("m", "position", "0.3 mm", limits=_SIZES, shown="mm"))
Density = quantity(
    Unit("kg/m**3", "density", "7900 kg/m^3", above=0.0, limits=(1.0, 1e5), shown="kg/m^3")
)
Modulus = quantity(Unit("Pa", "modulus", "140 GPa", above=0.0, limits=(1e4, 1e13), shown="GPa"))
Compliance = quantity(
    Unit("1/Pa", "elastic compliance", "15.8e-12 m^2/N", above=0.0, limits=(1e-13, 1e-4),
         shown="m^2/N")
)  # fmt: skip
PiezoConstant = quantity(
    Unit("m/V", "piezoelectric constant", "-385 pC/N", limits=(1e-18, 1e-6), shown="pC/N")
)
Stress = quantity(Unit("Pa", "stress", "28 MPa", above=0.0, limits=(1.0, 1e12), shown="MPa"))
ElectricField = quantity(
    Unit("V/m", "electric field", "0.4 kV/mm", above=0.0, limits=(1.0, 1e12), shown="kV/mm")
)
HeatTransfer = quantity(
    Unit("W/(m**2*K)", "heat transfer coefficient", "25 W/(m^2*K)", above=0.0, limits=(1e-3, 1e6))
)
RotationalStiffness = quantity(
    Unit("N*m/rad", "rotational stiffness", "0.24 N*m/rad", at_least=0.0, limits=(1e-12, 1e9))
)
LateralStiffness = quantity(Unit("N/m", "stiffness", "3e6 N/m", at_least=0.0, limits=(1e-6, 1e15)))
RotationalDamping = quantity(
    Unit("N*m*s/rad", "rotational damping", "4.46e-6 N*m*s/rad", at_least=0.0, limits=(1e-18, 1e3))
)
LateralDamping = quantity(
    Unit("N*s/m", "damping coefficient", "0.5 N*s/m", at_least=0.0, limits=(1e-12, 1e9))
)
RotationalInertia = quantity(
    Unit("kg*m**2", "rotational inertia", "1e-12 kg*m^2", at_least=0.0, limits=(1e-24, 1.0),
         shown="kg*m^2")
)  # fmt: skip
Mass = quantity(Unit("kg", "mass", "10 mg", at_least=0.0, limits=(1e-15, 1e3), shown="mg"))
VOLTAGE = Unit("V", "voltage", "50 V", limits=(1e-12, 1e6), sinusoid=True)
Voltage = quantity(VOLTAGE)
CURRENT = Unit("A", "current", "130 mA", limits=(1e-12, 1e4), shown="mA")
Current = quantity(CURRENT)
Force = quantity(Unit("N", "force", "110 mN", at_least=0.0, limits=(1e-9, 1e4), shown="mN"))
ForceAmplitude = quantity(Unit("N", "force", "1 N", limits=(1e-12, 1e6), sinusoid=True))
Acceleration = quantity(
    Unit("m/s**2", "acceleration", "1 g", limits=(1e-9, 1e7), shown="m/s^2", sinusoid=True)
)
Capacitance = quantity(
    Unit("F", "capacitance", "10 nF", at_least=0.0, limits=(1e-18, 1e3), shown="nF")
)
Inductance = quantity(
    Unit("H", "inductance", "10 mH", at_least=0.0, limits=(1e-12, 1e9), shown="mH")
)
ElectricalResistance = quantity(
    Unit("ohm", "resistance", "100 kohm", at_least=0.0, limits=(1e-9, 1e15))
)
Resistivity = quantity(
    Unit("ohm*m", "resistivity", "1.72e-8 ohm*m", above=0.0, limits=(1e-9, 1e-4))
)
Temperature = quantity(Unit("K", "temperature", "20 degC", above=0.0, limits=(1.0, 2000.0)))
FillFactor = quantity(Unit("", "share", "0.5", above=0.0, below=1.0))
Duration = quantity(Unit("s", "time", "600 s", above=0.0, limits=(0.1, 1e6)))
RelaxationTime = quantity(
    Unit("s", "relaxation time", "20 us", at_least=0.0, limits=(1e-12, 1.0), shown="us")
)
Resistance = quantity(Unit("ohm", "resistance", "10 ohm", at_least=0.0, limits=(1e-9, 1e9)))
#: Mechanical impedance: force per velocity.
IMPEDANCE = Unit("N*s/m", "mechanical impedance", "0.5 N s/m", limits=(0.0, 1e9))
#: Force per displacement, of either sign: a mass pulls.
DYNAMIC_STIFFNESS = Unit("N/m", "dynamic stiffness", "300 N/m", limits=(0.0, 1e15))
#: Moment per rotation, of either sign.
DYNAMIC_ROTATION = Unit(
    "N*m/rad", "dynamic rotational stiffness", "0.24 N m/rad", limits=(0.0, 1e12)
)
#: Of a motion that is felt: from below what anyone feels to what hurts.
AMPLITUDE = Unit("m", "displacement", "2 um", above=0.0, limits=(1e-12, 1.0))
PHASE = Unit("rad", "phase", "30 deg", limits=(0.0, 1e4))
Angle = quantity(Unit("rad", "angle", "45 deg", limits=(1e-6, 10.0), shown="deg"))
#: Up to where waves in the device are shorter than 0.1 mm.
FREQUENCY = Unit("Hz", "frequency", "500 Hz", at_least=0.0, limits=(1e-6, 1e7))
RelativePermittivity = quantity(
    Unit("", "relative permittivity", "6000", above=1.0, limits=(1.0, 1e7))
)
RelativePermeability = quantity(
    Unit("", "relative permeability", "1000", at_least=1.0, limits=(1.0, 1e7))
)
Turns = quantity(Unit("", "number of turns", "560", at_least=1.0, limits=(1.0, 1e6)))
QualityFactor = quantity(Unit("", "quality factor", "60", above=0.0, limits=(0.1, 1e9)))
#: Relative growth of a constant per amplitude of the electric field.
FieldGrowth = quantity(
    Unit("m/V", "growth per electric field", "2 mm/kV", at_least=0.0, limits=(1e-12, 1e-3),
         shown="mm/kV")
)  # fmt: skip
LossTangent = quantity(Unit("", "loss tangent", "0.03", at_least=0.0, limits=(1e-12, 10.0)))
LossFactor = quantity(Unit("", "loss factor", "0.02", at_least=0.0, limits=(1e-9, 2.0)))
PoissonRatio = quantity(Unit("", "Poisson ratio", "0.3", above=-1.0, below=0.5))
PositiveNumber = quantity(Unit("", "number", "0.8333", above=0.0, limits=(1e-3, 1e3)))
RelativeScatter = quantity(
    Unit("", "relative scatter", "0.02", at_least=0.0, below=0.3, limits=(1e-9, 0.3))
)
RelativeError = quantity(
    Unit("", "relative accuracy", "1e-3", above=0.0, below=1.0, limits=(1e-9, 1.0))
)


@dataclass(frozen=True)
class WholeNumber:
    """A validator of whole numbers in a range, with a remedy in its refusal."""

    least: int
    most: int
    example: str

    def __call__(self, value: Any) -> int:
        """`value` as an integer.

        Raises ValueError with a sentence that names the range.
        """
        text = str(value).strip() if isinstance(value, str | int | float) else ""
        # 3.0 is what some programs write for 3
        found = re.fullmatch(r"([+-]?[0-9]{1,9})(\.0*)?", text)
        number = int(found[1]) if found else self.least - 1
        if not self.least <= number <= self.most:
            raise ValueError(
                f"is not a whole number from {self.least} to {self.most}; "
                f"write for example {self.example}"
            )
        return number
