"""``tactgen simulate``: the generator in time, or a bimorph that its own support holds."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import (
    Commands,
    scene_options,
    settle,
    voltage_driven,
    warn,
)
from tactgen.validation.command_line.streams import announcer, print_json

if TYPE_CHECKING:
    from tactgen.tmm.generator.transient.waveform import Waveform
    from tactgen.validation.models.held_bimorph import HeldRun
    from tactgen.validation.models.transient import Simulation
    from tactgen.validation.scene.scene import Scene


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "simulate", help="motion in time: the generator, or a bimorph on its support"
    )
    scene_options(parser, default="generator")
    parser.add_argument(
        "--voltage", metavar="WAVEFORM", default="0 V",
        help='voltage of the bimorph: "10 V sine 200 Hz", "5 V step at 1 ms", FILE.csv',
    )  # fmt: skip
    parser.add_argument(
        "--coil", metavar="WAVEFORM",
        help='current or voltage of the coil: "120 mA square 100 Hz"; with '
        "support.kind=contact",
    )  # fmt: skip
    parser.add_argument(
        "--until", metavar="TIME", default="30 ms", help="end of the simulation (default 30 ms)"
    )
    parser.add_argument(
        "--accuracy", metavar="SHARE", default="0.05",
        help="requested error, relative to static deflection and stroke (default 0.05)",
    )  # fmt: skip
    parser.add_argument(
        "--map", metavar="FILE.nc", help="co-energy map from tactgen export (default: network)"
    )
    parser.add_argument("--out", metavar="FILE.nc", help="write the run as netCDF")
    parser.add_argument("--plot", metavar="FILE.svg", help="write a plot")
    parser.add_argument("--gif", metavar="FILE.gif", help="write a film of the motion")
    parser.add_argument("--mp4", metavar="FILE.mp4", help="write a film (needs ffmpeg)")
    parser.add_argument(
        "--fields", metavar="FILE.pvd", help="write the motion for ParaView, time steps in s"
    )
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.tmm.generator.transient.waveform import Sources
    from tactgen.tmm.reluctance.coenergy_fit import read_map
    from tactgen.validation.models.held_bimorph import run_held
    from tactgen.validation.models.transient import run_scene
    from tactgen.validation.scene.conditions import conditions
    from tactgen.validation.scene.load import load_scene
    from tactgen.validation.studies import simulate as output
    from tactgen.validation.studies.waveform_text import AMPERES, VOLTS, parsed

    _check_files(options)
    scene, _ = load_scene(options.scene, options.overrides)
    voltage_driven(scene, "simulate")
    settle(scene)
    voltage = parsed(options.voltage, "--voltage", (VOLTS,))
    coil = parsed(options.coil or "0 mA", "--coil", (AMPERES, VOLTS))
    until, accuracy = _until(options.until), _accuracy(options.accuracy)
    for option, waveform in (("--voltage", voltage.waveform), ("--coil", coil.waveform)):
        start = getattr(waveform, "start", 0.0)
        if start >= until:
            raise InputError(
                f"{option} starts at {1e3 * start:g} ms and the run ends at {1e3 * until:g} ms; "
                "give a later --until, or let it start earlier"
            )
    on_rod = scene.support.kind == "contact"
    if not on_rod:
        _refuse_of_rod(options, scene)
    result: Simulation | HeldRun
    with announcer() as announce:
        if on_rod:
            result = run_scene(
                scene,
                Sources(voltage.waveform, coil.waveform),
                until,
                coil=coil.of,
                accuracy=accuracy,
                pull=read_map(options.map) if options.map else None,
                announce=announce,
            )
        else:
            result = run_held(scene, voltage.waveform, until, accuracy=accuracy, announce=announce)
    warn(_doubts(result, {voltage.waveform, coil.waveform}))
    with announcer() as announce:
        _write(options, result, announce)
    if options.json:
        print_json(output.as_json(result))
    else:
        print("\n".join([conditions(scene), *output.lines(result)]))
    return 0


def _refuse_of_rod(options: argparse.Namespace, scene: Scene) -> None:
    """Refuse options of the generator where the bimorph's own support holds it."""
    for option in ("coil", "map", "gif", "mp4", "fields"):
        if getattr(options, option):
            raise InputError(
                f"--{option} is of the generator on its rod, and support.kind = "
                f'"{scene.support.kind}" holds the bimorph alone; leave --{option} out, or set '
                "support.kind=contact"
            )


def _doubts(result: Simulation | HeldRun, waveforms: set[Waveform]) -> list[str]:
    """Limits of a run's validity."""
    from tactgen.geometry.formats import share
    from tactgen.tmm.generator.transient.waveform import Step
    from tactgen.validation.models.held_bimorph import HeldRun

    doubts, answer = [], result.answer
    if waveforms == {Step(0.0)}:
        volts = f"{result.scene.drive.voltage:g} V sine 100 Hz"
        options = "--voltage" if isinstance(result, HeldRun) else "--voltage or --coil"
        doubts.append(f'nothing drives it; give {options}, for example --voltage "{volts}"')
    if result.load_misfit:
        doubts.append(
            "the load is taken as springs, dampers and masses, which only take energy; they are up "
            f"to {share(result.load_misfit)} off its law of frequency"
        )
    if answer.error > answer.accuracy:
        doubts.append(
            f"the accuracy of {answer.accuracy:g} holds until {1e3 * answer.certain_until:.4g} ms; "
            "later, bounces or a resonance have amplified the steps' errors beyond it, and a finer "
            "--accuracy moves that time a little"
        )
    if not isinstance(result, HeldRun) and result.sideways.max() > result.flange_gap:
        sideways = result.sideways
        at = float(answer.run.time[int((sideways > result.flange_gap).argmax())])
        doubts.append(
            f"from {1e3 * at:.4g} ms on the flange is up to {1e6 * sideways.max():.3g} um off "
            f"the middle, through the sleeve {1e6 * result.flange_gap:.3g} um away; give the "
            "bore's walls by guide.clearance with a stiffer guide.lateral_stiffness"
        )
    return doubts


def _check_files(options: argparse.Namespace) -> None:
    """Refuse options that would fail only after the run."""
    from tactgen.validation.show.export import check_place

    for option in ("out", "plot", "gif", "mp4", "fields"):
        if path := getattr(options, option):
            suffix = {"out": ".nc", "plot": ".svg", "fields": ".pvd"}.get(option, f".{option}")
            check_place(f"--{option}", Path(path), (suffix,))
    if options.mp4:
        from tactgen.validation.show.pictures import check_ffmpeg

        check_ffmpeg(Path(options.mp4))


def _write(
    options: argparse.Namespace, result: Simulation | HeldRun, announce: Callable[[str], None]
) -> None:
    from tactgen.geometry.files import write_text
    from tactgen.validation.models.transient import Simulation
    from tactgen.validation.studies.simulate import held_plot, time_plot, write_run

    drives = {"bimorph_voltage": options.voltage}
    if isinstance(result, Simulation):
        drives["coil_drive"] = options.coil or "0 mA"
    if options.out:
        write_run(options.out, result, drives)
    if options.plot:
        drawn = time_plot(result) if isinstance(result, Simulation) else held_plot(result)
        write_text(Path(options.plot), drawn)
    if not isinstance(result, Simulation):
        return
    if options.fields or options.gif or options.mp4:
        from tactgen.validation.show.run import write_run_film, write_run_steps

        if options.fields:
            announce("time steps for ParaView")
            write_run_steps(Path(options.fields), result)
        for path in filter(None, (options.gif, options.mp4)):
            write_run_film(Path(path), result, announce)


def _until(text: str) -> float:
    from tactgen.validation.studies.waveform_text import SECONDS

    try:
        value = SECONDS.parse(text.strip())
    except ValueError as error:
        raise InputError(f'--until "{text}" {error}') from None
    if not 1e-6 <= value <= 10.0:
        raise InputError(f"--until = {value:g} s is not between 1 us and 10 s; write such as 30 ms")
    return value


def _accuracy(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 1e-6 <= value <= 0.5:
        raise InputError(f'--accuracy "{text}" is not between 1e-6 and 0.5; write for example 0.05')
    return value
