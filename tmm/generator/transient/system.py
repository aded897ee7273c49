"""What moves: a linear passive structure, springs and stops that are not linear, a coil.

    M x'' + C x' + K x = f + θ U − Σ d_e f_e(δ_e, δ_e') − b F(i, g),
    δ_e = s_e + d_e·x,   g = g_0 + b·x,   λ' = v − R i,   Q = θ·x + C_p U.

The coordinates x are whatever the structure is made of: modes, rigid motions, the rod's height.
Nothing here knows the device; :mod:`tmm.generator.transient.march` moves it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.transient.laws import Law
from tactgen.tmm.reluctance.coenergy.cells import Coenergy


@dataclass(frozen=True)
class Element:
    """One spring or p of one kind, side by side: δ = `offset` + `direction` · x.

    Attributes
    ----------
    name : str
    law : Law
        Its parameters are numbers or (p,) arrays.
    direction : (p, n) or (n,) float
    offset : float or (p,) float
        m.
    """

    name: str
    law: Law
    direction: Floats
    offset: Floats | float = 0.0


@dataclass(frozen=True)
class Friction:
    """Coulomb friction under what an element pushes, rounded off at small speeds.

    T = −µ N v/√(v² + v_s²) along `direction` · x: it creeps where a rough surface would stick,
    and takes energy at any speed.

    Attributes
    ----------
    element : int
        Which of the system's elements pushes with N.
    direction : (n,) float
    coefficient : float
        µ.
    speed : float
        v_s (m/s).
    """

    element: int
    direction: Floats
    coefficient: float
    speed: float = 1e-4


@dataclass(frozen=True)
class Coil:
    """The winding and what its field pulls at.

    Attributes
    ----------
    coenergy : Coenergy
        W'(i, g).
    direction : (n,) float
        b: how the gap opens with the coordinates.
    gap : float
        g_0 at x = 0 (m).
    resistance : float
        Of the circuit (Ω).
    source : {"current", "voltage"}
        What the waveform prescribes.
    width : float
        A change of the gap that counts as large (m).
    largest_current, gaps : float, (float, float)
        Where the co-energy is known (A, m); a run that leaves this range ends.
    """

    coenergy: Coenergy
    direction: Floats
    gap: float
    resistance: float
    source: Literal["current", "voltage"] = "current"
    width: float = 1e-4
    largest_current: float = np.inf
    gaps: tuple[float, float] = (-np.inf, np.inf)


@dataclass(frozen=True)
class Output:
    """A linear output `row` · x in `unit`.

    `scale` is the size at which its error is judged, `step_scale` the size at which each step's is:
    what is not judged itself may carry errors into what is.
    """

    row: Floats
    unit: str
    scale: float
    meaning: str = ""
    step_scale: float | None = None


@dataclass(frozen=True)
class System:
    """A structure with its springs, its stops and its coil, in SI units.

    Attributes
    ----------
    mass, damping, stiffness : (n, n) float
        Symmetric and positive semidefinite; what has no mass is held by a damper or a spring.
    load : (n,) float
        Constant forces: preload and weight.
    coupling : (n,) float
        θ: force per volt across the bimorph, and its charge per coordinate.
    capacitance : float
        C_p at x = 0 (F).
    elements : tuple of Element
        Springs and stops.
    frictions : tuple of Friction
        Under elements that push.
    coil : Coil or None
        The normal actuator's winding.
    outputs : dict of str to Output
        What is recorded of x, and judged.
    """

    mass: Floats
    damping: Floats
    stiffness: Floats
    load: Floats
    coupling: Floats
    capacitance: float = 0.0
    elements: tuple[Element, ...] = ()
    frictions: tuple[Friction, ...] = ()
    coil: Coil | None = None
    outputs: Mapping[str, Output] = field(default_factory=dict)
