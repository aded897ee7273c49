"""Largest and least values over a band: found between the frequencies of a sweep."""

from dataclasses import astuple
from functools import cache

import numpy as np
import pytest

from tactgen.validation.engine.answers import quantity_from_json, quantity_json, representative
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies.whatif.aims import parse_aim

SWEEP = "frequency=100:1000:10"


@cache
def answer(name, model="tmm", *overrides):
    scene, _ = load_scene("prototype", [SWEEP, *overrides])
    return solve(scene, [model], [name]).get(name, model)


@pytest.mark.parametrize(("name", "quality"), [("tip_displacement", 20), ("ceramic_stress", 2000)])
def test_peak_equals_the_largest_value_of_a_dense_sweep(name, quality):
    """A dense sweep misses the top by less than its step squared, 1e-5 of the value here."""
    override = f"piezo.quality_factor={quality}"
    peak = answer(name, "tmm", override).extreme
    width = peak.frequency / quality
    dense = [f"frequency={peak.frequency - width}:{peak.frequency + width}:1001", override]
    scene, _ = load_scene("prototype", dense)
    largest = np.abs(solve(scene, ["tmm"], [name]).quantities[0].value).max()
    assert peak.value == pytest.approx(largest, rel=1e-5)
    assert peak.value >= 1.01 * np.abs(answer(name, "tmm", override).value).max()


def test_the_higher_of_two_peaks_between_two_frequencies():
    """A harvester's best power at its shorted resonance and, 0.7 % above, at its open one."""
    layers = "PZT-5A 0.26 mm to 25 mm +x; brass 0.2 mm; PZT-5A 0.26 mm to 25 mm +x"
    stated = ["bimorph.length=60 mm", "bimorph.width=10 mm", f"bimorph.layers={layers}",
              "support.kind=clamped", "load.kind=mass", "load.mass=2 g", "circuit.kind=load",
              "circuit.resistance=35 kohm", "drive.base_acceleration=0.05 g"]  # fmt: skip
    coarse, fine = (
        answer("optimum_power", "tmm", *stated, f"frequency={grid}").extreme
        for grid in ("1:1000:20", "22.5:23.1:61")
    )
    assert coarse.value == pytest.approx(fine.value, rel=1e-6)


def test_voltage_limit_is_the_least_over_the_band():
    """At that voltage the stress at resonance is the ceramic's strength; an aim sees it, too."""
    weak = "limits.ceramic_strength=1MPa"
    limit = answer("voltage_limit", "tmm", weak)
    least = limit.extreme.value
    assert least < np.min(limit.value)
    stress = answer("ceramic_stress", "tmm", f"drive.voltage={least} V")
    # both searches stop within 1e-9 of the top
    assert stress.extreme.value == pytest.approx(1e6, rel=1e-6)
    for shift, met in ((1e-6, False), (-1e-6, True)):
        aim = parse_aim(f"min_over(voltage_limit) >= {least * (1.0 + shift):.12g} V")
        assert (aim.margin({"voltage_limit": limit}) >= 0.0) is met
    # an expression of several quantities has the frequencies of the sweep alone
    plain = parse_aim("min_over(1 * voltage_limit) >= 0 V").margin({"voltage_limit": limit})
    assert plain == pytest.approx(limit.value.min())


def test_interpolated_peak_agrees_with_the_closed_form():
    """Beam elements are interpolated between the frequencies, the transfer matrix is not."""
    exact, beam = answer("tip_velocity").extreme, answer("tip_velocity", "beam").extreme
    assert abs(beam.value - exact.value) <= beam.error + exact.error
    assert beam.error < 1e-3 * beam.value
    assert beam.frequency == pytest.approx(exact.frequency, rel=1e-4)


def test_extremes_survive_json_and_represent_the_response():
    """A few frequencies are no band."""
    quantity = answer("voltage_limit")
    read = quantity_from_json(quantity_json(quantity)).extreme
    assert astuple(read) == pytest.approx(astuple(quantity.extreme), rel=1e-15, nan_ok=True)
    shown = representative(quantity)
    assert (shown.what, shown.at) == ("least", quantity.extreme.frequency)
    assert answer("tip_displacement", "tmm", "frequency=100:1000:7").extreme is None
