"""``tactgen scenes``, ``init``, ``bill``, ``cache``, ``completion``: what is there, and helpers."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactgen.validation.command_line.options import Commands, scene_options
from tactgen.validation.command_line.streams import print_json

if TYPE_CHECKING:
    from tactgen.validation.scene.scene import Scene


def add_scenes(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("scenes", help="list the built-in scenes")
    parser.set_defaults(run=_scenes)


def _scenes(_: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.scene.files import built_in_scenes

    for name, description in built_in_scenes().items():
        print(f"{name:12} {description}")
    return 0


def add_init(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("init", help="write a commented scene file to start from")
    parser.add_argument("file", metavar="FILE.toml")
    parser.set_defaults(run=_init)


def _init(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.scene.parameter_list import write_template

    print(write_template(Path(options.file)))
    return 0


#: Clearances that are shown without --all.
_CLEARANCES = 12


def add_bill(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("bill", help="the display's bill of parts, clearances, wiring")
    scene_options(parser, default="display")
    parser.add_argument("--all", action="store_true", help="every clearance, not the narrowest")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=_bill)


def _bill(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.geometry.display.clearances import check_display
    from tactgen.validation.scene.scene import load_scene

    scene, _ = load_scene(options.scene, options.overrides)
    check_display(scene.device, scene.display)
    found = _bill_values(scene)
    if options.json:
        print_json(found)
    else:
        _show_bill(found, None if options.all else _CLEARANCES)
    return 0


def _bill_values(scene: Scene) -> dict[str, Any]:
    """Return everything as plain values in SI units."""
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


def _show_bill(found: dict[str, Any], most: int | None) -> None:
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


#: Units of the table, largest first.
_BYTES = (("GB", 1e9), ("MB", 1e6), ("kB", 1e3))


def add_cache(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "cache", help="show or clear the results that are kept for the next run"
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--info", action="store_true", help="show what is kept (default)")
    what.add_argument("--clear", action="store_true", help="remove all of it")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=_cache)


def _cache(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.geometry.store.store import clear, holdings, size_limit, store_folder

    held = holdings()
    if options.clear:
        clear()
    entries, size = sum(h.entries for h in held.values()), sum(h.size for h in held.values())
    if options.json:
        kinds = {kind: {"entries": h.entries, "bytes": h.size} for kind, h in held.items()}
        found = {"folder": str(store_folder()), "limit": size_limit(), "kinds": kinds}
        print_json({**found, "cleared": options.clear})
        return 0
    for kind, h in held.items():
        print(f"{kind:24} {h.entries:6}  {_readable(h.size):>9}")
    done = "removed from" if options.clear else "in"
    print(f"{entries} entries, {_readable(size)} {done} {store_folder()}")
    if not options.clear:
        print(f"at most {_readable(size_limit())} (TACTGEN_CACHE_LIMIT), oldest use goes first")
    return 0


def _readable(size: int) -> str:
    for unit, worth in _BYTES:
        if size >= worth:
            return f"{size / worth:.3g} {unit}"
    return f"{size} B"


_BASH = """\
# tactgen: completion for bash (zsh: autoload -U bashcompinit; bashcompinit; then the same)
# use:  eval "$(tactgen completion)"      or put that line into ~/.bashrc
_tactgen() {{
  local word="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}" words=""
  case "$before" in
    --model) words="{models}" ;;
    --quantity) words="{quantities}" ;;
    --set|--key|--vary) words="{keys}"; compopt -o nospace 2>/dev/null ;;
    *) case "${{COMP_WORDS[1]}}" in
{options}
      esac ;;
  esac
  [ "$COMP_CWORD" -eq 1 ] && words="{commands}"
  COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o default -F _tactgen tactgen
"""


def add_completion(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "completion", help="print what bash or zsh needs to complete commands, options and keys"
    )
    parser.set_defaults(run=_completion, commands=commands)


def _completion(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.catalogue.models import MODELS
    from tactgen.validation.catalogue.quantities import QUANTITIES
    from tactgen.validation.scene.files import built_in_scenes
    from tactgen.validation.scene.scene import scene_keys

    parsers: dict[str, argparse.ArgumentParser] = options.commands.choices
    scenes = " ".join(built_in_scenes())
    lines = []
    for name, parser in parsers.items():
        actions = parser._actions
        words = [option for action in actions for option in action.option_strings]
        takes_scene = any(action.dest == "scene" for action in actions)
        told = " ".join([*words, *([scenes] if takes_scene else [])])
        lines.append(f'      {name}) words="{told}" ;;')
    print(
        _BASH.format(
            models=" ".join([*MODELS, "all"]), quantities=" ".join([*QUANTITIES, "all"]),
            keys=" ".join(f"{key}=" for key in scene_keys()), options="\n".join(lines),
            commands=" ".join(parsers),
        ),
        end="",
    )  # fmt: skip
    return 0
