"""What commands say as a whole: standard output, words beside it, and the files they write.

Each case is a few calls in one folder, on models that answer in milliseconds; what they say is
held against approved outputs.  Seconds, keys and the code's hashes are left out.
"""

import csv
import html
import json
import re
import shlex
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from alike import TINY
from approved import described, in_text, page_text

from tactgen.validation.command_line import progress
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine import costs

DATA = Path(__file__).parents[2] / "data"
CURVE = "frequency (Hz),velocity (mm/s)\n" + "".join(
    f"{f},{v}\n"
    for f, v in zip(
        range(600, 960, 30),
        (4.1, 5.2, 6.9, 9.6, 14.5, 22.0, 25.5, 17.5, 12.0, 9.1, 7.3, 6.1),
        strict=True,
    )
)
LOAD = "frequency (Hz),impedance_re (N s/m),impedance_im (N s/m)\n" + "".join(
    f"{f},{0.5 + 3.0 / f},{0.002 * f - 80.0 / f}\n" for f in (10, 30, 60, 100, 200, 400, 700, 1000)
)
THRESHOLD = "frequency (Hz),threshold (um)\n20,1.5\n100,0.6\n600,0.9\n"
OWN = """\
description = "a head that floats, a load that was measured, a threshold of one's own"
frequency = "20,100,600"
models = ["tmm", "network"]
quantities = ["tip_displacement", "detection_ratio", "load_force", "rod_position"]
[bimorph]
length = "18 mm"
[support]
kind = "contact"
[coil]
current = "90 mA"
[load]
kind = "table"
file = "load.csv"
[threshold]
kind = "table"
file = "threshold.csv"
"""
#: By name, the calls of a case.
CASES = {
    name: calls.splitlines()
    for name, calls in re.findall(
        r"^\[(.*)\]\n((?:.+\n)+)", (DATA / "calls.txt").read_text(encoding="utf-8"), re.MULTILINE
    )
}


@pytest.fixture
def told_alike(own_store, monkeypatch):
    """Keep nothing from other cases, neither answers nor what they cost, and figures as text."""
    monkeypatch.setattr(costs, "_LEAST", np.inf)
    in_text(monkeypatch)


@pytest.fixture
def announced(monkeypatch):
    """Return a list to which what a command says of its progress is added, as it is said."""
    found, announcer = [], progress.announcer

    @contextmanager
    def noted(*given):
        with announcer(*given) as announce:
            yield lambda text: found.append(text) or announce(text)

    monkeypatch.setattr(progress, "announcer", noted)
    return found


def without_times(text):
    """Return words of progress without the time that is left, and without a search's own steps."""
    text = re.sub(r"^\d+ points tried", "… points tried", re.sub(r", about .* left", "", text))
    return re.sub(r"[\d.]+", "…", text) if text.endswith(("%", "harmonics")) else text


@pytest.mark.parametrize("case", CASES)
@pytest.mark.usefixtures("told_alike")
def test_said(case, announced, approved, capsys, tmp_path, monkeypatch):
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    given = {"m.csv": CURVE, "load.csv": LOAD, "threshold.csv": THRESHOLD, "own.toml": OWN}
    for name, text in given.items():
        (folder / name).write_text(text, encoding="utf-8")
    said = []
    for call in CASES[case]:
        code = main(shlex.split(call))
        out, beside = capsys.readouterr()
        said += [f"$ {call}", f"exit code {code}", as_said(out), as_said(beside)]
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name not in given:
            said += [f"file {path.relative_to(folder)}", _READERS[path.suffix](path)]
    if announced:
        approved("\n".join(dict.fromkeys(map(without_times, announced))), "announced")
    text = "\n".join(said).replace(str(folder), "HERE")
    approved(re.sub(r"(?<![\w.])[0-9a-f]{16}\b", "a key", text))


def as_said(text):
    """Return what a stream holds, of JSON its entries, without what a run happens to take."""
    if text.startswith("{"):
        return described(steady(json.loads(text)))
    return re.sub(r"\d+(\.\d+)? s(?= )", "… s", text)


def steady(value):
    """Return JSON without seconds, keys and folders, and bars of rounding's size as words."""
    if isinstance(value, list):
        flat = np.array(value, dtype=object).ravel().tolist()
        numbers = bool(flat) and all(isinstance(entry, int | float) for entry in flat)
        return np.array(value) if numbers else [steady(entry) for entry in value]
    if not isinstance(value, dict):
        return value
    left_out = {"seconds", "folder", "limit", "kinds"}
    kept = {name: steady(entry) for name, entry in value.items() if name not in left_out}
    for bar, of in (("uncertainty", "value"), ("bar", "value"), ("bars", "margins")):
        if {bar, of} <= value.keys() and not isinstance(value[bar], dict):
            bars, numbers = (np.array(value[name], dtype=float) for name in (bar, of))
            if np.nanmax(bars, initial=0.0) < 1e-9 * np.nanmax(np.abs(numbers), initial=0.0):
                kept[bar] = "rounding"
    return kept


def table_text(path):
    """Return a table's columns, a line each."""
    rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
    return "\n".join(
        f"  {head}: {len(cells)} {' '.join(dict.fromkeys(short(cell) for cell in cells))}"
        for head, *cells in zip(*rows, strict=True)
        if head != "uncertainty"
    )


def short(cell):
    """Return a cell with seven digits; noughts, which are rounding, are one word."""
    try:
        return f"{float(cell) if abs(float(cell)) > TINY else 0.0:.7g}"
    except ValueError:
        return cell


def netcdf_text(path):
    """Return what a netCDF file says of itself, and its arrays."""
    from scipy.io import netcdf_file

    hashes = {"code_sha256", "versions", "scene_sha256", "scene_values", "program"}
    with netcdf_file(path, mmap=False) as file:
        lines = [
            f"  {name}: {value.decode() if isinstance(value, bytes) else value}"
            for name, value in file._attributes.items()
            if name not in hashes
        ]
        for name, variable in file.variables.items():
            if name == "seconds" or name.endswith("_uncertainty"):
                continue
            about = dict(variable._attributes)
            lines.append(f"  {name} {variable.dimensions} {about}")
            data = variable[...]
            text = data.tobytes().decode().replace("\0", " ") if data.dtype.kind == "S" else None
            lines.append(f"    {text.split()}" if text is not None else described(data, "   "))
    return "\n".join(lines)


def page(path):
    """Return what a page says, and the numbers that it holds for its script."""
    text = path.read_text(encoding="utf-8")
    data = re.findall(r'type="application/json"[^>]*>(.*?)</script>', text, flags=re.DOTALL)
    plain = [each for each in data if '"offset"' not in each]  # no numbers elsewhere in the page
    return "\n".join([page_text(text), *(described(steady(json.loads(each))) for each in plain)])


def plain_text(path):
    return path.read_text(encoding="utf-8")


_READERS = {
    ".csv": table_text, ".nc": netcdf_text, ".html": page, ".toml": plain_text,
    ".svg": lambda path: html.unescape(plain_text(path)), ".json": plain_text,
}  # fmt: skip
