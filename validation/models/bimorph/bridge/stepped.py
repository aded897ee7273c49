"""Why any response or bending mode of the beam is not the solid's: the bridge's steps, read off.

Each model of the bridge answers as a model of the scene does, with its losses, under the scene's
load and on its support; a step's share in a quantity is read off as the quantity itself is.  What
a step does to the stiffness, the resonance and the minima is in its share at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import direct_multiport
from tactgen.geometry.arrays import Floats
from tactgen.tmm.ports.multiport import Multiport
from tactgen.tmm.ports.readout import ModalReadout, PortMatrix
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.models import gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import QuantityRow
from tactgen.validation.engine.model import Modes, Refined
from tactgen.validation.engine.reading import balanced_size, read
from tactgen.validation.engine.stages import Stages
from tactgen.validation.models.bimorph.bridge.assumptions import SolidStep, with_energy_shear
from tactgen.validation.models.bimorph.bridge.solid_values import SolidCase, solve_static
from tactgen.validation.models.bimorph.model import BimorphModel
from tactgen.validation.models.bimorph.rows import TmmModel
from tactgen.validation.scene.scene import Scene

#: Shares of quantities in proportion to each other differ by the rounding of their readings.
_PROPORTIONAL = 1e-9
_NOT_JUDGED = "not judged: a step of the bridge"
#: Stages that each step of a bridge has of its own.
_OF_A_STEP = ("ports", "static", "modes", "crosstalk")


@dataclass(frozen=True)
class Stepped:
    """One quantity over the n frequencies, or the first n bending modes in x, after every step.

    Attributes
    ----------
    row : QuantityRow
        The quantity.
    steps : tuple of str
        Names of the k steps as in the bridge, the first of them the transfer-matrix model.
    values : (k, n, ...) array
        Its magnitude after each of them, in its unit.
    """

    row: QuantityRow
    steps: tuple[str, ...]
    values: Floats

    @cached_property
    def size(self) -> Floats:
        """What differences are relative to (n, ...): the last value; of a matrix see `read`."""
        last = self.values[-1]
        return balanced_size(last) if isinstance(self.row.read, PortMatrix) else last

    @property
    def shares(self) -> Floats:
        """What each step but the first adds to (beam / solid − 1), (k − 1, n, ...)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(-np.diff(self.values, axis=0) / self.size)

    @property
    def together(self) -> Floats:
        """(beam / solid − 1), (n, ...)."""
        return np.asarray(self.shares.sum(axis=0))

    @property
    def is_untouched(self) -> bool:
        """Whether no step changes it, as what the bimorph has no part in."""
        return bool(np.allclose(self.values, self.values[-1], rtol=_PROPORTIONAL, atol=0.0))

    def goes_with(self, other: Stepped) -> bool:
        """Return whether another quantity has the same shares, as one in proportion to it."""
        return self.shares.shape == other.shares.shape and np.allclose(
            self.shares, other.shares, rtol=0.0, atol=_PROPORTIONAL, equal_nan=True
        )


class SteppedSolid(BimorphModel):
    """A solid of the bridge, which answers for a scene that is read as the scene's own models."""

    name = "solid"

    def __init__(self, scene: Scene, case: SolidCase, stages: Stages | None = None) -> None:
        super().__init__(scene, stages or _stages(scene, self.name))
        self.case = case

    def ports(self) -> Refined[Multiport]:
        """Return D(Ω) with losses, each frequency by its own factorisation."""

        def work() -> Refined[Multiport]:
            system = self.case.system(lossy=True)
            return Refined(direct_multiport(system, self.frequencies), (), _NOT_JUDGED)

        return self.run("ports", work)

    def static(self) -> Refined[Multiport]:
        """Return the lossless D(0)."""
        return Refined(solve_static(self.case), (), _NOT_JUDGED)

    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Return the lossless bending modes in x."""
        scene = self.scene
        found = natural_modes(
            self.case.lossless, scene.ends, scene.modes, open_circuit=open_circuit
        )
        frequencies = np.array([mode.frequency for mode in found])
        return Refined(Modes(frequencies, tuple(m.kind for m in found)), (), _NOT_JUDGED)


def bridged(scene: Scene) -> list[str]:
    """Return the scene's quantities whose steps can be told: responses and lists of modes."""
    return [
        name
        for name in scene.quantities
        if gives("tmm", name) and gives("solid", name) and _is_stepped(QUANTITIES[name])
    ]


def stepped(
    scene: Scene,
    quantities: Iterable[str],
    announce: Callable[[str], None],
    solids: Iterable[SolidStep],
) -> list[Stepped]:
    """Return quantities of :func:`bridged` after every step from the beam to the solid.

    Parameters
    ----------
    scene : Scene
        With a bimorph whose lower end is the base (no rod); responses are at its frequencies.
    solids : iterable of SolidStep
        Those on the way, of which a bridge may have made use before.
    """
    threshold = threshold_of(scene.threshold)
    rows = [QUANTITIES[name].at_threshold(threshold) for name in quantities]
    names: list[str] = []
    found: list[list[Floats]] = []
    for name, model in _models(scene, solids):
        announce(f"bridge of responses and modes: {name}")
        names.append(name)
        found.append([_magnitude(row, model) for row in rows])
    return [
        Stepped(row, tuple(names), _as_long(values))
        for row, values in zip(rows, zip(*found, strict=True), strict=True)
    ]


def _is_stepped(row: QuantityRow) -> bool:
    if isinstance(row.read, ModalReadout):
        return row.read.combine is None
    return row.needs[0] in ("harmonic", "crosstalk", "small_signal")


def _models(scene: Scene, solids: Iterable[SolidStep]) -> Iterator[tuple[str, BimorphModel]]:
    before: list[Stages] = []

    def stages(model: str) -> Stages:
        found = _stages(scene, model, len(before))
        for other in before:
            found.adopt(other)
        before.append(found)
        return found

    yield "TMM", TmmModel(scene, stages("tmm"))
    yield "shear factor", TmmModel(with_energy_shear(scene), stages("tmm"))
    for solid in solids:
        yield solid.name, SteppedSolid(scene, solid.case, stages("solid"))


def _stages(scene: Scene, model: str, step: int = 0) -> Stages:
    """Return the stages of a step: the rod and what pulls it are the same at all of them."""
    own = dict.fromkeys((f"{model}.{stage}" for stage in _OF_A_STEP), str(step))
    shared = dict.fromkeys((f"{model}.machine", f"{scene.map_model}.map"), "")
    return Stages(own | shared, keeps=False)


def _magnitude(row: QuantityRow, model: BimorphModel) -> Floats:
    """Return the magnitude (n, ...) of a quantity; of modes those that bend in x."""
    found = read(row, model)
    size: Floats = np.abs(found.value)
    return size if found.classes is None else size[np.array(found.classes) == "bending_x"]


def _as_long(values: Iterable[Floats]) -> Floats:
    """Return values (k, n, ...), as many as all have."""
    found = list(values)
    shortest = min(map(len, found))
    return np.array([one[:shortest] for one in found])
