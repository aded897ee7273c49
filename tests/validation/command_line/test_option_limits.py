"""Options that take a number: both ends of their ranges are taken, what lies beyond is refused."""

from functools import partial

import pytest

from tactgen.geometry.errors import InputError
from tactgen.geometry.units import VOLTAGE
from tactgen.validation.command_line.commands import backbone, positions, simulate
from tactgen.validation.command_line.commands.common import low_high, values_of
from tactgen.validation.command_line.study_options import whole_number
from tactgen.validation.studies.waveform_text import AMPERES, VOLTS, parsed
from tactgen.validation.studies.whatif.axes import scene_field

#: By name, what reads the option, what it takes and with what result, and what it refuses.
OPTIONS = {
    "--until": (
        simulate._until, {"1 us": 1e-6, "10 s": 10.0}, ("0.995 us", "10.05 s", "3", "nan s"),
    ),
    "--accuracy": (
        simulate._accuracy, {"1e-6": 1e-6, "0.5": 0.5}, ("0.995e-6", "0.505", "nan", "fine"),
    ),
    "--voltage of backbone": (
        partial(values_of, option="--voltage", unit=VOLTAGE, example="1", most=100),
        {"1:3:2": [1.0, 3.0], "1:4:3:log": [1.0, 2.0, 4.0], "1:3:3:lin": [1.0, 2.0, 3.0],
         "2,0.5 V": [2.0, 0.5]},
        ("1:2:1", "1:2:101", "1:2", "1:2:3:log:4", "1:2:3:cubic", "0:2:3", "-1", "1 A"),
    ),
    "--frequency of backbone": (
        backbone._band, {"100:200": [100.0, 200.0], "0.1 kHz:200 Hz": [100.0, 200.0]},
        ("200:100", "100:100", "0:100", "100", "100:", ":100"),
    ),
    "--current": (
        positions._currents, {"0:1 A:2": [0.0, 1.0], "20 mA:60 mA:3": [0.02, 0.04, 0.06]},
        ("0:1A:1", "0:1A:10001", "1A:1A:3", "2A:1A:3", "0:1:3", "-1mA:1A:3", "0:1A", "0:1A:3:4"),
    ),
    "--sample": (
        partial(whole_number, option="--sample", least=1, most=30, example="2"),
        {"1": 1, "30": 30}, ("0", "31", "1.5", "-2", "", "100000000000"),
    ),
    "--band": (
        partial(low_high, option="--band", example="10:1000"), {"10 : 20": ["10", "20"]},
        ("10", "10:", ":20", "1:2:3"),
    ),
    "--lengths": (
        partial(scene_field("bimorph.length").read, where="--lengths"), {"20 mm": 0.02},
        ("20", "0 mm", "20 s"),
    ),
    "--coil": (
        lambda text: vars(parsed(text, "--coil", (AMPERES, VOLTS)).waveform),
        {"2 V step": {"level": 2.0, "start": 0.0, "stop": float("inf")},
         "1 mA square 100 Hz": {"high": 1e-3, "frequency": 100.0, "low": 0.0, "duty": 0.5,
                                "start": 0.0}},
        ("1 V step at 2 ms until 2 ms", "1 V square 100 Hz duty 1", "1 V square 100 Hz duty 0",
         "1 V sine 1 mHz phase 1", "1e-10 V", "1e6 V", "1 V sine 0 Hz", "1 V step at -1 ms"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("option", OPTIONS)
def test_ends_are_taken_and_no_more(option):
    read, taken, refused = OPTIONS[option]
    for text, value in taken.items():
        found = read(text)
        assert (list(found) if isinstance(value, list) else found) == pytest.approx(value), text
    for text in refused:
        with pytest.raises(InputError):
            pytest.fail(f"{text} was taken as {read(text)}")
