"""The solid's own error bars where no exact answer is known: against a finer division."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tactgen.fem.piezo.krylov import port_error, reduce_to_ports
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import direct_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bimorph_bricks import LEVELS, bimorph_bricks
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.bimorph.ends import Ends
from tactgen.geometry.device.parameters import Bimorph, Device, Glue
from tactgen.validation.checks.stress.answers import REFUSALS, Family
from tactgen.validation.checks.stress.result import Row, answered
from tactgen.validation.checks.stress.solid_exact import static_values
from tactgen.validation.engine.error_bars import BRICK_FACTOR, least_difference

_NAMES = ("tip", "capacitance", "f1")
#: Levels of the division that is judged, of the one that judges it, and of the reference.
_COARSE, _FINE, _REFERENCE = 0, 1, 2


def thickness_row(quick: bool) -> Row:
    """Share one thickness between shim and ceramic in any proportion."""
    devices = []
    for power in (-3, 3) if quick else range(-3, 4):
        ratio = 10.0**power
        piezo = 0.77e-3 / (2.0 + ratio)
        bimorph = Bimorph(length=5e-3, piezo_thickness=piezo, shim_thickness=ratio * piezo)
        devices.append((f"shim/piezo 1e{power}", Device(bimorph=bimorph)))
    what = "shim/piezo 1e-3 to 1e3 at one total thickness, M1876 as it is"
    return _own_bars("solid: thickness ratios", what, devices)


def short_electrode_row(quick: bool) -> Row:
    """Leave all but a sliver of the ceramic bare."""
    devices = []
    for share in (1e-2,) if quick else (0.5, 1e-1, 1e-2, 1e-3):
        bare = 0.5 * (1.0 - share) * 6e-3
        bimorph = Bimorph(length=6e-3, bare_below=bare, bare_above=bare)
        devices.append((f"electrode {share:g} of the length", Device(bimorph=bimorph)))
    what = "electrode on 1 to 1/1000 of the length, in the middle"
    return _own_bars("solid: short electrodes", what, devices)


def glue_row(quick: bool) -> Row:
    """Glue the layers with anything between jelly and steel, and nearly incompressible.

    Jelly is refused.
    """
    devices = []
    pairs = [(3e9, 0.4999), (1e3, 0.3)]
    if not quick:
        pairs += [(3e9, 0.3), (3e9, 0.49), (3e9, 0.49999), (1e6, 0.4999), (1e7, 0.3), (1e12, 0.3)]
    for modulus, ratio in pairs:
        device = Device(
            bimorph=Bimorph(length=5e-3, glue_thickness=20e-6),
            glue=Glue(youngs_modulus=modulus, poisson_ratio=ratio),
        )
        devices.append((f"glue of {modulus:g} Pa, ν {ratio:g}", device))
    return _own_bars("solid: glue", "20 µm of 1 kPa to 1 TPa, ν up to 0.49999", devices)


def _own_bars(name: str, what: str, devices: Iterable[tuple[str, Device]]) -> Row:
    family = Family()
    for where, device in devices:
        try:
            coarse, fine, known = (
                _answers(device, bimorph_bricks(device, LEVELS[level]))
                for level in (_COARSE, _FINE, _REFERENCE)
            )
        except REFUSALS as error:
            family.refuse(error)
            continue
        apart = np.abs(fine - coarse)
        apart[2] += fine[2] * least_difference(fine[2:], coarse[2:])
        for i, quantity in enumerate(_NAMES):
            family.compare(f"{where}, {quantity}", fine[i], known[i], BRICK_FACTOR * apart[i])
    return answered(name, what, family.points, family.refusals)


def _answers(device: Device, bricks: Bricks) -> Floats:
    """Return tip displacement per volt, capacitance, first two bending frequencies."""
    system = assemble(device, bricks, lossy=False)
    return np.array(
        [*static_values(system), *(mode.frequency for mode in natural_modes(system, Ends(), 2))]
    )


def resonance_row(quick: bool) -> Row:
    """Go into a lossless resonance, and as far as a peak of a Q of 1e8, by reduction."""
    family = Family()
    device = Device()
    bricks = bimorph_bricks(device, LEVELS[0])
    lossless = assemble(device, bricks, lossy=False)
    peak = natural_modes(lossless, Ends(), 1)[0].frequency
    sharp = device.model_copy(
        update={
            "piezo": device.piezo.model_copy(update={"quality_factor": 1e8, "loss_tangent": 1e-8})
        }
    )
    systems = {"lossless": lossless}
    if not quick:
        systems["Q 1e8"] = assemble(sharp, bricks, lossy=True)
    for name, system in systems.items():
        offsets = 10.0 ** -np.arange(1.0, 7.0 if quick else 13.0, 2.0 if quick else 1.0)
        frequencies = peak * (1.0 + offsets)
        reduced = reduce_to_ports(system, frequencies)
        # D(Ω) has no pole here, but what it is made of has one, which magnifies rounding twice;
        # the estimate, a distance of two reductions, is as much rounding: right to its size
        promised = 10.0 * reduced.error_estimate(frequencies) + 1e-9
        for offset, frequency, bound in zip(offsets, frequencies, promised, strict=True):
            where = f"{name}, {offset:.0e} beside the peak"
            if bound >= 1.0:  # how far it is off then is rounding alone, as is what would judge it
                family.refusals.append(f"{where}: the reduction says that no digit is left")
                continue
            try:
                exact = direct_multiport(system, frequency)
            except REFUSALS as error:
                family.refuse(error)
                continue
            miss = port_error(reduced.multiport(np.atleast_1d(frequency)), exact)[0]
            family.add(where, float(miss), float(bound))
    what = "D(Ω) by reduction against direct solution, 1e-1 to 1e-12 beside a resonance"
    return answered("solid: resonance", what, family.points, family.refusals)
