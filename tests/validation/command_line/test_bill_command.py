"""``tactgen bill``: the library's numbers as JSON, and the same on the screen in people's units."""

import json
from dataclasses import asdict

import pytest

from tactgen.geometry.device.parameters import Device, Display
from tactgen.geometry.display.bill import bill_of_parts, total_mass, wiring
from tactgen.geometry.display.clearances import clearances
from tactgen.geometry.display.layout import levels
from tactgen.validation.command_line.cli import main
from tactgen.validation.scene.scene import load_scene


@pytest.fixture(scope="module")
def device_and_display() -> tuple[Device, Display]:
    scene = load_scene("display")[0]
    return scene.device, scene.display


def said(capsys, *options):
    assert main(["bill", *options]) == 0
    return capsys.readouterr().out


def test_json_holds_what_the_library_says(capsys, device_and_display):
    """SI units: sizes, parts, clearances, wiring."""
    device, display = device_and_display
    lines, leads = bill_of_parts(device, display), wiring(device, display)
    assert json.loads(said(capsys, "--json")) == {
        "scene": "display",
        "height": levels(device, display).total,
        "width": display.width,
        "length": display.length,
        "mass": total_mass(lines),
        "parts": [asdict(line) for line in lines],
        "clearances": [asdict(each) for each in clearances(device, display)],
        "wiring": {**asdict(leads), "fits": leads.fits},
    }
