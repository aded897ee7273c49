"""``tactgen sensitivity``: derivatives and uncertainty of quantities."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import (
    Commands,
    asked_overrides,
    scene_options,
    warn,
)
from tactgen.validation.command_line.streams import announcer, print_json, say

if TYPE_CHECKING:
    from rich.table import Table

    from tactgen.geometry.device.materials import Spread
    from tactgen.validation.scene.scene import Scene
    from tactgen.validation.studies.parameter_uncertainty import Uncertainty
    from tactgen.validation.studies.sensitivity import SensitivityColumn


#: Of responses, unless --frequency or the user's own scene says otherwise (Hz).
_FREQUENCIES = "10,100,250"
#: Headline numbers of the lateral actuator.
_LATERAL = (
    "static_tip_displacement", "short_circuit_frequencies", "coupling_factor", "capacitance_free",
    "tip_displacement",
)  # fmt: skip
#: What is smaller is not shown in a table of three digits.
_SHOWN = 5e-4


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "sensitivity", help="sensitivity of a quantity to each parameter, with errors"
    )
    scene_options(parser)
    parser.add_argument(
        "--model",
        action="append",
        metavar="NAME",
        help="model; may be repeated (default tmm, or network)",
    )
    parser.add_argument(
        "--quantity",
        action="append",
        metavar="NAME",
        help="quantity; may be repeated; of modes the first",
    )
    parser.add_argument(
        "--frequency",
        metavar="LIST|START:STOP:N[:log]",
        help="frequencies in Hz (default: the scene's, of built-in scenes 10,100,250)",
    )
    parser.add_argument(
        "--key",
        action="append",
        metavar="KEY",
        help="scene key (default: all that the quantity depends on)",
    )
    parser.add_argument(
        "--sobol",
        action="store_true",
        help="also compute the uncertainty from the ranges of all parameters",
    )
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.catalogue.models import models_of
    from tactgen.validation.engine.warnings import request_warnings
    from tactgen.validation.scene.conditions import conditions
    from tactgen.validation.scene.load import load_scene
    from tactgen.validation.scene.parameter_list import is_built_in, ranges
    from tactgen.validation.scene.warnings import scene_warnings
    from tactgen.validation.studies.parameter_uncertainty import left_out, parameter_uncertainty
    from tactgen.validation.studies.sensitivity import all_columns, changed_scenes, thinned

    overrides = [*options.overrides, *asked_overrides(options)]
    scene, origins = load_scene(options.scene, overrides)
    names = _quantities(options, scene)
    models = _models(options, scene, names)
    overrides += ["quantities=" + ",".join(names), "models=" + ",".join(models)]
    lateral = bool(set(models) & set(models_of("bimorph")))
    own = "frequency" in origins and not is_built_in(origins["frequency"])
    if options.frequency is None and lateral and not own:
        overrides.append(f"frequency={_FREQUENCIES}")
    scene, _ = load_scene(options.scene, overrides)
    if options.sobol and not lateral:
        raise InputError(
            "--sobol is of the lateral actuator's headline numbers; remove it, or add a --model "
            "of that actuator"
        )
    warn(scene_warnings(scene, origins))
    uncertain: list[Uncertainty] = []
    with announcer() as announce:
        columns, omitted = all_columns(
            scene, changed_scenes(options.scene, overrides), options.key, announce
        )
        if options.sobol:
            uncertain = parameter_uncertainty(scene, announce=announce)
    warn(request_warnings(scene, scene.models, scene.quantities))
    if options.sobol and (sentence := left_out(scene)):
        omitted.append(sentence)
    for sentence in omitted:
        say(f"note: {sentence}")
    spreads = ranges(scene)
    known = {key: spreads.get(key) for column in columns for key in column.logarithmic}
    if options.json:
        print_json(_as_json(scene, columns, uncertain, known))
        return 0
    print(conditions(scene))
    shown = thinned(columns)
    if len(shown) < len(columns):
        say(f"note: {len(shown)} of {len(columns)} columns are shown; --json gives all")
    _print_sensitivities(scene, shown, known)
    if uncertain:
        _print_uncertainty(uncertain)
    return 0


def _models(options: argparse.Namespace, scene: Scene, names: Sequence[str]) -> tuple[str, ...]:
    """Models of the request: without --model the quick exact one of each actuator."""
    from tactgen.validation.catalogue.quantities import QUANTITIES

    if options.model:
        return scene.models
    usual = {"bimorph": "tmm", "reluctance": "network"}
    return tuple(dict.fromkeys(usual.get(QUANTITIES[name].actuator, "tmm") for name in names))


def _quantities(options: argparse.Namespace, scene: Scene) -> tuple[str, ...]:
    """Quantities of the request: without --quantity the headline numbers of the models."""
    from tactgen.validation.catalogue.models import gives, models_of
    from tactgen.validation.catalogue.quantities import OF_CIRCUIT, QUANTITIES, quantities_of

    if options.quantity:
        return scene.quantities
    # what a circuit is there for, in place of the motion under a voltage that nothing gives
    other = [name for name in _LATERAL if not name.endswith("tip_displacement")]
    lateral: tuple[str, ...] = _LATERAL
    if scene.circuit.kind in OF_CIRCUIT:
        lateral = (*other, *OF_CIRCUIT[scene.circuit.kind])
    normal = tuple(
        name for name in quantities_of("reluctance")
        if QUANTITIES[name].headline and "magnetic_point" in QUANTITIES[name].needs
    )  # fmt: skip
    if not options.model:
        return lateral if set(scene.models) & set(models_of("bimorph")) else normal
    return tuple(q for q in (*lateral, *normal) if any(gives(m, q) for m in options.model))


def _as_json(
    scene: Scene,
    columns: Sequence[SensitivityColumn],
    uncertain: Sequence[Uncertainty],
    known: dict[str, Spread | None],
) -> dict[str, Any]:
    from tactgen.validation.engine.answers import plain
    from tactgen.validation.scene.conditions import answer_head

    return {
        **answer_head(scene),
        "ranges": {
            key: {"low": spread.low, "high": spread.high, "reason": spread.reason}
            for key, spread in known.items()
            if spread is not None
        },
        "sensitivities": [
            {
                "quantity": column.quantity,
                "model": column.model,
                "unit": column.unit,
                "frequency": column.frequency,
                "extreme": column.extreme,
                "value": column.value,
                "modelling_error": plain(column.modelling_error),
                "derivatives": column.derivatives,
                "logarithmic": column.logarithmic,
                "uncertainty": column.bars,
                "uncertainty_method": column.method,
            }
            for column in columns
        ],
        "uncertainty": [
            {
                "name": row.target.label,
                "unit": row.target.unit,
                "value": row.value,
                "numerical": row.numerical,
                "interval_95": [row.low, row.high],
                "standard_first_order": row.standard,
                "standard_sampled": row.sampled,
                "worst_first_order": row.worst,
                "sobol_first": {key: index for key, (index, _) in row.first.items()},
                "sobol_total": {key: index for key, (index, _) in row.total.items()},
                "ill_conditioned": row.target.ill_conditioned,
            }
            for row in uncertain
        ],
    }


def _print(title: str, table: Table) -> None:
    """Print a table as wide as it has to be: digits are not to be cut off."""
    from rich.console import Console

    console = Console()
    needed = console.measure(table, options=console.options.update(width=1000)).maximum
    console.width = max(console.width, needed)
    print(title)  # a table's own title is broken to the table's width
    console.print(table)


def _print_sensitivities(
    scene: Scene, columns: Sequence[SensitivityColumn], known: dict[str, Spread | None]
) -> None:
    from rich.table import Table

    from tactgen.validation.scene.variation import value_of

    def entry(column: SensitivityColumn, key: str) -> str:
        """Write a sensitivity, with its error where it shows; nothing if the key is not read."""
        if key not in column.logarithmic:
            return ""
        value, error = column.logarithmic[key], column.bars[key]
        if error >= _SHOWN:
            return f"{value:+.3f} ± {error:.1g}"
        return f"{value:+.3f}" if abs(value) >= _SHOWN else "0"

    table = Table()
    table.add_column("parameter", no_wrap=True)
    table.add_column("may lie\nin percent", justify="right", no_wrap=True)
    several = len({column.model for column in columns}) > 1
    for column in columns:
        label = f"{column.label}\n{column.model}" if several else column.label
        table.add_column(label, justify="right")
    table.add_row("value", "", *(column.text for column in columns))
    modelling = (column.modelling.replace(" ± ", "±") for column in columns)  # columns are narrow
    table.add_row("modelling\nerror", "", *modelling, end_section=True)
    for key, spread in known.items():
        if any(key in column.logarithmic for column in columns):
            lies = _may_lie(value_of(scene, key), spread)
            table.add_row(key, lies, *(entry(column, key) for column in columns))
    _print("change in percent per percent of parameter", table)
    for model, method in {column.model: column.method for column in columns}.items():
        print(f"{model}: {method}")


def _may_lie(value: float, spread: Spread | None) -> str:
    """Write a range in percent of its value, and whose it is."""
    if spread is None:
        return "no range"
    low, high = sorted(100.0 * (end / value - 1.0) for end in (spread.low, spread.high))
    even = abs(low + high) < 1e-6 * (high - low)
    percent = f"±{high:.2g}" if even else f"{low:+.2g} to {high:+.2g}"
    return f"{percent} {spread.whose}"


def _print_uncertainty(uncertain: Sequence[Uncertainty]) -> None:
    from rich.table import Table

    from tactgen.geometry.formats import engineering, share, signed

    table = Table("number")
    for name in ("value", "numerical", "95 % of samples"):
        table.add_column(name, justify="right")
    table.add_column("main contributors")
    for row in uncertain:
        low, high = (100.0 * (end / row.value - 1.0) for end in (row.low, row.high))
        contributors = (f"{key} {100 * index:.0f} %" for key, index, _ in row.contributors[:3])
        table.add_row(
            row.target.label + (" (ill-conditioned)" if row.target.ill_conditioned else ""),
            engineering(row.value, row.target.unit),
            f"±{share(row.numerical / row.value)}",
            f"{signed(low, 1)} … {signed(high, 1)} %",
            ", ".join(contributors),
        )
    _print("uncertainty from the ranges of the parameters", table)
