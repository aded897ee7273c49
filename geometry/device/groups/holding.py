"""What holds the rod: its spring, the stops that it is pressed on, and the sleeve's bore."""

from __future__ import annotations

from tactgen.geometry import units as u
from tactgen.geometry.device.groups.declaration import Parameters, field


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
    stop_gap: u.SmallLength = field(
        20e-6,
        "assumed: reconstructed; coating and burrs keep the head off the sleeve",
        "gap left at the lower stop",
        (5e-6, 50e-6, "assumed: from a coating to a foil"),
    )
