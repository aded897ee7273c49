"""Speed and memory of the transfer-matrix model, and what accuracy they come with."""

from __future__ import annotations

import math
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.pieces import Piece
from tactgen.geometry.device.parameters import Beam, Device, Drive, Load, Support
from tactgen.tmm.beam.mounted_beam import mounted_response
from tactgen.tmm.beam.parametric import Actuator, tip_response
from tactgen.tmm.beam.sections import section
from tactgen.tmm.beam.span import BLOCK
from tactgen.tmm.beam.transfer_matrix import chain
from tactgen.tmm.ports.elements import base_stiffness, ends_of, tip_stiffness
from tactgen.tmm.ports.multiport import respond, terminate
from tactgen.validation.bench.one_core import least_time, on_one_core, peak_memory
from tactgen.validation.bench.result import Bench, Target, Timing
from tactgen.validation.checks.cases import reference_beam as reference
from tactgen.validation.checks.cases import textbook_beam

#: Ranges of frequency (Hz): the paper's, and one that asks for more.
CASES = {"10 Hz to 2 kHz": (10.0, 2e3), "1 mHz to 1 MHz": (1e-3, 1e6)}
_CHUNKS = (256, 1024, BLOCK, 16384, 262144)
_PATHS = {f"closed form, chunk {n}": n for n in _CHUNKS}
_CLOSED = f"closed form, chunk {BLOCK}"
_CASCADE, _NAIVE = "dynamic stiffness and LU", "matrix A (naive)"

_LENGTH = 20e-3
_BEAM = section(Piece("bimorph", _LENGTH), Device(), Beam(), lossy=True)
_ENDS = ends_of(Support(), Load())
#: Frequencies per case at which errors are taken.
_SAMPLES = 15


@dataclass(frozen=True)
class BeamTiming(Timing):
    """One way of computing, over one range of frequencies.

    Attributes
    ----------
    path : str
        The way.
    case : str
        The range.
    points : int
        Frequency points timed.
    seconds : float
        Least of several runs.
    error : float
        Worst relative error of the tip velocity on a sample; infinite where it overflows.
    """

    path: str
    case: str
    points: int
    seconds: float
    error: float

    columns: ClassVar[tuple[str, ...]] = (
        "way",
        "range",
        "points",
        "points per second",
        "ns per point",
        "worst error",
    )
    fields: ClassVar[tuple[str, ...]] = (
        "way",
        "range",
        "points",
        "seconds",
        "points_per_second",
        "error",
    )
    cost_label: ClassVar[str] = "time per point (ns)"
    #: Error asked for.
    wanted: float = 1e-12

    @property
    def rate(self) -> float:
        """Points per second."""
        return self.points / self.seconds

    @property
    def cost(self) -> float:
        """What is plotted along x."""
        return 1e9 / self.rate

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the table, as `columns`."""
        return (
            self.path, self.case, f"{self.points:,}", f"{self.rate:,.0f}", f"{self.cost:.0f}",
            f"{self.error:.1e}",
        )  # fmt: skip

    @property
    def values(self) -> tuple[str | float, ...]:
        """The row of the file, as `fields`."""
        return self.path, self.case, self.points, self.seconds, self.rate, self.error


def run(quick: bool, announce: Callable[[str], None]) -> Bench:
    """Measure everything on one core; a minute, or a third of it if `quick`."""
    started = time.perf_counter()
    timings = []
    for case in CASES:
        for path in (*_PATHS, _CASCADE, _NAIVE):
            announce(f"tmm: {path}, {case}")
            points = (100_000 if quick else 1_000_000) // (1 if path in _PATHS else 20)
            seconds = on_one_core(__name__, "seconds_of", path, case, points)
            timings.append(BeamTiming(path, case, points, seconds, error_of(path, case)))
    announce("tmm: design map")
    shape = [200, 2000, 3]
    map_seconds = on_one_core(__name__, "map_seconds", *shape)
    announce("tmm: memory")
    points = 1_000_000 if quick else 10_000_000
    memory = on_one_core(__name__, "memory_of", points)
    rate = next(t.rate for t in timings if t.path == _CLOSED)
    targets = (
        Target("terminated points per second", 1.5e6, rate, "points/s", False, _CLOSED),
        Target(
            "design map, 200 lengths x 2000 frequencies x 3 loads", 2.0, map_seconds, "s", True,
            "tactgen.tmm.beam.parametric.tip_response",
        ),
        Target(
            f"peak memory of {points:.0e} points", 1e9, memory, "B", True,
            "largest resident size of a process that does only this",
        ),
    )  # fmt: skip
    conditions = (
        "20 mm bimorph on the paper's springs under the finger, 1 V; one process per row with one "
        "thread (OMP_NUM_THREADS=1 and its like), processor time, best of three runs; "
        f"numpy {np.__version__}, {platform.machine()}"
    )
    return Bench("tmm", conditions, tuple(timings), targets, time.perf_counter() - started)


def seconds_of(path: str, case: str, points: int) -> float:
    """Return the least of three processor times (s) of one path; attachments are given."""
    f = _spaced(case, points)
    attached = _attached(f)
    return least_time(lambda: _velocity(path, f, *attached), 3)[0]


def map_seconds(lengths: int, frequencies: int, loads: int) -> float:
    """Return the least of three processor times (s) of a design map, attachments included."""
    kinds = [Load(kind="none"), Load(), Load(kind="mass", mass=1e-3)][:loads]
    l, f = np.linspace(5e-3, 40e-3, lengths), np.linspace(10.0, 2e3, frequencies)
    l, f = (grid.ravel() for grid in np.meshgrid(l, f, indexing="ij"))

    def work() -> None:
        for load in kinds:
            tip_response(_actuator(load), {"bimorph.length": l}, f)

    return least_time(work, 3)[0]


def memory_of(points: int) -> int:
    """Return the peak memory (bytes) of this process after one long sweep."""
    tip_response(_actuator(Load()), {}, np.linspace(10.0, 2e3, points))
    return peak_memory()


def _actuator(load: Load) -> Actuator:
    return Actuator(Device(), Support(), load, Beam(), Drive())


def error_of(path: str, case: str) -> float:
    """Return the worst relative error of the tip velocity against 80-digit arithmetic."""
    f = _spaced(case, _SAMPLES)
    (lateral, rotational), tip = _attached(f)
    velocity, worst = _velocity(path, f, (lateral, rotational), tip), 0.0
    for i, frequency in enumerate(f):
        omega = 2.0 * np.pi * float(frequency)
        exact = reference.dynamic_stiffness(reference.constants(_BEAM), _LENGTH, omega)
        base = (complex(lateral[i]), complex(rotational[i]))
        w_tip, _, _ = reference.tip_motion(exact, base, complex(tip[i]))
        error = reference.relative_error(velocity[i] / (1j * omega), w_tip)
        worst = max(worst, math.inf if math.isnan(error) else error)
    return worst


def _attached(f: Floats) -> tuple[tuple[Complex, Complex], Complex]:
    """Return the dynamic stiffnesses of base and tip, which are not timed."""
    assert _ENDS.base is not None
    return base_stiffness(_ENDS.base, f), tip_stiffness(_ENDS.tip, f)


def _velocity(path: str, f: Floats, base: tuple[Complex, Complex], tip: Complex) -> Complex:
    omega = 2.0 * np.pi * f
    if path == _NAIVE:
        return textbook_beam.tip_velocity(_BEAM, _LENGTH, f, base=base, tip=tip)
    if path == _CASCADE:
        loads = {"w_base": base[0], "psi_base": base[1], "w_tip": tip}
        port = terminate(chain([(_BEAM, _LENGTH)], f), loads)
        w_tip = respond(port, {"voltage": 1.0}).motion["w_tip"]
    else:
        w_tip = mounted_response(
            _BEAM, _LENGTH, omega, base=base, tip=tip, chunk=_PATHS[path]
        ).w_tip
    return np.asarray(1j * omega * w_tip)


def _spaced(case: str, points: int) -> Floats:
    low, high = CASES[case]
    return (np.geomspace if high > 1e3 * low else np.linspace)(low, high, points)


@dataclass(frozen=True)
class SolidTiming(Timing):
    """One solution of one job by one way of the piezoelectric solid.

    Attributes
    ----------
    path, level : str
        The way, and how fine.
    case : str
        The job, J1 or J2.
    own : bool
        Whether it is ours or a peer's.
    unknowns : int
        Size of the system.
    phases : dict of str to float
        Processor time (s) of mesh, assembly, factor, solve, eigen, sweep, as far as they
        occur.
    process_seconds, peak_memory : float, int
        Processor time of the whole process (s), its largest resident size (bytes).
    errors : dict of str to float
        Relative, by value.
    """

    path: str
    level: str
    case: str
    own: bool
    unknowns: int
    phases: dict[str, float]
    process_seconds: float
    peak_memory: int
    errors: dict[str, float]

    steps: ClassVar = ("mesh", "assembly", "factor", "solve", "eigen", "sweep")
    columns: ClassVar[tuple[str, ...]] = (
        "way", "fineness", "job", "unknowns", *steps, "compute", "process", "memory",
        "deflection", "f1…f4", "capacitance", "sweep error",
    )  # fmt: skip
    fields: ClassVar[tuple[str, ...]] = (
        "way", "fineness", "job", "unknowns", *(f"{step}_seconds" for step in steps),
        "compute_seconds", "process_seconds", "peak_memory", "error_deflection", "error_f1",
        "error_f2", "error_f3", "error_f4", "error_capacitance", "error_sweep",
    )  # fmt: skip
    cost_label: ClassVar[str] = "compute time (s)"
    wanted: float = 1e-3

    @property
    def cost(self) -> float:
        """Processor time (s) of all phases."""
        return sum(self.phases.values())

    @property
    def frequency_error(self) -> float:
        """Worst error of the natural frequencies; nan in a sweep."""
        return max((e for name, e in self.errors.items() if name[0] == "f"), default=math.nan)

    @property
    def worst(self) -> float:
        """What is judged: deflection and natural frequencies, or the sweep."""
        return max(error for name, error in self.errors.items() if name != "capacitance")

    @property
    def curves(self) -> dict[str, float]:
        """Errors to plot, one panel each."""
        if "sweep" in self.errors:
            return {"J2: damped sweep": self.errors["sweep"]}
        return {
            "J1: deflection": self.errors["deflection"],
            "J1: worst of f1…f4": self.frequency_error,
        }

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the table, as `columns`."""

        def shown(name: str) -> str:
            return f"{self.errors[name]:.1e}" if name in self.errors else ""

        worst = self.frequency_error
        return (
            self.path, self.level, self.case, f"{self.unknowns:,}",
            *(f"{self.phases[step]:.2f}" if step in self.phases else "" for step in self.steps),
            f"{self.cost:.2f}", f"{self.process_seconds:.1f}", f"{self.peak_memory / 1e9:.2f}",
            shown("deflection"), "" if math.isnan(worst) else f"{worst:.1e}",
            shown("capacitance"), shown("sweep"),
        )  # fmt: skip

    @property
    def values(self) -> tuple[str | float, ...]:
        """The row of the file, as `fields`."""
        names = ("deflection", "f1", "f2", "f3", "f4", "capacitance", "sweep")
        return (
            self.path, self.level, self.case, self.unknowns,
            *(self.phases.get(step, "") for step in self.steps), self.cost, self.process_seconds,
            self.peak_memory, *(self.errors.get(name, "") for name in names),
        )  # fmt: skip
