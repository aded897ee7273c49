"""Common base of the bimorph's models: the same ports, statics and modes; and the tip's load."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from copy import copy
from dataclasses import astuple, dataclass, replace
from typing import Any, ClassVar, Self, TypeVar

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.segments import CentreLine, beam_pieces
from tactgen.geometry.device.checks import check_read_at_tip
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import centre_line, lumped, transfer_matrix
from tactgen.tmm.beam.modes import NaturalFrequencies, natural_frequencies
from tactgen.tmm.beam.mounted_beam import uniform_response
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.ports.excitation_and_circuit import PortState
from tactgen.tmm.ports.measured_loads import OF_THE_TABLE, MeasuredLaw
from tactgen.tmm.ports.multiport import Multiport, Response
from tactgen.tmm.ports.supports_and_loads import tip_stiffness
from tactgen.validation.catalogue.quantities import Need
from tactgen.validation.models.model import SAFETY, Estimate, Model, Modes, Refined, Stages
from tactgen.validation.scene.scene import Scene

#: Rounding of a formula.
_ROUNDING = 1e-14


@dataclass(frozen=True)
class MeasuredLoad:
    """The load of a scene over frequencies (Hz)."""

    ends: Ends
    frequencies: Floats

    @property
    def method(self) -> str:
        """Description of the error estimate."""
        return OF_THE_TABLE if isinstance(self.ends.tip, MeasuredLaw) else "rounding of a formula"

    @property
    def impedance(self) -> Estimate:
        """Force per velocity (n,) in N s/m; nan at 0 Hz, where nothing moves steadily."""
        omega = 2.0 * np.pi * np.where(self.frequencies > 0.0, self.frequencies, np.nan)
        # a real division: of complex numbers by nan numpy warns
        value = tip_stiffness(self.ends.tip, self.frequencies) * (-1j * (1.0 / omega))
        bar = _ROUNDING * np.abs(value)
        if isinstance(self.ends.tip, MeasuredLaw):
            bar = bar + self.ends.tip.error(self.frequencies) / omega
        return Estimate(value, bar)


class BimorphModel(Model):
    """One model of the scene's lateral actuator."""

    #: D(Ω) at frequencies between the scene's, of :meth:`at`
    _between: Refined[Multiport] | None = None

    def __init__(self, scene: Scene, stages: Stages) -> None:
        super().__init__(scene, stages)
        self.frequencies = np.asarray(scene.frequency, dtype=float)
        self._at_others: dict[tuple[bytes, bool], Self] = {}

    def answer(self, need: Need) -> Any:
        """Answer that quantities of this analysis are read from."""
        if need in ("small_signal", "machine_poles"):
            return self._machine(need)
        if need == "crosstalk":
            return self._crosstalk()
        if need == "load":  # of whichever model: the load is the same
            return MeasuredLoad(self.scene.ends, self.frequencies)
        if need == "static":
            return self.static()
        if need == "harmonic":
            return self._between or self.ports()
        return self.modes(open_circuit=need == "modes_open")

    def _machine(self, need: Need) -> Any:
        """Machine's answer, with this bimorph on its rod."""
        from tactgen.validation.models.small_signal import SmallSignal, machine_of, measured_poles

        linear = self.run("machine", lambda: machine_of(self.scene, self.scene.pull))
        if need == "machine_poles":
            return measured_poles(self.scene, linear)
        return SmallSignal(self.scene, self.ports(), linear)

    def _crosstalk(self) -> Any:
        """Crosstalk of one unit at the others, all on this bimorph."""
        from tactgen.validation.models.display import crosstalk

        return self.run("crosstalk", lambda: crosstalk(self.scene, self.ports()))

    def at(self, frequencies: Floats, *, judged: bool = True) -> Self:
        """Copy with harmonic answers at other frequencies (n,) in the scene's band (Hz).

        Unless `judged` without the basis of their error.  Several responses are followed to the
        same frequencies, which are solved once.
        """
        key = frequencies.tobytes(), judged
        if key in self._at_others:
            return self._at_others[key]
        other = copy(self)
        other.scene = self.scene.model_copy(update={"frequency": tuple(frequencies.tolist())})
        other.frequencies = frequencies
        found = self._ports_between(frequencies, judged=judged)
        other._between = found if judged else replace(found, coarser=())
        self._at_others[key] = other
        return other

    @property
    def versions(self) -> list[tuple[Self, float]]:
        """Copies with each of the harmonic answers that judge this one's, and its factor."""
        of = self.answer("harmonic")
        found = [(copy(self), factor) for _, factor in of.coarser]
        for (version, _), (port, _) in zip(found, of.coarser, strict=True):
            # whose own rounding is of no interest, and may not be known where an error is not
            version._between = replace(of, fine=port, coarser=(), rounds_apart=True)
        return found

    def _ports_between(self, frequencies: Floats, *, judged: bool) -> Refined[Multiport]:
        """D(Ω) between the scene's frequencies, by splines over Ω², in which it is smooth."""
        known = self.ports()
        order = np.unique(known.fine.frequencies, return_index=True)[1]
        found = _spline(known.fine, order, frequencies)
        if not judged:
            return Refined(found, (), known.method)
        coarser = [(_spline(port, order, frequencies), by) for port, by in known.coarser]
        half = np.union1d(np.arange(0, order.size, 2), order.size - 1)
        coarser.append((_spline(known.fine, order[half], frequencies), SAFETY))
        method = f"{known.method}; interpolated, judged by every other frequency"
        return replace(known, fine=found, coarser=tuple(coarser), method=method)

    @abstractmethod
    def ports(self) -> Refined[Multiport]:
        """D(Ω) with losses over the scene's frequencies, parallel wiring."""

    @abstractmethod
    def static(self) -> Refined[Multiport]:
        """Lossless D(0), parallel wiring."""

    @abstractmethod
    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Lossless modes on the scene's support."""


def _spline(port: Multiport, order: Ints, frequencies: Floats) -> Multiport:
    """Multiport between some of its frequencies, named by their places in ascending order."""
    from scipy.interpolate import CubicSpline  # slow to import

    entries = CubicSpline(port.frequencies[order] ** 2, port.stiffness[order], axis=0)
    return Multiport(frequencies, np.asarray(entries(frequencies**2)), port.ports)


class BeamTheoryModel(BimorphModel):
    """A model of a row of beams: stages ports, static and modes, all of them fast."""

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse a bimorph shorter than it is thick, about which no beam theory says anything."""
        bimorph, mm = scene.bimorph, 1e3
        if bimorph.length < bimorph.thickness:
            raise InputError(
                f"bimorph.length = {bimorph.length * mm:g} mm is less than the layers' thickness "
                f"of {bimorph.thickness * mm:g} mm: that is not a beam, and the models lumped, tmm "
                "and beam have no answer; make it longer or ask for --set models=solid"
            )

    def answer(self, need: Need) -> Any:
        """Answer that quantities of this analysis are read from, unit by unit."""
        return self._spread() if need == "spread" else super().answer(need)

    def _spread(self) -> Any:
        from tactgen.validation.models.display import first_frequency, spread

        def first(scene: Scene) -> Estimate:
            return first_frequency(type(self)(scene, self.stages)._modes(open_circuit=False))

        alone = self.scene.model_copy(update={"modes": 1})
        return self.run("spread", lambda: spread(alone, first))

    def ports(self) -> Refined[Multiport]:
        """D(Ω) with losses over the scene's frequencies."""
        return self.run("ports", lambda: self._multiport(self.frequencies, lossy=True))

    def static(self) -> Refined[Multiport]:
        """Lossless D(0)."""
        return self.run("static", lambda: self._multiport(np.zeros(1), lossy=False))

    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Lossless modes."""
        both = self.run("modes", lambda: tuple(self._modes(open_circuit=q) for q in (False, True)))
        return both[open_circuit]

    @abstractmethod
    def mode_lines(self, *, open_circuit: bool) -> list[CentreLine]:
        """Centre line of every mode of :meth:`modes`, of unit tip displacement."""

    @abstractmethod
    def driven_line(self, state: PortState) -> CentreLine:
        """Centre line, relative to the ground, between ports that move so; at rest lossless."""

    @abstractmethod
    def _multiport(self, frequencies: Floats, *, lossy: bool) -> Refined[Multiport]:
        """D(Ω), parallel wiring."""

    @abstractmethod
    def _modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Lossless modes in one circuit."""


#: Ratio of a size at both ends of a segment from which on its order is not that of a smooth
#: taper: (ratio − 1)⁴ is then no longer small.
_STEEP = 1.5

T = TypeVar("T")


class RowModel(BeamTheoryModel):
    """Closed forms for a row of beams, in which tapers are divided into segments."""

    _METHOD: str
    #: Order in which a taper's error falls with its segments' length.
    _ORDER: int
    #: Gives the model over its ports, of the row divided into segments.
    _solved: ClassVar[Callable[..., Multiport]]

    def _multiport(self, frequencies: Floats, *, lossy: bool) -> Refined[Multiport]:
        s = self.scene
        return self._judged(
            lambda n: self._solved(
                s.device, s.support, s.beam, frequencies, lossy=lossy, segments=n
            )
        )

    def _ports_between(self, frequencies: Floats, *, judged: bool) -> Refined[Multiport]:
        return self._multiport(frequencies, lossy=True)

    def _row(self, *, lossy: bool, segments: int = transfer_matrix.SEGMENTS) -> list[Element]:
        s = self.scene
        return transfer_matrix.sections(s.device, s.support, s.beam, lossy=lossy, segments=segments)

    def _judged(self, read: Callable[[int], T], method: str = "") -> Refined[T]:
        """Result of `read` with an error from half as many segments."""
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

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse a place of measurement below the tip, too: a lumped model has no shape."""
        super().check(scene)
        check_read_at_tip(scene.device)

    _METHOD = "rounding of closed forms; the model's own error is not included"
    _ORDER = 2  # the mass of a segment's cubic shapes; the statics are of order 4
    _solved = staticmethod(lumped.multiport)

    def mode_lines(self, *, open_circuit: bool) -> list[CentreLine]:
        """Centre line of the first mode."""
        row, ends = self._row(lossy=False), self.scene.ends
        *motion, charge = lumped.first_mode(row, ends, open_circuit=open_circuit)
        frequency = float(self.modes(open_circuit=open_circuit).fine.frequencies[0])
        state = PortState(frequency, np.array(motion), charge)
        return [centre_line.line_between(row, state, inertia=False)]

    def driven_line(self, state: PortState) -> CentreLine:
        """Static line between the ends as the ports move them."""
        row = self._row(lossy=state.frequency > 0.0)
        return centre_line.line_between(row, state, inertia=False)

    def circuit(
        self, segments: int = transfer_matrix.SEGMENTS, *, open_circuit: bool = False
    ) -> lumped.EquivalentCircuit:
        """First mode as a one-mode circuit (parallel wiring)."""
        row = self._row(lossy=False, segments=segments)
        return lumped.equivalent_circuit(row, self.scene.ends, open_circuit=open_circuit)

    def _modes(self, *, open_circuit: bool) -> Refined[Modes]:
        def mode(segments: int) -> Modes:
            circuit = self.circuit(segments, open_circuit=open_circuit)
            return Modes(np.array([circuit.short_circuit_frequency]), ("bending_x",))

        return self._judged(mode)


class TmmModel(RowModel):
    """Exact Timoshenko beams in a row."""

    name = "tmm"
    _METHOD = "rounding: machine epsilon times the condition number of the port equations"
    _ORDER = 4
    _solved = staticmethod(transfer_matrix.multiport)

    def mode_lines(self, *, open_circuit: bool) -> list[CentreLine]:
        """Centre lines of the modes."""
        s = self.scene
        return centre_line.mode_lines(
            self._row(lossy=False), s.ends, s.modes, open_circuit=open_circuit
        )

    def driven_line(self, state: PortState) -> CentreLine:
        """Centre line between ports that move so."""
        return centre_line.line_between(self._row(lossy=state.frequency > 0.0), state)

    def closed_form(self, ends: Ends) -> Refined[Response] | None:
        """Response of one uniform beam, right also at the poles of D(Ω)."""
        s = self.scene
        if s.measurement.below_tip:
            return None
        row = transfer_matrix.sections(s.device, s.support, s.beam, lossy=True)
        series = s.bimorph.wiring == "series"
        found = uniform_response(row, ends, self.frequencies, series=series)
        if found is None:
            return None
        method = "bound from the condition number of the closed form"
        return Refined(found.response, (), method, found.error)

    def _modes(self, *, open_circuit: bool) -> Refined[Modes]:
        s = self.scene

        def found(segments: int) -> NaturalFrequencies:
            row = self._row(lossy=False, segments=segments)
            return natural_frequencies(row, s.ends, s.modes, open_circuit=open_circuit)

        def modes(of: NaturalFrequencies) -> Modes:
            return Modes(of.frequencies, ("bending_x",) * of.frequencies.size)

        method = "counted (Wittrick-Williams), rounding from a second evaluation in other units"
        judged = self._judged(found, method)
        coarser = tuple((modes(of), factor) for of, factor in judged.coarser)
        rounding = float(judged.fine.rounding.max())
        return Refined(modes(judged.fine), coarser, judged.method, rounding)
