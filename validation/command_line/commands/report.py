"""``tactgen report``: write the verification report."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactgen.validation.command_line.commands.common import (
    Commands,
    asked_overrides,
    asking_options,
    scene_options,
    warn,
)
from tactgen.validation.command_line.streams import announcer, say

#: What is meant where nothing is said.
_SCENE, _OUT = "paper", "report"


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("report", help="write the verification report (HTML)")
    scene_options(parser, _SCENE)
    asking_options(parser)
    parser.add_argument("--out", default=_OUT, metavar="DIR", help="output folder (default report)")
    parser.add_argument(
        "--quick", action="store_true", help="use coarser meshes and no map of the magnetic field"
    )
    parser.add_argument(
        "--pdf", action="store_true", help="also write report.pdf (needs Chromium or Chrome)"
    )
    parser.add_argument(
        "--reproduce",
        metavar="FOLDER",
        help="compute all numbers of a report again and compare; exit code 1 if any differs by "
        "more than its error",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    if options.reproduce is not None:
        return _reproduce(options)
    from tactgen.validation.report.page import print_report, write_report
    from tactgen.validation.scene.load import load_scene
    from tactgen.validation.scene.warnings import scene_warnings
    from tactgen.validation.show.browser import need_browser

    scene, origins = load_scene(options.scene, [*options.overrides, *asked_overrides(options)])
    warn(scene_warnings(scene, origins, report=True))
    browser = need_browser("--pdf") if options.pdf else ""  # refused before minutes of work
    with announcer() as announce:
        page = write_report(scene, origins, Path(options.out), options.quick, announce)
        print(page)
        if browser:
            announce("printing")
            print(print_report(browser, page))
    return 0


def _reproduce(options: argparse.Namespace) -> int:
    """Compute a report again; its own scene and models, whatever else is asked is refused."""
    from tactgen.geometry.errors import InputError
    from tactgen.validation.report.provenance import reproduce

    asked = [*options.overrides, *asked_overrides(options)]
    if asked or options.quick or options.pdf or options.scene != _SCENE or options.out != _OUT:
        raise InputError(
            "--reproduce takes the scene and the models of the report that it names; leave the "
            "scene and all other options out"
        )
    with announcer() as announce:
        found = reproduce(Path(options.reproduce), announce)
    for words in found.elsewhere:
        say(f"note: {words}")
    for row in found.rows:
        shares = "" if row.verdict == "identical" else (
            f"  off by {row.difference:.1e} of it, {row.over_bars:.1e} of its bars"
        )  # fmt: skip
        print(f"{row.name:32} {row.model:14} {row.verdict}{shares}")
    counts = (
        f"{sum(row.verdict == verdict for row in found.rows)} {verdict}"
        for verdict in ("identical", "within bars", "differs")
    )
    print(f"{found.scene}: {', '.join(counts)}")
    return int(not found.holds)
