"""Sensitivities of a scene's quantities, one column per quantity and frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.device.parameters import Drive
from geometry.errors import InputError
from tmm.beam.parametric import Actuator, parameter_keys
from tmm.beam.port_quantities import READOUTS
from tmm.beam.sensitivities import DIFFERENTIABLE, derivatives, values
from validation.catalogue.detection import DISPLAY_THRESHOLD
from validation.catalogue.quantities import QUANTITIES
from validation.engine.limits import check_held
from validation.scene.scene import Scene
from validation.studies.uncertainty.headline_numbers import actuator
from validation.studies.uncertainty.varied_keys import chosen_keys
from validation.view.formats import engineering

#: The quantity that follows from the tip's motion and a stated threshold.
_THRESHOLD, _VOLTAGE = "threshold_voltage", "drive.voltage"
#: Columns that a table for people has at most, if a quantity's frequencies can be thinned.
_SHOWN = 8


@dataclass(frozen=True)
class SensitivityColumn:
    """One number with its derivatives; complex quantities by their magnitude.

    Attributes
    ----------
    frequency : float or None
        In Hz, for quantities that depend on it.
    derivatives : dict of str to float
        dq/dp in SI units by scene key.
    logarithmic : dict of str to float
        d ln q / d ln p by scene key.
    """

    quantity: str
    unit: str
    frequency: float | None
    value: float
    derivatives: dict[str, float]
    logarithmic: dict[str, float]

    @property
    def label(self) -> str:
        """Heading for people, a word per line."""
        name = self.quantity.replace("_", "\n")
        if self.frequency is not None:
            return f"{name}\n{self.frequency:g} Hz"
        return name.replace("frequencies", "frequency 1")

    @property
    def text(self) -> str:
        """The value with its unit."""
        return engineering(self.value, self.unit)


def sensitivity_columns(scene: Scene, keys: Sequence[str] | None = None) -> list[SensitivityColumn]:
    """Return the scene's quantities at its frequencies, each with its derivatives.

    Parameters
    ----------
    keys : sequence of str, optional
        Scene keys; by default all numbers that the model reads.

    Raises
    ------
    InputError
        For a quantity without derivative, a key that the model does not read, or a number
        that is zero, so that no relative change exists.

    Notes
    -----
    The threshold voltage has columns only where the threshold is stated.
    """
    _check_quantities(scene.quantities)
    check_held(scene, scene.quantities)
    device = actuator(scene)
    chosen = parameter_keys(device) if keys is None else chosen_keys(scene, device, keys)
    return [
        column
        for name in scene.quantities
        for column in (
            _thresholds(scene, device, chosen)
            if name == _THRESHOLD
            else _columns(scene, device, name, chosen)
        )
    ]


def _check_quantities(names: Sequence[str]) -> None:
    for name in names:
        if name in DIFFERENTIABLE or name == _THRESHOLD:
            continue
        why = (
            "belongs to the normal actuator, but sensitivities are those of the transfer-matrix "
            "model of the lateral one"
            if QUANTITIES[name].magnetic
            else "is a matrix and has no sensitivities here"
        )
        raise InputError(
            f"quantity {name} {why}; use one of {', '.join((*DIFFERENTIABLE, _THRESHOLD))}"
        )


def _columns(
    scene: Scene, device: Actuator, name: str, keys: Sequence[str]
) -> list[SensitivityColumn]:
    by_frequency = name in READOUTS and not READOUTS[name].static
    frequencies = np.asarray(scene.frequency)
    at = frequencies if by_frequency else None
    value = values(device, name, at)
    slopes = derivatives(device, name, keys, at)
    columns = []
    for i in range(value.size):
        size = float(abs(value[i]))
        if size == 0.0:
            raise InputError(
                f"{name} is 0 in this scene, so no parameter changes it in relation to its "
                "size; give drive.voltage and piezo.d31 a value, or ask at another frequency"
            )
        slope = {k: float((np.conj(value[i]) * s[i]).real / size) for k, s in slopes.items()}
        columns.append(
            SensitivityColumn(
                name,
                QUANTITIES[name].unit,
                float(frequencies[i]) if by_frequency else None,
                size,
                slope,
                {key: device.value(key) * s / size for key, s in slope.items()},
            )
        )
    return columns


def _thresholds(scene: Scene, device: Actuator, keys: Sequence[str]) -> list[SensitivityColumn]:
    """Return the threshold voltage a/|w/U|, where the threshold a is stated.

    No parameter moves a, so that d ln(threshold voltage) = −d ln|w/U|.
    """
    if scene.piezo.d31 == 0.0:
        raise InputError(
            f"{_THRESHOLD} has no value with piezo.d31 = 0, for no voltage moves the tip; give "
            "piezo.d31 a value"
        )
    f = np.asarray(scene.frequency)
    stated = tuple(float(v) for v in f[~DISPLAY_THRESHOLD.outside(f)])
    if not stated:
        return []
    per_volt = replace(device, drive=Drive(voltage=1.0))
    moved = _columns(
        scene.model_copy(update={"frequency": stated}), per_volt, "tip_displacement", keys
    )
    columns = []
    for column, amplitude in zip(moved, DISPLAY_THRESHOLD.at(np.array(stated)), strict=True):
        value = float(amplitude) / column.value
        ratio = {k: 0.0 if k == _VOLTAGE else -s for k, s in column.logarithmic.items()}
        columns.append(
            replace(
                column,
                quantity=_THRESHOLD,
                unit=QUANTITIES[_THRESHOLD].unit,
                value=value,
                derivatives={
                    k: 0.0 if k == _VOLTAGE else value * s / device.value(k)
                    for k, s in ratio.items()
                },
                logarithmic=ratio,
            )
        )
    return columns


def thinned(columns: Sequence[SensitivityColumn]) -> list[SensitivityColumn]:
    """Return as many columns as people can read: of each quantity a few of its frequencies."""
    names = list(dict.fromkeys(c.quantity for c in columns))
    if len(columns) <= _SHOWN:
        return list(columns)
    groups = [[c for c in columns if c.quantity == name] for name in names]
    single = sum(len(group) == 1 for group in groups)
    each = max(1, (_SHOWN - single) // max(1, len(groups) - single))
    return [
        group[i]
        for group in groups
        for i in np.unique(np.linspace(0, len(group) - 1, min(len(group), each)).astype(int))
    ]
