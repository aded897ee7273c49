"""Fields of the 3D piezoelectric solid, on bricks or on tetrahedra."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from tactgen.fem.piezo.modes import SolidState, driven_state, mode_states
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.symmetry import Motion
from tactgen.fem.piezo.system import Material, SolidSystem, materials
from tactgen.geometry.arrays import Ints, Numbers
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.fields.brick_fields import BrickSampler, Detail
from tactgen.validation.fields.result import MODE_SIZE, Array
from tactgen.validation.fields.tet_fields import TetSampler
from tactgen.validation.models.bimorph.two_meshes import TwoMeshModel

#: Fields, tip displacement (m) and charge (C) of one state.
Found = tuple[Mapping[str, Array], complex, complex]


class Sampler(Protocol):
    """Points of the whole device, and values and gradients at them from the nodes'."""

    @property
    def mesh(self) -> Mesh:
        """The points and cells."""

    def sample(self, values: Numbers) -> tuple[Numbers, Numbers]:
        """Return values (n, k) and gradients (n, k, 3) at the points."""


class SolidFields:
    """The states of a solid model with all their fields, at points of one mesh."""

    def __init__(self, model: TwoMeshModel, detail: Detail) -> None:
        self._model = model
        solved = model.meshes()[0]
        self._system: SolidSystem = model.systems()[0]
        self._lossy: SolidSystem | None = None
        self._of_motion: dict[Motion, SolidSystem] = {}
        self._without_ports: dict[Motion, list[SolidState]] = {}
        self._sampler: Sampler = (
            BrickSampler(solved, detail)
            if isinstance(solved, Bricks)
            else TetSampler(solved, self._system.nodes)
        )

    @property
    def mesh(self) -> Mesh:
        """The points and cells."""
        return self._sampler.mesh

    def modes(self, count: int, *, open_circuit: bool) -> list[tuple[str, Found]]:
        """Return class and fields of the lowest `count` modes, ascending."""
        model, system = self._model, self._system
        found: list[SolidState] = []
        for motion, number in model.motions(open_circuit=open_circuit).items():
            of = system if system.related is None else self._related(motion)
            if of.has_ports:
                found += mode_states(of, model.scene.ends, number, open_circuit=open_circuit)
            else:
                found += self._apart(of, number)
        found.sort(key=lambda state: state.frequency)
        out: list[tuple[str, Found]] = []
        for state in found[:count]:
            size = float(np.linalg.norm(state.values[:, :3], axis=1).max())
            sign = -1.0 if state.tip.real < 0.0 else 1.0
            scaled = state.scaled(sign * MODE_SIZE / size)
            out.append((state.kind, self._fields(scaled, lossy=False)))
        return out

    def _related(self, motion: Motion) -> SolidSystem:
        """Return the system of a class of motion, the same for every circuit."""
        assert self._system.related is not None
        if motion not in self._of_motion:
            own = motion == self._system.motion
            self._of_motion[motion] = self._system if own else self._system.related(motion)
        return self._of_motion[motion]

    def _apart(self, system: SolidSystem, number: int) -> list[SolidState]:
        """Return modes that no circuit changes, of a class in which the ports take no part."""
        if len(self._without_ports.get(system.motion, ())) < number:
            ends = self._model.scene.ends
            self._without_ports[system.motion] = mode_states(system, ends, number)
        return self._without_ports[system.motion][:number]

    def static(self, voltage: float) -> Found:
        """Return the lossless fields at rest under a voltage (V) across each layer."""
        ends = self._model.scene.ends.lossless
        state = driven_state(self._system, ends, 0.0, voltage)
        real = SolidState(0.0, state.values.real, state.tip.real, state.charge.real)
        return self._fields(real, lossy=False)

    def harmonic(self, frequency: float, voltage: float) -> Found:
        """Return the fields with losses at a frequency (Hz) and voltage (V) across each layer."""
        scene = self._model.scene
        if self._lossy is None:
            self._lossy = assemble(scene.device, self._model.meshes()[0], lossy=True)
        return self._fields(driven_state(self._lossy, scene.ends, frequency, voltage), lossy=True)

    def _fields(self, state: SolidState, *, lossy: bool) -> Found:
        scene, mesh = self._model.scene, self.mesh
        values, gradients = self._sampler.sample(state.values)
        slope = gradients[:, :3]
        strain = np.stack([slope[:, i, i] for i in range(3)], axis=1)
        pairs = ((1, 2), (0, 2), (0, 1))
        shear = np.stack([slope[:, i, j] + slope[:, j, i] for i, j in pairs], axis=1)
        strain = np.concatenate([strain, shear], axis=1)
        field = -gradients[:, 3]
        stress = np.zeros_like(strain)
        flux = np.zeros_like(field)
        ceramic = scene.device.piezo.ceramic()
        known = materials(scene.device, mesh.regions, ceramic, lossy=lossy)
        for region, at in points_of_regions(mesh).items():
            stress[at], flux[at] = _constitutive(known[region], strain[at], field[at])
            if known[region].piezo is None:
                field[at] = 0.0
        fields = {
            "displacement": values[:, :3],
            "potential": values[:, 3],
            "strain": strain,
            "stress": stress,
            "electric_field": field,
            "electric_displacement": flux,
        }
        return fields, state.tip, state.charge


def _constitutive(material: Material, strain: Numbers, field: Numbers) -> tuple[Numbers, Numbers]:
    """Return T = c S − eᵀ E and D = e S + ε E of one material, (n, 6) and (n, 3)."""
    stress = strain @ material.c.T
    if material.piezo is None:
        return stress, np.zeros_like(field)
    e, eps = material.piezo.e, material.piezo.eps
    return stress - field @ e, strain @ e.T + field @ eps.T


def points_of_regions(mesh: Mesh) -> dict[str, Ints]:
    """Return the points of every region."""
    return {
        region: np.unique(mesh.cells[mesh.region_of_cell == number])
        for number, region in enumerate(mesh.regions)
    }
