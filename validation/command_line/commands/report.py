"""``tactgen report``: write the verification report."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactgen.validation.command_line.commands.common import (
    Commands,
    overrides_of,
    scene_options,
    warn,
)


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("report", help="write the verification report (HTML)")
    scene_options(parser)
    parser.add_argument(
        "--model",
        action="append",
        metavar="NAME",
        help="may be repeated; see tactgen solve --help",
    )
    parser.add_argument("--out", default="report", metavar="DIR", help="folder (default report)")
    parser.add_argument(
        "--quick",
        action="store_true",
        help="coarser meshes, one mesh family, no heavy checks, no map of the magnetic field",
    )
    parser.add_argument(
        "--pdf", action="store_true", help="also print it to report.pdf (needs Chromium or Chrome)"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.command_line.progress import announcer
    from tactgen.validation.report.page import print_report, write_report
    from tactgen.validation.scene.idle_keys import scene_warnings
    from tactgen.validation.scene.scene import load_scene
    from tactgen.validation.view.browser import need_browser

    asked = overrides_of("model", "models", options.model, "tmm")
    scene, origins = load_scene(options.scene, [*options.overrides, *asked])
    warn(scene_warnings(scene, origins, report=True))
    browser = need_browser("--pdf") if options.pdf else ""  # refused before minutes of work
    with announcer() as announce:
        page = write_report(scene, origins, Path(options.out), options.quick, announce)
        print(page)
        if browser:
            announce("printing")
            print(print_report(browser, page))
    return 0
