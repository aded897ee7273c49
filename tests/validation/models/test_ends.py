"""Ends by name: a tip mass with a size, and hinges."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tactgen.geometry.bimorph.boundary_conditions import Ends, TipLoad
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.sections import Section
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

#: A block of 4 x 4 x 8 mm on the tip of the neutral 20 mm bimorph.
BLOCK = (
    "support.kind=clamped", "load.kind=mass", "load.mass=0.5 g", "load.offset=4 mm",
    "load.rotational_inertia=3.3e-9 kg*m^2",
)  # fmt: skip


def wavenumbers(mass, offset, inertia):
    """First three β of a clamped Euler-Bernoulli beam of EI = m = l = 1, by its own equation."""

    def unbalanced(b):
        c, s, ch, sh = np.cos(b), np.sin(b), np.cosh(b), np.sinh(b)
        shapes = (ch - c, sh + s, ch + c, sh - s), (sh - s, ch - c, sh + s, ch + c)
        rows = []
        for w, slope, bent, shear in shapes:
            centre = w + offset * b * slope
            rows.append((
                b**2 * bent - b**4 * (mass * offset * centre + inertia * b * slope),
                b**3 * shear + b**4 * mass * centre,
            ))  # fmt: skip
        return np.linalg.det(np.array(rows)) / ch

    at = np.linspace(0.05, 12.0, 4000)
    signs = np.sign([unbalanced(b) for b in at])
    return [brentq(unbalanced, at[i], at[i + 1]) for i in np.flatnonzero(np.diff(signs))[:3]]


@pytest.mark.parametrize(("mass", "offset", "inertia"), [(1.0, 0.2, 0.05), (5.0, -0.1, 0.3)])
def test_frequencies_are_those_of_the_differential_equation(mass, offset, inertia):
    """Transfer matrices find them by counting; here the boundary conditions are written down."""
    beam = Section(EI=1.0, GA=1e12, m=1.0, rhoI=0.0, K=0.0, C=1.0)
    ends = Ends(None, TipLoad(mass=mass, offset=offset, inertia=inertia))
    found = bending_frequencies([(beam, 1.0)], ends, 3, open_circuit=False)
    exact = np.square(wavenumbers(mass, offset, inertia)) / (2.0 * np.pi)
    # GA of 1e12 leaves a shear of 1e-10 at the third mode
    assert found == pytest.approx(exact, rel=1e-8)


#: Natural frequencies (Hz), motion and force at 100 Hz.
NAMES = ["short_circuit_frequencies", "tip_displacement", "load_force"]


def answers(model, *overrides):
    scene, _ = load_scene("j1", [*BLOCK, "frequency=100 Hz", "mesh.level=1", *overrides])
    found = solve(scene, model, NAMES, modelling=False)
    return {name: np.asarray(found.get(name, model).value) for name in NAMES}


def test_beam_models_agree():
    """Beam elements carry the same block at their last node; the first mode of four is near."""
    lumped, tmm, beam = (answers(model) for model in ("lumped", "tmm", "beam"))
    for name in NAMES:
        # rounding of beam elements
        np.testing.assert_allclose(beam[name], tmm[name], rtol=1e-7)
    assert lumped["short_circuit_frequencies"][0] == pytest.approx(
        tmm["short_circuit_frequencies"][0], rel=1e-4
    )


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_solid_carries_the_block():
    """Its first frequency falls by the block's size as the beam's does, of the same materials."""
    small = ("load.offset=0 mm", "load.rotational_inertia=0 kg*m^2")

    def first(model, *overrides):
        return answers(model, "modes=1", *overrides)[NAMES[0]][0]

    solid, tmm = (first(model) / first(model, *small) for model in ("solid", "tmm"))
    # both bend by 1.4 % differently, of which a tenth is left in the quotient
    assert solid == pytest.approx(tmm, rel=2e-3)
    assert tmm < 0.8


def test_force_on_the_block_moves_it():
    """m times the acceleration of its centre, which turns with the tip."""
    scene, _ = load_scene("j1", [*BLOCK, "frequency=100 Hz"])
    found = solve(scene, "tmm", ["tip_displacement", "tip_rotation", "load_force"], modelling=False)
    w, psi, force = (
        found.get(n, "tmm").value[0] for n in ("tip_displacement", "tip_rotation", "load_force")
    )
    omega = 200.0 * np.pi
    assert force == pytest.approx(-(omega**2) * 0.5e-3 * (w - 4e-3 * psi), rel=1e-12)


def test_time_simulation_refuses_a_size():
    """It knows parts that move the tip, and none that turn it."""
    from tactgen.tmm.ports.elements import chain_of

    scene, _ = load_scene("j1", [*BLOCK])
    with pytest.raises(InputError, match=r"load\.offset = 4 mm .* set both to 0"):
        chain_of(scene.ends.tip)


@pytest.mark.parametrize("model", ["tmm", "beam", pytest.param("solid", marks=pytest.mark.heavy)])
def test_hinges_at_both_ends(model):
    """A slender beam on hinges: (π/1.8751)² times the first frequency on a clamp."""
    slender = ["bimorph.length=60 mm", "bimorph.width=2 mm", "load.kind=none", "mesh.level=1"]
    first = [
        solve(load_scene("j1", [*slender, *ends])[0], model, names, modelling=False)
        .get("short_circuit_frequencies", model)
        .value[0]
        for names in [["short_circuit_frequencies"]]
        for ends in (["support.kind=clamped"], ["support.kind=pinned", "load.kind=pinned"])
    ]
    # shear takes some h²/l² = 2e-4, at the hinges as at the clamp; a solid's clamp also holds it
    # across, over a tenth of its width beyond it
    within = 2.0 * 0.1 * 2.0 / 60.0 if model == "solid" else 1e-3
    assert first[1] / first[0] == pytest.approx((np.pi / 1.8751041) ** 2, rel=within)


def test_one_hinge_holds_nothing():
    """Static values of a bimorph that may turn are refused; its response is not."""
    loose, _ = load_scene("j1", ["support.kind=pinned", "frequency=100 Hz"])
    with pytest.raises(InputError, match=r'support\.kind = "pinned" lets the actuator turn'):
        solve(loose, "tmm", ["static_tip_displacement"], modelling=False)
    assert solve(loose, "tmm", ["tip_displacement"], modelling=False).get("tip_displacement", "tmm")
