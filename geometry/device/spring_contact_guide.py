"""The machine's mechanics about the rod: return spring, contact of the head, guide in the bore."""

from __future__ import annotations

from typing import Literal

from tactgen.geometry import units as u
from tactgen.geometry.device.parameter_group import PAPER_4, Parameters, field


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
