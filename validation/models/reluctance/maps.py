"""The co-energy map that pulls at a scene's rod, made once in a process and kept on disk.

Loaded by name from the scene and the engine, as the models are.
"""

from __future__ import annotations

from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.tmm.reluctance.map_range import network_pull
from tactgen.validation.engine.inputs import stage_key
from tactgen.validation.engine.model import make_model
from tactgen.validation.engine.stages import Stages
from tactgen.validation.models.reluctance.model import MagneticModel, NetworkModel
from tactgen.validation.scene.scene import Scene

#: Maps that this process has got, by the key of their stage; the first goes if there are more.
_AT_HAND: dict[str, CoenergyMap] = {}
_MOST = 32


def map_of(scene: Scene, stages: Stages | None = None) -> CoenergyMap:
    """Map by the model that the scene asks for, the network by default.

    Parameters
    ----------
    stages : Stages, optional
        Of a plan in which the map is a stage: it runs there.

    Raises InputError if the model cannot make a map of the scene.
    """
    name = scene.map_model
    if stages is None and name == NetworkModel.name:
        return network_pull(scene.device)
    key = _key(scene)
    if stages is None and key in _AT_HAND:
        return _AT_HAND[key]
    model = make_model(name, scene, stages or Stages({f"{name}.map": key}))
    assert isinstance(model, MagneticModel)
    found = model.map()
    while len(_AT_HAND) >= _MOST:
        del _AT_HAND[next(iter(_AT_HAND))]
    _AT_HAND[key] = found
    return found


def is_at_hand(scene: Scene) -> bool:
    """Whether this process has the map of a scene already."""
    return _key(scene) in _AT_HAND


def _key(scene: Scene) -> str:
    return stage_key(f"{scene.map_model}.map", scene)
