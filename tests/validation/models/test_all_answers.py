"""All that the detailed models answer, on meshes far coarser than any answer needs."""

import pytest
from approved import answered

from tactgen.validation.catalogue.quantities import quantities_of
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph.solid import level_for
from tactgen.validation.scene.scene import load_scene

COARSE = ("models=solid", "modes=3", "frequency=100,700", "accuracy=0.1")
SCENES = {
    "on springs": ("prototype", COARSE),
    "in series under a finger": ("paper", (*COARSE, "bimorph.wiring=series")),
    "clamped": ("prototype", (*COARSE, "support.kind=clamped", "bimorph.bare_above=1 mm")),
}
#: Of one current and gap.
POINT = ("magnetic_force", "flux_linkage", "coenergy", "inductance", "incremental_inductance")


@pytest.mark.usefixtures("own_store", "coarse_bricks")
@pytest.mark.parametrize("scene", SCENES)
def test_solid(scene, approved):
    name, sets = SCENES[scene]
    found = solve(load_scene(name, sets)[0], ("solid",), quantities_of("bimorph"))
    approved("\n".join([answered(found.quantities), *found.warnings]))


def test_field(rough_fields, tmp_path, approved):
    with rough_fields(tmp_path):
        scene, _ = load_scene("reluctance", ["models=axisymmetric", "accuracy=0.1"])
        found = solve(scene, ("axisymmetric",), POINT)
    approved("\n".join([answered(found.quantities), *found.warnings]))


def test_bricks_by_accuracy(approved):
    """Which level answers, on springs and on the rod; the heavy tests say that it may."""
    wanted = (0.2, 0.05, 5e-3, 2e-3, 1.2e-3, 6e-4, 4e-4, 3e-4)
    levels = {
        name: [level_for(load_scene(name, [f"accuracy={accuracy}"])[0]) for accuracy in wanted]
        for name in ("prototype", "bimorph_on_rod")
    }
    approved("\n".join(f"{name}: {levels[name]}" for name in levels))
