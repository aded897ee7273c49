"""``tactgen design`` as people and programs call it."""

import json

from tactgen.validation.command_line.cli import main


def run(capsys, *arguments):
    """Return exit code, stdout and stderr of a call in this process."""
    code = main(["design", *arguments])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_units_at_the_edge(capsys):
    """The band takes Hz and kHz, the lengths any length."""
    one = run(capsys, "--band", "50Hz:0.5kHz", "--lengths", "2cm:40mm", "--json")
    other = run(capsys, "--band", "50:500", "--lengths", "0.02m:40mm", "--json")
    assert one == other
    assert one[0] == 0


def test_overrides_reach_the_design(capsys):
    """Half the voltage asks for a longer actuator."""
    lengths = [
        json.loads(run(capsys, "--json", *extra)[1])["length"]
        for extra in ([], ["--set", "drive.voltage=25V"])
    ]
    assert lengths[0] < lengths[1]


def test_plot_is_a_whole_svg(capsys, tmp_path):
    """One SVG element, the same bytes every time."""
    files = [tmp_path / "a.svg", tmp_path / "b.svg"]
    for file in files:
        assert run(capsys, "--lengths", "22mm:24mm", "--plot", str(file))[0] == 0
    text = files[0].read_text(encoding="utf-8")
    assert text.startswith("<svg")
    assert text.rstrip().endswith("</svg>")
    assert text == files[1].read_text(encoding="utf-8")
    assert sorted(tmp_path.iterdir()) == files
