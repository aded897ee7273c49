"""The display: crosstalk, units that differ, the field between units, what fits."""

from __future__ import annotations

import numpy as np

from tactgen.fem.magnetics.array_3d import NineForces, array_forces, nine_forces
from tactgen.geometry.device.display import Display
from tactgen.geometry.display.clearances import clearances
from tactgen.geometry.display.layout import drawn_units, levels
from tactgen.geometry.reluctance.sector_tets import UNITS
from tactgen.tmm.display import between_heads, network_forces
from tactgen.tmm.ports.multiport import Multiport, passivity_margin, reciprocity_error
from tactgen.validation.catalogue.quantities import CROSSTALK_LARGEST, SHORT_CIRCUIT_FREQUENCIES
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.evidence.case import Case, Check, Null, case
from tactgen.validation.evidence.mesh_levels import cached
from tactgen.validation.models.classes import make_model
from tactgen.validation.models.display import display_ports, with_device
from tactgen.validation.models.model import Stages
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import with_values

#: Scatter of the length so small that its square does not matter, and the step of a slope.
_SMALL, _STEP = 1e-5, 1e-4
#: Current (A), gap and pitch (m) at which the field between units is looked at: the scene's.
_CURRENT, _GAP, _PITCH = 0.05, 0.2e-3, 2.4e-3


def _scene(*overrides: str) -> Scene:
    return load_scene("display", ["frequency=10,100,430,1000", *overrides])[0]


@cached
def _array() -> Multiport:
    scene = _scene("display.rows=2", "display.columns=3")
    plan = make_plan(scene, ("tmm",), (CROSSTALK_LARGEST.name,))
    bimorph = make_model("tmm", scene, Stages(plan.keys)).answer("crosstalk").ports.fine
    return display_ports(scene, bimorph)


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
        return first(with_values(scene, {"bimorph.length": (1.0 + share) * scene.bimorph.length}))

    units = drawn_units(scene.device, scene.display, scene.scatter)
    lengths = [unit.bimorph.length / scene.bimorph.length - 1.0 for unit in units]
    slope = (longer(_STEP) - longer(-_STEP)) / (2.0 * _STEP)
    found = [first(with_device(scene, unit)) for unit in units]
    return float(np.ptp(found) / (abs(slope) * np.ptp(lengths)))


def _far_apart() -> float:
    """By how much the loss to alternating neighbours follows their permeance, far apart."""
    shares = []
    for pitch in (1e8, 1e16):
        found = network_forces(_scene().device, Display(pitch=pitch), _CURRENT, _GAP)
        lost = 1.0 - found.alternating / found.same
        shares.append(lost / between_heads(_scene().device, pitch))
    return shares[0] / shares[1]


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
    """Loss of a unit's pull where others' current is reversed (N)."""
    nine = _nine()
    return _mean(getattr(nine["all"], unit)) - _mean(getattr(nine[reversed_one], unit))


@cached
def _all_four() -> float:
    """Loss of a unit of an endless array where all nearest neighbours reverse (N)."""
    found = array_forces(_scene().device, _CURRENT, _GAP, _PITCH)
    return _mean(found.same) - _mean(found.alternating)


CASES: tuple[Case, ...] = (
    case(
        "ARR", "Generators on one board under one skin",
        "Each is solved once by model tmm, placed on the upper board and tied at its tip to the "
        "others. What goes in comes out or stays; what one does to another, the other does to it.",
        [
            Check("Six generators on their board under skin are reciprocal over all tips and "
                  "voltages.", (0.0, 1e-9), "1", lambda: float(reciprocity_error(_array()).max()),
                  reason="rounding of joining and reducing; a wrong sign shows at order one",
                  source="Maxwell and Betti"),
            Check("No power comes out of them, over what goes in.", (-1e-9, np.inf), "1",
                  lambda: float(passivity_margin(_array()).min()), source="energy",
                  reason="rounding, as of ARR-1"),
            Check("The charge at one corner per volt at the other is the same both ways.",
                  (0.0, 1e-8), "1", _both_ways, source="reciprocity",
                  reason="the coupling is a small share of what cancels, which magnifies rounding"),
        ],
        model="ports joined by name; board as a plate on its spacers, skin as a sheet",
        scene="display",
    ),
    case(
        "SPR", "Units as they come out of the shop",
        "Lengths drawn from a narrow scatter; what it does to the first frequencies of four units.",
        [Check("A small scatter of lengths spreads the first frequencies as their slope says.", 1.0,
               "1", _spread)],
        model="model tmm, each unit on its own contact", scene="display", tolerance=1e-3,
        source="first order in the scatter, slope by central differences",
        reason="second order: scatter of 1e-5, step of 1e-4 squared times a few",
    ),
    case(
        "NEI", "The field between units, by the network",
        "Permeances between neighbouring heads beside each working gap. Far apart they vanish; one "
        "driven unit among others without current is where one of an endless array is.",
        [
            Check("Far apart, what alternating neighbours take by the network goes with their "
                  "permeance.", 1.0, "1", _far_apart, 2e-3,
                  "the permeance falls with the logarithm of the pitch, so the second order is "
                  "slow to go: it is a part of the loss itself, still 0.4 % at a pitch of 1e8 m",
                  "limit: first order in the permeance between heads"),
            Check("One driven unit among eight without current pulls by the network as by nine "
                  "units' field.", 1.0, "1",
                  lambda: network_forces(_scene().device, Display(rows=3, columns=3), _CURRENT,
                                         _GAP).single / _mean(_nine()["alone"].middle), 0.33,
                  "a third, as of an endless array: the network knows no flux between a head and "
                  "another's sleeve, nor what passes above the heads",
                  "the nonlinear field of three by three units in open air", tier="cross-model",
                  heavy=True),
            Check("Four neighbours reversed take from the middle of nine what they take in an "
                  "endless array.", 1.0, "1",
                  lambda: _reversal("middle", "beside") / _all_four(), 0.12,
                  "the bars of both differences, 6 % each; units farther away than the eight have "
                  "a share of a percent or two",
                  "the array's pulls, of which the table's crosstalk is an eighth per ampere",
                  tier="cross-model", heavy=True),
            Check("One unit reversed alone takes less from a rod beside it than a quarter of all "
                  "four.", (0.0, 1.0), "1",
                  lambda: 4.0 * _reversal("beside", "middle") / _all_four(), 0.0,
                  "a bound, not a value: where all change alike no force passes from unit to unit, "
                  "where one does its neighbours' heads draw on each other",
                  "the table's crosstalk, which lets all four change alike", tier="cross-model",
                  heavy=True),
            Check("On the diagonal, which the table leaves out, it takes less than dipoles would.",
                  (0.0, 2.0**-1.5), "1",
                  lambda: _reversal("diagonal", "middle") / _reversal("beside", "middle"), 0.0,
                  "heads and sleeves between shield, so the dipoles' share is a bound",
                  "a dipole's field falls with the cube of the distance", tier="cross-model",
                  heavy=True),
            Check("The forces on all rods and sleeves of nine units balance, over the driven "
                  "rod's.", (-0.02, 0.02), "1",
                  lambda: _mean(_nine()["alone"].unbalanced) / _mean(_nine()["alone"].middle), 0.0,
                  "discretisation: either potential's force has 2.7 % by their difference, of "
                  "which the mean has less", "Newton's third law", heavy=True),
        ],
        model="model network", scene="display",
    ),
    case(
        "FIT", "Sixteen generators in the paper's room",
        "All distances that could close, and the heights of all parts.",
        [
            Check("At the paper's pitch no part touches another: the narrowest clearance.",
                  (0.0, 1e-3), "m",
                  lambda: clearances(_scene().device, _scene().display)[0].gap, 0.0,
                  "an interference is a clearance below 0",
                  null=Null("the pitch less the sleeve's diameter", lambda: float(
                      _scene().display.pitch - 2.0 * _scene().device.sleeve.outer_radius))),
            Check("The heights of all parts add up to the paper's.", 45e-3, "m",
                  lambda: levels(_scene().device, _scene().display).total, 1e-3,
                  "two printed digits, sums of sizes that are printed to 0.05 mm",
                  fitted="the plates' thicknesses, which the paper does not give, make up the sum"),
        ],
        model="closed form, from the sizes of the parts", tier="validation", scene="display",
        source="paper section 2: a pitch of 2.4 mm, 45 mm high",
    ),
)  # fmt: skip
