"""NGSolve solves fresh bimorphs on their rods: rod, glue and tab on tetrahedra of its own."""

import secrets
from dataclasses import astuple

import numpy as np
import pytest

from tactgen.fem.piezo.system import materials
from tactgen.geometry.device.parts import Turned, layout
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.random_devices import between
from tactgen.validation.scene.load import load_scene

#: Solids by their name here, and in the device; a quarter has one of the two ceramics.
SOLIDS = {"rod": "rod", "glue": "glue", "shim": "shim", "piezo": "piezo_top"}
#: Tetrahedra in the bond and at the edges of tab and ceramic (mm).
FINENESS = ((0.12, 0.06), (0.08, 0.03))
#: Bimorphs; each costs the witness some minutes.
_COUNT = 2


def plain(material):
    """Return a region's lossless tensors as lists."""
    piezo = material.piezo
    return {
        "stiffness": material.c.tolist(),
        "coupling": piezo.e.tolist() if piezo else [],
        "permittivity": piezo.eps.tolist() if piezo else [],
        "density": material.density,
    }


def job(device, bond, edge):
    known = materials(device, tuple(SOLIDS.values()), device.piezo.ceramic(), lossy=False)
    solids = {}
    for name, region in SOLIDS.items():
        part = layout(device, "rod", (region,))[region]
        turned = isinstance(part.body, Turned)
        solids[name] = {
            "box": [] if turned else [*astuple(part.body)],
            "outline": [*part.body.outline] if turned else [],
            "cut": [*astuple(part.cut)] if part.cut else [],
            "material": plain(known[region]),
        }
    return {"solids": solids, "bond": bond, "edge": edge}


def drawn(rng):
    """Return overrides: another tab, bond, slot and length, without losses or load."""
    return [
        f"bimorph.length={between(rng, 8.0, 16.0):.4g}mm",
        f"bimorph.tab_length={between(rng, 0.8, 2.5):.4g}mm",
        f"bimorph.shim_thickness={between(rng, 0.2, 0.3):.4g}mm",
        f"glue.thickness={between(rng, 30.0, 60.0):.4g}um",
        f"glue.youngs_modulus={between(rng, 1.0, 10.0):.4g}GPa",
        "bimorph.width=2mm", "glue.loss_factor=0", "shim.loss_factor=0", "load.kind=none",
        "drive.voltage=1V", "modes=1", "accuracy=3e-3",
    ]  # fmt: skip


@pytest.mark.heavy
def test_fresh_feet(witness):
    """Deflection and first frequency; the seed is drawn anew and shown."""
    seed = secrets.randbits(32)
    print(f"seed {seed}")
    rng = np.random.default_rng(seed)
    for _ in range(_COUNT):
        overrides = drawn(rng)
        scene, _ = load_scene("bimorph_on_rod", overrides)
        coarse, finer = (
            witness("ngsolve", "ngsolve_foot", job(scene.device, *sizes)) for sizes in FINENESS
        )
        quantities = ("static_tip_displacement", "short_circuit_frequencies")
        own = {q.name: q for q in solve(scene, ["cad"], quantities).quantities}
        for name, key in zip(quantities, ("deflection", "frequency"), strict=True):
            value, bar = np.ravel(own[name].value)[0], np.ravel(own[name].error)[0]
            apart, other = abs(value - finer[key]), abs(finer[key] - coarse[key])
            print(f"{name}: {apart / value:.1e} of {bar / value:.1e} and {other / value:.1e}")
            assert apart <= bar + other, (name, overrides)
