"""``tactgen bill``: the display's parts, clearances and room for its leads."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from tactgen.validation.command_line.commands.common import Commands, scene_options
from tactgen.validation.command_line.streams import print_json

if TYPE_CHECKING:
    from tactgen.validation.scene.scene import Scene

#: Clearances that are shown without --all.
_SHOWN = 12


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("bill", help="parts, masses, clearances and wiring of the display")
    scene_options(parser, default="display")
    parser.add_argument(
        "--all", action="store_true", help="list all clearances, not the narrowest only"
    )
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.geometry.display.clearances import check_display
    from tactgen.validation.scene.load import load_scene

    scene, _ = load_scene(options.scene, options.overrides)
    check_display(scene.device, scene.display)
    found = _found(scene)
    if options.json:
        print_json(found)
    else:
        _show(found, None if options.all else _SHOWN)
    return 0


def _found(scene: Scene) -> dict[str, Any]:
    """Everything as plain values in SI units."""
    from dataclasses import asdict

    from tactgen.geometry.display.bill import bill_of_parts, total_mass, wiring
    from tactgen.geometry.display.clearances import clearances
    from tactgen.geometry.display.layout import levels

    device, display = scene.device, scene.display
    lines, leads = bill_of_parts(device, display), wiring(device, display)
    return {
        "scene": scene.name,
        "height": levels(device, display).total,
        "width": display.width,
        "length": display.length,
        "mass": total_mass(lines),
        "parts": [asdict(line) for line in lines],
        "clearances": [asdict(clearance) for clearance in clearances(device, display)],
        "wiring": {**asdict(leads), "fits": leads.fits},
    }


def _show(found: dict[str, Any], most: int | None) -> None:
    mm = 1e3
    print(
        f"{found['scene']}: {mm * found['width']:g} x {mm * found['length']:g} mm, "
        f"{mm * found['height']:.4g} mm high, {1e3 * found['mass']:.3g} g\n"
    )
    print(f"{'part':18} {'count':>5} {'volume mm^3':>12} {'mass mg':>9}  material")
    for line in found["parts"]:
        print(
            f"{line['name']:18} {line['count']:5d} {1e9 * line['volume']:12.4g} "
            f"{1e6 * line['mass']:9.4g}  {line['material']}"
        )
    print(f"\n{'clearance':32} {'where':26} {'mm':>8}  changed by")
    for row in found["clearances"][:most]:
        print(f"{row['between']:32} {row['where']:26} {mm * row['gap']:8.3f}  {row['key']}")
    left = len(found["clearances"]) - (most or len(found["clearances"]))
    if left > 0:
        print(f"{left} wider ones with --all; no two parts overlap")
    _show_leads(found["wiring"])


def _show_leads(leads: dict[str, Any]) -> None:
    verdict = "all leads have room" if leads["fits"] else "LEADS HAVE NO ROOM"
    print(
        f"\nwiring: {verdict}\n"
        f"upper board: {leads['traces_needed']} traces in each channel of "
        f"{1e3 * leads['channel']:.2f} mm, {leads['traces_fit']} fit (enough for "
        f"{leads['most_rows']} rows); longest {1e3 * leads['trace_length']:.0f} mm, "
        f"{1e12 * leads['trace_capacitance']:.2g} pF to its neighbour\n"
        f"coils: {leads['wires_needed']} wires of {1e6 * leads['wire_diameter']:.0f} um in each "
        f"gap of {1e3 * leads['wire_gap']:.2f} mm between sleeves, {leads['wires_fit']} fit"
    )
