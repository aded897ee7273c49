"""``tactgen positions``: where the rod is while the coil's current rises and falls."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import Commands, scene_options, warn
from tactgen.validation.command_line.streams import print_json

if TYPE_CHECKING:
    from tactgen.geometry.arrays import Floats
    from tactgen.validation.models.generator.rod_loop import RodLoop

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
        "positions", help="where the rod is while the coil's current rises and falls"
    )
    scene_options(parser, default="generator")
    parser.add_argument(
        "--model", action="append", metavar="NAME",
        help="of the normal actuator: network, axisymmetric or magnetic3d (default: the scene's)",
    )  # fmt: skip
    parser.add_argument(
        "--current", metavar="START:STOP:N",
        help=f"currents, for example {_EXAMPLE} (default: as far as what moves the rod)",
    )  # fmt: skip
    parser.add_argument("--plot", metavar="FILE.svg", help="draw the loop")
    parser.add_argument("--csv", metavar="FILE.csv", help="write all places on the way, in SI")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.catalogue.quantities import DROP_OUT_CURRENT, PULL_IN_CURRENT
    from tactgen.validation.command_line.progress import announcer
    from tactgen.validation.engine.solve import solve
    from tactgen.validation.models.generator.rod_loop import rod_loop
    from tactgen.validation.models.reluctance.model import MagneticModel
    from tactgen.validation.scene.scene import load_scene

    _check_files(options)
    currents = _currents(options.current) if options.current else None
    scene, _ = load_scene(options.scene, options.overrides)
    models = _models(options.model, scene.models)
    asked = (PULL_IN_CURRENT.name, DROP_OUT_CURRENT.name)
    with announcer() as announce:
        solution = solve(scene, models, asked, announce)
        loops = []
        for name in models:
            model = solution.models[name]
            assert isinstance(model, MagneticModel)
            announce(f"positions by {name}")
            loops.append(rod_loop(model, currents))
    warn(solution.warnings)
    _write(options, loops, abs(scene.coil.current))
    if options.json:
        print_json({"scene": scene.name, "loops": [_plain(f) for f in loops]})
    else:
        for found in loops:
            _print(found)
    return 0


def _models(asked: list[str] | None, of_scene: tuple[str, ...]) -> tuple[str, ...]:
    from tactgen.validation.catalogue.models import MODELS, models_of
    from tactgen.validation.scene.files import choices

    known = models_of("reluctance")
    if asked:
        for name in ",".join(asked).split(","):
            if name.strip() in MODELS and name.strip() not in known:
                raise InputError(
                    f'--model "{name.strip()}" is of the bimorph, and positions are of the normal '
                    f"actuator; name one of {', '.join(known)}"
                )
        return choices(",".join(asked), known, "model", "--model")
    return tuple(name for name in of_scene if name in known) or known[:1]


def _currents(text: str) -> Floats:
    """Return the currents that ``--current`` states (A)."""
    import numpy as np

    parts = [part.strip() for part in text.split(":")]
    count = parts[2] if len(parts) == 3 else ""
    if not (count.isascii() and count.isdigit() and 2 <= int(count) <= _MOST):
        raise InputError(
            f'--current "{text}" is not START:STOP:N with N from 2 to {_MOST}; write for example '
            f"{_EXAMPLE}"
        )
    low, high = (_ampere(part, text) for part in parts[:2])
    if not low < high:
        raise InputError(f'--current "{text}" does not rise; write for example {_EXAMPLE}')
    return np.linspace(low, high, int(count))


def _ampere(part: str, text: str) -> float:
    from tactgen.geometry.units import CURRENT

    try:
        value = 0.0 if part == "0" else CURRENT.parse(part)
    except ValueError:
        value = math.nan
    _, high = CURRENT.limits or (0.0, math.inf)
    if not 0.0 <= value <= high:
        raise InputError(
            f'--current "{text}" has "{part}", which is no current of 0 A or more with its unit; '
            f"write for example {_EXAMPLE}"
        )
    return value


def _check_files(options: argparse.Namespace) -> None:
    from tactgen.validation.export.files import check_place

    for option, path, suffix in (("plot", options.plot, ".svg"), ("csv", options.csv, ".csv")):
        if path:
            check_place(f"--{option}", Path(path), (suffix,))


def _write(options: argparse.Namespace, loops: list[RodLoop], current: float) -> None:
    from tactgen.geometry.files import write_text

    if options.plot:
        from tactgen.validation.report.sections.machine import position_plot

        write_text(Path(options.plot), position_plot(loops, current))
    if options.csv:
        lines = [_COLUMNS]
        for found in loops:
            lines += [
                ",".join([found.model, f"{i:.10g}", *rising, *falling])
                for i, rising, falling in _steps(found)
            ]
        write_text(Path(options.csv), "\n".join(lines) + "\n")


def _steps(found: RodLoop) -> list[tuple[float, list[str], list[str]]]:
    """Return each current with position, bar, kind and contact force of both ways."""
    ways = [
        [
            [f"{p.lift:.10g}", f"{bar:.3g}", p.kind, f"{p.contact_force:.10g}"]
            for p, bar in zip(way, bars, strict=True)
        ]
        for way, bars in (
            (found.loop.rising, found.rising_bar),
            (found.loop.falling, found.falling_bar),
        )
    ]
    return list(zip(found.loop.currents.tolist(), *ways, strict=True))


def _plain(found: RodLoop) -> dict[str, Any]:
    loop = found.loop

    def way(places: Any, bars: Floats) -> dict[str, Any]:
        return {"places": places, "uncertainty": bars}

    return {
        "model": found.model,
        "current": loop.currents,
        "rising": way(loop.rising, found.rising_bar),
        "falling": way(loop.falling, found.falling_bar),
        "unstable": loop.unstable,
        "switching": found.switching,
    }


def _print(found: RodLoop) -> None:
    from tactgen.geometry.formats import engineering, with_bar

    print(f"{found.model}: position of the rod, 0 at the upper stop, negative down")
    if found.switching is not None:
        for name in ("lift_off", "pull_in", "holding", "drop_out"):
            at = getattr(found.switching, name)
            shown = with_bar(at.value, at.error, "A") if math.isfinite(at.value) else "not reached"
            print(f"  {name.replace('_', '-'):10} {shown}")
    print(f"  {'current':>10}  {'rising':>28}  {'falling':>28}")
    last = len(found.loop.currents) - 1
    shown_at = sorted({round(k * last / (_SHOWN - 1)) for k in range(_SHOWN)})
    for k in shown_at:
        cells = [
            f"{engineering(way[k].lift, 'm', 4)} {way[k].kind}"
            for way in (found.loop.rising, found.loop.falling)
        ]
        print(
            f"  {engineering(found.loop.currents[k], 'A', 4):>10}  {cells[0]:>28}  {cells[1]:>28}"
        )
