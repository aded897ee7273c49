"""The glued tab as an elastic joint, against beam elements and its limits."""

import numpy as np
import pytest

from tactgen.fem import beam as elements
from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Glue, Shim
from tactgen.tmm.beam.transfer_matrix import bonded_tab

DEPTH = 0.4e-3
PIECE = Piece("bond", DEPTH)


def device(modulus=3e9, **shim):
    return Device(
        bimorph=Bimorph(tab_length=2e-3), glue=Glue(youngs_modulus=modulus), shim=Shim(**shim)
    )


@pytest.mark.parametrize("modulus", [3e6, 10e9])
def test_closed_form_equals_beam_elements(modulus):
    """The founded beam in closed form and by finite elements, glue of rubber to filled epoxy."""
    closed = np.linalg.inv(bonded_tab(PIECE, device(modulus), Beam()).compliance)
    by_elements = elements.bonded_tab(device(modulus), Beam(), DEPTH)
    # eight elements of order five: 3e-9 at the stiffest glue, whose waves are the shortest
    np.testing.assert_allclose(by_elements, closed, rtol=1e-8)


def test_a_loss_that_all_parts_share_turns_the_joint_by_it():
    """Tab and glue with one loss factor: stiffness times (1 + jη), by both witnesses."""
    eta = 0.3
    lossy = Device(
        bimorph=Bimorph(tab_length=2e-3), glue=Glue(loss_factor=eta), shim=Shim(loss_factor=eta)
    )
    closed = np.linalg.inv(bonded_tab(PIECE, lossy, Beam(), lossy=True).compliance)
    lossless = np.linalg.inv(bonded_tab(PIECE, lossy, Beam()).compliance)
    np.testing.assert_allclose(closed, (1.0 + 1j * eta) * lossless, rtol=1e-12)
    by_elements = elements.bonded_tab(lossy, Beam(), DEPTH, lossy=True)
    # as above, eight elements of order five
    np.testing.assert_allclose(by_elements, closed, rtol=1e-8)


def test_soft_glue_carries_a_rigid_tab():
    """A tab much stiffer than its glue turns about a point, as springs that add up demand."""
    soft = device(modulus=3e3)
    g, b, h = soft.glue, soft.bimorph.width, soft.bimorph.shim_thickness
    shear = g.youngs_modulus / (2 * (1 + g.poisson_ratio))
    squeezed = g.youngs_modulus * (1 - g.poisson_ratio) / (
        (1 + g.poisson_ratio) * (1 - 2 * g.poisson_ratio)
    )  # fmt: skip
    t, l = g.thickness, DEPTH
    face, side = 2 * (squeezed * b + shear * h) / t, 2 * shear * (b * h**2 / 4 + h**3 / 12) / t
    below, turned = shear * b * h / t, squeezed * b * h**3 / 12 / t
    # displacement at depth d is w + d ψ
    stiffness = np.array(
        [
            [face * l + below, face * l**2 / 2 + below * l],
            [face * l**2 / 2 + below * l, face * l**3 / 3 + side * l + below * l**2 + turned],
        ]
    )
    compliance = bonded_tab(PIECE, soft, Beam()).compliance
    # what the tab itself gives way by shear: face l²/GA = 3e-5
    np.testing.assert_allclose(np.linalg.inv(compliance), stiffness, rtol=3e-5)
