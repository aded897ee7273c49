"""Which writer is given what for each kind of file: made with stand-ins for all that takes time."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.export.files import export
from tactgen.validation.scene.scene import Scene, load_scene

#: What is stood in for, by module and name; what has a file among its arguments writes it.
WRITERS = (
    "geometry.meshing.mesh_files:write_mesh", "validation.export.files:write_port_files",
    "validation.export.fmu.unit:write_fmu", "validation.export.machine_state_space:write_machine",
    "tmm.reluctance.coenergy.files:write_map", "geometry.cad.solids:export_step",
    "geometry.cad.solids:export_glb", "geometry.cad.display:export_display",
    "validation.export.fields:write_fields", "validation.export.animated_gltf:write_animated_glb",
    "validation.models.reluctance.field:check_solid_map",
)  # fmt: skip
GIVERS = {
    "validation.models.bimorph.meshes:mesh_pair": SimpleNamespace(meshes=("fine", "coarse")),
    "validation.models.bimorph.meshes:cells_of": "cells",
    "validation.models.generator.transient:scene_machine": "machine",
    "validation.engine.model:make_model": SimpleNamespace(map=lambda: "map"),
    "validation.fields.gather:gather": ["fields"],
    "geometry.cad.solids:build_solids": "solids",
}
SUFFIX = {"step": "stp", "glb": "glb", "mesh": "msh", "map": "nc", "fields": "vtkhdf", "fmu": "fmu",
          "animated_glb": "glb"}  # fmt: skip


@pytest.fixture
def calls(monkeypatch):
    """Return the list of what was asked, a line each."""
    found = []

    def stand_in(at, answer=None):
        module, _, name = at.partition(":")

        def called(*given, **named):
            shown = [*map(said, given), *(f"{key}={said(v)}" for key, v in named.items())]
            found.append(f"{name}({', '.join(shown)})")
            for one in (*given, *named.values()):
                for path in one.values() if isinstance(one, dict) else (one,):
                    if isinstance(path, Path):
                        path.write_text(name)
            return answer

        monkeypatch.setattr(f"tactgen.{module}.{name}", called)

    for at in WRITERS:
        stand_in(at)
    for at, answer in GIVERS.items():
        stand_in(at, answer)
    monkeypatch.setattr("tactgen.validation.models.reluctance.model.MagneticModel", SimpleNamespace)
    return found


def said(value):
    """Return what is handed over in a word: scenes and devices by what tells them apart."""
    if isinstance(value, Path):
        return "a draft"
    if isinstance(value, dict) and value and all(isinstance(v, Path) for v in value.values()):
        return " ".join(value)
    if isinstance(value, Scene):
        return f"scene {value.name}"
    plain = value is None or isinstance(value, str | tuple | list | float)
    return str(value) if plain else type(value).__name__


CASES = {
    "bimorph": ("paper", ["step", "mesh", "ports", "state_space", "fields", "animated_glb"]),
    "ports alone": ("paper", ["ports"]),
    "glb alone": ("bimorph_on_rod", ["glb", "mesh"]),
    "machine": ("generator", ["fmu", "machine", "map", "step"]),
    "normal actuator": ("reluctance", ["step", "map"]),
    "by the network": ("reluctance models=network", ["map"]),
    "in three dimensions": ("reluctance models=network,magnetic3d", ["map"]),
    "field at rest": ("reluctance models=axisymmetric", ["fields"]),
    "display": ("display", ["step", "glb"]),
    "one of the display": ("display", ["glb"]),
    "movement": ("paper models=tmm", ["animated_glb"]),
}


@pytest.mark.parametrize("case", CASES)
def test_each_file_is_its_own_writers(case, calls, tmp_path, approved):
    """All are written under their own names, what is solved is announced, nothing else is made."""
    scene, kinds = CASES[case]
    name, *overrides = scene.split()
    targets = {kind: tmp_path / f"{kind}.{SUFFIX.get(kind, 'npz')}" for kind in kinds}
    scene = load_scene(name, overrides)[0]
    found = export(scene, targets, lambda text: calls.append(f"  {text}"))
    assert found == list(targets.values())
    written = [f"{path.name}: {path.read_text()}" for path in sorted(tmp_path.iterdir())]
    approved("\n".join([*calls, *written]))


@pytest.mark.parametrize(
    ("scene", "kinds", "words"),
    [
        ("reluctance models=network", ["ports"], "have no bimorph to reduce to its ports"),
        ("reluctance models=network", ["state_space"], "have no bimorph to reduce to its ports"),
        ("reluctance models=network", ["mesh"], "have no bimorph to divide into a mesh"),
        ("paper models=tmm", ["map"], "--map needs one of the models network, axisymmetric, magn"),
        ("paper", ["machine"], "--machine is the state space of the machine on its rod"),
        ("paper frequency=0", ["state_space"], "alone gives a state space no range"),
        ("reluctance models=axisymmetric", ["animated_glb"], "--animated-glb .* is for what moves"),
        ("paper support.kind=spring support.rotational_stiffness=0N*m/rad", ["state_space"],
         "support.rotational_stiffness = 0 N m/rad does not hold the base"),
        ("paper support.kind=spring support.lateral_stiffness=0N/m", ["state_space"],
         "support.lateral_stiffness = 0 N/m does not hold the base"),
    ],
)  # fmt: skip
def test_what_a_scene_cannot_give_is_refused_first(scene, kinds, words, calls, tmp_path):
    """One sentence, before anything is made."""
    name, *overrides = scene.split()
    targets = {kind: tmp_path / f"{kind}.{SUFFIX.get(kind, 'npz')}" for kind in kinds}
    with pytest.raises(InputError, match=words):
        export(load_scene(name, overrides)[0], targets, calls.append)
    assert calls == []
    assert list(tmp_path.iterdir()) == []


def test_a_refusal_names_the_file_that_was_meant(calls, tmp_path, monkeypatch):
    """And not the draft that it would have been written to."""

    def fail(path, *_):
        raise InputError(f"{path} is full")

    monkeypatch.setattr("tactgen.validation.export.fields.write_fields", fail)
    with pytest.raises(InputError) as caught:
        export(load_scene("paper")[0], {"fields": tmp_path / "a.vtu"}, calls.append)
    assert str(caught.value) == f"{tmp_path / 'a.vtu'} is full"
    assert list(tmp_path.iterdir()) == []
