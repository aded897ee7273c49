"""Figures of the report on made-up numbers: all that they draw, and what they leave out."""

from types import SimpleNamespace

import numpy as np
import pytest
from approved import figure_text
from unpainted import placed

from tactgen.geometry.device.load_table import LoadTable
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.reluctance.section_grid import Region
from tactgen.tmm.generator.network_pull import network_pull
from tactgen.validation.engine.results import Quantity
from tactgen.validation.report.figures import (
    amplitude,
    bimorph,
    drive_limits,
    load,
    machine,
    magnetic_field,
    reluctance,
)
from tactgen.validation.view.figures import new_figure

F = np.array([10.0, 100.0, 1000.0])
ROOMS = (amplitude, bimorph, drive_limits, load, machine, magnetic_field, reluctance)


@pytest.fixture
def told(monkeypatch, approved):
    """Return a function that compares what figures hold, how words stand to what they name."""
    found = []
    for room in ROOMS:
        monkeypatch.setattr(
            room, "svg", lambda figure: found.append(f"{figure_text(figure)}\n{placed(figure)}")
        )
    return lambda: approved("\n".join(found))


def curve(voltage, *, stable, peaks=1):
    size = voltage * np.array([1e-6, 5e-6, 3e-6, 1e-6]) * (1.0 + 0.2j)
    tops = [
        SimpleNamespace(
            frequency=220.0 - voltage, velocity=7e-3 * voltage, displacement=5e-6 * voltage
        )
        for _ in range(peaks)
    ]
    return SimpleNamespace(
        voltage=voltage, frequencies=np.array([100.0, 220.0, 210.0, 300.0]), displacement=size,
        stable=np.array(stable), peaks=tuple(tops),
    )  # fmt: skip


def test_amplitudes(told):
    """Unstable orbits dotted from where they begin; a backbone through two peaks, not one."""
    turned = curve(2.0, stable=[True, True, False, True])
    plain = curve(1.0, stable=[True] * 4, peaks=2)
    flat = curve(0.5, stable=[True] * 4, peaks=0)
    amplitude.backbone_plot(SimpleNamespace(curves=(plain, turned)))
    amplitude.backbone_plot(SimpleNamespace(curves=(flat, turned)))
    states = [
        SimpleNamespace(state="not activated", curves=(plain, turned, flat)),
        SimpleNamespace(state="held", curves=()),
        SimpleNamespace(state="lifted", curves=(flat,)),
    ]
    amplitude.states_plot(states)
    deflection = SimpleNamespace(frequencies=F, displacement=(3.0 - 4.0j) * 1e-6 / F)
    states = [SimpleNamespace(state=s, deflection=deflection) for s in ("not activated", "held")]
    linear = {"not activated": 1e-6 / F, "held": 2e-6 / F}
    amplitude.deflection_plot(states, F, linear, {"held": (1e-9, 2e-8)})
    told()


def test_responses(told, approved):
    """Phases that begin alike; differences from the last model; nothing moves, or is unknown."""
    falls = np.array([1.0, 3.0j, -0.5]) * 1e-6
    curves = {
        "none": {"lumped": -falls, "tmm": 1.1 * falls},
        "finger": {"lumped": np.zeros(3, complex), "tmm": np.array([0.0, 0.0, np.nan]) * 1j},
    }
    labels = {"none": "free tip", "finger": "under the finger"}
    bimorph.response_plot(F, curves, labels)
    bimorph.response_plot(np.array([0.0, 20.0, 40.0]), {"none": {"own": falls}}, labels)
    one = {"none": {"tmm": falls[:1]}}
    bimorph.response_plot(F[:1], one, labels)
    told()
    said = [bimorph.response_values(F, curves, labels)]
    said.append(bimorph.response_values(np.array([0.0, 20.0, 40.0]), one | {}, labels))
    approved("\n".join(said), "values")


def test_bridges(told):
    """Bars from where the last one ended, marks of closed forms where there are some."""

    def rung(name, value, step=np.nan, predicted=np.nan):
        names = ("deflection", "first_frequency", "capacitance")
        of = {key: (1.0 + 0.1 * n) * value for n, key in enumerate(names)}
        parts = {
            part: SimpleNamespace(**dict.fromkeys(names, of_part))
            for part, of_part in (("step", step), ("predicted", predicted), ("section", 0.5 * step))
        }
        return SimpleNamespace(name=name, **of, **parts)

    rungs = [rung("beam", 1.0), rung("first", 1.2, 0.2, 0.19), rung("last", 1.17, -0.000001)]
    bimorph.bridge_plot(rungs, "in all")
    steps = [
        SimpleNamespace(name=f"step {k}", left={"force": left, "flux": -0.3 * left})
        for k, left in enumerate((0.2, 0.5, 0.45))
    ]
    reluctance.bridge_plot(steps, {"force": "pull", "flux": "flux linkage"}, "the field")
    reluctance.bridge_plot(steps[:1], {"force": "pull"}, "the field")
    told()


def test_loads_and_limits(told):
    """Impedance, stiffness, force and power; points of a table; the lowest of three limits."""
    stiffness = 100.0 + 2j * np.pi * F * (0.5 + 1.0 / F)
    table = LoadTable("t", np.array([20.0, 200.0]), np.array([0.5 - 2.0j, 0.4 + 0.1j]))
    for measured in (table, None):
        load.load_plot(F, stiffness, 1e-3 * F, 1e-6 / F, measured)
    limits = {"free tip": np.array([300.0 / F, 50.0 + 0.0 * F, F]), "held": np.ones((3, 3))}
    drive_limits.limits_plot(F, limits, 40.0)
    told()


def quantity(name, unit, values, frequencies=tuple(F)):
    values = np.asarray(values)
    bars = np.zeros(values.shape)
    return Quantity(name, "tmm", values, unit, bars, "", 0.0, frequencies, None)


def test_the_machine(told):
    """Places of rest with a gap at a jump, arrows only within the currents shown; transfers."""

    def places(*lifts):
        ends = {0.0: "upper stop", -5e-5: "lower stop"}
        return [SimpleNamespace(lift=x, kind=ends.get(x, "floating")) for x in lifts]

    def loop(model, unstable, switching):
        loop = SimpleNamespace(
            currents=np.array([0.0, 0.05, 0.1]), rising=places(0.0, 0.0, -5e-5),
            falling=places(0.0, -2e-5, -5e-5), unstable=np.array(unstable),
        )  # fmt: skip
        return SimpleNamespace(model=model, loop=loop, switching=switching)

    def at(pull_in, drop_out):
        return SimpleNamespace(
            pull_in=SimpleNamespace(value=pull_in), drop_out=SimpleNamespace(value=drop_out)
        )

    first = loop("network", [[0.03, -1e-5], [0.04, -2e-5]], at(0.08, 0.1))
    machine.position_plot([first], 0.06)
    second = loop("axisymmetric", [[0.03, -1e-5]], at(0.2, 0.0))
    machine.position_plot([first, second], 0.0)
    machine.position_plot([second], 0.0)
    machine.position_plot([loop("network", [], None)], 0.02)
    solution = SimpleNamespace(quantities=[
        quantity("axial_tip", "m/V", [1e-6, 2e-6j, 1.5e-6]),
        quantity("lateral_tip", "m/V", [1e-6, 2e-3j, 1.5e-6]),
        quantity("none", "m/V", [0.0, 0.0, 0.0]),
        quantity("current", "m/A", [1.0, 2.0, 3.0], (0.0, 1.0, 2.0)),
        quantity("number", "m/A", 3.0, None),
    ])  # fmt: skip
    machine.transfer_plot(solution, ("m/V", "m/A"))
    machine.transfer_plot(SimpleNamespace(quantities=[]), ("m/V", "m/A"))
    told()


@pytest.fixture(scope="module")
def pull():
    return network_pull(Device())


def test_the_normal_actuator(told, pull):
    """Families with circles at their own current and gap; switching with and without a spring."""
    device = Device()
    points = [
        SimpleNamespace(
            current=i, gap=g, force=0.02, flux_linkage=1e-3, incremental_inductance=5e-3
        )
        for i, g in ((0.05, 1.5e-4), (0.05, 2e-4), (0.07, 1.5e-4))
    ]  # fmt: skip
    gaps = np.array([1e-4, 1.5e-4, 2e-4])
    found = SimpleNamespace(
        pull_in=SimpleNamespace(value=0.08), drop_out=SimpleNamespace(value=0.03)
    )
    never = SimpleNamespace(
        pull_in=SimpleNamespace(value=np.nan), drop_out=SimpleNamespace(value=np.nan)
    )
    shown = reluctance.Families(device, {"network": pull}, np.array([0.05, 0.1]), gaps, points)
    reluctance.force_families(shown)
    reluctance.flux_families(shown)
    reluctance.switching_plot(shown, pull, found)
    reluctance.switching_plot(shown, pull, never)
    told()


def test_the_sections_outline_and_names(told):
    """Edges of iron and winding, none within one piece; names apart, with arrows."""
    figure = new_figure(3.0, 3.0)
    axis = figure.add_subplot()
    iron = object()
    regions = (
        Region("rod", (0.0, 1e-3), (0.0, 2e-3), iron),
        Region("head", (0.0, 2e-3), (2e-3, 3e-3), iron),
        Region("coil", (1.2e-3, 2e-3), (0.0, 1e-3), None),
    )  # fmt: skip
    magnetic_field._outline(axis, regions)
    device = Device()
    magnetic_field._names(axis, device, 0.5 * device.gap)
    axis.set_ylim(magnetic_field._heights(device))
    magnetic_field.svg(figure)
    told()


def test_names_keep_their_distance():
    assert magnetic_field._apart(np.array([3.0, 2.9, 1.0, 0.95]), 0.5).tolist() == [
        3.0,
        2.5,
        1.0,
        0.5,
    ]
