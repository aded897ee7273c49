"""Numbers with a tolerance, as drawings and data sheets write them."""

import re

import pytest

from tactgen.geometry.units import Unit
from tactgen.validation.scene.tolerances import has_tolerance, read_tolerance

LENGTH = Unit("m", "length", "0.2 mm", above=0.0, limits=(1e-9, 1.0), shown="mm")
Q = Unit("", "quality factor", "60", above=0.0, limits=(0.1, 1e9))
TEMPERATURE = Unit("K", "temperature", "20 degC", above=0.0, limits=(1.0, 2000.0))
HEAT = Unit("W/(m**2*K)", "heat transfer coefficient", "25 W/(m^2*K)", above=0.0)


@pytest.mark.parametrize(
    ("text", "unit", "low", "high", "value"),
    [
        ("0.20 ± 0.01 mm", LENGTH, 0.19e-3, 0.21e-3, "0.20 mm"),
        ("0.20 mm +/- 10um", LENGTH, 0.19e-3, 0.21e-3, "0.20 mm"),
        ("0.20mm±5%", LENGTH, 0.19e-3, 0.21e-3, "0.20 mm"),
        ("0.20 mm ± 0 mm", LENGTH, 0.2e-3, 0.2e-3, "0.20 mm"),
        ("0.20 (0.18..0.22) mm", LENGTH, 0.18e-3, 0.22e-3, "0.20 mm"),
        ("0.20 mm (180 um..0.22)", LENGTH, 0.18e-3, 0.22e-3, "0.20 mm"),
        ("60 +- 2e1", Q, 40.0, 80.0, "60"),
        ("20 ± 2 degC", TEMPERATURE, 291.15, 295.15, "20 degC"),
        ("20 degC ± 2 K", TEMPERATURE, 291.15, 295.15, "20 degC"),
        ("25 W/(m^2*K) (20 W/(m^2*K)..30 W/(m^2*K))", HEAT, 20.0, 30.0, "25 W/(m^2*K)"),
    ],
)
def test_what_is_written_is_what_is_meant(text, unit, low, high, value):
    """Units may stand once or with each number; of temperatures a difference is in degrees."""
    assert has_tolerance(text)
    found = read_tolerance(text, unit)
    # sums and differences of what was written, to rounding
    assert (found.low, found.high) == pytest.approx((low, high), rel=1e-14)
    assert found.text == value


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        ("0.2 ± 0.01", LENGTH, "has no unit"),
        ("0.2 mm ± 1 V", LENGTH, "not a length"),
        ("0.2 ± 0.3 mm", LENGTH, 'reaches "-0.1 mm", which must be greater than 0 mm; narrow it'),
        ("0.2 ± -0.1 mm", LENGTH, "negative tolerance"),
        ("0.2 mm ±", LENGTH, 'cannot be read; write for example "0.2 mm ± 5 %"'),
        ("0.2 mm (0.3..0.4)", LENGTH, "in which 0.2 mm does not lie"),
        ("60 ± nan", Q, "finite"),
        ("0 mm ± 5 %", Unit("m", "length", "2 mm", at_least=0.0), "percent of 0"),
    ],
)
def test_wrong_forms_are_refused_with_a_remedy(text, unit, words):
    """In half a sentence that follows the text."""
    with pytest.raises(ValueError, match=re.escape(words)):
        read_tolerance(text, unit)


def test_plain_numbers_have_none():
    """Nor has a path with two points in a row, nor a text of any length."""
    for text in ("0.2 mm", "../steel.csv", "25 W/(m^2*K)", "(" * 100_000 + ".."):
        assert not has_tolerance(text)
