"""Whatever a picture may show has words."""

from tactgen.fem.piezo.modal_model import Motion
from tactgen.validation.catalogue.models import models_of
from tactgen.validation.show import field as shading


def test_every_model_and_class_of_motion_has_words():
    """Those of the lateral actuator, and the field of the normal one."""
    assert set(shading.MODELS) == {*models_of("bimorph"), "axisymmetric"}
    assert set(shading.MOTIONS) == set(Motion.__args__) - {"all"} | {"mixed"}
    for words in (shading.MODELS, shading.MOTIONS, shading.REGIONS):
        assert all(words.values())
        assert len(set(words.values())) == len(words)
