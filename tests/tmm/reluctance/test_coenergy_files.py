"""Co-energy maps as netCDF files: what is written, read back, refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.io import netcdf_file

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.coenergy_fit import fit, read_map, write_map
from tactgen.tmm.reluctance.coenergy_map import Samples
from tactgen.tmm.reluctance.network import network_samples

CURRENTS, GAPS = np.linspace(0.0, 0.2, 8), np.geomspace(0.02e-3, 0.25e-3, 7)


@pytest.fixture(scope="module")
def pull():
    samples = network_samples(Device(), CURRENTS, GAPS)
    return fit(replace(samples, force_error=None, model="network", device="mine"))


def test_round_trip(pull, tmp_path):
    """A map read back is the map written, to the last bit; flux linkage and force are enough."""
    bare = fit(Samples(CURRENTS, GAPS, pull.samples.flux_linkage, pull.samples.force))
    for written in (pull, bare):
        write_map(tmp_path / "map.nc", written)
        again = read_map(tmp_path / "map.nc")
        assert np.array_equal(again.coefficients, written.coefficients)
        assert again.interpolation_error == written.interpolation_error
        assert (again.samples.coenergy is None) is (written is bare)
        for name in ("model", "device"):
            assert getattr(again.samples, name) == getattr(written.samples, name)


def test_file_explains_itself(pull, tmp_path):
    """Any netCDF reader finds names, dimensions, units and the sign of the force."""
    write_map(tmp_path / "map.nc", pull)
    with netcdf_file(str(tmp_path / "map.nc"), "r", mmap=False) as file:
        force = file.variables["force"]
        assert (force.dimensions, force.units) == (("current", "gap"), b"N")
        assert b"closes the gap" in force.long_name
        np.testing.assert_array_equal(force[:], pull.samples.force)


def test_other_files_are_refused(pull, tmp_path):
    """Half a file, a text, another netCDF file and no file: one sentence each."""
    write_map(tmp_path / "map.nc", pull)
    whole = (tmp_path / "map.nc").read_bytes()
    (tmp_path / "half.nc").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.nc").write_text("B (T), H (A/m)\n")
    (tmp_path / "empty.nc").write_bytes(b"")
    with netcdf_file(str(tmp_path / "other.nc"), "w") as file:
        file.title = "temperature of the sea"
    for name, words in (
        ("half.nc", "not a whole netcdf file"),
        ("text.nc", "not a whole netcdf file"),
        ("empty.nc", "not a whole netcdf file"),
        ("other.nc", "not a co-energy map: .*; give a file that tactgen export --map wrote"),
        ("none.nc", "no such file"),
    ):
        with pytest.raises(InputError, match=words):
            read_map(tmp_path / name)


def test_damaged_files_are_refused_or_read(pull, tmp_path):
    """Cut anywhere or with bytes flipped, a file gives a map or one sentence, never a traceback."""
    write_map(tmp_path / "map.nc", pull)
    whole = (tmp_path / "map.nc").read_bytes()
    random = np.random.default_rng(7)
    damaged = [whole[:size] for size in range(3, 400, 7)]
    for _ in range(60):
        flipped = bytearray(whole)
        for at in random.integers(0, 600, 3):
            flipped[at] ^= int(random.integers(1, 256))
        damaged.append(bytes(flipped))
    sentences = []
    for content in damaged:
        (tmp_path / "bad.nc").write_bytes(content)
        try:
            read_map(tmp_path / "bad.nc")
        except InputError as error:
            sentences.append(str(error))
    assert len(sentences) > 60
    assert not any("\n" in sentence for sentence in sentences)


@pytest.mark.parametrize(
    ("name", "dimensions", "unit", "words"),
    [
        ("force", ("current", "gap"), "mN", "in 'mN'; it must be over"),
        ("force", ("gap",), "N", "over .'gap',. in 'N'"),
        (None, (), "", "no variable current"),
    ],
)
def test_wrong_variables_are_refused(tmp_path, name, dimensions, unit, words):
    """A variable with another unit or other dimensions, or none, is named."""
    with netcdf_file(str(tmp_path / "map.nc"), "w") as file:
        file.title = "co-energy map of a reluctance actuator"
        if name:
            for axis, values, units in (("current", CURRENTS, "A"), ("gap", GAPS, "m")):
                file.createDimension(axis, values.size)
                variable = file.createVariable(axis, "f8", (axis,))
                variable[:], variable.units = values, units
            linkage = file.createVariable("flux_linkage", "f8", ("current", "gap"))
            linkage[:], linkage.units = 0.0, "Wb"
            table = file.createVariable(name, "f8", dimensions)
            table[:], table.units = 0.0, unit
    with pytest.raises(InputError, match=words):
        read_map(tmp_path / "map.nc")
