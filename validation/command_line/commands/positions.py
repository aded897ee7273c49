"""``tactgen positions``: where the rod is while the coil's current rises and falls."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import (
    Commands,
    scene_options,
    settle,
    values_of,
    warn,
)
from tactgen.validation.command_line.streams import announcer, print_json

if TYPE_CHECKING:
    from tactgen.geometry.arrays import Floats
    from tactgen.validation.models.reluctance.model import RodLoop

_EXAMPLE = "0:200mA:101"
#: Most currents of one request, and how many a table shows.
_MOST, _SHOWN = 10_000, 13
_COLUMNS = (
    "model,current (A),position rising (m),error rising (m),kind rising,contact force rising (N),"
    "position falling (m),error falling (m),kind falling,contact force falling (N)"
)


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "positions", help="equilibrium of the rod while the coil current rises and falls"
    )
    scene_options(parser, default="generator")
    parser.add_argument(
        "--model", action="append", metavar="NAME",
        help="network, axisymmetric or magnetic3d (default: the scene's)",
    )  # fmt: skip
    parser.add_argument(
        "--current", metavar="START:STOP:N",
        help=f"currents, for example {_EXAMPLE} (default: beyond pull-in)",
    )  # fmt: skip
    parser.add_argument("--plot", metavar="FILE.svg", help="write a plot of the loop")
    parser.add_argument("--csv", metavar="FILE.csv", help="write all positions, in SI units")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.engine.solve import solve
    from tactgen.validation.models.reluctance.model import MagneticModel, rod_loop
    from tactgen.validation.scene.conditions import answer_head, conditions
    from tactgen.validation.scene.load import load_scene
    from tactgen.validation.show.export import check_place

    for option, path, suffix in (("plot", options.plot, ".svg"), ("csv", options.csv, ".csv")):
        if path:
            check_place(f"--{option}", Path(path), (suffix,))
    currents = _currents(options.current) if options.current else None
    scene, _ = load_scene(options.scene, options.overrides)
    settle(scene)
    models = _models(options.model, scene.models)
    with announcer() as announce:
        solution = solve(scene, models, ("pull_in_current", "drop_out_current"), announce)
        loops = []
        for name in models:
            model = solution.models[name]
            assert isinstance(model, MagneticModel)
            announce(f"positions by {name}")
            loops.append(rod_loop(model, currents))
    warn(solution.warnings)
    _write(options, loops, abs(scene.coil.current))
    if options.json:
        print_json({**answer_head(scene), "loops": [_plain(loop) for loop in loops]})
    else:
        print(conditions(scene))
        for loop in loops:
            _print(loop)
    return 0


def _models(names: list[str] | None, of_scene: tuple[str, ...]) -> tuple[str, ...]:
    from tactgen.validation.catalogue.models import MODELS, models_of
    from tactgen.validation.scene.files import choices

    known = models_of("reluctance")
    if not names:
        return tuple(name for name in of_scene if name in known) or known[:1]
    for name in ",".join(names).split(","):
        if name.strip() in MODELS and name.strip() not in known:
            raise InputError(
                f'--model "{name.strip()}" is of the bimorph, and positions are of the normal '
                f"actuator; name one of {', '.join(known)}"
            )
    return choices(",".join(names), known, "model", "--model")


def _currents(text: str) -> Floats:
    """Currents (A) of ``--current``."""
    import numpy as np

    from tactgen.geometry.units import CURRENT

    currents = np.array(values_of(text, "--current", CURRENT, _EXAMPLE, _MOST, zero=True))
    if currents.size < 2 or not (np.diff(currents) > 0.0).all():
        raise InputError(
            f'--current "{text}" does not rise; write for example --current {_EXAMPLE}'
        )
    return currents


def _write(options: argparse.Namespace, loops: list[RodLoop], current: float) -> None:
    if options.plot:
        from tactgen.geometry.files import write_text
        from tactgen.validation.report.sections.generator import position_plot

        write_text(Path(options.plot), position_plot(loops, current))
    if options.csv:
        from tactgen.geometry.csv_tables import write_csv

        def cells(places: Any, errors: Floats) -> list[list[str]]:
            return [
                [f"{p.lift:.10g}", f"{error:.3g}", p.kind, f"{p.contact_force:.10g}"]
                for p, error in zip(places, errors, strict=True)
            ]

        rows = [
            [of.model, f"{current:.10g}", *rising, *falling]
            for of in loops
            for current, rising, falling in zip(
                of.loop.currents.tolist(), cells(of.loop.rising, of.rising_bar),
                cells(of.loop.falling, of.falling_bar), strict=True,
            )
        ]  # fmt: skip
        write_csv(Path(options.csv), _COLUMNS.split(","), rows)


def _plain(of: RodLoop) -> dict[str, Any]:
    return {
        "model": of.model,
        "current": of.loop.currents,
        "rising": {"places": of.loop.rising, "uncertainty": of.rising_bar},
        "falling": {"places": of.loop.falling, "uncertainty": of.falling_bar},
        "unstable": of.loop.unstable,
        "switching": of.switching,
    }


def _print(of: RodLoop) -> None:
    from tactgen.geometry.formats import engineering, with_error

    print(f"{of.model}: position of the rod, 0 at the upper stop, negative down")
    if of.switching is not None:
        for name in ("lift_off", "pull_in", "holding", "drop_out"):
            at = getattr(of.switching, name)
            shown = (
                with_error(at.value, at.error, "A") if math.isfinite(at.value) else "not reached"
            )
            print(f"  {name.replace('_', '-'):10} {shown}")
    print(f"  {'current':>10}  {'rising':>28}  {'falling':>28}")
    last = len(of.loop.currents) - 1
    for k in sorted({round(n * last / (_SHOWN - 1)) for n in range(_SHOWN)}):
        cells = [
            f"{engineering(way[k].lift, 'm', 4)} {way[k].kind}"
            for way in (of.loop.rising, of.loop.falling)
        ]
        current = engineering(of.loop.currents[k], "A", 4)
        print(f"  {current:>10}  {cells[0]:>28}  {cells[1]:>28}")
