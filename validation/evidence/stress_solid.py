"""The piezoelectric solid far beyond the device: right to its bar, or a clear refusal.

Held against exact answers (scaling laws, fields that the elements contain, beams so slender
that beam theory is exact), else against a much finer division.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from tactgen.fem.piezo.krylov import port_error, reduce_to_ports
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import direct_multiport, static_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.system import SolidSystem
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.bricks import LEVELS, Axis, BrickMeshing, Bricks, bimorph_bricks
from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.device.parameters import Bimorph, Device, Shim
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.evidence.bench_solid_jobs import layered_tetrahedra
from tactgen.validation.evidence.coverage_bimorph import Case, judged
from tactgen.validation.evidence.judgement import Family
from tactgen.validation.evidence.stress_driven import shim

_TWO_LEVELS = 1.25
_ONE_ELEMENT = BrickMeshing((2, 2, 2), smallest=0.5)
#: First root of cos x cosh x = −1: a cantilever's first mode.
_FIRST_ROOT = 1.8751040687119612


def _without_poisson(device: Device, *, coupling: bool) -> Piezoceramic:
    """Device's ceramic strained along z by d31 alone, and no Poisson's effect."""
    ceramic = device.piezo.ceramic()
    d = np.zeros((3, 6))
    d[2, 0] = ceramic.d[2, 0] if coupling else 0.0
    return replace(ceramic, d=d, s=np.diag(np.diag(ceramic.s)))


def _static(system: SolidSystem) -> tuple[float, float, Floats]:
    """Tip displacement per volt, capacitance and the tip's compliance (2, 2)."""
    d = static_multiport(system).stiffness[0].real
    compliance = np.linalg.inv(d[2:4, 2:4])
    tip = -compliance @ d[2:4, 4]
    return float(tip[0]), float(d[4, 4] + d[4, 2:4] @ tip), compliance


def _scales(family: Family, quick: bool) -> None:
    """Scale permittivity, elasticity, density and lengths: the answers scale exactly."""
    device = Device()
    bricks, ceramic, shim = (
        bimorph_bricks(device, _ONE_ELEMENT),
        device.piezo.ceramic(),
        device.shim,
    )
    usual = _cantilever(device, bricks, ceramic)
    powers = (-10, 10) if quick else (-10, -3, 3, 10)
    for kind, power in product(("permittivity", "elasticity", "density", "length"), powers):
        a = 10.0**power
        root = np.sqrt(a)
        material, body, other = ceramic, bricks, shim
        # factors: displacement per volt, capacitance, frequency
        if kind == "permittivity":
            material = replace(ceramic, d=ceramic.d * root, eps_t=ceramic.eps_t * a)
            factors = (root, a, 1.0)
        elif kind == "elasticity":
            material = replace(ceramic, s=ceramic.s / a, d=ceramic.d / root)
            moduli = {n: getattr(shim, n) * a for n in ("youngs_modulus", "shear_modulus")}
            other, factors = shim.model_copy(update=moduli), (1.0 / root, 1.0, root)
        elif kind == "density":
            material = replace(ceramic, density=ceramic.density * a)
            other = shim.model_copy(update={"density": shim.density * a})
            factors = (1.0, 1.0, 1.0 / root)
        else:
            x, y, z = (Axis(axis.breaks * a, axis.degree) for axis in bricks.axes)
            body, factors = replace(bricks, x=x, y=y, z=z), (1.0, a, 1.0 / a)
        with family.attempt():
            found = _cantilever(device.model_copy(update={"shim": other}), body, material)
            pairs = zip(found[:3], factors, usual[:3], strict=True)
            worst = max(abs(v / (f * u) - 1.0) for v, f, u in pairs)
            # rounding of both: that of the stiffness, (L/h)⁴ times that of a number, some 1e-9
            family.add(f"{kind} x 1e{power}", worst, 1e-7)


def _slender(family: Family, quick: bool) -> None:
    """Make the bimorph so slender that beam theory is exact: no locking, or a refusal."""
    thickness = 1e-4
    for slenderness in (100.0, 1e4) if quick else (100.0, 500.0, 1e3, 1e4):
        bimorph = Bimorph(
            length=slenderness * thickness, width=3.0 * thickness,
            piezo_thickness=thickness / 3.0, shim_thickness=thickness / 3.0,
        )  # fmt: skip
        device = Device(bimorph=bimorph, shim=Shim(poisson_ratio=0.0))
        ceramic = _without_poisson(device, coupling=True)
        tip, frequency = _beam(device, ceramic)
        with family.attempt():
            # the coarse one first: what it refuses costs less
            (coarse, _, blunt, _), (fine, _, sharp, spurious) = (
                _cantilever(device, bimorph_bricks(device, LEVELS[level]), ceramic)
                for level in (0, 1)
            )
            # beam theory ignores the stress in which the layers end, which turns the last
            # thickness at the tip, and in vibration shear and the inertia of rotation
            model = 1.0 / slenderness**2
            bar = _TWO_LEVELS * abs(fine - coarse) / abs(tip) + spurious + model
            family.add(f"L/h {slenderness:g}, tip", abs(fine / tip - 1.0), bar)
            bar = _TWO_LEVELS * abs(sharp - blunt) / frequency + spurious + 10.0 * model
            family.add(f"L/h {slenderness:g}, f1", abs(sharp / frequency - 1.0), bar)


def _beam(device: Device, ceramic: Piezoceramic) -> tuple[float, float]:
    """Tip displacement per volt and first frequency (Hz) of Euler and Bernoulli's beam.

    The potential is quadratic through a layer and D_x constant, so a layer bends about its
    own middle with c + e²/ε.
    """
    b, shim = device.bimorph, device.shim
    modulus = 1.0 / ceramic.s[0, 0]
    e = ceramic.d[2, 0] * modulus
    eps = ceramic.eps_t[2, 2] - ceramic.d[2, 0] * e
    hp, hs = b.piezo_thickness, b.shim_thickness
    own, arm = hp**3 / 12.0, 0.5 * (hs + hp)
    layers = 2.0 * (modulus * (own + hp * arm**2) + e**2 / eps * own)
    ei = b.width * (shim.youngs_modulus * hs**3 / 12.0 + layers)
    mass = b.width * (2.0 * hp * ceramic.density + hs * shim.density)
    curvature = -b.poling_sign * b.width * abs(e) * (hs + hp) / ei
    frequency = _FIRST_ROOT**2 / (2.0 * np.pi * b.length**2) * np.sqrt(ei / mass)
    return 0.5 * curvature * b.length**2, float(frequency)


def _cantilever(
    device: Device, bricks: Bricks, ceramic: Piezoceramic
) -> tuple[float, float, float, float]:
    """Tip displacement per volt, capacitance, first frequency, and their rounding error."""
    system = assemble(device, bricks, lossy=False, ceramic=ceramic)
    tip, capacitance, compliance = _static(system)
    frequency = natural_modes(system, Ends(), 1)[0].frequency
    return tip, capacitance, frequency, float(compliance[0, 0] * system.spurious_stiffness)


def _distorted(family: Family, quick: bool) -> None:
    """Shift the nodes of tetrahedra until they are slivers: bending stays exact."""
    modulus = 1.0 / 15.8e-12
    for shift in (0.0, 0.9) if quick else (0.0, 0.6, 0.9, 0.99, 0.999):
        shim = Shim(poisson_ratio=0.0, youngs_modulus=modulus)
        device = Device(bimorph=Bimorph(length=4e-3), shim=shim)
        mesh, ceramic = _shifted(device, shift), _without_poisson(device, coupling=False)
        with family.attempt():
            system = assemble(device, mesh, lossy=False, ceramic=ceramic)
            b, (_, capacitance, compliance) = device.bimorph, _static(system)
            ei = modulus * b.width * b.thickness**3 / 12.0
            plates = 2.0 * ceramic.eps_t[2, 2] * b.width * b.length / b.piezo_thickness
            worst = max(
                abs(compliance[1, 1] * ei / b.length - 1.0),
                abs(compliance[0, 1] * -2.0 * ei / b.length**2 - 1.0),
                abs(capacitance / plates - 1.0),
            )
            # rounding: slivers are as much stiffer as they are flat
            family.add(f"shift {shift:g}", worst, 1e-10 / (1.0 - shift) ** 2)


def _shifted(device: Device, shift: float) -> Mesh:
    """Layers of tetrahedra with nodes moved in the planes that they must stay in.

    All move by one share, `shift` of what would flatten the first tetrahedron.
    """
    b = device.bimorph
    half = 0.5 * b.shim_thickness
    x = np.array([-half - b.piezo_thickness, -half, 0.0, half, half + b.piezo_thickness])
    y, z = np.linspace(-0.5, 0.5, 4) * b.width, np.linspace(0.0, b.length, 7)
    mesh = layered_tetrahedra(x, y, z, half)
    rng = np.random.default_rng(3)
    steps = np.array([x[3] - x[2], y[1] - y[0], z[1] - z[0]])
    move = rng.uniform(-1.0, 1.0, mesh.points.shape) * steps
    for axis, planes in enumerate((x[[0, 1, 3, 4]], y[[0, -1]], z[[0, -1]])):
        move[np.isin(mesh.points[:, axis], planes), axis] = 0.0
    largest = _flattening(mesh, move)
    return replace(mesh, points=mesh.points + shift * largest * move)


def _flattening(mesh: Mesh, move: Floats) -> float:
    """Largest motion of nodes before a tetrahedron becomes flat (bisection)."""
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        p = (mesh.points + middle * move)[mesh.cells]
        volumes = np.linalg.det(p[:, 1:] - p[:, :1])
        low, high = (middle, high) if volumes.min() > 0.0 else (low, middle)
    return low


#: Clamped bimorphs with one thickness shared between shim and ceramic in any proportion, with all
#: but a sliver of the ceramic bare, and with glue between jelly, which is refused, and steel.
_THICKNESSES = [("bimorph.length=5mm", *shim(power)) for power in range(-3, 4)]
_ELECTRODES = [
    ("bimorph.length=6mm", *(f"bimorph.bare_{end}={3.0 * (1.0 - share):g}mm"
                             for end in ("below", "above")))
    for share in (1e-2, 0.5, 1e-1, 1e-3)
]  # fmt: skip
_GLUES = [
    ("bimorph.length=5mm", "bimorph.glue_thickness=20um",
     f"glue.youngs_modulus={modulus}", f"glue.poisson_ratio={ratio}")
    for modulus, ratio in (
        ("3GPa", 0.4999), ("3GPa", 0.3), ("3GPa", 0.49), ("3GPa", 0.49999), ("10kPa", 0.3),
        ("1MPa", 0.4999), ("10MPa", 0.3), ("1TPa", 0.3),
    )
]  # fmt: skip


def _own_bars(devices: Sequence[tuple[str, ...]], family: Family, quick: bool) -> None:
    """Hold answers against bricks two levels finer, by the model's own bars."""
    for overrides in (devices[0], devices[-1]) if quick else devices:
        with family.attempt():
            clamped = ("support.kind=clamped", "load.kind=none", "modes=2")
            found = judged(Case((*overrides, *clamped)))
            family.take([replace(one, promised=1.0) for one in found])


def _resonance(family: Family, quick: bool) -> None:
    """Go into a lossless resonance, and as far as a peak of a Q of 1e8, by reduction."""
    device = Device()
    bricks = bimorph_bricks(device, LEVELS[0])
    systems = {"lossless": assemble(device, bricks, lossy=False)}
    peak = natural_modes(systems["lossless"], Ends(), 1)[0].frequency
    if not quick:
        piezo = device.piezo.model_copy(update={"quality_factor": 1e8, "loss_tangent": 1e-8})
        sharp = device.model_copy(update={"piezo": piezo})
        systems["Q 1e8"] = assemble(sharp, bricks, lossy=True)
    for name, system in systems.items():
        offsets = 10.0 ** -np.arange(1.0, 7.0 if quick else 13.0, 2.0)
        frequencies = peak * (1.0 + offsets)
        reduced = reduce_to_ports(system, frequencies)
        # D(Ω) has no pole here, but what it is made of has one, which magnifies rounding twice;
        # the estimate, a distance of two reductions, is as much rounding: right to its size
        promised = 10.0 * reduced.error_estimate(frequencies) + 1e-9
        for offset, frequency, bound in zip(offsets, frequencies, promised, strict=True):
            where = f"{name}, {offset:.0e} beside the peak"
            if bound >= 1.0:  # how far it is off then is rounding alone, as is what would judge it
                family.refuse(f"{where}: the reduction says that no digit is left")
                continue
            with family.attempt():
                exact = direct_multiport(system, frequency)
                miss = port_error(reduced.multiport(np.atleast_1d(frequency)), exact)[0]
                family.add(where, float(miss), float(bound))


#: By title, with the range.
FAMILIES: dict[str, Callable[[Family, bool], None]] = {
    "scales: permittivity with d, moduli with d, densities, lengths: 1e-10 to 1e10 times": _scales,
    "thickness ratios: shim/piezo 1e-3 to 1e3 at one total thickness, M1876 as it is":
        partial(_own_bars, _THICKNESSES),
    "slender: L/h 100 to 1e4 against beam theory, which is exact there": _slender,
    "distorted tetrahedra: nodes moved by up to 99.9 % of what keeps volumes positive; bending and "
    "capacitance": _distorted,
    "short electrodes: electrode on 1/2 to 1/1000 of the length, in the middle":
        partial(_own_bars, _ELECTRODES),
    "glue: 20 µm of 10 kPa to 1 TPa, ν up to 0.49999": partial(_own_bars, _GLUES),
    "resonance: D(Ω) by reduction against direct solution, 1e-1 to 1e-12 beside a resonance":
        _resonance,
}  # fmt: skip
