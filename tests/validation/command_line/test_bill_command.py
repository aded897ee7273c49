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


def test_the_screen_shows_the_same(capsys, device_and_display):
    """Each part with count, volume and mass; the narrowest gaps, all of them when asked."""
    device, display = device_and_display
    text, every = said(capsys), said(capsys, "--all")
    lines, gaps, leads = (f(device, display) for f in (bill_of_parts, clearances, wiring))
    assert text.startswith(
        f"display: 50 x 70 mm, {1e3 * levels(device, display).total:.4g} mm high, "
        f"{1e3 * total_mass(lines):.3g} g\n"
    )
    rows = {
        line.split()[0]: line.split() for line in text.split("\nclearance")[0].splitlines() if line
    }
    for line in lines:
        count, volume, mass = rows[line.name][1:4]
        assert int(count) == line.count
        assert float(volume) == pytest.approx(1e9 * line.volume, rel=1e-3)
        assert float(mass) == pytest.approx(1e6 * line.mass, rel=1e-3)
    shown = [gap for gap in gaps if f"{1e3 * gap.gap:8.3f}  {gap.key}" in text]
    assert shown == list(gaps[: len(shown)])
    assert f"{len(gaps) - len(shown)} wider ones with --all; no two parts overlap" in text
    assert all(f"{1e3 * gap.gap:8.3f}  {gap.key}" in every for gap in gaps)
    assert "--all" not in every
    assert (
        f"wiring: {'all leads have room' if leads.fits else 'LEADS HAVE NO ROOM'}\n"
        f"upper board: {leads.traces_needed} traces in each channel of "
        f"{1e3 * leads.channel:.2f} mm, {leads.traces_fit} fit "
        f"(enough for {leads.most_rows} rows); longest {1e3 * leads.trace_length:.0f} mm, "
        f"{1e12 * leads.trace_capacitance:.2g} pF to "
        f"its neighbour\ncoils: {leads.wires_needed} wires of {1e6 * leads.wire_diameter:.0f} um "
        f"in each gap of {1e3 * leads.wire_gap:.2f} mm between sleeves, {leads.wires_fit} fit\n"
    ) in text
