"""Classes of the models, each loaded when it is asked for; and the co-energy map of a scene.

A model's libraries take up to seconds to load: an answer by transfer matrices loads no scikit-fem.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.models.model import Model, Stages
from tactgen.validation.scene.inputs import stage_key
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.tmm.reluctance.coenergy_map import CoenergyMap


def _lumped() -> type[Model]:
    from tactgen.validation.models.bimorph.model import LumpedModel

    return LumpedModel


def _tmm() -> type[Model]:
    from tactgen.validation.models.bimorph.model import TmmModel

    return TmmModel


def _beam() -> type[Model]:
    from tactgen.validation.models.bimorph.beam import BeamModel

    return BeamModel


def _solid() -> type[Model]:
    from tactgen.validation.models.bimorph.solid import SolidModel

    return SolidModel


def _cad() -> type[Model]:
    from tactgen.validation.models.bimorph.solid import CadModel

    return CadModel


def _network() -> type[Model]:
    from tactgen.validation.models.reluctance.model import NetworkModel

    return NetworkModel


def _axisymmetric() -> type[Model]:
    from tactgen.validation.models.reluctance.field import AxisymmetricModel

    return AxisymmetricModel


def _magnetic3d() -> type[Model]:
    from tactgen.validation.models.reluctance.field import Magnetic3dModel

    return Magnetic3dModel


#: By name what loads the class.
CLASSES: dict[str, Callable[[], type[Model]]] = {
    "lumped": _lumped, "tmm": _tmm, "beam": _beam, "solid": _solid, "cad": _cad,
    "network": _network, "axisymmetric": _axisymmetric, "magnetic3d": _magnetic3d,
}  # fmt: skip


@cache
def model_class(name: str) -> type[Model]:
    """Class of a model."""
    return CLASSES[name]()


def make_model(name: str, scene: Scene, stages: Stages) -> Model:
    """Named model of a scene."""
    return model_class(name)(scene, stages)


def stage_code(stage: str) -> tuple[str, ...]:
    """Modules that compute a stage whose result is kept; nothing for any other."""
    model, _, own = stage.partition(".")
    return model_class(model).code() if own in MODELS[model].kept else ()


def map_of(scene: Scene, stages: Stages | None = None) -> CoenergyMap:
    """Co-energy map by the model that the scene asks for; the scene has it from now on.

    A field's takes half a minute once, then is read from the store.

    Parameters
    ----------
    stages : Stages, optional
        Of a plan in which the map is a stage: it runs there.

    Raises InputError if the model cannot make a map of the scene.
    """
    if stages is None and scene.has_map:
        return scene.pull
    from tactgen.validation.models.reluctance.model import MagneticModel

    stage = f"{scene.map_model}.map"
    model = make_model(scene.map_model, scene, stages or Stages({stage: stage_key(stage, scene)}))
    assert isinstance(model, MagneticModel)
    found = model.map()
    scene.take_map(found)
    return found
