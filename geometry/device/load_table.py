"""A measured load as a CSV file: mechanical impedance or dynamic stiffness over frequency.

Read and refused here; what a model makes of it is in ``tmm/ports/measured_loads``.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.csv_tables import Table, read_table, remembered
from tactgen.geometry.device.parameters import Load
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import DYNAMIC_STIFFNESS, FREQUENCY, IMPEDANCE, PHASE, Unit, quoted

_EXAMPLE = "frequency (Hz), impedance_re (N s/m), impedance_im (N s/m)"
_KINDS = {"impedance": IMPEDANCE, "stiffness": DYNAMIC_STIFFNESS}
_KNOWN = {"frequency": FREQUENCY} | {
    f"{kind}{part}": PHASE if part == "_phase" else unit
    for kind, unit in _KINDS.items()
    for part in ("", "_phase", "_re", "_im")
}
#: Fewer points leave nothing to judge the interpolation by.
LEAST = 6
#: Most points that a table may have: a sweep of a laboratory analyser has a few thousand.
_MOST = 100_000
#: Share of the magnitude by which the real part may be below 0: digits of a file, no more.
_PRINTED = 1e-6


@dataclass(frozen=True, eq=False)
class LoadTable:
    """Measured load: impedance over frequency."""

    source: str  #: What messages call it
    frequencies: Floats  #: (n,) Hz, ascending
    #: (n,) complex Force per velocity (N s/m), time factor e^{+jΩt}; a spring's is −jk/Ω
    impedance: Complex

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency (Hz)."""
        return float(self.frequencies[0]), float(self.frequencies[-1])


def load_table(load: Load) -> LoadTable:
    """Table that a scene's load names.

    Raises InputError if there is none, or the file cannot be used.
    """
    if not load.file:
        raise InputError(
            'load.kind = "table" needs load.file, the path of a CSV file with the columns '
            f"{_EXAMPLE}"
        )
    return remembered(read_load_table, load.file)


def read_load_table(path: Path) -> LoadTable:
    """Read a table of a load.

    Columns, each with its unit in the header: ``frequency``, and the ``impedance`` (force per
    velocity) or the dynamic ``stiffness`` (force per displacement), either as ``…_re`` with
    ``…_im`` or as a magnitude with ``…_phase``.

    Raises InputError in one sentence: if columns or units are not these, the frequencies do not
    ascend, there are too few, or the load would give energy away.
    """
    source = f"load.file = {quoted(str(path))}"
    table = read_table(path, source, _KNOWN, _EXAMPLE)
    kind, values = _complex(table, source)
    frequencies = table.columns["frequency"]
    check_count(frequencies.size, source)
    impedance = values if kind == "impedance" else values / (2j * np.pi * frequencies)
    _check_passive(frequencies, impedance, table.lines, source)
    return LoadTable(source, frequencies, impedance)


def check_count(count: int, source: str) -> None:
    """Refuse tables of too few or too many frequencies."""
    if not LEAST <= count <= _MOST:
        raise InputError(
            f"{source} holds {count} frequencies; give {LEAST} to {_MOST} over the band of interest"
        )


def _complex(table: Table, source: str) -> tuple[str, Complex]:
    """Kind of table (impedance or stiffness) and its complex values."""
    names = set(table.columns) - {"frequency"}
    for kind, unit in _KINDS.items():
        if names in ({f"{kind}_re", f"{kind}_im"}, {kind, f"{kind}_phase"}):
            values = complex_column(table, kind, unit, source)
            assert values is not None
            return kind, values
    raise InputError(
        f"{source} has besides the frequency {_listed(names)}, which is not a complex load; give "
        "impedance_re and impedance_im, impedance and impedance_phase, or the same of stiffness"
    )


def complex_column(table: Table, kind: str, unit: Unit, source: str) -> Complex | None:
    """Complex values (n,) of a kind from its two columns; None if neither is there.

    Raises InputError if one of two columns is missing, or a magnitude is below 0.
    """
    columns = table.columns
    own = {name for name in columns if name.removesuffix("_phase").removesuffix("_re")
           .removesuffix("_im") == kind}  # fmt: skip
    if own == {f"{kind}_re", f"{kind}_im"}:
        return np.asarray(columns[f"{kind}_re"] + 1j * columns[f"{kind}_im"])
    if own == {kind, f"{kind}_phase"}:
        negative = np.flatnonzero(columns[kind] < 0.0)
        if negative.size:
            line, size = table.lines[negative[0]], columns[kind][negative[0]]
            raise InputError(
                f"{source} line {line}: {kind} {size:g} {unit.si} is below 0 as no "
                f"magnitude is; give {kind}_re and {kind}_im, or add 180 deg to the phase"
            )
        return np.asarray(columns[kind] * np.exp(1j * columns[f"{kind}_phase"]))
    if own:
        raise InputError(
            f"{source} has of {kind} {' and '.join(sorted(own))}; give {kind}_re and {kind}_im, or "
            f"{kind} and {kind}_phase"
        )
    return None


def _listed(names: set[str]) -> str:
    return " and ".join(name for name in _KNOWN if name in names) or "no column"


def _check_passive(frequencies: Floats, impedance: Complex, lines: list[int], source: str) -> None:
    """Refuse a load that gives energy away at some frequency."""
    active = np.flatnonzero(impedance.real < -_PRINTED * np.abs(impedance))
    if active.size:
        i = int(active[0])
        raise InputError(
            f"{source} line {lines[i]}: at {frequencies[i]:g} Hz the real part of the impedance is "
            f"{impedance[i].real:.4g} N s/m, so that the load would give energy away; check the "
            "sign of the phase (time factor exp(+jwt)), or remove the line"
        )
