"""Normal actuators of the cases, each by its field or circuit as finely as a check's level says."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.magnetisation import MagnetisationCurve
from tactgen.geometry.device.parameters import NOMINAL_GAP, Coil, Device, Rod, Sleeve
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import Samples
from tactgen.tmm.reluctance.flux_ladder import Ladder
from tactgen.tmm.reluctance.flux_ladder import solve as solve_ladder
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.mesh_levels import cached, counted, degree
from tactgen.validation.scene.keys import declaration, scene_keys
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.tolerances import unit_of
from tactgen.validation.scene.variation import value_of, with_values

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric import FieldPoint


@cached
def field_point(
    device: Device, current: float, gap: float | None = None, refinement: float = 1.0
) -> FieldPoint:
    """Normal actuator's field at a current (A) and a gap (m), its own by default."""
    from tactgen.fem.magnetics.axisymmetric import ORDER, solve_point

    found = solve_point(
        device, current, gap, order=degree(ORDER), refinement=refinement, any_grid=True
    )
    counted(found.unknowns)
    return found


#: The device; its steel is that of TEAM problem 20.
COLLARED = Device(
    rod=Rod(
        radius=0.62e-3,
        flange_radius=0.91e-3,
        flange_thickness=0.9e-3,
        flange_position=2.4e-3,
        length=3.3e-3,
    ),
    coil=Coil(
        inner_radius=0.62e-3, outer_radius=0.88e-3, length=2e-3, position=0.3e-3, turns=849.0
    ),
    sleeve=Sleeve(
        inner_radius=0.96e-3, length=3.6e-3, collar_radius=0.9e-3, collar_thickness=0.2e-3
    ),
)


def collared(**changes: dict[str, float]) -> Device:
    """Device with some values of its groups changed, as ``sleeve={"length": 3e-3}``."""
    groups = {name: getattr(COLLARED, name).model_copy(update=new) for name, new in changes.items()}
    return COLLARED.model_copy(update=groups)


#: Gap (m), and by current (A) the pull (N) and the flux linkage per turn (Wb), by an axisymmetric
#: solution that is not published, of a program that shares nothing with this one; it states 0.03 %
#: and 0.01 % as its own error.
GAP = 0.2e-3
KNOWN = {0.13: (110.0507e-3, 2.278879e-6), 0.05: (37.9644e-3, 1.376275e-6)}


#: Stated from the nominal gap.
_POSITIONS = ("rod.length", "rod.flange_position", "coil.position")
#: No two edges level, so that every size may become larger and smaller.
_DEVICE = (
    "rod.radius=0.62mm", "rod.head_radius=1.12mm", "rod.length=4.8mm",
    "sleeve.collar_radius=0.93mm", "coil.outer_radius=0.89mm", "accuracy=1%",
)  # fmt: skip
#: Factor of all lengths.
_GROWTH = 1.25
#: What a power of the size is known of.
_QUANTITIES = ("coenergy", "flux_linkage", "magnetic_force")


@cached
def powers_of_size() -> dict[str, float]:
    """Power with which each quantity grows with the device, as it is grown."""
    scene, _ = load_scene("reluctance", ["models=axisymmetric", *_DEVICE])
    grown = {"coil.current": _GROWTH * scene.coil.current}
    for key in scene_keys():
        unit = unit_of(declaration(key))
        if key.startswith(("rod.", "coil.", "sleeve.", "gap")) and unit and unit.si == "m":
            shift = NOMINAL_GAP * (key in _POSITIONS)
            grown[key] = _GROWTH * (float(value_of(scene, key)) + shift) - shift
    before, after = (
        solve(each, ("axisymmetric",), _QUANTITIES) for each in (scene, with_values(scene, grown))
    )
    return {
        name: math.log(
            float(after.get(name, "axisymmetric").value / before.get(name, "axisymmetric").value),
            _GROWTH,
        )
        for name in _QUANTITIES
    }


#: Of the transformer with a core of B ∝ √H (A, Wb).
CURRENT, FLUX_LINKAGE = 0.2, 0.25


@dataclass(frozen=True)
class SquareLaw(MagnetisationCurve):
    """H = Hs (B/Bs)² through the last point (Bs, Hs); the ladder needs no more of a curve."""

    def field_strength(self, b: Floats) -> Floats:
        """H (A/m) at flux density `b` (T)."""
        return np.asarray(self.field[-1] * (b / self.flux_density[-1]) ** 2)

    def slope(self, b: Floats) -> Floats:
        """DH/dB (m/H) at flux density `b` (T)."""
        return np.asarray(2.0 * self.field[-1] * b / self.flux_density[-1] ** 2)

    def energy_density(self, b: Floats) -> Floats:
        """∫ H dB (J/m³) at flux density `b` (T)."""
        return np.asarray(self.field_strength(b) * b / 3.0)


def one_loop(
    curve: MagnetisationCurve, area: float, length: float, turns: float, reluctance: float = 0.0
) -> Ladder:
    """One flux through one piece of iron and one gap."""
    none = np.zeros((1, 1))
    return Ladder(
        curve=curve,
        area=np.array([[area]]),
        length=np.array([[length]]),
        d_length=none,
        cell=np.array([0]),
        reluctance=np.array([[0.0, reluctance]]),
        d_reluctance=np.zeros((1, 2)),
        turns=np.array([[turns]]),
        d_turns=none,
    )


def by_ladder() -> tuple[float, float]:
    """Co-energy and stored energy iλ − W' (J) at 0.2 A by the circuit's solver."""
    field, flux_density, turns, area = 100.0, 2.0, 10.0, 0.01
    core = SquareLaw(np.array([0.0, flux_density]), np.array([0.0, field]))
    # the core's length for which λ(0.2 A) = N A Bs √(N i/(l Hs)) is 0.25 Wb
    length = turns * CURRENT / field * (turns * area * flux_density / FLUX_LINKAGE) ** 2
    found = solve_ladder(one_loop(core, area, length, turns), np.array([CURRENT]))
    coenergy = float(found.coenergy[0, 0])
    return coenergy, CURRENT * float(found.flux_linkage[0, 0]) - coenergy


def by_map() -> tuple[float, float]:
    """Both at 0.2 A and 0.2 mm by a map of the flux linkage 0.25 Wb √(i/0.2 A) · 0.2 mm/g."""
    i, g = 0.3 * (np.arange(25) / 24.0) ** 3, np.linspace(0.1e-3, 0.3e-3, 8)
    linkage = FLUX_LINKAGE * np.sqrt(i[:, None] / CURRENT) * 0.2e-3 / g
    coenergy = 2.0 / 3.0 * i[:, None] * linkage
    found = fit(Samples(i, g, linkage, coenergy / g, coenergy))
    return float(found.coenergy(CURRENT, 0.2e-3)), float(found.energy(CURRENT, 0.2e-3))
