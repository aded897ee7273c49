"""How the device is held, loaded and driven, and what only some models ask besides."""

from __future__ import annotations

from typing import Literal

from tactgen.geometry import units as u
from tactgen.geometry.device.groups.declaration import PAPER_4, Parameters, field, printed


class Support(Parameters):
    """What holds the lower end of the lateral actuator (paper eqs 6-8)."""

    kind: Literal["spring", "clamped", "rod", "contact"] = field(
        "spring",
        PAPER_4,
        "the paper's springs, a rigid clamp, the glued joint in the real rod, or the rod's head "
        "pressed on its stop",
    )
    rotational_stiffness: u.RotationalStiffness = printed(0.24, PAPER_4, "c_s", 0.005)
    lateral_stiffness: u.LateralStiffness = printed(
        3e6, f"{PAPER_4} (printed with the unit Nm, meant N/m)", "c_sl", 0.5e6
    )
    rotational_damping: u.RotationalDamping = printed(4.46e-6, PAPER_4, "d_s", 0.005e-6)
    rotational_inertia: u.RotationalInertia = printed(1e-12, PAPER_4, "theta", 0.5e-12)


class Load(Parameters):
    """What the tip pushes against."""

    kind: Literal["none", "finger", "mass", "spring_damper"] = field(
        "finger", "paper section 3", "free tip, the paper's finger (eqs 1-5), or lumped elements"
    )
    mass: u.Mass = field(0.0, "not in the paper", "tip mass, used by kind mass")
    stiffness: u.LateralStiffness = field(0.0, "not in the paper", "used by kind spring_damper")
    damping: u.LateralDamping = field(0.0, "not in the paper", "used by kind spring_damper")
    normal_force: u.Force = field(
        0.0, "assumed: nothing rests on the tip", "force with which the finger presses the tip down"
    )


class Drive(Parameters):
    """The electrical source."""

    voltage: u.Voltage = field(50.0, PAPER_4, "amplitude (peak) of the drive voltage")


class Beam(Parameters):
    """What only the one-dimensional models need."""

    shear_correction: u.PositiveNumber = field(
        5.0 / 6.0,
        "assumed: rectangular section",
        "Timoshenko's shear correction factor",
        (0.4, 0.9, "0.425 by the shear energy of the paper's layers, 0.88 with a stiff shim"),
    )
