"""The upper board on which the heads press: it moves in its plane, and bends under their moments.

Between its spacers the board is a thin plate, simply supported on the rectangle through their axes
(Navier's double sine series; S. Timoshenko and S. Woinowsky-Krieger, Theory of Plates and Shells,
2nd ed., section 28).  A head gives it its moment about y by a ring of pressure p cos θ, whose share
in a wave of number k is 2 J1(kR)/(kR); the board's tilt is read off with the same weight, so that
the compliance is symmetric.  In its plane it is rigid, on the spacers' stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.device.parameters import Device, Display
from tactgen.geometry.display.layout import axes, spacer_axes
from tactgen.tmm.ports.multiport import Multiport, connect
from tactgen.tmm.ports.port import LATERAL, ROTATION, Port

#: Poisson ratio of woven glass in epoxy, as the plate stiffness has it (D grows by 2 % from none).
_POISSON = 0.14
#: Waves kept, in k R: what is left out of a head's own tilt falls with the cube of it.
_SHORTEST = 15.0
#: Waves with a natural frequency below this many times the highest are given their inertia.
_DYNAMIC = 10.0


@dataclass(frozen=True)
class PlateWaves:
    """The board's waves as seen by the heads.

    Attributes
    ----------
    slopes : (waves, units) float
        Tilt at each head per amplitude (1/m).
    stiffness : (waves,) float
        Per amplitude (N/m).
    mass : float
        Per amplitude, the same for all (kg).
    """

    slopes: Floats
    stiffness: Floats
    mass: float


def plate_waves(device: Device, display: Display) -> PlateWaves:
    """Return the waves of the upper board between its spacers."""
    from scipy.special import j1

    corner = spacer_axes(display.width, display.board_length, display)[-1]
    a, b = 2.0 * corner[0], 2.0 * corner[1]
    radius, thickness = device.rod.head_radius, display.board_thickness
    most = _SHORTEST / radius
    m, n = np.meshgrid(
        np.arange(1, int(most * a / np.pi) + 2), np.arange(1, int(most * b / np.pi) + 2)
    )
    along_x, along_y = (np.pi * m / a).ravel(), (np.pi * n / b).ravel()
    k = np.hypot(along_x, along_y)
    kept = k <= most
    along_x, along_y, k = along_x[kept], along_y[kept], k[kept]
    x, y = (np.array(c) for c in zip(*axes(display), strict=True))
    slopes = (
        (2.0 * j1(k * radius) / (k * radius) * along_x)[:, None]
        * np.cos(along_x[:, None] * (x + 0.5 * a))
        * np.sin(along_y[:, None] * (y + 0.5 * b))
    )
    bending = display.board_modulus * thickness**3 / (12.0 * (1.0 - _POISSON**2))
    share = 0.25 * a * b
    return PlateWaves(slopes, share * bending * k**4, share * display.board_density * thickness)


def tilt_compliance(waves: PlateWaves, frequencies: Floats, loss: float) -> Complex:
    """Return tilts per moment (n, units, units) in rad/(N m), symmetric."""
    omega2 = (2.0 * np.pi * frequencies) ** 2
    slow = waves.stiffness / waves.mass < _DYNAMIC**2 * max(float(omega2.max()), 1.0)
    still, moving = waves.slopes[~slow], waves.slopes[slow]
    rest = (still.T / waves.stiffness[~slow]) @ still / (1.0 + 1j * loss)
    dynamic = waves.stiffness[slow] * (1.0 + 1j * loss) - omega2[:, None] * waves.mass
    return np.asarray(rest + np.einsum("wi,nw,wj->nij", moving, 1.0 / dynamic, moving))


def board(
    device: Device, display: Display, frequencies: Floats, units: tuple[str, ...], mass: float
) -> Multiport:
    """Return the upper board over ``w_board`` and a tilt ``psi_UNIT`` under each head.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    units : tuple of str
        The generators' names, as :func:`geometry.display.layout.unit_names`.
    mass : float
        The board's (kg).
    """
    f = np.asarray(frequencies, dtype=float)
    compliance = tilt_compliance(plate_waves(device, display), f, display.board_loss)
    tilts = tuple(Port(f"psi_{unit}", ROTATION) for unit in units)
    inverse = np.linalg.inv(compliance)
    symmetric = np.asarray(0.5 * (inverse + inverse.transpose(0, 2, 1)), dtype=complex)
    bending = Multiport(f, symmetric, tilts)
    held = display.lateral_stiffness * (1.0 + 1j * display.board_loss)
    in_plane = np.asarray(held - (2.0 * np.pi * f) ** 2 * mass, dtype=complex)[:, None, None]
    return connect(Multiport(f, in_plane, (Port("w_board", LATERAL),)), bending, {})
