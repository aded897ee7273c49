"""Field files: read back by PyVista and meshio, and a glTF that says what moves."""

import json
import struct
from dataclasses import replace
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import pyvista as pv
from approved import described

from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.surface import surface_of
from tactgen.validation.export.animated_gltf import drawn_scale, write_animated_glb
from tactgen.validation.export.fields import STEPS, moving_state, write_fields
from tactgen.validation.export.files import export
from tactgen.validation.fields.gather import Request, gather
from tactgen.validation.models.bimorph import solid
from tactgen.validation.scene.scene import load_scene


@pytest.fixture(scope="module")
def scene():
    return load_scene("j1", ["mesh.level=1", "modes=1", "models=solid"])[0]


@pytest.fixture(scope="module")
def result(scene, tmp_path_factory, few_bricks):
    """On few bricks, with a store of their own whose keys do not know."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("few")))
        patch.setattr(solid, "LEVELS", few_bricks)
        return gather(scene, ["solid"], Request((300.0,), "edges"))[0]


@pytest.mark.parametrize("suffix", [".vtu", ".vtkhdf"])
def test_every_field_comes_back(result, tmp_path, suffix, approved):
    """Numbers as they were, named with units; complex amplitudes in two parts."""
    path = tmp_path / f"fields{suffix}"
    write_fields(path, result)
    grid = pv.read(path)
    assert grid.points == pytest.approx(result.mesh.points)
    moving = result.state("300 Hz").fields["displacement"]
    for part, values in (("real", moving.real), ("imaginary", moving.imag)):
        name = f"300 Hz: displacement, {part} part (m)"
        assert grid.point_data[name] == pytest.approx(values, rel=1e-12, abs=0.0)
    strain = grid.point_data["static: strain (1)"]
    own = result.state("static").fields["strain"]
    assert strain[:, 5] == pytest.approx(0.5 * own[:, 4])  # xz last, half the shear angle
    if suffix == ".vtu":
        read = meshio.read(path).point_data["static: electric potential (V)"]
        assert read == pytest.approx(result.state("static").fields["potential"])
    sizes = {name: np.abs(grid[name]) for name in grid.array_names}
    approved(described([sizes, dict(grid.field_data.items())]))


def test_a_file_that_hdf_cannot_write_is_said(result, tmp_path, monkeypatch):
    from vtkmodules import vtkIOHDF

    failing = SimpleNamespace(
        SetInputData=str, SetFileName=str, SetCompressionLevel=str, Write=lambda: 0
    )
    monkeypatch.setattr(vtkIOHDF, "vtkHDFWriter", lambda: failing)
    with pytest.raises(
        InputError,
        match=r"f\.vtkhdf cannot be written .VTK's HDF5 writer failed.; .* or write \.vtu",
    ):
        write_fields(tmp_path / "f.vtkhdf", result)
    assert not list(tmp_path.iterdir())


def test_a_period_is_a_series_of_steps(result, tmp_path):
    """The eighth of 24 steps is at a third of the period, and has its phase."""
    path = tmp_path / "swing.pvd"
    write_fields(path, result)
    reader = pv.PVDReader(path)
    assert reader.time_values == pytest.approx(np.arange(STEPS) / STEPS / 300.0)
    reader.set_active_time_point(STEPS // 3)
    (block,) = reader.read()
    expected = (result.state("300 Hz").fields["displacement"] * np.exp(2j * np.pi / 3)).real
    assert block.point_data["300 Hz: displacement (m)"] == pytest.approx(expected)


def test_gltf_animates_every_motion(result, tmp_path, approved):
    """Targets are the displacements to scale; weights at a quarter period are those of e^{jΩt}."""
    path = tmp_path / "swing.glb"
    write_animated_glb(path, result, {})
    raw = path.read_bytes()
    magic, version, length, size, kind = struct.unpack_from("<4sIIII", raw)
    assert (magic, version, length, kind) == (b"glTF", 2, len(raw), 0x4E4F534A)
    content, data = json.loads(raw[20 : 20 + size]), raw[28 + size :]

    def array(number):
        accessor = content["accessors"][number]
        view = content["bufferViews"][accessor["bufferView"]]
        dtype = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        flat = np.frombuffer(data, dtype, view["byteLength"] // 4, view["byteOffset"])
        return flat.reshape(-1, 3) if accessor["type"] == "VEC3" else flat

    moving = [s for s in result.states if s.kind != "static"]
    names = [animation["name"].rsplit(", ", 1)[0] for animation in content["animations"]]
    assert names == [state.name for state in moving]
    surface = surface_of(result.mesh)
    used = np.unique(surface.triangles[surface.region_of_triangle == 0])
    (mesh,) = content["meshes"]
    imaginary = array(mesh["primitives"][0]["targets"][-1]["POSITION"])
    state = moving[-1]
    scaled = drawn_scale(result, state) * state.fields["displacement"][used].imag
    assert imaginary == pytest.approx(scaled, abs=1e-7 * np.abs(scaled).max())
    weights = array(content["animations"][-1]["samplers"][0]["output"])
    weights = weights.reshape(-1, len(mesh["weights"]))
    assert weights[8, -2:] == pytest.approx([0.0, -1.0], abs=1e-7)
    assert not weights[:, :-2].any()
    assert pv.read(path).n_blocks > 0
    bulk = ("accessors", "bufferViews", "buffers")
    approved(described({key: value for key, value in content.items() if key not in bulk}))


def test_export_writes_both_or_none(tmp_path):
    """A scene with no bimorph is refused before anything is solved."""
    scene, _ = load_scene("j1", ["modes=1", "models=tmm"])
    files = {"fields": tmp_path / "f.vtu", "animated_glb": tmp_path / "f.glb"}
    for models, words in (("network", "neither a bimorph"), ("axisymmetric", "is for what moves")):
        lonely, _ = load_scene("reluctance", [f"models={models}"])
        with pytest.raises(InputError, match=words):
            export(lonely, files, lambda _: None)
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match=r"--fields .* must end in .vtu or .vtkhdf or .pvd"):
        export(scene, {"fields": tmp_path / "f.txt"}, lambda _: None)
    export(scene, files, lambda _: None)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["f.glb", "f.vtu"]


def test_what_moves_is_the_first_driven_state_else_the_first(result):
    """Of modes alone the first."""
    assert moving_state(result).kind == "harmonic"
    modes = tuple(state for state in result.states if state.kind == "mode")
    assert moving_state(replace(result, states=modes)) is modes[0]
