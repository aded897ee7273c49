"""``tactgen bill``: the library's numbers as JSON."""

import json
from dataclasses import asdict

from tactgen.geometry.display.bill import bill_of_parts, total_mass, wiring
from tactgen.geometry.display.clearances import clearances
from tactgen.geometry.display.layout import levels
from tactgen.validation.command_line.cli import main
from tactgen.validation.scene.load import load_scene


def test_json_holds_what_the_library_says(capsys):
    """SI units: sizes, parts, clearances, wiring."""
    scene, _ = load_scene("display")
    device, display = scene.device, scene.display
    lines, leads = bill_of_parts(device, display), wiring(device, display)
    assert main(["bill", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "scene": "display",
        "height": levels(device, display).total,
        "width": display.width,
        "length": display.length,
        "mass": total_mass(lines),
        "parts": [asdict(line) for line in lines],
        "clearances": [asdict(each) for each in clearances(device, display)],
        "wiring": {**asdict(leads), "fits": leads.fits},
    }
