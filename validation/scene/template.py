"""A scene file with every key, as ``tactgen init`` writes it."""

from __future__ import annotations

from pathlib import Path

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.validation.catalogue.models import MODELS, WITNESSES, models_of
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.scene.files import NEUTRAL
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.parameter_list import ParameterRow, parameter_rows

_HEAD = """\
# A tactgen scene.  Lines without "# " are the conditions of your test: how the device is held,
# loaded, wired and driven.  Set them first.  All other keys are commented out and show the value
# of the paper's device; remove the leading "# " from those that you change.
# A quantity with a unit must be written with its unit.  A number of the device may carry its
# tolerance: "0.26 ± 0.01 mm", "60 (50..80)", "50 V ± 2 %".
# Run:  tactgen solve THIS_FILE      tactgen report THIS_FILE      tactgen plan THIS_FILE

description = "my device"
start_from = "neutral"    # conditions that this file does not state: "neutral" or "paper"
"""
_SKIPPED = ("name", "description", "start_from")


def write_template(path: Path) -> Path:
    """Write the template.

    Raises InputError if the file exists already, is named as another format, or cannot be written.
    """
    if path.suffix != ".toml":
        raise InputError(f"{path} must end in .toml, the format of scenes; name the file so")
    if path.exists():
        raise InputError(f"{path} exists already; choose another file name or remove it first")
    return write_text(path, template())


def template() -> str:
    """Template's text: valid TOML, the paper's device under neutral conditions."""
    scene, _ = load_scene("paper")
    rows = [row for row in parameter_rows(scene, {}) if row.key not in _SKIPPED]
    lines = [_HEAD]
    lines += [_line(row, row.key) for row in rows if "." not in row.key]
    group = ""
    for row in rows:
        head, _, name = row.key.rpartition(".")
        if not head:
            continue
        if head != group:
            lines += ["", f"[{head}]"]
            group = head
        lines.append(_line(row, name))
    return "\n".join(lines) + "\n"


def _lists() -> dict[str, tuple[str, str]]:
    """Keys whose TOML value is a list or text of another form, with what to add."""
    usual = ", ".join(f'"{name}"' for name in models_of("bimorph") if name in WITNESSES)
    return {
        "frequency": ('"10 Hz:1000 Hz:100:log"', ""),
        "models": (f"[{usual}]", f": all, or of {', '.join(MODELS)}"),
        "quantities": ('["all"]', f": all, or of {', '.join(QUANTITIES)}"),
    }


def _line(row: ParameterRow, name: str) -> str:
    written, choices = _lists().get(row.key, ("", ""))
    value = written or (row.written if _is_number(row.written) else f'"{row.written}"')
    if row.written == "derived":
        value = '"13 GPa"'
    source = f"  [{row.source}]" if row.source else ""
    if row.key in NEUTRAL:
        return f'{name} = "{NEUTRAL[row.key]}"    # {row.meaning}'
    return f"# {name} = {value}    # {row.meaning}{choices}{source}"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
