"""``tactgen identify``: fit a scene's parameters to a measured curve."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import (
    Commands,
    lateral_scene,
    scene_options,
    warn,
)
from tactgen.validation.command_line.streams import print_json

_ABOUT = """\
Fit parameters of a scene to a measured frequency response with the transfer-matrix model,
as the paper did by hand for its support (Fig 8).

MEASURED.csv has a header that names each column with its unit:
  frequency (Hz)               ascending, above 0
  velocity (mm/s)              a magnitude; or with velocity_phase (deg);
                               or velocity_re (mm/s) and velocity_im (mm/s)
  uncertainty (mm/s)           optional: one standard deviation of each point, or
  weight                       optional: how much a point counts; only ratios matter, the
                               variance of its noise goes as 1/weight, 0 leaves it out
Instead of velocity: {others}.  Comma, semicolon or tab
between columns, a decimal point, comments from # to the end of a line.  Amplitudes are peak
values, the phase is that against the voltage, with the time factor exp(+j omega t).  All but
the admittance are those at the scene's drive.voltage (1 V in prototype): set another with
--set drive.voltage=5V.
"""
_EXAMPLES = """\
NAME is c_s, c_sl, d_s, theta, rho_p or a scene key such as piezo.quality_factor.  START is the
scene's value unless given; bounds are a factor 100 either side of it.  By default c_s and d_s
are fitted: c_sl and theta hardly act below 2 kHz.  Intervals are 95 %, linear in the logarithm
where that is safe, else by profile likelihood; an end that no data set is called open.

  tactgen identify sweep.csv
  tactgen identify sweep.csv --fit c_s=0.2N*m/rad:0.05..2N*m/rad --fit d_s --fit c_sl
  tactgen identify sweep.csv mine.toml --set bimorph.length=14.2mm --plot fit.svg --json
"""


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "identify",
        help="fit parameters to a measured frequency response",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.listing = _listing
    parser.add_argument("measured", metavar="MEASURED.csv", help="measured curve")
    scene_options(parser, default="prototype")
    parser.add_argument(
        "--fit",
        action="append",
        metavar="NAME[=START][:LOW..HIGH]",
        help="parameter to fit; may be repeated (default: c_s and d_s)",
    )
    parser.add_argument(
        "--noise",
        choices=("relative", "constant"),
        help="noise model if the file has no uncertainty: relative to the value, or constant "
        "(default: the more likely one)",
    )
    parser.add_argument(
        "--plot", metavar="FILE.svg", help="write a plot of data and fit (.svg, .png)"
    )
    parser.add_argument("--write", metavar="FILE.toml", help="write a scene with the fitted values")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def _listing() -> tuple[str, str]:
    from tactgen.validation.catalogue.quantities import measurable

    units = {name: row.curve.example.split()[-1] for name, row in measurable().items() if row.curve}
    others = [f"{name} ({unit})" for name, unit in units.items() if name != "velocity"]
    return _ABOUT.format(others=", ".join(others)), _EXAMPLES


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.scene.warnings import scene_warnings
    from tactgen.validation.show.export import check_place
    from tactgen.validation.studies import identify_output as output
    from tactgen.validation.studies.identify import DEFAULT_FIT, identify
    from tactgen.validation.studies.measured_data import read_measured

    # what is wrong with the names is said before any work is done
    plot = Path(options.plot) if options.plot is not None else None
    if plot:
        check_place("--plot", plot, (".svg", ".png"))
    target = None if options.write is None else output.checked_scene_name(options.write)
    scene, origins = lateral_scene(options.scene, options.overrides, "identify")
    data = read_measured(options.measured)
    if options.noise and data.error is not None:
        raise InputError(
            f"--noise {options.noise} has no effect, for {data.source} states its uncertainty; "
            "remove one of them"
        )
    result = identify(scene, data, options.fit or DEFAULT_FIT, options.noise, origins)
    warn((*scene_warnings(scene, origins), *result.warnings))
    if plot:
        output.write_plot(result, plot)
    if target:
        output.write_scene(result, origins, target)
    if options.json:
        print_json(output.as_json(result))
    else:
        print(output.as_text(result))
    return 0
