"""``tactgen export``: write CAD, mesh or map files."""

from __future__ import annotations

import argparse
from pathlib import Path

from geometry.errors import InputError
from validation.commands.common import Commands, scene_options


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("export", help="write CAD, mesh or map files")
    scene_options(parser)
    parser.add_argument("--step", metavar="FILE", help="solids as STEP (mm)")
    parser.add_argument("--glb", metavar="FILE", help="solids as binary glTF")
    parser.add_argument("--mesh", metavar="FILE.vtu", help="the solid model's mesh (m)")
    parser.add_argument(
        "--map", metavar="FILE.nc", help="the normal actuator's co-energy map as netCDF (SI)"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from validation.export import export
    from validation.progress import announcer
    from validation.scene import load_scene

    scene, _ = load_scene(options.scene, options.overrides)
    targets = {kind: getattr(options, kind) for kind in ("step", "glb", "mesh", "map")}
    wanted = {kind: Path(file) for kind, file in targets.items() if file}
    if not wanted:
        raise InputError(
            "export needs at least one of --step FILE, --glb FILE, --mesh FILE.vtu, --map FILE.nc"
        )
    with announcer() as announce:
        for path in export(scene, wanted, announce):
            print(path)
    return 0
