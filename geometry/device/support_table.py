"""A measured support as a CSV file: dynamic stiffness over frequency.

Read and refused here; what models make of it is in ``tmm/ports/measured_loads``.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.csv_tables import read_table, remembered
from tactgen.geometry.device.load_table import check_count, complex_column
from tactgen.geometry.device.parameters import Support
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import DYNAMIC_ROTATION, DYNAMIC_STIFFNESS, FREQUENCY, PHASE, quoted

_EXAMPLE = (
    "frequency (Hz), rotational_stiffness_re (N m/rad), rotational_stiffness_im (N m/rad), and if "
    "it was measured lateral_stiffness_re (N/m), lateral_stiffness_im (N/m)"
)
_ROTATIONAL, _LATERAL = "rotational_stiffness", "lateral_stiffness"
_KINDS = {_ROTATIONAL: DYNAMIC_ROTATION, _LATERAL: DYNAMIC_STIFFNESS}
_KNOWN = {"frequency": FREQUENCY} | {
    f"{kind}{part}": PHASE if part == "_phase" else unit
    for kind, unit in _KINDS.items()
    for part in ("", "_phase", "_re", "_im")
}
#: Share of the magnitude by which the imaginary part may be below 0: digits of a file, no more.
_PRINTED = 1e-6


@dataclass(frozen=True, eq=False)
class SupportTable:
    """Measured support: dynamic stiffness over frequency, time factor e^{+jΩt}."""

    source: str  #: What messages call it
    frequencies: Floats  #: (n,) Hz, ascending
    rotational: Complex  #: (n,) Moment per rotation of the base about y (N m/rad)
    lateral: Complex | None  #: (n,) Force per displacement along x (N/m); None holds it

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency (Hz)."""
        return float(self.frequencies[0]), float(self.frequencies[-1])


def support_table(support: Support) -> SupportTable:
    """Table that a scene's support names.

    Raises InputError if there is none, or the file cannot be used.
    """
    if not support.file:
        raise InputError(
            'support.kind = "table" needs support.file, the path of a CSV file with the columns '
            f"{_EXAMPLE}"
        )
    return remembered(read_support_table, support.file)


def read_support_table(path: Path) -> SupportTable:
    """Read a table of a support.

    Columns, each with its unit in the header: ``frequency``; ``rotational_stiffness`` and, if it
    was measured, ``lateral_stiffness``, each as ``…_re`` with ``…_im`` or as a magnitude with
    ``…_phase``.

    Raises InputError in one sentence: if columns or units are not these, the frequencies do not
    ascend, there are too few, or the support would give energy away.
    """
    source = f"support.file = {quoted(str(path))}"
    table = read_table(path, source, _KNOWN, _EXAMPLE)
    found = {kind: complex_column(table, kind, unit, source) for kind, unit in _KINDS.items()}
    frequencies, rotational = table.columns["frequency"], found[_ROTATIONAL]
    if rotational is None:
        raise InputError(f"{source} has no rotational stiffness; give the columns {_EXAMPLE}")
    check_count(frequencies.size, source)
    for kind, values in found.items():
        if values is None:
            continue
        active = np.flatnonzero(values.imag < -_PRINTED * np.abs(values))
        if active.size:
            i = int(active[0])
            raise InputError(
                f"{source} line {table.lines[i]}: at {frequencies[i]:g} Hz the imaginary part of "
                f"the {kind} is {values[i].imag:.4g} {_KINDS[kind].si}, so that the support would "
                "give energy away; check the sign of the phase (time factor exp(+jwt)), or remove "
                "the line"
            )
    return SupportTable(source, frequencies, rotational, found[_LATERAL])
