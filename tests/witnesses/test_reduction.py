"""pyMOR reduces a damped bimorph, clamped: at peaks and dips its response is that of ours."""

import secrets

import numpy as np
import pytest

from tactgen.fem.piezo.krylov import reduce_to_ports
from tactgen.fem.piezo.port_model import extremes
from tactgen.fem.piezo.solid import assemble
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.bricks import BrickMeshing, bimorph_bricks
from tactgen.tmm.ports.multiport import respond
from tactgen.tmm.ports.supports_and_loads import attach
from tactgen.validation.evidence.random_devices import slender_bimorph
from tactgen.validation.scene.load import load_scene

SWEEP = np.geomspace(10.0, 20000.0, 400)
#: Points (Hz) at which the witness interpolates; what the second half adds is its error.
POINTS = np.geomspace(200.0, 20000.0, 8)
#: What rounding of the factorisations leaves at a peak, relative: see the direct solutions in
#: tests/fem/piezo/test_krylov.py, which the witness does not refine.
ROUNDING = 1e-6


def written(system, path):
    """Write the clamped solid: tip force, tip moment and voltage to tip motions and charge."""
    volt = system.stiffness.border[:, 2:]
    ends = {
        "inputs": np.hstack([system.tip[: system.inner], -volt]),
        "outputs": np.hstack([system.tip[: system.inner], -volt]).T,
        # the last row is minus the charge
        "through": np.diag([0.0, 0.0, -system.stiffness.corner[2, 2]]),
    }
    for name, matrix in (("mass", system.mass.inner), ("stiffness", system.stiffness.inner)):
        columns = matrix.tocsc()
        ends |= {f"{name}_{part}": getattr(columns, part) for part in ("data", "indices", "indptr")}
    np.savez(path, **ends)


def per_input(port):
    """Return tip displacement, tip rotation and charge per force, moment and volt, (n, 3, 3)."""
    held, columns = attach(port, Ends()), []
    for force, moment, voltage in np.eye(3):
        answer = respond(held, {"voltage": voltage}, {"w_tip": force, "psi_tip": moment})
        motion = answer.motion
        columns.append([motion["w_tip"], motion["psi_tip"], answer.effort["voltage"]])
    return np.moveaxis(np.array(columns), 2, 0).transpose(0, 2, 1)


@pytest.mark.heavy
def test_a_fresh_reduction(witness, tmp_path):
    """Three motions per three loads of a random damped bimorph; the seed is shown."""
    seed = secrets.randbits(32)
    print(f"seed {seed}")
    device = load_scene("paper", slender_bimorph(np.random.default_rng(seed)))[0].device
    system = assemble(
        device, bimorph_bricks(device, BrickMeshing((2, 2, 2), smallest=0.5)), lossy=True
    )
    own = reduce_to_ports(system, SWEEP)
    at = extremes(own.fine, SWEEP[0], SWEEP[-1], (Ends(),))
    written(system, tmp_path / "clamped.npz")
    coarse, finer = (
        witness(
            "pymor", "pymor_ports",
            {"file": str(tmp_path / "clamped.npz"), "points": [*points], "frequencies": [*at]},
        )
        for points in (POINTS[::2], POINTS)
    )  # fmt: skip
    right, less = (np.array(a["real"]) + 1j * np.array(a["imaginary"]) for a in (finer, coarse))
    found = per_input(own.multiport(at))
    apart, other = (np.abs(a / right - 1.0).max(axis=(1, 2)) for a in (found, less))
    estimate = own.error_estimate(at)
    kept = own.fine.stiffness.shape[0]
    print(f"{system.inner} unknowns, {finer['order']} and {kept} left, {at.size} extremes")
    print(f"apart {apart.max():.1e}, own estimate {estimate.max():.1e}, other {other.max():.1e}")
    assert at.size > 5
    assert np.all(apart <= estimate + other + ROUNDING)
