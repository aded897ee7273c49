"""Units at the edge: what is read, and every way of being refused."""

import contextlib
import math
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BeforeValidator, TypeAdapter, ValidationError

from tactgen.geometry import units as u
from tactgen.geometry.device.parameters import Bimorph

FREQUENCY = Annotated[float, BeforeValidator(u.FREQUENCY), u.FREQUENCY]
SCENE = {"units_required": True}


def read(kind, value, context=None):
    return TypeAdapter(kind).validate_python(value, context=context)


def refusal(kind, value, context=None):
    with pytest.raises(ValidationError) as caught:
        read(kind, value, context)
    return caught.value.errors()[0]["msg"]


@pytest.mark.parametrize(
    ("kind", "text", "si"),
    [
        (u.Length, "20mm", 20e-3),
        (u.Length, " 260 µm ", 260e-6),
        (u.Position, "-0.3 mm", -0.3e-3),
        (u.Compliance, "15.8e-12 m^2/N", 15.8e-12),
        (u.PiezoConstant, "-385 pm/V", -385e-12),
        (u.LateralStiffness, "3 N/um", 3e6),
        (u.RotationalInertia, "1 mg*mm^2", 1e-12),
        (u.Voltage, "-0.05 kV", -50.0),
        (u.Temperature, "20 degC", 293.15),
        (u.Duration, "10 min", 600.0),
        (FREQUENCY, "500 1/s", 500.0),
        (u.LossTangent, "3 %", 0.03),
    ],
)
def test_text_becomes_si(kind, text, si):
    """A number with a unit of the right dimension becomes the SI value.

    To the last bit where units differ by a power of ten, so that a scene that writes a
    default out in full is the same scene; one multiplication otherwise.
    """
    ulps = 2e-16 if kind is u.Duration else 0.0
    assert read(kind, text, SCENE) == pytest.approx(si, rel=ulps, abs=0.0)


@given(st.floats(min_value=1e-5, max_value=1.0))
def test_any_number_survives_its_text(value):
    """What Python prints is read back without loss when the unit is the SI unit."""
    assert read(u.Length, f"{value!r} m", SCENE) == value


def test_who_needs_a_unit():
    """A number of a scene and any text; no Python caller's float, library value or pure number."""
    for value in (0.02, 20, "20", " 20 "):
        assert "has no unit; a length needs one" in refusal(u.Length, value, SCENE)
    assert "has no unit" in refusal(u.Length, "20")
    assert Bimorph(length=0.014).length == 0.014
    assert read(FREQUENCY, 500) == 500.0
    assert read(u.QualityFactor, 60, SCENE) == 60.0
    assert read(u.Length, u.SI(0.02), SCENE) == 0.02


@pytest.mark.parametrize(
    ("kind", "text", "unit"),
    [
        (u.Length, "20 kg", "kg"),
        (u.QualityFactor, "60 mm", "mm"),
        (u.Length, "20 degC", "°C"),
        # taken for Hz they would be off by 2π
        (FREQUENCY, "628 rad/s", "rad"),
        (FREQUENCY, "60 rpm", "rpm"),
    ],
)
def test_wrong_dimension_is_refused(kind, text, unit):
    """A unit of another dimension is refused and named."""
    message = refusal(kind, text)
    assert "which is not a" in message
    assert unit in message


@pytest.mark.parametrize(
    "text",
    ["", "mm", "20,5 mm", "[1, 2] mm", "20 mm 3", "2*10 mm", "1/0 mm", "1 m + 1 s", "(((",
     "--20 mm", "1+1j m", "0x14 mm", "٣ mm", "\x00", "20 *", "1e99999 mm"],
)  # fmt: skip
def test_garbage_is_refused(text):
    """Whatever is not one number and one unit is refused; nothing is computed or dropped."""
    assert "write for example" in refusal(u.Length, text)


@given(st.text(max_size=12))
def test_any_text_is_read_or_refused(text):
    """No text makes the reader fail in another way than by a refusal."""
    with contextlib.suppress(ValidationError):
        assert math.isfinite(read(u.Length, text))


def test_what_is_no_number_is_refused():
    """Booleans, lists and other objects; not-a-number and infinity, as text and as float."""
    for value in (True, None, [20.0], {"value": 20}, object(), 1j):
        assert "is not a length" in refusal(u.Length, value)
    for value in ("nan mm", "-inf mm", "1e999 mm", math.nan, -math.inf):
        assert "must be a finite length" in refusal(u.Length, value)


@pytest.mark.parametrize(
    ("kind", "value", "words"),
    [
        (u.LayerThickness, "5 mm", "from 0.001 um to 1000 um"),
        (u.RelativePermittivity, 1.0, "greater than 1"),
        (u.PoissonRatio, 0.5, "less than 0.5"),
        (u.RelativeError, "100 %", "less than 1"),
        (u.SmallLength, "1e300 m", "must be from 1e-06 mm to 100000 mm"),
        (u.QualityFactor, 10**400, "must be a finite quality factor"),
        (u.LengthOrZero, "1e-300 m", "must be 0 or from 1e-06 mm to 100000 mm"),
        (u.Position, "-200 m", "must be 0 or a magnitude from 1e-06 mm to 100000 mm"),
        (u.Voltage, "1e9 V", "must be 0 or a magnitude from 1e-12 V to 1000000 V"),
    ],
)
def test_out_of_range_is_refused(kind, value, words):
    """What a quantity cannot have, or no device has, with the bound, before arithmetic overflows;
    the smallest magnitude is no bound for nothing at all."""
    assert words in refusal(kind, value, None if isinstance(value, float) else SCENE)
    if "must be 0 or" in words:
        assert read(kind, 0.0) == 0.0


def test_quoted_is_one_short_line():
    """Whatever was given can be repeated in a message."""
    assert u.quoted("a\nb\0") == r'"a\nb\x00"'
    assert len(u.quoted("x" * 5000)) == 60
    assert u.quoted(1 << 40000) == "this int"


def test_shown_values_read_back():
    """A value is shown in the unit people write it in, and that text is valid input."""
    unit = next(m for m in u.Length.__metadata__ if isinstance(m, u.Unit))
    for text in ("20 mm", "0.26 mm", "2.1 mm"):
        assert unit.show(read(u.Length, text)) == text


@pytest.mark.parametrize("name", u.BY_HEART)
def test_what_is_known_by_heart_is_what_pint_says(name, monkeypatch):
    """The same double with and without pint, and nothing is taken for another kind of quantity."""
    si, _ = u.BY_HEART[name]
    kinds = [u.Unit(si, "value", "1"), u.Unit("kg*m/s", "momentum", "1 kg*m/s")]
    for text in (f"0.96 {name}", f"-3.21e-5 {name}", f"7 {name}"):
        known = kinds[0].parse(text)
        with monkeypatch.context() as patch:
            patch.setattr(u, "BY_HEART", {})
            assert kinds[0].parse(text) == known
        with pytest.raises(ValueError, match="momentum"):
            kinds[1].parse(text)


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (u.Unit("kg/m**3", "density", "7800 kg/m^3"), "7.9 g/cm3", 7900.0),
        (u.Unit("ohm", "resistance", "1 kohm"), "35 kOhm", 35e3),
        (u.Unit("V*m/N", "voltage constant", "1 V*m/N"), "-11.9e-3 Vm/N", -11.9e-3),
        (u.Unit("m/s**2", "acceleration", "1 m/s^2"), "2.5 m/s2", 2.5),
        (u.Unit("1/Pa", "compliance", "1e-12 m^2/N"), "16.5 pm²/N", 16.5e-12),
    ],
)
def test_units_as_data_sheets_print_them(kind, text, value):
    assert kind.parse(text) == pytest.approx(value, rel=1e-12)
