"""Speed, memory and accuracy of the transfer-matrix model."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device, Drive, Load, Support
from tactgen.tmm.beam.mounted_beam import mounted_response
from tactgen.tmm.beam.parametric import Actuator, tip_response
from tactgen.tmm.beam.sections import section
from tactgen.tmm.beam.span import BLOCK
from tactgen.tmm.beam.transfer_matrix import chain
from tactgen.tmm.ports.multiport import respond, terminate
from tactgen.tmm.ports.supports_and_loads import base_stiffness, ends_of, tip_stiffness
from tactgen.validation.evidence.bench import Bench, Target, Timing
from tactgen.validation.evidence.bench_timing import least_time, on_one_core, peak_memory
from tactgen.validation.evidence.cases import textbook_beam
from tactgen.validation.evidence.cases.exact_beam import relative_error
from tactgen.validation.evidence.stress_beam import exactly

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


#: Error asked for.
_WANTED = 1e-12


def timing_of(path: str, case: str, points: int, seconds: float, error: float) -> Timing:
    """Timing of one way over one range of frequencies."""
    values: dict[str, str | float] = {
        "way": path, "range": case, "points": points, "seconds": seconds,
        "points_per_second": points / seconds, "error": error,
    }  # fmt: skip
    return Timing(path, case, 1e9 * seconds / points, error, values, _WANTED)


def run(quick: bool, announce: Callable[[str], None]) -> Bench:
    """Measure everything on one core; a minute, or a third of it if `quick`."""
    started = time.perf_counter()
    timings = []
    for case in CASES:
        for path in (*_PATHS, _CASCADE, _NAIVE):
            announce(f"tmm: {path}, {case}")
            points = (100_000 if quick else 1_000_000) // (1 if path in _PATHS else 20)
            seconds = on_one_core(__name__, "seconds_of", path, case, points)
            timings.append(timing_of(path, case, points, seconds, error_of(path, case)))
    announce("tmm: design map")
    map_time = on_one_core(__name__, "map_seconds")
    announce("tmm: memory")
    points = 1_000_000 if quick else 10_000_000
    memory = on_one_core(__name__, "memory_of", points)
    rate = next(1e9 / t.cost for t in timings if t.path == _CLOSED)
    targets = (
        Target("terminated points per second", 1.5e6, rate, "points/s", False, _CLOSED),
        Target(
            "design map, 200 lengths x 2000 frequencies x 3 loads", 2.0, map_time, "s", True,
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
    seconds = time.perf_counter() - started
    return Bench("tmm", conditions, tuple(timings), targets, seconds, "time per point (ns)")


def seconds_of(path: str, case: str, points: int) -> float:
    """Least of three processor times (s) of one path; attachments are given."""
    f = _spaced(case, points)
    attached = _attached(f)
    return least_time(lambda: _velocity(path, f, *attached), 3)[0]


def map_seconds() -> float:
    """Least of three processor times (s) of a design map, attachments included."""
    kinds = Load(kind="none"), Load(), Load(kind="mass", mass=1e-3)
    axes = np.linspace(5e-3, 40e-3, 200), np.linspace(10.0, 2e3, 2000)
    l, f = (grid.ravel() for grid in np.meshgrid(*axes, indexing="ij"))

    def work() -> None:
        for load in kinds:
            tip_response(_actuator(load), {"bimorph.length": l}, f)

    return least_time(work, 3)[0]


def memory_of(points: int) -> int:
    """Peak memory (bytes) of this process after one long sweep."""
    tip_response(_actuator(Load()), {}, np.linspace(10.0, 2e3, points))
    return peak_memory()


def _actuator(load: Load) -> Actuator:
    return Actuator(Device(), Support(), load, Beam(), Drive())


def error_of(path: str, case: str) -> float:
    """Worst relative error of the tip velocity against 80-digit arithmetic."""
    f = _spaced(case, _SAMPLES)
    errors = []
    for frequency, velocity in zip(f.tolist(), _velocity(path, f, *_attached(f)), strict=True):
        _, (w_tip, *_) = exactly(_BEAM, _LENGTH, frequency, _ENDS)
        errors.append(relative_error(velocity / (2j * np.pi * frequency), w_tip))
    return float(np.max(np.nan_to_num(errors, nan=np.inf)))


def _attached(f: Floats) -> tuple[tuple[Complex, Complex], Complex]:
    """Dynamic stiffnesses of base and tip, which are not timed."""
    assert _ENDS.base is not None
    return base_stiffness(_ENDS.base, f), tip_stiffness(_ENDS.tip, f)


def _velocity(path: str, f: Floats, base: tuple[Complex, Complex], tip: Complex) -> Complex:
    omega = 2.0 * np.pi * f
    if path == _NAIVE:
        a = textbook_beam.transfer(_BEAM, _LENGTH, f)
        velocity: Complex = textbook_beam.response(a, f, base=base, tip=tip)[0]
        return velocity
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
