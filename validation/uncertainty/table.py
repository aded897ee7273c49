"""Sensitivities of a scene's quantities, one column per quantity and frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.errors import InputError
from tmm.parametric import parameter_keys
from tmm.port_quantities import READOUTS
from tmm.sensitivities import DIFFERENTIABLE, derivatives, values
from validation.formats import engineering
from validation.limits import check_held
from validation.quantities import QUANTITIES
from validation.scene import Scene
from validation.uncertainty.headline_numbers import actuator


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
    """
    check_held(scene, scene.quantities)
    device = actuator(scene)
    keys = parameter_keys(device) if keys is None else tuple(dict.fromkeys(keys))
    frequencies = np.asarray(scene.frequency)
    columns = []
    for name in scene.quantities:
        if name not in DIFFERENTIABLE:
            raise InputError(
                f"quantity {name} is a matrix and has no sensitivities here; "
                f"use one of {', '.join(DIFFERENTIABLE)}"
            )
        by_frequency = name in READOUTS and not READOUTS[name].static
        at = frequencies if by_frequency else None
        value = values(device, name, at)
        slopes = derivatives(device, name, keys, at)
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
