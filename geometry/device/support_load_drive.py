"""Support, load, drive and model settings."""

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
        "paper Fig 13, left: at the upper end",
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


class Spring(Parameters):
    """The return spring below the rod, and the two stops between which the rod moves.

    The upper stop leaves the working gap `gap`, the lower one `stop_gap`.
    """

    preload: u.Force = field(
        110e-3,
        "assumed: the paper's 110 mN on the finger (section 5.1), without current",
        "spring force at the upper stop",
        (99e-3, 121e-3, "assumed: set by grub screws, a tenth either way"),
    )
    stiffness: u.LateralStiffness = field(
        100.0,
        "assumed: reconstructed; soft beside the magnetic pull, so that the rod snaps",
        "stiffness",
        (20.0, 500.0, "assumed: the force over the stroke grows by 3 to 80 percent"),
    )
    eccentricity: u.Position = field(
        0.0,
        "assumed: centred",
        "distance from the axis at which the spring presses; one that leans by an angle presses as "
        "if it stood the rod's length times that angle off the axis",
    )
    eccentricity_angle: u.Angle = field(
        0.0,
        "assumed: in the plane of bending",
        "direction in which it presses off the axis, from +x towards +y; between the axes the "
        "rod rocks in both planes together, in small motions",
    )
    stop_gap: u.SmallLength = field(
        20e-6,
        "assumed: reconstructed; coating and burrs keep the head off the sleeve",
        "gap left at the lower stop",
        (5e-6, 50e-6, "assumed: from a coating to a foil"),
    )

    @property
    def tilts_both_planes(self) -> bool:
        """Whether it presses off the plane of bending."""
        return bool(self.eccentricity and self.eccentricity_angle)


class Contact(Parameters):
    """Contact of the rod's head with a stop: two rough surfaces.

    Decay length and relaxation time are those of the upper stop, a circuit board; the lower one,
    the sleeve, has them times a ratio of its own.  The rest is the same for both.  The law is in
    tmm.generator.contact.
    """

    shape: Literal["ring", "disc"] = field(
        "ring",
        "assumed: the upper board is open above the head for the bimorph, the sleeve is a ring",
        "contact area of the head: ring (its rim) or disc",
    )
    decay_length: u.RoughnessLength = field(
        # N R² / (2 c_s) to ten digits, with the ring's law in tmm.generator.contact
        round(0.110 * 1.15e-3**2 / (2.0 * 0.24), 16),
        f"assumed: calibrated to c_s of {PAPER_4} at a preload of 110 mN (a disc needs half)",
        "approach of the surfaces over which their pressure grows by e",
        (
            0.24e-6,
            0.37e-6,
            "assumed: from c_s taken at 1 V, as the paper fitted it, to a preload a fifth higher",
        ),
    )
    relaxation_time: u.RelaxationTime = field(
        round(4.46e-6 / 0.24, 14),
        f"assumed: calibrated, d_s / c_s of {PAPER_4}",
        "damping of the contact over its stiffness",
        (15e-6, 22e-6, "assumed: a fifth either way"),
    )
    lower_decay_ratio: u.PositiveNumber = field(
        1.0,
        "assumed: as at the upper stop",
        "decay length at the lower stop over that at the upper one: 0.5 is twice as stiff under "
        "the same load",
        (0.5, 1.5, "assumed: ground steel is smoother than a board, a worn collar rougher"),
    )
    lower_relaxation_ratio: u.PositiveNumber = field(
        1.0,
        "assumed: as at the upper stop",
        "relaxation time at the lower stop over that at the upper one",
        (0.1, 1.5, "assumed: steel on steel loses less than steel on a board, unless it is oily"),
    )
    tangential_ratio: u.PositiveNumber = field(
        0.82,
        "assumed: Mindlin 1949, 2 (1 - nu) / (2 - nu) with nu = 0.3",
        "stiffness of the contact along the surfaces over that across them",
        (0.7, 1.0, "measured on rough surfaces: at most that of Mindlin's smooth ones, or equal"),
    )
    board_stiffness: u.LateralStiffness = field(
        0.0,
        "assumed: rigid",
        "of the springs that hold the upper board in its plane, in small motions and harmonic "
        "balance; 0 holds it rigidly",
    )
    board_mass: u.Mass = field(
        5.1e-3,
        "assumed: that of the upper board in the bill of parts",
        "of the upper board, where springs hold it",
        (4e-3, 8e-3, "assumed: boards of 0.8 to 1.6 mm"),
    )
    board_loss_factor: u.LossTangent = field(
        0.02,
        "assumed: loss factor of glass-fibre epoxy",
        "of the springs that hold the board",
        (0.01, 0.04, "assumed: laminates"),
    )
    friction: u.PositiveNumber = field(
        0.2,
        "assumed: dry steel on board or steel",
        "coefficient of friction of the head on a stop, in time simulations",
        (0.1, 0.5, "dry metals and boards"),
    )


class Guide(Parameters):
    """Guide of the rod: bore, spring ends, air.

    Its two springs act beyond the play that `clearance` leaves.  The law is in
    tmm.generator.contact.  The magnetic gap around the flange, sleeve.inner_radius less
    rod.flange_radius, is another length: a coating or a bush may fill it.
    """

    axial_damping: u.LateralDamping = field(
        0.01,
        "assumed: 3 % of critical on the return spring",
        "damping of the axial motion",
        (0.001, 0.05, "assumed: from air alone to a rod that rubs"),
    )
    friction: u.Force = field(
        0.0,
        "assumed: none",
        "Coulomb friction of the rod in its bore, a constant force along the axis against its "
        "motion, in time simulations",
        (0.0, 22e-3, "assumed: up to a fifth of the preload"),
    )
    lateral_stiffness: u.LateralStiffness = field(
        100.0,
        "assumed: that of the return spring along its axis",
        "holds the rod laterally",
        (10.0, 1000.0, "assumed: by an order of magnitude either way"),
    )
    rotational_stiffness: u.RotationalStiffness = field(
        1e-4,
        "assumed: the return spring's stiffness times its radius squared",
        "holds the rod against tilting",
        (1e-5, 1e-3, "assumed: by an order of magnitude either way"),
    )
    clearance: u.LengthOrZero = field(
        0.0,
        "assumed: none; the return spring's ends hold the rod at any motion (fits of sliding "
        "pins of this size leave 2 to 20 um)",
        "diameter of the bore minus that of the rod; no guide within it",
    )
    guided_length: u.SmallLength = field(
        4.7e-3,
        "assumed: from the sleeve's top to the flange's lower face",
        "length over which the bore guides: the rod tilts freely by clearance over this",
        (3.0e-3, 5.0e-3, "assumed: from the flange alone to all of the rod in the sleeve"),
    )
