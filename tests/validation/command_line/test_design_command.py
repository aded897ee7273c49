"""``tactgen design`` as people and programs call it."""

import json

from tactgen.validation.command_line.cli import main


def test_units_and_overrides_reach_the_design(capsys, tmp_path):
    """The band takes Hz and kHz, the lengths any length; less voltage asks for a longer one."""
    plot = tmp_path / "a.svg"
    one = "--band", "50Hz:1kHz", "--lengths", "2.2cm:24mm", "--plot", str(plot)
    other = "--band", "50:1000", "--lengths", "0.022m:24mm", "--json"
    assert main(["design", *one]) == 0
    said = capsys.readouterr().out
    lengths = []
    for voltage in ("50V", "48V"):
        assert main(["design", *other, "--set", f"drive.voltage={voltage}"]) == 0
        lengths.append(json.loads(capsys.readouterr().out)["length"])
    assert f"over 50 to 1000 Hz is {1e3 * lengths[0]:.5g} mm" in said
    assert lengths[0] < lengths[1]
    text = plot.read_text(encoding="utf-8")
    assert text.startswith("<svg")
    assert text.rstrip().endswith("</svg>")
    assert list(tmp_path.iterdir()) == [plot]
