"""The four models of the lateral actuator behind one interface.

Each gives, with the means to judge its numerical error: D(Ω) over the scene's
frequencies, the lossless D(0), and the lossless modes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from functools import partial
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from geometry.arrays import Floats
from geometry.beam_pieces import beam_pieces
from tmm import lumped, transfer_matrix
from tmm.modes import Fixture, NaturalFrequencies, natural_frequencies
from tmm.multiport import Multiport
from tmm.terminations import conservative_load
from validation.refinement import SAFETY, two_mesh_factor
from validation.scene import Scene
from validation.stages import Stages

if TYPE_CHECKING:
    from fem.piezo_solid import SolidSystem
    from fem.solid_response import SolidMode
    from geometry.mesh import Mesh

#: Ratio of a size at both ends of a segment from which on its order is not that of a smooth
#: taper: (ratio − 1)⁴ is then no longer small.
_STEEP = 1.5

T = TypeVar("T")


@dataclass(frozen=True)
class Refined(Generic[T]):
    """A result and what its numerical error is judged by.

    Attributes
    ----------
    fine : T
        The result.
    coarser : tuple of (T, float)
        Poorer results, each with the factor that turns its distance into an error bar;
        the bars add.  Empty for closed forms, whose error is rounding.
    method : str
        How the error bar comes about, for the reader.
    rounding : float
        Relative rounding error beyond that of the port equations.
    """

    fine: T
    coarser: tuple[tuple[T, float], ...]
    method: str
    rounding: float = 0.0


@dataclass(frozen=True)
class Modes:
    """Natural frequencies (Hz), ascending, with the class of each."""

    frequencies: Floats
    classes: tuple[str, ...]

    @property
    def first_bending(self) -> float:
        """Lowest bending mode in x (Hz); nan if there is none among the modes."""
        if "bending_x" not in self.classes:
            return float("nan")
        return float(self.frequencies[self.classes.index("bending_x")])


class Model(ABC):
    """One model of the scene's lateral actuator; results are computed at most once."""

    name: str

    def __init__(self, scene: Scene, stages: Stages) -> None:
        self.scene, self.stages = scene, stages
        self.frequencies = np.asarray(scene.frequency, dtype=float)

    @abstractmethod
    def ports(self) -> Refined[Multiport]:
        """Return D(Ω) with losses over the scene's frequencies, parallel wiring."""

    @abstractmethod
    def static(self) -> Refined[Multiport]:
        """Return the lossless D(0), parallel wiring."""

    @abstractmethod
    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Return the lossless modes on the scene's support."""

    def _base(self) -> tuple[float, float, float]:
        support = self.scene.support
        return (
            support.lateral_stiffness,
            support.rotational_stiffness,
            support.rotational_inertia,
        )

    @property
    def _clamped(self) -> bool:
        return self.scene.support.kind != "spring"

    def _fixture(self) -> Fixture:
        lateral, rotational, inertia = (0.0, 0.0, 0.0) if self._clamped else self._base()
        stiffness, mass = conservative_load(self.scene.load)
        return Fixture(self._clamped, lateral, rotational, inertia, stiffness, mass)


class RowModel(Model):
    """Closed forms for a row of beams, in which tapers are divided into segments."""

    _METHOD: str
    #: Order in which a taper's error falls with its segments' length.
    _ORDER: int

    def _judged(self, read: Callable[[int], T], method: str = "") -> Refined[T]:
        """Return what `read` gives for a number of segments, judged by half as many."""
        method = method or self._METHOD
        fine = read(transfer_matrix.SEGMENTS)
        if not transfer_matrix.is_tapered(self.scene.device, self.scene.support):
            return Refined(fine, (), method)
        coarse = read(transfer_matrix.SEGMENTS // 2)
        order = 1 if self._steep else self._ORDER
        taper = f"half as many segments of the taper, order {order}, safety factor {SAFETY}"
        factor = SAFETY / (2.0**order - 1.0)
        return Refined(fine, ((coarse, factor),), f"{method}; {taper}")

    @property
    def _steep(self) -> bool:
        """Whether some coarse segment ends much thinner or narrower than it begins.

        Where a taper runs out, what goes with 1/thickness is resolved by ever shorter parts
        of the last segment, and the error falls only with its length.
        """
        pieces = beam_pieces(self.scene.device, self.scene.support)
        sizes = [np.array([astuple(end) for end in p.ends]) for p in pieces if p.ends]
        share = 1.0 / (transfer_matrix.SEGMENTS // 2)
        ratios = (both.max(axis=0) / both.min(axis=0) for both in sizes)
        return any((1.0 + share * (ratio - 1.0) > _STEEP).any() for ratio in ratios)


class LumpedModel(RowModel):
    """Closed-form statics with a consistent mass matrix."""

    name = "lumped"
    _METHOD = "rounding of closed forms; the model's own error is not included"
    _ORDER = 2  # the mass of a segment's cubic shapes; the statics are of order 4

    def ports(self) -> Refined[Multiport]:
        """Return D(Ω) with losses over the scene's frequencies."""

        def work() -> Refined[Multiport]:
            s = self.scene
            return self._judged(
                lambda n: lumped.multiport(
                    s.device, s.support, s.beam, self.frequencies, segments=n
                )
            )

        return self.stages.run("lumped.ports", work)

    def static(self) -> Refined[Multiport]:
        """Return the lossless D(0)."""

        def work() -> Refined[Multiport]:
            s = self.scene
            return self._judged(
                lambda n: lumped.multiport(
                    s.device, s.support, s.beam, np.zeros(1), lossy=False, segments=n
                )
            )

        return self.stages.run("lumped.static", work)

    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Return the lossless modes."""
        short, opened = self.stages.run("lumped.modes", self._both_modes)
        return opened if open_circuit else short

    def circuit(self, *, open_circuit: bool = False) -> lumped.EquivalentCircuit:
        """Return the first mode as a one-mode circuit (parallel wiring)."""
        return self._circuit(transfer_matrix.SEGMENTS, open_circuit=open_circuit)

    def _circuit(self, segments: int, *, open_circuit: bool) -> lumped.EquivalentCircuit:
        s = self.scene
        row = transfer_matrix.sections(s.device, s.support, s.beam, lossy=False, segments=segments)
        return lumped.equivalent_circuit(row, self._fixture(), open_circuit=open_circuit)

    def _both_modes(self) -> tuple[Refined[Modes], Refined[Modes]]:
        def mode(segments: int, *, open_circuit: bool) -> Modes:
            circuit = self._circuit(segments, open_circuit=open_circuit)
            return Modes(np.array([circuit.short_circuit_frequency]), ("bending_x",))

        short, opened = (
            self._judged(partial(mode, open_circuit=circuit)) for circuit in (False, True)
        )
        return short, opened


class TmmModel(RowModel):
    """Exact Timoshenko beams in a row."""

    name = "tmm"
    _METHOD = "rounding: machine epsilon times the condition number of the port equations"
    _ORDER = 4

    def ports(self) -> Refined[Multiport]:
        """Return D(Ω) with losses over the scene's frequencies."""

        def work() -> Refined[Multiport]:
            s = self.scene
            return self._judged(
                lambda n: transfer_matrix.multiport(
                    s.device, s.support, s.beam, self.frequencies, segments=n
                )
            )

        return self.stages.run("tmm.ports", work)

    def static(self) -> Refined[Multiport]:
        """Return the lossless D(0)."""

        def work() -> Refined[Multiport]:
            s = self.scene
            return self._judged(
                lambda n: transfer_matrix.multiport(
                    s.device, s.support, s.beam, np.zeros(1), lossy=False, segments=n
                )
            )

        return self.stages.run("tmm.static", work)

    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Return the lossless modes."""
        short, opened = self.stages.run("tmm.modes", self._both_modes)
        return opened if open_circuit else short

    def _both_modes(self) -> tuple[Refined[Modes], ...]:
        s = self.scene

        def found(segments: int, *, open_circuit: bool) -> NaturalFrequencies:
            row = transfer_matrix.sections(
                s.device, s.support, s.beam, lossy=False, segments=segments
            )
            return natural_frequencies(row, self._fixture(), s.modes, open_circuit=open_circuit)

        def modes(of: NaturalFrequencies) -> Modes:
            return Modes(of.frequencies, ("bending_x",) * of.frequencies.size)

        method = "counted (Wittrick-Williams), rounding from a second evaluation in other units"
        both = []
        for circuit in (False, True):
            judged = self._judged(partial(found, open_circuit=circuit), method)
            coarser = tuple((modes(of), factor) for of, factor in judged.coarser)
            rounding = float(judged.fine.rounding.max())
            both.append(Refined(modes(judged.fine), coarser, judged.method, rounding))
        return tuple(both)


class BeamModel(Model):
    """Timoshenko beam elements of order five."""

    name = "beam"
    _METHOD = (
        "difference from half as many elements (it bounds that mesh's error), and rounding of "
        "the elimination of inner unknowns"
    )
    #: Rounding of the elimination: machine epsilon times the condition number, about 1e5,
    #: of the scaled element matrices.
    _ROUNDING = 2e-11

    def ports(self) -> Refined[Multiport]:
        """Return D(Ω) with losses over the scene's frequencies."""
        return self.stages.run("beam.ports", lambda: self._refined(self.frequencies, lossy=True))

    def static(self) -> Refined[Multiport]:
        """Return the lossless D(0)."""
        return self.stages.run("beam.static", lambda: self._refined(np.zeros(1), lossy=False))

    def _refined(self, frequencies: Floats, *, lossy: bool) -> Refined[Multiport]:
        from fem import beam

        s = self.scene
        n = beam.elements_for(s.device, float(frequencies.max()))
        fine, coarse = (
            beam.multiport(s.device, s.support, s.beam, frequencies, elements=e, lossy=lossy)
            for e in (n, n // 2)
        )
        return Refined(fine, ((coarse, 1.0),), self._METHOD, self._ROUNDING)

    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Return the lossless modes."""
        short, opened = self.stages.run("beam.modes", self._both_modes)
        return opened if open_circuit else short

    def _both_modes(self) -> tuple[Refined[Modes], ...]:
        from fem import beam

        s = self.scene
        n = 12 + 2 * s.modes
        levels = [
            beam.assemble(s.device, s.support, s.beam, elements=e, lossy=False) for e in (n, n // 2)
        ]
        out = []
        for circuit in (False, True):
            fine, coarse = (
                beam.bending_frequencies(
                    matrices,
                    clamped=self._clamped,
                    base=self._base(),
                    tip=conservative_load(s.load),
                    count=s.modes,
                    open_circuit=circuit,
                )
                for matrices in levels
            )
            classes = ("bending_x",) * fine.size
            out.append(
                Refined(
                    Modes(fine, classes),
                    ((Modes(coarse, classes), 1.0),),
                    self._METHOD,
                    self._ROUNDING,
                )
            )
        return tuple(out)


class SolidModel(Model):
    """The piezoelectric solid on two meshes, so that its error shows."""

    name = "solid"

    def meshes(self) -> tuple[Mesh, Mesh]:
        """Return the finer and the coarser mesh."""
        from validation.solid_meshes import mesh_pair

        return self.stages.run("solid.mesh", lambda: mesh_pair(self.scene))

    def systems(self) -> tuple[SolidSystem, SolidSystem]:
        """Return the lossless systems on the finer and the coarser mesh."""

        def work() -> tuple[SolidSystem, SolidSystem]:
            from fem.piezo_solid import assemble

            fine, coarse = (assemble(self.scene.device, m, lossy=False) for m in self.meshes())
            return fine, coarse

        return self.stages.run("solid.assembly", work)

    def static(self) -> Refined[Multiport]:
        """Return the lossless D(0)."""

        def work() -> Refined[Multiport]:
            from fem.solid_response import static_multiport

            systems = self.systems()
            fine, coarse = (static_multiport(system) for system in systems)
            return self._two_meshes(fine, coarse, (systems[0].size, systems[1].size))

        return self.stages.run("solid.static", work)

    def ports(self) -> Refined[Multiport]:
        """Return D(Ω) with losses over the scene's frequencies."""
        return self.stages.run("solid.ports", self._reduced)

    def _reduced(self) -> Refined[Multiport]:
        from fem.piezo_solid import assemble
        from fem.solid_response import reduce_to_ports

        ports, sizes = [], []
        extra: tuple[tuple[Multiport, float], ...] = ()
        for mesh in self.meshes():
            system = assemble(self.scene.device, mesh, lossy=True)
            reduced = reduce_to_ports(
                system, self.frequencies, tolerance=1e-3 * self.scene.accuracy
            )
            ports.append(reduced.multiport(self.frequencies))
            sizes.append(system.size)
            if not extra:
                extra = ((reduced.coarser_multiport(self.frequencies), SAFETY),)
        two = self._two_meshes(ports[0], ports[1], (sizes[0], sizes[1]))
        method = f"{two.method}; plus the last Krylov block of the port reduction"
        return Refined(two.fine, two.coarser + extra, method)

    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Return the lossless modes."""
        systems = self.systems()
        fine, coarse = (
            Modes(np.array([m.frequency for m in found]), tuple(m.kind for m in found))
            for found in self.shapes(open_circuit=open_circuit)
        )
        return self._two_meshes(fine, _matched(fine, coarse), (systems[0].size, systems[1].size))

    def shapes(self, *, open_circuit: bool = False) -> tuple[Sequence[SolidMode], ...]:
        """Return the modes with their shapes, on the finer and the coarser mesh."""

        def work() -> tuple[Sequence[SolidMode], ...]:
            from fem.solid_response import Attachment, natural_modes

            stiffness, mass = conservative_load(self.scene.load)
            attachment = Attachment(None if self._clamped else self._base(), stiffness, mass)
            found = []
            for system in self.systems():
                count = self.scene.modes
                modes = natural_modes(system, attachment, count, open_circuit=open_circuit)
                # a narrow bimorph bends in y first; the coupling factor needs bending in x
                while all(m.kind != "bending_x" for m in modes) and count < _MOST_MODES:
                    count = 2 * count + 2
                    modes = natural_modes(system, attachment, count, open_circuit=open_circuit)
                found.append(modes)
            return tuple(found)

        return self.stages.run("solid.modes_open" if open_circuit else "solid.modes_short", work)

    @staticmethod
    def _two_meshes(fine: T, coarse: T, sizes: tuple[int, int]) -> Refined[T]:
        ratio = (sizes[0] / sizes[1]) ** (1.0 / 3.0)
        method = (
            f"two meshes ({sizes[0]} and {sizes[1]} unknowns), order 1.5 assumed, "
            f"safety factor {SAFETY}"
        )
        return Refined(fine, ((coarse, two_mesh_factor(ratio)),), method)


#: Where the search for a bending mode in x ends.
_MOST_MODES = 40


def _matched(fine: Modes, coarse: Modes) -> Modes:
    """Pair coarse modes with fine ones by class and order, so that like meets like."""
    left = list(zip(coarse.classes, coarse.frequencies, strict=True))
    paired = []
    for kind, frequency in zip(fine.classes, fine.frequencies, strict=True):
        if not left:
            paired.append(np.nan)
            continue
        same = [entry for entry in left if entry[0] == kind] or left
        nearest = min(same, key=lambda entry: abs(entry[1] - frequency))
        left.remove(nearest)
        paired.append(nearest[1])
    return Modes(np.array(paired), fine.classes)


_CLASSES: dict[str, type[Model]] = {
    c.name: c for c in (LumpedModel, TmmModel, BeamModel, SolidModel)
}


def make_model(name: str, scene: Scene, stages: Stages) -> Model:
    """Return the named model of a scene."""
    return _CLASSES[name](scene, stages)
