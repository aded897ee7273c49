"""What one member of a family has to say: its modes and its answers to unit loads, as shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.expansion import POTENTIAL
from tactgen.fem.bimorph.reduction.parametric.products import Shapes
from tactgen.fem.piezo.bricks import quarter_unknowns
from tactgen.fem.piezo.modes import eigenpairs
from tactgen.fem.piezo.system import SolidSystem
from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.bimorph.ends import Ends

#: Blocks of the series in Ω² K⁻¹ M that answers to the ports' loads are given with.
_BLOCKS = 3


@dataclass(frozen=True)
class Grid:
    """Where the unknowns of one class of motion are on the grid of nodes.

    Attributes
    ----------
    shape : (int, int, int)
        Nodes along each axis.
    index : (n,) int array
        Flat positions of the unknowns among the values (u_x, u_y, u_z, φ) of each node.
    lift : (nx, ny, nz) array
        Potential per volt of the electrodes, in units of the potential.
    """

    shape: tuple[int, int, int]
    index: Ints
    lift: Floats

    @classmethod
    def of(cls, bricks: Bricks, system: SolidSystem) -> Grid:
        """Return where a system's unknowns are."""
        unknowns = quarter_unknowns(bricks, system.motion, system.volts_per_unit)
        lift = unknowns.ports.reshape(*bricks.shape, 4, -1)[..., POTENTIAL, 2]
        return cls(bricks.shape, unknowns.index, lift)

    def spread(self, columns: Floats) -> Shapes:
        """Return states of the unknowns (n, k) as shapes: k of displacement, k of potential."""
        full = np.zeros((int(np.prod(self.shape)) * 4, columns.shape[1]))
        full[self.index] = columns
        values = np.moveaxis(full.reshape(*self.shape, 4, -1), 3, 0)
        return Shapes(np.ascontiguousarray(values[:3]), np.ascontiguousarray(values[3]))

    def gathered(self, shapes: Shapes) -> Floats:
        """Return the unknowns (n, k) of as many displacements as potentials."""
        values = np.concatenate([shapes.moved, shapes.charged[None]])
        flat = np.moveaxis(values, 0, 3).reshape(-1, shapes.charged.shape[-1])
        return np.asarray(flat[self.index])


def answers(system: SolidSystem, count: int, lossy: SolidSystem | None = None) -> Floats:
    """Return the lowest `count` modes and, of a body with ports, its answers to their loads.

    Held at the base; (n, k) states of the unknowns but the ports.

    Parameters
    ----------
    lossy : SolidSystem, optional
        The same with losses: then also what they add to the states.
    """
    factor, mass, n = system.held_factor, system.mass.inner, system.inner
    _, modes = eigenpairs(system, Ends(), count)
    states = list(modes)
    if system.has_ports:
        follows = -factor.solve(system.stiffness.border[:, :2])
        carried = mass @ follows + system.mass.border[:, :2]
        block = factor.solve(
            np.column_stack([carried, system.tip[:n], system.stiffness.border[:, 2]])
        )
        lost = None if lossy is None else _of_losses(system, lossy, block)
        for _ in range(_BLOCKS):
            states += [column for column in block.T if column.any()]
            if lossy is not None and lost is not None:
                # what losses add to first order, to second order, and with inertia
                states += [*lost.T, *_of_losses(system, lossy, lost, volt=False).T]
                lost = factor.solve(mass @ lost)
            block = factor.solve(mass @ block)
    return np.column_stack(states)


def _of_losses(
    system: SolidSystem, lossy: SolidSystem, block: Floats, *, volt: bool = True
) -> Floats:
    """Return −K⁻¹ K'' x of states x, K'' the stiffness's loss.

    The last of them may be that of minus a volt, on the electrode of which losses act, too.
    """
    force = lossy.stiffness.inner.imag @ block
    if volt:
        force[:, -1] -= lossy.stiffness.border[:, 2].imag
    return np.asarray(-system.held_factor.solve(force))
