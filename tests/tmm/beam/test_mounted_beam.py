"""The closed form of the mounted beam: as good as 80 digits allow, at any shape and chunk."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device, Load, Support
from tactgen.tmm.beam.mounted_beam import mounted_response
from tactgen.tmm.beam.sections import section
from tactgen.tmm.ports.elements import base_stiffness, tip_stiffness

LENGTH = 20e-3
EPS = np.finfo(float).eps
CLAMPED, SPRING = Support(kind="clamped"), Support()
FREE, FINGER = Load(kind="none"), Load()


def bimorph(*, lossy=True):
    return section(Piece("bimorph", LENGTH), Device(), Beam(), lossy=lossy)


def respond_at(beam, length, f, ends, **options):
    base = ends.base and base_stiffness(ends.base, f)
    tip, omega = tip_stiffness(ends.tip, f), 2 * np.pi * f
    return mounted_response(beam, length, omega, base=base, tip=tip, **options)


def test_everything_broadcasts():
    """Sections, lengths, supports, loads and frequencies in one call, each on its own axis, and
    some of all points at a time."""
    one, f = bimorph(), np.array([0.0, 100.0, 2e3])
    beam = replace(one, EI=one.EI * np.array([1.0, 1.1])[:, None, None, None])
    lengths, tips = np.array([5e-3, 20e-3])[:, None, None], np.array([0.0, 700.0])[:, None]
    base = (1e5, np.array([0.2, 0.3, 0.4]))
    got = mounted_response(beam, lengths, 2 * np.pi * f, base=base, tip=tips, chunk=5)
    assert got.w_tip.shape == got.charge.shape == got.error.shape == (2, 2, 2, 3)
    for i, j, k, n in np.ndindex(got.w_tip.shape):
        alone = mounted_response(
            replace(one, EI=beam.EI[i, 0, 0, 0]), lengths[j, 0, 0], 2 * np.pi * f[n],
            base=(1e5, base[1][n]), tip=tips[k, 0],
        )  # fmt: skip
        np.testing.assert_allclose(got.w_tip[i, j, k, n], alone.w_tip, rtol=20 * EPS)


def test_unheld_beam_has_no_static_response():
    """Without support or load nothing balances the motion at 0 Hz."""
    with pytest.raises(np.linalg.LinAlgError, match="nothing holds"):
        mounted_response(bimorph(), LENGTH, 0.0, base=(0.0, 0.0), tip=0.0)


def test_memory_stays_flat():
    """Beside inputs and results a sweep needs memory for one block, however long it is."""
    beam, extra = bimorph(), []
    base, tip = (3e6, 0.2), 700.0
    for n in (10_000, 40_000):
        f = np.linspace(10.0, 2e3, n)
        tracemalloc.start()
        got = mounted_response(beam, LENGTH, 2 * np.pi * f, base=base, tip=tip)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        extra.append(peak - f.nbytes - 3 * got.w_tip.nbytes - got.error.nbytes)
    assert extra[1] < 1.1 * extra[0]
    assert extra[1] < 40e6
