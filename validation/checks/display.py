"""The checks of the display as declarative rows; see :mod:`validation.checks.row`."""

from __future__ import annotations

from functools import cache

import numpy as np

from tactgen.geometry.device.parameters import Display
from tactgen.geometry.display.clearances import clearances
from tactgen.geometry.display.layout import levels
from tactgen.geometry.display.units import drawn_units
from tactgen.tmm.display.field import between_heads, endless_share, head_levels, network_forces
from tactgen.tmm.ports.invariants import passivity_margin, reciprocity_error
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.catalogue.bimorph import SHORT_CIRCUIT_FREQUENCIES
from tactgen.validation.catalogue.display import CROSSTALK_LARGEST
from tactgen.validation.checks.row import Check
from tactgen.validation.engine.model import make_model
from tactgen.validation.engine.plan import make_plan
from tactgen.validation.engine.solve import solve
from tactgen.validation.engine.stages import Stages
from tactgen.validation.models.display.crosstalk import display_ports
from tactgen.validation.models.display.spread import with_device
from tactgen.validation.scene.scene import Scene, load_scene

_PAPER = "paper section 2: a pitch of 2.4 mm, 45 mm high"
#: Scatter of the length so small that its square does not matter, and the step of a slope.
_SMALL, _STEP = 1e-5, 1e-4


def _scene(*overrides: str) -> Scene:
    return load_scene("display", ["frequency=10,100,430,1000", *overrides])[0]


@cache
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
    """Return the spread of a small scatter of lengths over the slope's times the lengths' own."""
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
    """Return by how much the loss to alternating neighbours follows their permeance, far apart."""
    device, current, gap = _scene().device, 0.05, 0.2e-3
    pitches = 1e8, 1e16
    losses = []
    for pitch in pitches:
        found = network_forces(device, Display(pitch=pitch), current, gap)
        losses.append(1.0 - found.alternating / found.same)
    over = [between_heads(device, pitch) for pitch in pitches]
    return (losses[0] / losses[1]) / (over[0] / over[1])


def _three_by_three() -> float:
    return float(head_levels(Display(rows=3, columns=3), 0.05)[4] / endless_share(0.05))


def _narrowest() -> float:
    scene = _scene()
    return clearances(scene.device, scene.display)[0].gap


def _height() -> float:
    scene = _scene()
    return levels(scene.device, scene.display).total


DISPLAY_CHECKS: tuple[Check, ...] = (
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
        1.0, "1", "limit: first order in the permeance between heads", 0.2,
        "the permeance falls with the logarithm of the pitch, so the second order is slow to go: "
        "at a pitch of 1e8 m the loss is still a few percent times a factor of a few",
        _far_apart, scene="display",
    ),
    Check(
        "NEI-2", "cross-model",
        "The middle unit of three by three, driven alone, is where one of an endless array is.",
        1.0, "1", "mean over all waves from unit to unit", 5e-4,
        "a unit at the edge has three neighbours, not four: 4 r^3 at r = 0.05, r the permeance "
        "between heads over a unit's own", _three_by_three,
        scene="display",
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
        calibrated="the plates' thicknesses, which the paper does not give, make up the sum",
    ),
)  # fmt: skip
