"""``tactgen export``: write CAD, mesh, field, map or reduced solid files."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import Commands, scene_options, settle
from tactgen.validation.command_line.streams import announcer


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "export", help="write CAD solids, meshes, fields, maps, state space or an FMU"
    )
    scene_options(parser)
    parser.add_argument("--step", metavar="FILE", help="CAD solids as STEP (mm)")
    parser.add_argument("--glb", metavar="FILE", help="CAD solids as binary glTF")
    parser.add_argument("--mesh", metavar="FILE.vtu", help="mesh of the model solid or cad (m)")
    parser.add_argument(
        "--map", metavar="FILE.nc", help="co-energy map of the normal actuator as netCDF (SI)"
    )
    parser.add_argument(
        "--ports", metavar="FILE.npz", help="solid reduced to its ports, both ends free (SI)"
    )
    parser.add_argument(
        "--state-space",
        metavar="FILE.npz",
        help="solid on its support as state space x' = A x + B u (SI)",
    )
    parser.add_argument(
        "--fields",
        metavar="FILE.vtu",
        help="modes, static and driven fields of the model solid (or of the first model) for "
        "ParaView: .vtu, .vtkhdf, or .pvd with one period as time steps (SI)",
    )
    parser.add_argument(
        "--animated-glb", metavar="FILE.glb", help="the same fields as glTF animations"
    )
    parser.add_argument(
        "--fmu", metavar="FILE.fmu", help="generator as a co-simulation unit (FMI 2.0, C sources)"
    )
    parser.add_argument(
        "--machine",
        metavar="FILE.npz",
        help="generator in small motions as state space x' = A x + B u (SI)",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.scene.load import ON_COMMAND_LINE, load_scene
    from tactgen.validation.show.export import export
    from tactgen.validation.show.view import harmonic_frequencies

    scene, origins = load_scene(options.scene, options.overrides)
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
        moving = {"fields", "animated_glb"} & set(wanted)
        stated = origins.get("frequency") == ON_COMMAND_LINE
        frequencies = harmonic_frequencies(scene) if moving and stated else None
        for path in export(scene, wanted, announce, frequencies):
            print(path)
    return 0
