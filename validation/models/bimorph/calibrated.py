"""The transfer-matrix model with its known differences from the solid taken off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.segments import CentreLine
from tactgen.tmm.beam import calibrated_row, centre_line, transfer_matrix
from tactgen.tmm.beam.calibrated_section import (
    SectionFactors,
    check_known,
    properties,
    section_factors,
)
from tactgen.tmm.beam.modes import natural_frequencies
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.ports.excitation_and_circuit import ELECTRICAL, PortState
from tactgen.tmm.ports.multiport import Multiport, Response
from tactgen.validation.models.bimorph.model import TmmModel
from tactgen.validation.models.model import Modes, Refined, Stages
from tactgen.validation.scene.scene import Scene

#: Where its error comes from, for the reader.
METHOD = "95 % of fresh random bimorphs, by calibration on solids"


class CalibratedModel(TmmModel):
    """Exact beams in a row with sections calibrated on solids.

    Parameters
    ----------
    against_solid : bool
        Let errors say how far the solid may be, in place of the numerical ones.
    """

    name = "calibrated"

    def __init__(self, scene: Scene, stages: Stages, *, against_solid: bool = False) -> None:
        super().__init__(scene, stages)
        self._against_solid = against_solid
        self._known: dict[bool, Refined[Modes]] = {}
        self._rows: dict[tuple[bool, int], list[Element]] = {}

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse a bimorph shorter than it is thick, and one on its rod."""
        super().check(scene)
        check_known(scene.device, scene.support)

    @cached_property
    def factors(self) -> SectionFactors:
        """Calibrated section relative to that of beam theory."""
        return section_factors(self.scene.device, self.scene.beam)

    @property
    def _origin(self) -> str:
        """Where the calibration's errors come from, and whether it is beyond its range."""
        beyond = (*self.factors.beyond, *properties(self.scene.device))
        return f"{METHOD}; beyond the range of the fit: {', '.join(beyond)}" if beyond else METHOD

    def closed_form(self, ends: Ends) -> Refined[Response] | None:
        """None: its row is of two parts at least."""
        return None

    def _row(self, *, lossy: bool, segments: int = transfer_matrix.SEGMENTS) -> list[Element]:
        s, key = self.scene, (lossy, segments)
        if key not in self._rows:
            self._rows[key] = calibrated_row.sections(
                s.device, s.support, s.beam, self.factors, lossy=lossy, segments=segments
            )
        return self._rows[key]

    def _multiport(self, frequencies: Floats, *, lossy: bool) -> Refined[Multiport]:
        def solved(segments: int, at: Floats = frequencies) -> Multiport:
            return self._of(self._row(lossy=lossy, segments=segments), at)

        found = self._judged(solved)
        if not self._against_solid:
            return found
        others = _disturbed(found.fine, self._coupled, self.factors)
        if lossy:
            others.append(self._damped(found.fine))
        if frequencies.any():
            others.append(self._faster(solved, frequencies))
        return Refined(found.fine, tuple((other, 1.0) for other in others), self._origin)

    @cached_property
    def _coupled(self) -> float:
        """Free less blocked capacitance (F) at rest, the base held."""
        port = self._of(self._row(lossy=False), np.zeros(1))
        volt = port.index(ELECTRICAL)
        tip = [port.index(name) for name in ("w_tip", "psi_tip")]
        stiffness = port.stiffness[0].real
        force = stiffness[tip, volt]
        return float(force @ np.linalg.solve(stiffness[np.ix_(tip, tip)], force))

    def _ports_between(self, frequencies: Floats, *, judged: bool) -> Refined[Multiport]:
        if judged:
            return super()._ports_between(frequencies, judged=judged)
        row = self._row(lossy=True)
        return Refined(self._of(row, frequencies), (), METHOD)

    def _of(self, row: list[Element], frequencies: Floats) -> Multiport:
        below = self.scene.measurement.below_tip
        return calibrated_row.multiport(row, self.factors, frequencies, below)

    def _damped(self, port: Multiport) -> Multiport:
        """D(Ω) of as much more damping of the motion as its error allows."""
        error = calibrated_row.loss_error(self._row(lossy=True), self.factors)
        moving = np.arange(len(port.ports)) != port.index(ELECTRICAL)
        more = 1j * error * port.stiffness.imag * (moving[:, None] & moving)
        return replace(port, stiffness=port.stiffness + more)

    def _faster(self, solved: Callable[..., Multiport], frequencies: Floats) -> Multiport:
        """D(Ω) of natural frequencies that are off by their error; nan where that is not known."""
        error = self.factors.frequency_error(frequencies)
        moved = frequencies * (1.0 + np.nan_to_num(error))
        found = solved(transfer_matrix.SEGMENTS, moved)
        stiffness = found.stiffness.copy()
        stiffness[np.isnan(error)] = np.nan
        return replace(found, frequencies=frequencies, stiffness=stiffness)

    def _modes(self, *, open_circuit: bool) -> Refined[Modes]:
        if open_circuit not in self._known:
            self._known[open_circuit] = self._solved_modes(open_circuit=open_circuit)
        return self._known[open_circuit]

    def _solved_modes(self, *, open_circuit: bool) -> Refined[Modes]:
        s, of_row = self.scene, self.factors.of_beam

        def found(segments: int) -> tuple[Modes, float]:
            row = self._row(lossy=False, segments=segments)
            lowest = natural_frequencies(
                row, s.ends, s.modes, open_circuit=open_circuit, of_row=of_row
            )
            classes = ("bending_x",) * lowest.frequencies.size
            return Modes(lowest.frequencies, classes), float(lowest.rounding.max())

        judged = self._judged(found)
        (fine, rounding), classes = judged.fine, judged.fine[0].classes
        coarser = tuple((modes, factor) for (modes, _), factor in judged.coarser)
        if not self._against_solid:
            return Refined(fine, coarser, judged.method, rounding)
        error = self.factors.mode_error(fine.frequencies.size)
        moved = Modes(fine.frequencies * (1.0 + error), classes)
        farther = self._opened_farther(fine.frequencies) if open_circuit else fine.frequencies
        beside = ((Modes(farther, classes), 1.0),)
        return Refined(fine, ((moved, 1.0),), self._origin, rounding, beside=beside)

    def _opened_farther(self, opened: Floats) -> Floats:
        """Open-circuit frequencies (n,) of a coupling factor that is larger by its error."""
        short = self._modes(open_circuit=False).fine.frequencies
        squared = (1.0 - (short / opened) ** 2) * (1.0 + self.factors.errors[6]) ** 2
        return np.asarray(short / np.sqrt(1.0 - np.minimum(squared, 1.0 - 1e-9)))

    def mode_lines(self, *, open_circuit: bool) -> list[CentreLine]:
        """Centre lines of the modes, of beams that have just their frequencies."""
        s, found = self.scene, []
        row = self._row(lossy=False)
        for k, frequency in enumerate(self.modes(open_circuit=open_circuit).fine.frequencies):
            scaled = self._as_beam(row, frequency)
            found.append(
                centre_line.mode_lines(scaled, s.ends, k + 1, open_circuit=open_circuit)[k]
            )
        return found

    def driven_line(self, state: PortState) -> CentreLine:
        """Centre line between ports that move so."""
        row = self._as_beam(self._row(lossy=state.frequency > 0.0), state.frequency)
        return centre_line.line_between(row, state)

    def _as_beam(self, row: list[Element], frequency: float) -> list[Element]:
        """Row whose inertia at a frequency (Hz) is that of the calibrated one."""
        at = np.array([frequency])
        inertia = float(self.factors.of_beam(at)[0] / frequency) ** 2 if frequency else 1.0
        return [calibrated_row.with_inertia(element, inertia) for element in row]


def _disturbed(port: Multiport, coupled: float, factors: SectionFactors) -> list[Multiport]:
    """D(Ω) as far off as the calibration may be, in one property each.

    All that moves stiffer, its motion per voltage unchanged; more motion per voltage; more
    capacitance.  The calibration's capacitance is the free one, which the first two leave alone:
    of it a part `coupled` (F) comes from the motion.
    """
    errors, volt = factors.errors, port.index(ELECTRICAL)
    moving = np.arange(len(port.ports)) != volt
    between = moving[:, None] != moving
    others = []
    for share, error, less in (
        (moving[:, None] | moving, errors[0], errors[0]),
        (between, errors[1], 2.0 * errors[1]),
        (~(moving[:, None] | moving), errors[2], -errors[2]),
    ):
        # an error that is not known says nothing of the other entries
        stiffness = port.stiffness * (1.0 + np.where(share, error, 0.0))
        stiffness[:, volt, volt] -= less * coupled
        others.append(replace(port, stiffness=stiffness))
    return others
