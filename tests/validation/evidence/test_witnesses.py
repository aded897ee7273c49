"""Programs that share nothing with this one solve fresh bimorphs: both bars cover, everywhere."""

import secrets

import numpy as np
import pytest

from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence import bench_solid_jobs as jobs
from tactgen.validation.evidence import peers
from tactgen.validation.evidence.random_devices import slender_bimorph
from tactgen.validation.scene.load import load_scene

#: Order of the witness's bricks.
ORDER = 3
QUANTITIES = ("static_tip_displacement", "capacitance_free", "short_circuit_frequencies")


def witnessed(peer, scene):
    """Return deflection, capacitance and frequencies by a witness, with what half the size adds.

    A higher order is no measure: the corners of the clamp hold both orders back alike.
    """
    bimorph = scene.bimorph
    coarse, finer = (
        peers.solve(
            peer,
            jobs.job(
                order=ORDER, device=scene.device,
                longest=bimorph.length / (6 * n), first=bimorph.thickness / (6 * n),
                through_piezo=n, through_shim=n, across=2 * n,
            ),
        )
        for n in (1, 2)
    )  # fmt: skip
    volts = scene.drive.voltage
    return [
        (scale * np.atleast_1d(finer[key]), scale * np.abs(np.subtract(finer[key], coarse[key])))
        for key, scale in (("deflection", volts), ("capacitance", 1.0), ("natural", 1.0))
    ]


#: Bimorphs: each costs NGSolve half a minute, SfePy with SuperLU some minutes.
_COUNT = {"NGSolve": 4, "SfePy": 2}


@pytest.mark.heavy
@pytest.mark.parametrize("peer", peers.PEERS)
def test_fresh_bimorphs(peer):
    """Deflection, capacitance and four frequencies; the seed is drawn anew and shown."""
    if why := peers.missing(peer):
        pytest.skip(why)
    seed = secrets.randbits(32)
    print(f"seed {seed}")
    rng = np.random.default_rng(seed)
    for _ in range(_COUNT[peer]):
        drawn = [o for o in slender_bimorph(rng) if not o.startswith(("support", "frequency"))]
        clamped = ["support.kind=clamped", "load.kind=none", f"modes={jobs.MODES}", "accuracy=3e-3"]
        scene, _ = load_scene("paper", [*drawn, *clamped])
        own = {q.name: q for q in solve(scene, ["solid"], QUANTITIES).quantities}
        for name, (value, bar) in zip(QUANTITIES, witnessed(peer, scene), strict=True):
            apart, ours = np.abs(np.atleast_1d(own[name].value) - value), own[name].error
            shares = (
                np.stack(np.broadcast_arrays(apart, ours, bar), axis=-1) / np.abs(value)[:, None]
            )
            for difference, one, other in shares:
                print(f"{name}: {difference:.1e} of {one:.1e} and {other:.1e}")
            assert (apart <= ours + bar).all(), (name, drawn)
