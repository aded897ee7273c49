"""The assembled piezoelectric solid as a value, and the tensors of its regions.

Which elements it came from does not matter to anyone who asks it for ports or modes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.fem.piezo.modal_model import Motion
from tactgen.fem.piezo.symmetry import PORTS, Bordered, Expansion
from tactgen.fem.solvers.linear_solver import Factor, factorise
from tactgen.geometry.arrays import Floats, Ints, Numbers
from tactgen.geometry.bimorph.segments import material_of
from tactgen.geometry.device.materials import (
    Piezoceramic,
    PiezoTensors,
    isotropic_stiffness,
    lossy_modulus,
)
from tactgen.geometry.device.parameters import Device, Glue, Piezo, Rod, Shim

#: Voigt index of a pair of axes.
VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])

#: Where a system keeps its factor once it is asked for.
_FACTOR = "_held_factor"


@dataclass(frozen=True)
class SolidSystem:
    """Assembled solid over y = [free displacements and potentials, w_base, ψ_base, U]."""

    #: Symmetric indefinite; complex when lossy.  Its last row is minus the charge
    stiffness: Bordered
    mass: Bordered  #: Zero in the rows of potentials
    #: (n, 2) Columns give tip displacement and tip rotation from y, and port forces to y
    tip: Floats
    #: ``expand @ y`` are (u_x, u_y, u_z, φ) at the nodes (4 * n_nodes, …), component by component,
    #: in metres and volts
    expand: Expansion
    nodes: Floats  #: (n_nodes, 3) Where the nodes are (m)
    node_mass: Floats  #: (n_nodes,) Lumped mass (kg), for weighing modes
    volts_per_unit: float  #: Size of the potential's unit (V); U is in volts all the same
    #: The motions that it can make.  In bending across the width the first two ports are the base's
    #: motions there; those that no port takes part in leave the last three rows empty
    motion: Motion = "all"
    #: Gives the same body in another class of motion; None for a body taken whole
    related: Callable[[Motion], SolidSystem] | None = None
    #: The other classes of motion
    others: tuple[Motion, ...] = ()
    #: (n - 3,) A good order in which to eliminate all but the last three unknowns
    elimination: Ints | None = None
    #: (n,) The body moved along x by 1, as far as its motions let it
    translation: Floats | None = None
    #: (n, m) Its column gives the mean displacement of the section where motion is measured; none
    #: at the tip itself
    measured: Floats | None = None

    @property
    def seen(self) -> Floats:
        """All that is seen of y and loaded, (n, t): the tip, and the place of measurement."""
        return self.tip if self.measured is None else np.hstack([self.tip, self.measured])

    @property
    def has_ports(self) -> bool:
        """Whether base, tip and electrodes can act on these motions."""
        return self.motion in ("all", "bending_x")

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.inner + PORTS

    @property
    def inner(self) -> int:
        """Number of unknowns less the ports."""
        return int(self.stiffness.inner.shape[0])

    @property
    def lossy(self) -> bool:
        """Whether the stiffness is complex."""
        return np.iscomplexobj(self.stiffness.inner.data)

    @cached_property
    def spurious_stiffness(self) -> float:
        """Stiffness (N/m) by which rounding of the matrix may change that of bending.

        A translation in x needs no force; this is the sum of those it seems to need at all
        unknowns.  In a slender body, (L/h)⁴ times stiffer across than in bending, it counts.
        """
        assert self.translation is not None
        moved = self.translation.astype(np.longdouble)
        forces = self.stiffness.wide_product(moved)
        return float(np.abs(forces.real[moved == 1.0]).sum())

    def nodal_displacement(self, columns: Floats) -> Floats:
        """Displacement of the nodes (n_nodes, 3, k) in k states of y (m, k).

        Of y the first m are given, the others are zero.
        """
        others = np.zeros((self.size - columns.shape[0], columns.shape[1]))
        nodal = self.expand @ np.vstack([columns, others])
        return np.asarray(nodal.reshape(4, -1, columns.shape[1])[:3].transpose(1, 0, 2))

    @property
    def charge(self) -> Numbers:
        """Charge on the electrodes (C) per unit of each unknown (n,)."""
        return -np.concatenate([self.stiffness.border[:, -1], self.stiffness.corner[:, -1]])

    @property
    def held_factor(self) -> Factor:
        """The factor of K with base and electrodes held: statics and all modes come from this one.

        No cached_property: in Python 3.11 that lets one thread at a time factorise.
        """
        if _FACTOR not in self.__dict__:
            self.__dict__[_FACTOR] = factorise(self.stiffness.inner, order=self.elimination)
        found: Factor = self.__dict__[_FACTOR]
        return found

    def dynamic_factor(self, omega2: complex) -> Factor:
        """The factor of K − Ω² M with base and electrodes held, Ω² in rad²/s²."""
        if omega2 == 0.0:
            return self.held_factor
        dynamic = self.stiffness.inner - omega2 * self.mass.inner
        return factorise(dynamic, order=self.elimination)

    def drop_factor(self) -> None:
        """Give back the memory of the factor; who asks for it again has it made again."""
        self.__dict__.pop(_FACTOR, None)


@dataclass(frozen=True)
class Material:
    """Tensors of one region; `piezo` None where there is no field."""

    c: Numbers
    density: float
    piezo: PiezoTensors | None = None

    def flux_tensor(self, unit: float) -> Numbers:
        """C (4, 3, 4, 3): flux (p, a) = C grad (q, b) of (u_x, u_y, u_z, φ / unit)."""
        tensor = np.zeros((4, 3, 4, 3), dtype=self.c.dtype)
        tensor[:3, :, :3, :] = self.c[VOIGT[:, :, None, None], VOIGT[None, None]]
        if self.piezo is not None:
            tensor = tensor.astype(np.result_type(self.c, self.piezo.e, self.piezo.eps))
            e = unit * self.piezo.e[:, VOIGT]
            tensor[:3, :, 3, :] = np.moveaxis(e, 0, 2)
            tensor[3, :, :3, :] = e
            tensor[3, :, 3, :] = -(unit**2) * self.piezo.eps
        return tensor


def materials(
    device: Device, regions: tuple[str, ...], ceramic: Piezoceramic, *, lossy: bool
) -> dict[str, Material]:
    """Material of each region (SI, in the device's axes, with the device's poling)."""
    sign = device.bimorph.poling_sign
    known: dict[str, Piezo | Shim | Glue | Rod] = {
        "shim": device.shim, "glue": device.glue, "rod": device.rod,
    }  # fmt: skip
    poled = dict.fromkeys(("piezo", "piezo_top", "piezo_bottom"), (ceramic, sign))
    for number, layer in enumerate(device.bimorph.layers):
        of, region = material_of(device, layer), device.bimorph.layers.region(number)
        if isinstance(of, Piezo):
            poled[region] = of.ceramic(), float(device.bimorph.drive_poling(number))
        else:
            known[region] = of
    return {
        region: _poled(*poled[region], lossy=lossy)
        if region in poled
        else _elastic(known[region], lossy=lossy)
        for region in regions
    }


def _poled(ceramic: Piezoceramic, sign: float, *, lossy: bool) -> Material:
    """Ceramic poled along x, or against it."""
    tensors = ceramic.tensors(lossy=lossy)
    turned = PiezoTensors(tensors.c, sign * tensors.e, tensors.eps)
    return Material(tensors.c, ceramic.density, turned)


def _elastic(of: Piezo | Shim | Glue | Rod, *, lossy: bool) -> Material:
    """Material without a field."""
    assert not isinstance(of, Piezo)
    if isinstance(of, Rod):
        stiffness = isotropic_stiffness(of.youngs_modulus, of.poisson_ratio)
    else:
        stiffness = of.stiffness()
    return Material(lossy_modulus(stiffness, of.loss_factor, lossy=lossy), of.density)


def volts_per_unit(known: dict[str, Material]) -> float:
    """Voltage whose field energy is that of a unit displacement's strain energy."""
    piezo = next(m.piezo for m in known.values() if m.piezo is not None)
    return float(np.sqrt(np.abs(piezo.c[0, 0] / piezo.eps[0, 0])))
