"""The normal actuator: moving iron, coil, sleeve and steel.

Reconstructed: the paper gives the outer diameter, the gap, the force, three currents and the
total height.  The other sizes are those that meet these with the least heat in the coil, found in
``notebooks/reconstructed_actuator.py``; none of them is known.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator

from tactgen.geometry import units as u
from tactgen.geometry.device.materials import Own
from tactgen.geometry.device.parameter_group import (
    PAPER_5,
    RECONSTRUCTED,
    Parameters,
    field,
    printed,
)
from tactgen.geometry.device.steel_library import STEELS, steel_name

#: Gap at which the reconstructed normal actuator's axial positions are stated (m).
NOMINAL_GAP = 0.2e-3


#: How far turned parts of somebody else may lie from what is said of them.
_TURNED = Own("turned part", 0.02)
_DIAMETER = f"{PAPER_5} (outer diameter 2.3 mm)"


class Rod(Parameters):
    """The moving iron: shaft, head (the pole above the gap), flange, slot for the tab."""

    radius: u.SmallLength = field(0.64e-3, RECONSTRUCTED, "shaft radius")
    head_radius: u.SmallLength = printed(1.15e-3, _DIAMETER, "head radius", 0.025e-3, own=_TURNED)
    head_thickness: u.SmallLength = field(0.5e-3, RECONSTRUCTED, "head thickness")
    flange_radius: u.SmallLength = field(0.91e-3, RECONSTRUCTED, "flange radius")
    flange_thickness: u.SmallLength = field(3.0e-3, RECONSTRUCTED, "flange thickness")
    flange_position: u.Position = field(
        1.7e-3, RECONSTRUCTED, "flange's top below the sleeve's top at the 200 um gap"
    )
    length: u.SmallLength = field(
        4.7e-3, RECONSTRUCTED, "shaft's end below the sleeve's top at the 200 um gap"
    )
    slot_depth: u.SmallLength = field(
        0.45e-3,
        "assumed: slot stays inside the head",
        "depth of the slot that takes the tab",
        (0.4e-3, 0.49e-3, "at least a bond, at most the head's thickness"),
    )
    youngs_modulus: u.Modulus = field(
        205e9, "assumed: low-carbon steel", "modulus", (200e9, 212e9, "steels")
    )
    poisson_ratio: u.PoissonRatio = field(
        0.29, "assumed: low-carbon steel", "Poisson ratio", (0.27, 0.3, "steels")
    )
    density: u.Density = field(
        7850.0, "assumed: low-carbon steel", "mass density", (7800.0, 7900.0, "low-carbon steels")
    )
    loss_factor: u.LossFactor = field(
        0.0,
        "assumed: none; steels have 0.0001 to 0.001, with what rubs in a bore far more",
        "structural damping of the rod: all moduli times (1 + j loss factor)",
    )


class Coil(Parameters):
    """The winding on the rod's shaft."""

    inner_radius: u.SmallLength = field(0.64e-3, RECONSTRUCTED, "inner radius")
    outer_radius: u.SmallLength = field(0.9e-3, RECONSTRUCTED, "outer radius")
    length: u.SmallLength = field(1.6e-3, RECONSTRUCTED, "axial length")
    position: u.Position = field(
        0.06e-3, RECONSTRUCTED, "coil's top below the sleeve's top at the 200 um gap"
    )
    turns: u.Turns = field(
        560.0,
        "assumed: gives the paper's 110 mN (section 5.1) at its 130 mA",
        "number of turns",
        (504.0, 616.0, "assumed: a reconstruction, a tenth either way"),
    )
    current: u.Current = field(130e-3, PAPER_5, "direct current in the winding")
    history: Literal["rising", "falling"] = field(
        "rising",
        "assumed: switched on from 0",
        "selects the equilibrium where there are several: current rising from 0, or "
        "falling from a current that holds the rod down",
    )
    fill_factor: u.FillFactor = field(
        0.5,
        "assumed: fine enamelled wire",
        "bare copper's share of the winding's window",
        (0.35, 0.65, "assumed: thin wires, wound wild to in layers"),
    )
    resistivity: u.Resistivity = field(
        1.7241e-8,
        "assumed: annealed copper at 20 degC (IEC 60028)",
        "the wire's resistivity at 20 degC",
        (1.7241e-8, 1.777e-8, "annealed to hard-drawn copper, 97 % of its conductivity"),
    )
    temperature: u.Temperature = field(
        293.15,
        "assumed: 20 degC, a cold coil",
        "the wire's temperature",
        (293.15, 393.15, "assumed: from cold to the limit of common enamel"),
    )
    copper_density: u.Density = field(
        8890.0,
        "assumed: annealed copper (IEC 60028); enamel is left out",
        "the wire's density, for the mass that moves with the rod",
        (8890.0, 8960.0, "annealed to fully dense copper"),
    )
    supply: Literal["current", "voltage"] = field(
        "current",
        "assumed: the paper states currents",
        "constant current or constant voltage at the coil",
    )
    source_resistance: u.Resistance = field(
        0.0, "assumed: none", "resistance of supply and leads, in series with the wire's"
    )


class Sleeve(Parameters):
    """The fixed iron around the coil, the return spring's housing below the rod.

    A collar at the upper end may reach inwards; as reconstructed there is none, so that the rod
    with its coil goes in from above.
    """

    inner_radius: u.SmallLength = field(0.96e-3, RECONSTRUCTED, "bore radius")
    outer_radius: u.SmallLength = printed(1.15e-3, _DIAMETER, "outer radius", 0.025e-3, own=_TURNED)
    length: u.SmallLength = field(
        18.7e-3, RECONSTRUCTED, "axial length, the housing of the return spring included"
    )
    collar_radius: u.SmallLength = field(
        0.96e-3, RECONSTRUCTED, "bore radius of the collar; the bore's own: no collar"
    )
    collar_thickness: u.SmallLength = field(0.2e-3, RECONSTRUCTED, "axial length of the collar")


def _known_curve(text: str) -> str:
    """Name of a built-in curve as it is spelt, or the text, which is a path."""
    return steel_name(text) or text


class Steel(Parameters):
    """The magnetic behaviour of rod and sleeve, one material."""

    curve: Annotated[str, AfterValidator(_known_curve)] = field(
        "team20",
        "assumed: steel of TEAM Workshop problem 20",
        f"{', '.join(STEELS)}, or the path of a CSV file with the columns B (T) and H (A/m)",
    )
    relative_permeability: u.RelativePermeability = field(
        1000.0,
        "assumed: typical of low-carbon steel",
        "used by the curve linear",
        (500.0, 2000.0, "low-carbon steels, by annealing and field"),
    )
