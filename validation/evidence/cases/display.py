"""The checks of the display as declarative rows; see :mod:`validation.evidence.case`."""

from __future__ import annotations

import numpy as np

from tactgen.fem.magnetics.array_3d import NineForces, array_forces, nine_forces
from tactgen.geometry.device.parameters import Display
from tactgen.geometry.display.clearances import clearances
from tactgen.geometry.display.layout import drawn_units, levels
from tactgen.geometry.reluctance.sector_tets import UNITS
from tactgen.tmm.display.array import between_heads, network_forces
from tactgen.tmm.ports.multiport import Multiport, passivity_margin, reciprocity_error
from tactgen.validation.catalogue.quantities import CROSSTALK_LARGEST, SHORT_CIRCUIT_FREQUENCIES
from tactgen.validation.engine.model import make_model
from tactgen.validation.engine.plan import make_plan
from tactgen.validation.engine.solve import solve
from tactgen.validation.engine.stages import Stages
from tactgen.validation.evidence.case import Check
from tactgen.validation.evidence.mesh_levels import cached
from tactgen.validation.models.display.field import display_ports, with_device
from tactgen.validation.scene.scene import Scene, load_scene

_PAPER = "paper section 2: a pitch of 2.4 mm, 45 mm high"
#: Scatter of the length so small that its square does not matter, and the step of a slope.
_SMALL, _STEP = 1e-5, 1e-4
#: Current (A), gap and pitch (m) at which the field between units is looked at: the scene's.
_CURRENT, _GAP, _PITCH = 0.05, 0.2e-3, 2.4e-3


def _scene(*overrides: str) -> Scene:
    return load_scene("display", ["frequency=10,100,430,1000", *overrides])[0]


@cached
def _array() -> Multiport:
    scene = _scene("display.rows=2", "display.columns=3")
    return display_ports(scene, _bimorph(scene))


def _bimorph(scene: Scene) -> Multiport:
    plan = make_plan(scene, ("tmm",), (CROSSTALK_LARGEST.name,))
    found: Multiport = make_model("tmm", scene, Stages(plan.keys)).answer("crosstalk").ports.fine
    return found


def _reciprocity() -> float:
    return float(reciprocity_error(_array()).max())


def _passivity() -> float:
    return float(passivity_margin(_array()).min())


def _both_ways() -> float:
    whole = _array()
    there = whole["voltage_r1c1", "voltage_r2c3"]
    back = whole["voltage_r2c3", "voltage_r1c1"]
    return float(np.abs(there / back - 1.0).max())


def _spread() -> float:
    """Spread of a small scatter of lengths over the slope's times the lengths' own."""
    none = [f"scatter.{key}=0" for key in ("thickness", "roughness", "preload")]
    scene = _scene("display.rows=1", "display.columns=4", f"scatter.length={_SMALL}", *none)

    def first(at: Scene) -> float:
        return float(solve(at, ("tmm",), (SHORT_CIRCUIT_FREQUENCIES.name,)).quantities[0].value[0])

    def longer(share: float) -> float:
        length = (1.0 + share) * scene.bimorph.length
        bimorph = scene.bimorph.model_copy(update={"length": length})
        return first(scene.model_copy(update={"bimorph": bimorph}))

    units = drawn_units(scene.device, scene.display, scene.scatter)
    lengths = [unit.bimorph.length / scene.bimorph.length - 1.0 for unit in units]
    slope = (longer(_STEP) - longer(-_STEP)) / (2.0 * _STEP)
    found = [first(with_device(scene, unit)) for unit in units]
    return float(np.ptp(found) / (abs(slope) * np.ptp(lengths)))


def _far_apart() -> float:
    """By how much the loss to alternating neighbours follows their permeance, far apart."""
    device, pitches = _scene().device, (1e8, 1e16)
    losses = []
    for pitch in pitches:
        found = network_forces(device, Display(pitch=pitch), _CURRENT, _GAP)
        losses.append(1.0 - found.alternating / found.same)
    over = [between_heads(device, pitch) for pitch in pitches]
    return (losses[0] / losses[1]) / (over[0] / over[1])


@cached
def _nine() -> dict[str, NineForces]:
    """Pulls of nine units: one driven, all, those beside reversed, the middle one."""
    states = {"alone": (1, 0, 0), "all": (1, 1, 1), "beside": (1, -1, 1), "middle": (-1, 1, 1)}
    driven = [
        {unit: _CURRENT * sign for unit, sign in zip(UNITS, signs, strict=True)}
        for signs in states.values()
    ]
    found = nine_forces(_scene().device, driven, _GAP, _PITCH)
    return dict(zip(states, found, strict=True))


def _mean(pair: tuple[float, float]) -> float:
    return 0.5 * sum(pair)


def _reversal(unit: str, reversed_one: str) -> float:
    """Loss of a unit's force where others' current is reversed (N)."""
    nine = _nine()
    return _mean(getattr(nine["all"], unit)) - _mean(getattr(nine[reversed_one], unit))


@cached
def _all_four() -> float:
    """Loss of force in an endless array where all nearest neighbours reverse (N)."""
    found = array_forces(_scene().device, _CURRENT, _GAP, _PITCH)
    return _mean(found.same) - _mean(found.alternating)


def _one_driven() -> float:
    network = network_forces(_scene().device, Display(rows=3, columns=3), _CURRENT, _GAP).single
    return network / _mean(_nine()["alone"].middle)


def _four_of_eight() -> float:
    return _reversal("middle", "beside") / _all_four()


def _one_of_four() -> float:
    return 4.0 * _reversal("beside", "middle") / _all_four()


def _on_the_diagonal() -> float:
    return _reversal("diagonal", "middle") / _reversal("beside", "middle")


def _out_of_balance() -> float:
    alone = _nine()["alone"]
    return _mean(alone.unbalanced) / _mean(alone.middle)


def _narrowest() -> float:
    scene = _scene()
    return clearances(scene.device, scene.display)[0].gap


def _height() -> float:
    scene = _scene()
    return levels(scene.device, scene.display).total


CASES: tuple[Check, ...] = (
    Check(
        "ARR-1", "code verification",
        "Six generators on their board under skin are reciprocal over all tips and voltages.",
        (0.0, 1e-9), "1", "Maxwell and Betti", 0.0,
        "rounding of joining and reducing; a wrong sign shows at order one", _reciprocity,
        scene="display",
    ),
    Check(
        "ARR-2", "code verification",
        "No power comes out of them, over what goes in.",
        (-1e-9, np.inf), "1", "energy", 0.0, "rounding, as of ARR-1", _passivity,
        scene="display",
    ),
    Check(
        "ARR-3", "code verification",
        "The charge at one corner per volt at the other is the same both ways.",
        (0.0, 1e-8), "1", "reciprocity", 0.0,
        "the coupling is a small share of what cancels, which magnifies rounding", _both_ways,
        scene="display",
    ),
    Check(
        "SPR-1", "code verification",
        "A small scatter of lengths spreads the first frequencies as their slope says.",
        1.0, "1", "first order in the scatter, slope by central differences", 1e-3,
        "second order: scatter of 1e-5, step of 1e-4 squared times a few", _spread,
        scene="display",
    ),
    Check(
        "NEI-1", "code verification",
        "Far apart, what alternating neighbours take by the network goes with their permeance.",
        1.0, "1", "limit: first order in the permeance between heads", 2e-3,
        "the permeance falls with the logarithm of the pitch, so the second order is slow to go: "
        "it is a part of the loss itself, still 0.4 % at a pitch of 1e8 m",
        _far_apart, scene="display",
    ),
    Check(
        "NEI-2", "cross-model",
        "One driven unit among eight without current pulls by the network as by nine units' field.",
        1.0, "1", "the nonlinear field of three by three units in open air", 0.33,
        "a third, as of an endless array: the network knows no flux between a head and another's "
        "sleeve, nor what passes above the heads", _one_driven, heavy=True, scene="display",
    ),
    Check(
        "NEI-3", "cross-model",
        "Four neighbours reversed take from the middle of nine what they take in an endless array.",
        1.0, "1", "the array's pulls, of which the table's crosstalk is an eighth per ampere", 0.12,
        "the bars of both differences, 6 % each; units farther away than the eight have a share of "
        "a percent or two", _four_of_eight, heavy=True, scene="display",
    ),
    Check(
        "NEI-4", "cross-model",
        "One unit reversed alone takes less from a rod beside it than a quarter of all four.",
        (0.0, 1.0), "1", "the table's crosstalk, which lets all four change alike", 0.0,
        "a bound, not a value: where all change alike no force passes from unit to unit, where one "
        "does its neighbours' heads draw on each other", _one_of_four, heavy=True, scene="display",
    ),
    Check(
        "NEI-5", "cross-model",
        "On the diagonal, which the table leaves out, it takes less than dipoles would.",
        (0.0, 2.0**-1.5), "1", "a dipole's field falls with the cube of the distance", 0.0,
        "heads and sleeves between shield, so the dipoles' share is a bound", _on_the_diagonal,
        heavy=True, scene="display",
    ),
    Check(
        "NEI-6", "code verification",
        "The forces on all rods and sleeves of nine units balance, over the driven rod's.",
        (-0.02, 0.02), "1", "Newton's third law", 0.0,
        "discretisation: either potential's force has 2.7 % by their difference, of which the mean "
        "has less", _out_of_balance, heavy=True, scene="display",
    ),
    Check(
        "FIT-1", "validation",
        "At the paper's pitch no part touches another: the narrowest clearance.",
        (0.0, 1e-3), "m", _PAPER, 0.0, "an interference is a clearance below 0", _narrowest,
        scene="display",
    ),
    Check(
        "FIT-2", "validation", "The heights of all parts add up to the paper's.",
        45e-3, "m", _PAPER, 1e-3, "two printed digits, sums of sizes that are printed to 0.05 mm",
        _height, scene="display",
        fitted="the plates' thicknesses, which the paper does not give, make up the sum",
    ),
)  # fmt: skip
