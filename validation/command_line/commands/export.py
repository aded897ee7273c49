"""``tactgen export``: write CAD, mesh, field, map or reduced solid files."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import Commands, scene_options, settle


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("export", help="write CAD, mesh, field, map or port files")
    scene_options(parser)
    parser.add_argument("--step", metavar="FILE", help="solids as STEP (mm)")
    parser.add_argument("--glb", metavar="FILE", help="solids as binary glTF")
    parser.add_argument("--mesh", metavar="FILE.vtu", help="the mesh of solid, or of cad (m)")
    parser.add_argument(
        "--map", metavar="FILE.nc", help="the normal actuator's co-energy map as netCDF (SI)"
    )
    parser.add_argument(
        "--ports", metavar="FILE.npz", help="the solid reduced to its ports, free at both ends (SI)"
    )
    parser.add_argument(
        "--state-space",
        metavar="FILE.npz",
        help="the solid on its support as x' = A x + B u for time simulation (SI)",
    )
    parser.add_argument(
        "--fields",
        metavar="FILE.vtu",
        help="modes, static and harmonic fields of solid (or of the first other model) for "
        "ParaView: .vtu, .vtkhdf, or .pvd for one period as time steps (SI)",
    )
    parser.add_argument(
        "--animated-glb", metavar="FILE.glb", help="the same motions as glTF animations"
    )
    parser.add_argument(
        "--fmu", metavar="FILE.fmu", help="the generator for co-simulation (FMI 2.0, in C)"
    )
    parser.add_argument(
        "--machine",
        metavar="FILE.npz",
        help="the generator in small motions as x' = A x + B u, for control tools (SI)",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.command_line.streams import announcer
    from tactgen.validation.scene.scene import load_scene
    from tactgen.validation.show.export import export

    scene, _ = load_scene(options.scene, options.overrides)
    settle(scene)
    kinds = ("step", "glb", "mesh", "map", "ports", "state_space", "fields", "animated_glb", "fmu",
             "machine")  # fmt: skip
    targets = {kind: getattr(options, kind) for kind in kinds}
    wanted = {kind: Path(file) for kind, file in targets.items() if file}
    if not wanted:
        raise InputError(
            "export needs at least one of --step FILE, --glb FILE, --mesh FILE.vtu, --map FILE.nc, "
            "--ports FILE.npz, --state-space FILE.npz, --fields FILE.vtu, --animated-glb FILE.glb, "
            "--fmu FILE.fmu, --machine FILE.npz"
        )
    with announcer() as announce:
        for path in export(scene, wanted, announce):
            print(path)
    return 0
