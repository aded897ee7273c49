"""Sensitivities of a scene's quantities by tmm, one column per quantity and frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import engineering
from tactgen.tmm.beam.parametric import Actuator, parameter_keys
from tactgen.tmm.beam.sensitivities import derivatives, values
from tactgen.tmm.ports.readout import ModalReadout, Readout
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import QuantityRow
from tactgen.validation.engine.warnings import check_held
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.uncertainty.headline_numbers import actuator
from tactgen.validation.studies.uncertainty.varied_keys import chosen_keys

#: Columns that a table for people has at most, if a quantity's frequencies can be thinned.
_SHOWN = 8
#: Relative error of the transfer-matrix model's derivatives, of the largest of a column:
#: rounding where an entry of the ports' matrix is next to a pole or zero.
_ERROR = 2e-9
_METHOD = "exact derivatives by Cauchy's integral; the bar is the rounding next to a pole"


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
    model : str
        By which it is.
    bars : dict of str to float
        Error bars of `logarithmic`.
    method : str
        How derivatives and bars come about.
    """

    quantity: str
    unit: str
    frequency: float | None
    value: float
    derivatives: dict[str, float]
    logarithmic: dict[str, float]
    model: str
    bars: dict[str, float]
    method: str

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
    threshold = threshold_of(scene.threshold)
    asked = [QUANTITIES[name].at_threshold(threshold) for name in scene.quantities]
    for row in asked:
        _check_differentiable(row)
    check_held(scene, scene.quantities)
    device = actuator(scene)
    chosen = parameter_keys(device) if keys is None else chosen_keys(scene, device, keys)
    return [column for row in asked for column in _columns(scene, device, row, chosen)]


def _check_differentiable(row: QuantityRow) -> None:
    if is_differentiable(row):
        return
    able = ", ".join(name for name, other in QUANTITIES.items() if is_differentiable(other))
    raise InputError(f"quantity {row.name} is a matrix and has no sensitivities here; use one of "
                     f"{able}")  # fmt: skip


def is_differentiable(row: QuantityRow) -> bool:
    """Return whether the transfer-matrix model has exact derivatives of a quantity."""
    return isinstance(row.read, Readout | ModalReadout)


def _columns(
    scene: Scene, device: Actuator, row: QuantityRow, keys: Sequence[str]
) -> list[SensitivityColumn]:
    """Return a column for each frequency or mode at which the quantity has a value."""
    assert isinstance(row.read, Readout | ModalReadout)
    if row.has_level and scene.piezo.d31 == 0.0:
        raise InputError(
            f"{row.name} has no value with piezo.d31 = 0, for no voltage moves the tip; give "
            "piezo.d31 a value"
        )
    frequencies = np.asarray(scene.frequency)
    at = frequencies if row.by_frequency else None
    value = values(device, row.read, at)
    if (value == 0.0).any():
        raise InputError(
            f"{row.name} is 0 in this scene, so no parameter changes it in relation to its "
            "size; give drive.voltage and piezo.d31 a value, or ask at another frequency"
        )
    slopes = derivatives(device, row.read, keys, at)
    columns = []
    for i in np.flatnonzero(np.isfinite(value)):
        size = float(abs(value[i]))
        slope = {k: float((np.conj(value[i]) * s[i]).real / size) for k, s in slopes.items()}
        logarithmic = {key: device.value(key) * s / size for key, s in slope.items()}
        error = _ERROR * max((abs(s) for s in logarithmic.values()), default=0.0)
        columns.append(
            SensitivityColumn(
                row.name,
                row.unit,
                float(frequencies[i]) if row.by_frequency else None,
                size,
                slope,
                logarithmic,
                "tmm",
                dict.fromkeys(logarithmic, error),
                _METHOD,
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
