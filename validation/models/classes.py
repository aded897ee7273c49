"""Classes of the models, each loaded when it is asked for; and the co-energy map of a scene.

A model's libraries take up to seconds to load: an answer by transfer matrices loads no scikit-fem.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.models.model import Model, Stages
from tactgen.validation.scene.inputs import stage_key
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.tmm.reluctance.coenergy_map import CoenergyMap


#: Where the class of each model is, and its name.
CLASSES = {
    "lumped": ("bimorph.model", "LumpedModel"), "tmm": ("bimorph.model", "TmmModel"),
    "beam": ("bimorph.beam", "BeamModel"),
    "calibrated": ("bimorph.calibrated", "CalibratedModel"),
    "solid": ("bimorph.solid", "SolidModel"), "cad": ("bimorph.solid", "CadModel"),
    "network": ("reluctance.model", "NetworkModel"),
    "axisymmetric": ("reluctance.field", "AxisymmetricModel"),
    "magnetic3d": ("reluctance.field", "Magnetic3dModel"),
}  # fmt: skip


@cache
def model_class(name: str) -> type[Model]:
    """Class of a model."""
    module, own = CLASSES[name]
    found: type[Model] = getattr(import_module(f"tactgen.validation.models.{module}"), own)
    return found


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
