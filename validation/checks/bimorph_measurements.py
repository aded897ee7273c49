"""What the rows of :mod:`validation.checks.bimorph` measure, on the built-in scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactgen.tmm.ports.finger import finger_spring_damper
from tactgen.validation.checks.cases.fineness import cached, level
from tactgen.validation.engine.results import Estimate
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.scene.scene import Scene, load_scene

if TYPE_CHECKING:
    from tactgen.validation.models.difference import Step


def _scene(name: str, *overrides: str) -> Scene:
    return load_scene(name, overrides)[0]


@cached
def _solved(name: str, models: str, quantities: str, *overrides: str) -> Solution:
    return solve(_scene(name, *overrides), models.split(","), quantities.split(","))


def _value(name: str, model: str, quantity: str, *overrides: str) -> NDArray[Any]:
    found: NDArray[Any] = _solved(name, model, quantity, *overrides).get(quantity, model).value
    return found


def _first(name: str, model: str, quantity: str, *overrides: str) -> Estimate:
    """Return a number, or the first of a list, with the model's own bar."""
    return _number(_solved(name, model, quantity, *overrides), model, quantity)


def _number(found: Solution, model: str, quantity: str, number: int = 0) -> Estimate:
    q = found.get(quantity, model)
    value, bar = (float(np.ravel(array)[number]) for array in (q.value, q.error))
    return Estimate(value, bar)


@cached
def _prototype_peak() -> tuple[float, float]:
    """Locate the velocity peak by repeated narrowing around the largest of a sweep."""
    low, high = 600.0, 1000.0
    while True:
        sweep = f"frequency={low!r}:{high!r}:101"
        speed = np.abs(_value("prototype", "tmm", "tip_velocity", sweep))
        at = int(np.clip(np.argmax(speed), 1, 99))
        step = (high - low) / 100.0
        centre = low + at * step
        if step < 1e-2:
            # vertex of the parabola through the three highest points
            left, middle, right = speed[at - 1 : at + 2]
            shift = 0.5 * (left - right) / (left - 2.0 * middle + right)
            return centre + shift * step, float(middle - 0.25 * (left - right) * shift)
        low, high = centre - step, centre + step


def prototype_peak_frequency() -> float:
    """Frequency of the prototype's velocity peak (Hz)."""
    return _prototype_peak()[0]


def prototype_peak_velocity() -> float:
    """Height of that peak (m/s)."""
    return _prototype_peak()[1]


_CLAMPED = ("support.kind=clamped", "load.kind=none", "drive.voltage=1V")


def clamped_short_circuit() -> Estimate:
    """First short-circuit frequency of the clamped paper bimorph by TMM (Hz)."""
    return _first("paper", "tmm", "short_circuit_frequencies", *_CLAMPED)


def clamped_open_circuit() -> Estimate:
    """First open-circuit frequency (Hz)."""
    return _first("paper", "tmm", "open_circuit_frequencies", *_CLAMPED)


def clamped_static() -> Estimate:
    """Return the static tip displacement at 1 V (m)."""
    return _first("paper", "tmm", "static_tip_displacement", *_CLAMPED)


def beam_first_frequency() -> Estimate:
    """First short-circuit frequency by beam elements (Hz)."""
    return _first("paper", "beam", "short_circuit_frequencies", *_CLAMPED)


def finger_stiffness_maximum() -> float:
    """Largest stiffness of the finger between 10 and 1000 Hz (N/m)."""
    return float(finger_spring_damper(np.linspace(10.0, 1000.0, 9901))[0].max())


def finger_damping_minimum() -> float:
    """Least damping of the finger between 10 and 1000 Hz (N s/m)."""
    return float(finger_spring_damper(np.linspace(10.0, 1000.0, 9901))[1].min())


def finger_damping_start() -> float:
    """Damping of the finger at 10 Hz (N s/m)."""
    return float(finger_spring_damper(np.array([10.0]))[1][0])


def j1_default_deflection() -> Estimate:
    """Return the static tip displacement of job J1 on the default mesh (m)."""
    return _first("j1", "solid", "static_tip_displacement")


def j1_default_first_frequency() -> Estimate:
    """First frequency of job J1 on the default mesh (Hz)."""
    return _first("j1", "solid", "short_circuit_frequencies")


def _j1_fine() -> Solution:
    quantities = "static_tip_displacement,short_circuit_frequencies"
    # bricks begin at level 2
    return _solved("j1", "solid", quantities, f"mesh.level={level(4, least=2)}")


def j1_fine_deflection() -> Estimate:
    """Return the static tip displacement of job J1 on the fine mesh (m)."""
    return _number(_j1_fine(), "solid", "static_tip_displacement")


def j1_fine_frequency(number: int) -> Estimate:
    """Natural frequency `number` (from 0) of job J1 on the fine mesh (Hz)."""
    return _number(_j1_fine(), "solid", "short_circuit_frequencies", number)


def j1_cad_against_bricks() -> float:
    """Largest difference of the models solid and cad on job J1, in sums of their bars."""
    names = (
        "static_tip_displacement,capacitance_free,capacitance_blocked,coupling_factor,"
        "short_circuit_frequencies"
    )
    found = _solved("j1", "solid,cad", names, "accuracy=3e-3")
    ratios = []
    for name in names.split(","):
        bricks, tetrahedra = (found.get(name, model) for model in ("solid", "cad"))
        assert bricks.classes == tetrahedra.classes
        apart = np.abs(bricks.value - tetrahedra.value)
        ratios.append(np.max(apart / (bricks.error + tetrahedra.error)))
    return float(np.max(ratios))


def lumped_over_tmm_static() -> float:
    """Ratio of the two static tip displacements."""
    lumped, tmm = (_value("paper", m, "static_tip_displacement") for m in ("lumped", "tmm"))
    return float(lumped / tmm)


def lumped_over_tmm_frequency() -> float:
    """Ratio of the two first short-circuit frequencies on the paper's support."""
    lumped, tmm = (_value("paper", m, "short_circuit_frequencies")[0] for m in ("lumped", "tmm"))
    return float(lumped / tmm)


@cached
def _clamped_steps() -> list[Step]:
    """Return steps from beam to solid of the paper's bimorph on a clamp, where f1 is its own."""
    from tactgen.validation.models.difference import beam_to_solid

    scene = _scene("paper", "support.kind=clamped")
    return beam_to_solid(scene, lambda _: None, level=level(1, least=0))


def beam_like_solid_over_tmm(quantity: str) -> float:
    """Ratio of the solid with a beam's constants and a linear potential to TMM."""
    beam, solid = (step.values for step in _clamped_steps()[1:3])
    return solid[quantity] / beam[quantity]


def field_variation(quantity: str) -> float:
    """Ratio of measured to predicted change by the field's variation, both plus 1."""
    step = _clamped_steps()[3]
    return (1.0 + step.change[quantity]) / (1.0 + step.predicted[quantity])


def _deflection(frequency: float, *overrides: str) -> float:
    sweep = f"frequency={frequency!r}"
    return float(np.abs(_value("paper", "tmm", "tip_displacement", sweep, *overrides)[0]))


def paper_end_deflection() -> float:
    """Return the loaded deflection at 1000 Hz and 50 V (m)."""
    return _deflection(1000.0)


def paper_slope() -> float:
    """Slope of the line fitted to the loaded deflection from 10 to 1000 Hz (m/Hz)."""
    values = np.abs(_value("paper", "tmm", "tip_displacement", "frequency=10:1000:496"))
    return float(np.polyfit(np.linspace(10.0, 1000.0, 496), values, 1)[0])


def _threshold_voltage(frequency: float) -> float:
    return float(_value("paper", "tmm", "threshold_voltage", f"frequency={frequency!r}")[0])


def threshold_voltage_start() -> float:
    """Voltage for 2 um at 10 Hz under the finger (V)."""
    return _threshold_voltage(10.0)


def threshold_voltage_250() -> float:
    """Voltage for 0.2 um at 250 Hz under the finger (V)."""
    return _threshold_voltage(250.0)


def threshold_voltage_1000() -> float:
    """Voltage for 1 um at 1000 Hz under the finger (V)."""
    return _threshold_voltage(1000.0)
