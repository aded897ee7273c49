"""Support, load and drive of the bimorph: also its circuit, limits and place of measurement."""

from __future__ import annotations

from typing import Literal

from tactgen.geometry import units as u
from tactgen.geometry.device.materials import Own
from tactgen.geometry.device.parameter_group import PAPER_4, Parameters, field, printed
from tactgen.geometry.formats import engineering

#: How far a support of somebody else may lie from what is said of it.
_FITTED = Own("support", 0.2)


class Support(Parameters):
    """Support of the lateral actuator's lower end (paper eqs 6-8)."""

    kind: Literal["spring", "clamped", "pinned", "table", "rod", "contact"] = field(
        "spring",
        PAPER_4,
        "the paper's springs, a rigid clamp, a hinge, a measured table, the glued joint in the "
        "real rod, or the rod's head pressed on its stop",
    )
    file: str = field(
        "",
        "not in the paper",
        "used by kind table: a CSV file with the columns frequency, rotational_stiffness and, if "
        "measured, lateral_stiffness as ..._re and ..._im or with ..._phase, each with its unit; "
        "modes and statics take its real part at the lowest frequency",
    )
    rotational_stiffness: u.RotationalStiffness = printed(0.24, PAPER_4, "c_s", 0.005, own=_FITTED)
    lateral_stiffness: u.LateralStiffness = printed(
        3e6, f"{PAPER_4} (printed with the unit Nm, meant N/m)", "c_sl", 0.5e6, own=_FITTED
    )
    rotational_damping: u.RotationalDamping = printed(
        4.46e-6, PAPER_4, "d_s", 0.005e-6, own=_FITTED
    )
    rotational_inertia: u.RotationalInertia = printed(1e-12, PAPER_4, "theta", 0.5e-12, own=_FITTED)


class Load(Parameters):
    """Load at the tip."""

    kind: Literal["none", "pinned", "finger", "mass", "spring_damper", "table", "pad"] = field(
        "finger",
        "paper section 3",
        "free tip, a hinge that holds it, the paper's finger (eqs 1-5), lumped elements, a "
        "measured table, or imitation skin with a weight on it",
    )
    mass: u.Mass = field(0.0, "not in the paper", "tip mass, used by kind mass")
    offset: u.Position = field(
        0.0,
        "not in the paper",
        "used by kind mass: height of its centre above the tip, along the length",
    )
    rotational_inertia: u.RotationalInertia = field(
        0.0, "not in the paper", "used by kind mass: about the y axis through its centre"
    )
    stiffness: u.LateralStiffness = field(0.0, "not in the paper", "used by kind spring_damper")
    damping: u.LateralDamping = field(0.0, "not in the paper", "used by kind spring_damper")
    normal_force: u.Force = field(
        0.0, "assumed: nothing rests on the tip", "force with which the finger presses the tip down"
    )
    file: str = field(
        "",
        "not in the paper",
        "used by kind table: a CSV file with the columns frequency, and impedance or stiffness as "
        "..._re and ..._im or with ..._phase, each with its unit",
    )
    extrapolation: Literal["refuse", "passive_fit"] = field(
        "refuse",
        "not in the paper",
        "used by kind table: refuse frequencies outside it, or let springs, dampers and masses "
        "fitted to it answer, up to a factor of 3 beyond it",
    )

    pad_modulus: u.Modulus = field(
        0.25e6,
        "assumed: soft rubber, Shore A 20 by Gent (1958); the paper says rubber of a crash dummy",
        "used by kind pad: shear modulus at 100 Hz",
        (0.05e6, 0.6e6, "assumed: from gels to Shore A 40"),
    )
    pad_loss_factor: u.LossTangent = field(
        0.3,
        "assumed: soft vinyl or rubber",
        "used by kind pad: loss factor of its modulus, the same at all frequencies",
        (0.1, 0.6, "assumed: from silicone to damping vinyl"),
    )
    pad_thickness: u.SmallLength = field(
        5e-3,
        "assumed: a dummy's skin",
        "used by kind pad: of the sheet",
        (2e-3, 10e-3, "assumed: dummies' skins"),
    )
    pad_radius: u.SmallLength = field(
        0.618e-3,
        "paper section 2.1: a disc as large as its 0.8 mm x 1.5 mm contact",
        "used by kind pad: radius of the contact",
        (0.55e-3, 0.72e-3, "assumed: up to the bimorph's whole end face, 0.77 mm x 2.1 mm"),
    )
    pad_weight: u.Mass = field(
        50e-3,
        "paper section 2.2",
        "used by kind pad: mass that rests on it",
        (49.5e-3, 50.5e-3, "assumed: a weight to its printed digits"),
    )
    pad_backing: u.LateralStiffness = field(
        5e3,
        "assumed: a square centimetre of the same sheet, held by support plate and other tips",
        "used by kind pad: stiffness that holds sheet and weight sideways, at 100 Hz",
        (1e3, 50e3, "assumed: from the other tips alone to the whole plate"),
    )


class Threshold(Parameters):
    """From which amplitude on a motion of the tip is felt."""

    kind: Literal["paper", "table"] = field(
        "paper", "paper section 6, Fig 17", "the paper's, stated at three frequencies, or a table"
    )
    file: str = field(
        "",
        "not in the paper",
        "used by kind table: a CSV file with the columns frequency and threshold (peak amplitude "
        "of the displacement), each with its unit",
    )


class Measurement(Parameters):
    """Where motion is read."""

    below_tip: u.LengthOrZero = field(
        0.0,
        "paper section 6: at the upper end",
        "distance below the tip at which the motion of the tip is measured in place of the tip's "
        "own, as where a laser looks below a support plate",
    )

    @property
    def place(self) -> str:
        """Where motion is read, in words."""
        return f"{engineering(self.below_tip, 'm')} below the tip" if self.below_tip else "tip"

    @property
    def where(self) -> str:
        """The same after a noun."""
        return self.place if self.below_tip else "of the tip"


class Drive(Parameters):
    """What excites the lateral actuator: amplitudes (peak) of sinusoids in phase."""

    voltage: u.Voltage = field(
        50.0, PAPER_4, "amplitude of the drive voltage (peak unless stated as pp or rms)"
    )
    base_acceleration: u.Acceleration = field(
        0.0,
        "not in the paper",
        "amplitude of the acceleration of what the support stands on, along x",
    )
    tip_force: u.ForceAmplitude = field(
        0.0, "not in the paper", "amplitude of a force on the tip, along x"
    )


class Circuit(Parameters):
    """What the bimorph's electrodes are connected to."""

    kind: Literal["source", "load", "open"] = field(
        "source",
        "paper section 4",
        "source: the drive voltage behind an impedance; load: an impedance alone (short circuit if "
        "nothing is stated); open: nothing",
    )
    resistance: u.ElectricalResistance = field(
        0.0, "not in the paper", "resistor of source or load; 0 if there is none"
    )
    inductance: u.Inductance = field(
        0.0, "not in the paper", "inductor of source or load; 0 if there is none"
    )
    capacitance: u.Capacitance = field(
        0.0, "not in the paper", "capacitor of source or load; 0 if there is none"
    )
    connection: Literal["series", "parallel"] = field(
        "series", "not in the paper", "how resistor, inductor and capacitor are connected"
    )


class Limits(Parameters):
    """Strength and drive limits of bimorph, amplifier and coil."""

    ceramic_strength: u.Stress = field(
        28e6,
        "assumed: rated dynamic tensile strength of PZT-5A and 5H, 4000 psi; M1876's is not public",
        "largest amplitude of the stress in the ceramic",
        (20e6, 40e6, "assumed: soft ceramics, by grain, surface and number of cycles"),
    )
    depoling_field: u.ElectricField = field(
        0.4e6,
        "assumed: half the coercive field of a soft ceramic (0.8 kV/mm below 1 Hz, CTS 3203HD)",
        "largest amplitude of the field in a layer, half of each period against the poling",
        (0.27e6, 0.8e6, "assumed: from a third of the coercive field to all of it"),
    )
    amplifier_current: u.Current = field(
        0.1,
        "assumed: small amplifier for capacitive loads; the paper gives no current",
        "amplitude of the current that the amplifier gives all its channels together",
        (0.02, 1.0, "assumed: from driver chips to laboratory amplifiers"),
    )
    amplifier_channels: u.Turns = field(
        16.0, "paper section 5.2: sixteen generators", "channels that share the current"
    )
    winding_temperature: u.Temperature = field(
        428.15,
        "IEC 60085: class 155 (F), polyurethane enamel",
        "temperature that the winding stands for long",
        (403.15, 453.15, "classes 130 to 180"),
    )
    ambient_temperature: u.Temperature = field(
        293.15, "assumed: 20 degC", "temperature of the air", (288.15, 308.15, "rooms")
    )
    heat_transfer: u.HeatTransfer = field(
        25.0,
        "Incropera and DeWitt, table 1.1: the most that free convection gives",
        "heat from the actuator's outer surface to the air",
        (5.0, 30.0, "assumed: from among fifteen others to alone, with radiation"),
    )


class Beam(Parameters):
    """Settings of the one-dimensional models."""

    shear_correction: u.PositiveNumber = field(
        5.0 / 6.0,
        "assumed: rectangular section",
        "Timoshenko's shear correction factor",
        (0.4, 0.9, "0.425 by the shear energy of the paper's layers, 0.88 with a stiff shim"),
    )
