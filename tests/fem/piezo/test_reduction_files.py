"""Reduced solids on disk: what a file holds, what stands for a solid; the cache."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.piezo import reduction_files as port_cache
from tactgen.fem.piezo.krylov import reduce_to_ports
from tactgen.fem.piezo.reduction_files import made_from, reduced_solid, write_ports
from tactgen.fem.piezo.solid import assemble
from tactgen.geometry.bimorph.bricks import BrickMeshing, bimorph_bricks
from tactgen.geometry.device.parameters import Bimorph, Device, Piezo
from tactgen.geometry.errors import InputError
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.export import export

MESHING = BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0))
SWEEP = np.array([10.0, 1000.0, 5000.0])


@pytest.fixture(scope="module")
def mesh():
    return bimorph_bricks(Device(), MESHING)


@pytest.fixture(scope="module")
def reduced(mesh):
    return reduce_to_ports(assemble(Device(), mesh, lossy=True), SWEEP)


def test_a_file_holds_the_matrices(reduced, tmp_path):
    """To the last bit, under fixed names, for readers without this package."""
    write_ports(tmp_path / "p.npz", reduced, made_from="mine")
    with np.load(tmp_path / "p.npz", allow_pickle=False) as found:
        for level in ("fine", "coarse"):
            for name in ("stiffness", "mass", "tip"):
                own = getattr(getattr(reduced, level), name)
                assert np.array_equal(found[f"{level} {name}"], own)
        assert tuple(found["range"]) == reduced.range
        assert float(found["error"]) == reduced.error
        assert int(found["unknowns"]) == reduced.unknowns
        assert found["made_from"].item() == "mine"


def test_stamp_holds_all_that_matters(mesh):
    """Materials, poling and mesh change it; coil and width, which the mesh has, need not."""
    one = made_from(Device(), mesh)
    assert one == made_from(Device(), bimorph_bricks(Device(), MESHING))
    assert one != made_from(Device(piezo=Piezo(quality_factor=31.0)), mesh)
    assert one != made_from(Device(bimorph=Bimorph(poling="+x")), mesh)
    breaks = mesh.z.breaks.copy()
    breaks[1] *= 1.0 + 1e-15
    assert one != made_from(Device(), replace(mesh, z=replace(mesh.z, breaks=breaks)))


@pytest.fixture
def calls(own_store, monkeypatch):
    """Return what grows with each reduction, and leave nothing that is kept."""
    made = []

    def counted(*arguments, **options):
        made.append(1)
        return reduce_to_ports(*arguments, **options)

    monkeypatch.setattr(port_cache, "reduce_to_ports", counted)
    return made


def test_second_time_factorises_nothing(mesh, calls):
    """Kept for its range: other frequencies in it are served, a wider range is reduced anew."""
    first = reduced_solid(Device(), mesh, SWEEP, tolerance=1e-6)
    denser = np.geomspace(10.0, 5000.0, 50)
    second = reduced_solid(Device(), mesh, denser, tolerance=1e-6)
    assert len(calls) == 1
    assert np.array_equal(first.multiport(denser).stiffness, second.multiport(denser).stiffness)
    reduced_solid(Device(), mesh, np.array([10.0, 6000.0]), tolerance=1e-6)
    reduced_solid(Device(piezo=Piezo(quality_factor=31.0)), mesh, SWEEP, tolerance=1e-6)
    assert len(calls) == 3


def test_what_did_not_reach_the_tolerance_is_kept_too(mesh, calls, monkeypatch):
    """All shifts used and still an estimate above the tolerance: a second try would end there."""
    monkeypatch.setattr("tactgen.fem.piezo.krylov._MOST_SHIFTS", 2)
    first = reduced_solid(Device(), mesh, SWEEP, tolerance=1e-16)
    assert first.error > 1e-16
    second = reduced_solid(Device(), mesh, SWEEP, tolerance=1e-16)
    assert (len(calls), second.error) == (1, first.error)


@pytest.mark.parametrize("kind", ["ports", "state_space"])
def test_ports_of_the_normal_actuator_are_refused(tmp_path, kind):
    """A scene about the normal actuator alone has no bimorph; nothing is written."""
    with pytest.raises(InputError, match="no bimorph"):
        export(load_scene("reluctance")[0], {kind: tmp_path / "a.npz"}, lambda _: None)
    assert list(tmp_path.iterdir()) == []


def test_who_is_judged_by_what_is_lacking_is_served_by_what_knows_it(mesh, monkeypatch):
    """Reduced without it before, it is reduced anew; also where the estimate is too large."""
    monkeypatch.setattr(port_cache, "cached_result", lambda *_, serves: serves)
    for missing, lacking, served in (
        (None, None, True), (None, lambda: None, False), ("known", lambda: None, True),
    ):  # fmt: skip
        serves = reduced_solid(Device(), mesh, SWEEP, tolerance=1e-6, lacking=lacking)
        for estimate, small in ((1e-7, True), (1e-5, False)):
            found = SimpleNamespace(
                missing=missing, error=1e-8, error_estimate=lambda f, e=estimate: np.full(f.size, e)
            )
            assert serves(found) is (served and small)
