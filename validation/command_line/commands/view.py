"""``tactgen view``: modes and fields in a page that moves, as stills and as films."""

from __future__ import annotations

import argparse
import webbrowser
from pathlib import Path

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import (
    PAPER,
    Commands,
    scene_options,
    settle,
    warn,
)
from tactgen.validation.command_line.streams import announcer

#: Options that ask something of a scene, which a run's file has answered.
_OF_A_SCENE = ("scene", "model", "frequency", "lengths", "png", "gif", "mp4", "state", "field")


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("view", help="show modes and fields in motion, in one HTML page")
    # None, so that a scene beside --run is seen
    scene_options(parser, default=None)
    parser.add_argument(
        "--model",
        action="append",
        metavar="NAME",
        help="model; may be repeated, two are shown side by side",
    )
    parser.add_argument(
        "--frequency",
        metavar="LIST|START:STOP:N[:log]",
        help="frequencies of driven states in Hz (default: first natural frequency and its half)",
    )
    parser.add_argument(
        "--lengths",
        metavar="LOW:HIGH",
        help="add a slider of the bimorph's length, for example 15mm:30mm, with shapes, "
        "frequencies and their errors",
    )
    parser.add_argument("--out", metavar="FILE.html", help="page to write (default view.html)")
    parser.add_argument(
        "--run", dest="of_run", metavar="RUN.nc",
        help="show a run of tactgen simulate --out RUN.nc instead of modes",
    )  # fmt: skip
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    parser.add_argument("--png", metavar="FILE.png", help="write a picture instead of the page")
    parser.add_argument("--gif", metavar="FILE.gif", help="write a film of one period")
    parser.add_argument("--mp4", metavar="FILE.mp4", help="write a film (needs ffmpeg)")
    parser.add_argument(
        "--state",
        metavar="NAME",
        help='state of picture and film, for example "mode 2, open circuit"',
    )
    parser.add_argument(
        "--field", metavar="NAME", help="field that colours picture and film, for example stress_zz"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    if options.of_run:
        return _show_run(options)
    options.scene = PAPER if options.scene is None else options.scene
    _refuse_unused(options)
    from tactgen.validation.catalogue.models import MODELS
    from tactgen.validation.scene.load import load_scene
    from tactgen.validation.scene.warnings import scene_warnings
    from tactgen.validation.show.view import Look, harmonic_frequencies, view

    asked = [] if options.frequency is None else [f"frequency={options.frequency}"]
    scene, origins = load_scene(options.scene, [*options.overrides, *asked])
    settle(scene)
    # what is no model is refused below, in words for pictures
    known = tuple(name for name in options.model or () if name in MODELS)
    asking = {"models": known} if known else {}
    warn(scene_warnings(scene.model_copy(update=asking), origins))
    named = {kind: getattr(options, kind) for kind in ("out", "png", "gif", "mp4")}
    files = {kind: Path(name) for kind, name in named.items() if name}
    if not files or (options.open and "out" not in files):
        files["out"] = Path("view.html")
    look = Look(
        models=tuple(options.model or ()),
        frequencies=harmonic_frequencies(scene) if asked else None,
        state=options.state or "",
        shade=options.field or "",
        lengths=_lengths(options),
    )
    with announcer() as announce:
        for path in view(scene, look, files, announce):
            print(path)
    if options.open:
        _open(files["out"])
    return 0


def _refuse_unused(options: argparse.Namespace) -> None:
    """Refuse a state or colour that no still or film is asked to have: the page has them all."""
    if options.png or options.gif or options.mp4:
        return
    for name in ("state", "field"):
        if value := getattr(options, name):
            raise InputError(
                f'--{name} "{value}" is of a still or a film, and none is asked for; add --png '
                f"FILE.png, or leave --{name} out, since the page lets you choose"
            )


def _show_run(options: argparse.Namespace) -> int:
    """Write the page of a run's file."""
    from tactgen.geometry.files import write_text
    from tactgen.validation.show.export import check_place
    from tactgen.validation.show.run import run_page
    from tactgen.validation.studies.simulate import read_film

    given = {name: getattr(options, name) for name in _OF_A_SCENE}
    given["set"] = options.overrides
    for name, value in given.items():
        if value:
            raise InputError(
                f"--run {options.of_run} shows a run as it is, without "
                f"{'a scene' if name == 'scene' else f'--{name}'}; leave that out "
                "(films of a run: tactgen simulate --gif or --mp4)"
            )
    page = Path(options.out or "run.html")
    check_place("--out", page, (".html",))
    write_text(page, run_page(read_film(Path(options.of_run))))
    print(page)
    if options.open:
        _open(page)
    return 0


def _open(page: Path) -> None:
    if not webbrowser.open(page.resolve().as_uri()):
        warn([f"no browser could be started; open {page} yourself"])


def _lengths(options: argparse.Namespace) -> tuple[float, float] | None:
    """Ends (m) of the slider: lengths that the scene may have."""
    if options.lengths is None:
        return None
    from tactgen.validation.scene.load import load_scene

    ends = options.lengths.split(":")
    if len(ends) != 2:
        raise InputError(
            f"--lengths {options.lengths} is not a range; write two lengths, such as 15mm:30mm"
        )
    low, high = (
        load_scene(options.scene, [*options.overrides, f"bimorph.length={end}"])[0].bimorph.length
        for end in ends
    )
    return low, high
