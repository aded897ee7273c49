"""The co-energy map: one surface, its derivatives, its error, what it refuses, its files."""

from dataclasses import replace

import numpy as np
import pytest
from reluctance_samples import G0, C, falling_samples, linear_samples
from scipy.io import netcdf_file

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.coenergy_fit import fit, read_map, write_map
from tactgen.tmm.reluctance.coenergy_map import Samples, cells, closed_loop_work
from tactgen.tmm.reluctance.network import network_samples

CURRENTS = 0.2 * (np.arange(11) / 10.0) ** 1.5
GAPS = np.geomspace(0.02e-3, 0.25e-3, 10)
DEVICE = Device()


@pytest.fixture(scope="module")
def samples():
    return network_samples(DEVICE, CURRENTS, GAPS)


@pytest.fixture(scope="module")
def pull(samples):
    return fit(samples)


def saturating_samples(currents, gaps):
    """i = λ (g + G0)/C + (λ/λs)⁹ A: a gap in series with iron that saturates, solved for λ.

    Its energy W(λ, g) is a polynomial, so W' = iλ − W and F = ∂W/∂g at constant λ are exact.
    """
    i, g = (v.astype(float) for v in np.broadcast_arrays(currents[:, None], gaps[None]))
    saturation = 1.2e-3

    def needed(linkage):
        return linkage * (g + G0) / C + (linkage / saturation) ** 9

    low, high = np.zeros_like(i), i * C / (g + G0) + 1e-30
    for _ in range(200):
        middle = 0.5 * (low + high)
        enough = needed(middle) > i
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    energy = 0.5 * low**2 * (g + G0) / C + saturation * (low / saturation) ** 10 / 10.0
    slope = (g + G0) / C + 9.0 / saturation * (low / saturation) ** 8
    return Samples(currents, gaps, low, 0.5 * low**2 / C, i * low - energy, 1.0 / slope)


def between(values, spaced="arithmetic"):
    if spaced == "geometric":
        return np.sqrt(values[1:] * values[:-1])
    return 0.5 * (values[1:] + values[:-1])


def largest_error(found, expected):
    """Return the largest error as the map states it: see MapError."""
    size = np.abs(expected)
    return (np.abs(found - expected) / np.maximum(size, 0.1 * size.max(axis=0))).max()


def test_linear_actuator():
    """Every quantity of a linear actuator has a closed form."""
    pull = fit(linear_samples(CURRENTS, GAPS))
    i, g = between(CURRENTS)[:, None], between(GAPS)[None]
    linkage, width = C * i / (g + G0), g + G0
    # W' is quadratic in i, as the map is; cubic splines in ln(g + g0) leave h⁴, 1e-5 of W',
    # and lose one order with every derivative by the gap
    for found, expected, tolerance in (
        (pull.coenergy(i, g), 0.5 * i * linkage, 1e-4),
        (pull.energy(i, g), 0.5 * i * linkage, 1e-4),
        (pull.flux_linkage(i, g), linkage, 1e-4),
        (pull.incremental_inductance(i, g), linkage / i, 1e-4),
        (pull.force(i, g), 0.5 * linkage**2 / C, 1e-3),
        (pull.motional_coefficient(i, g), -linkage / width, 1e-3),
        (pull.force_gradient(i, g), -(linkage**2) / (C * width), 3e-2),
    ):
        np.testing.assert_allclose(found, expected, rtol=tolerance)
    assert pull.gap_offset == pytest.approx(G0, rel=1e-9)


def test_derivatives_are_of_one_surface(pull):
    """λ, F, inductance, motional coefficient and force gradient by central differences of W'."""
    i, g = np.array([0.013, 0.08, -0.17])[:, None], np.array([0.031e-3, 0.11e-3, 0.23e-3])
    di, dg = 1e-6, 1e-9
    for name, of, by, step, sign in (
        ("flux_linkage", "coenergy", "i", di, 1.0),
        ("incremental_inductance", "flux_linkage", "i", di, 1.0),
        ("force", "coenergy", "g", dg, -1.0),
        ("motional_coefficient", "flux_linkage", "g", dg, 1.0),
        ("motional_coefficient", "force", "i", di, -1.0),
        ("force_gradient", "force", "g", dg, 1.0),
    ):
        function = getattr(pull, of)
        up = function(i + step, g) if by == "i" else function(i, g + step)
        down = function(i - step, g) if by == "i" else function(i, g - step)
        slope = sign * (up - down) / (2.0 * step)
        # rounding over the step, 1e-15/1e-5
        np.testing.assert_allclose(getattr(pull, name)(i, g), slope, rtol=1e-6)


def test_cell_by_cell_it_is_the_same_surface(pull):
    """At random points, at breaks and at the ends, for either sign of the current; beyond the
    ends it goes on smoothly, for an iteration that strays."""
    found = cells(pull)
    chosen = np.random.default_rng(5)
    currents = [0.0, 0.2, *found.current_breaks[1:3], *chosen.uniform(-0.2, 0.2, 20)]
    low, high = pull.gap_limits
    gaps = [low, high, *np.exp(found.width_breaks[1:3]) - pull.gap_offset]
    gaps += list(chosen.uniform(low, high, 20))
    for current, gap in zip(currents, gaps, strict=True):
        point = found.at(current, gap)
        for value, method in (
            (point.coenergy, pull.coenergy),
            (point.flux_linkage, pull.flux_linkage),
            (point.force, pull.force),
            (point.inductance, pull.incremental_inductance),
            (point.motional, pull.motional_coefficient),
            (point.force_gradient, pull.force_gradient),
        ):
            expected = float(method(current, gap))
            size = float(np.abs(method(0.2, gap)))
            assert value == pytest.approx(expected, rel=1e-11, abs=1e-13 * size)
    for gap in (low, high):
        inside, outside = (found.at(0.1, gap * (1.0 + d)) for d in (-1e-9, 1e-9))
        assert inside == pytest.approx(outside, rel=1e-6)
    assert np.isfinite(found.at(0.3, -1.0)).all()


def test_loop_work_sees_an_inconsistent_model():
    """A force that belongs to another co-energy does net work: the test can fail."""

    def wrong(currents, gaps):
        samples = linear_samples(currents, gaps)
        return replace(samples, force=1.01 * samples.force)

    net, side = closed_loop_work(wrong, (0.01, 0.15), (0.03e-3, 0.2e-3))
    assert abs(net) > 1e-3 * side


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_monotone_everywhere(samples, noise):
    """∂λ/∂i > 0 at every current and gap, even if noise makes the samples contradict it."""
    rng = np.random.default_rng(3)

    def shaken(values):
        return values * (1.0 + noise * rng.uniform(-1.0, 1.0, values.shape))

    # sorting keeps λ rising from sample to sample, which is asked of them
    linkage, force = np.sort(shaken(samples.flux_linkage), axis=0), shaken(samples.force)
    pull = fit(Samples(CURRENTS, GAPS, linkage, force))
    i, g = np.linspace(-0.2, 0.2, 201)[:, None], np.linspace(0.02e-3, 0.25e-3, 101)
    assert (pull.incremental_inductance(i, g) > 0.0).all()
    assert (pull.coefficients > 0.0).all()
    if noise:
        assert pull.residual.flux_linkage > 0.1 * noise  # and the contradiction is reported


@pytest.mark.parametrize(
    ("points", "power"),
    [
        (14, 1.5),
        *(pytest.param(*grid, marks=pytest.mark.heavy) for grid in ((7, 1.0), (7, 1.5), (14, 1.0))),
        *(pytest.param(10, power, marks=pytest.mark.heavy) for power in (1.0, 1.5)),
    ],
)
@pytest.mark.parametrize(
    "model", [lambda i, g: network_samples(DEVICE, i, g), saturating_samples], ids=("net", "exact")
)
def test_interpolation_error_is_honest(points, power, model):
    """The error found by leaving samples out covers the true one between the samples.

    Of 216 grids and networks it covered 92 % in flux linkage and 95 % in force; with
    inductances given, as here, the others were within a factor of two.
    """
    currents = 0.2 * (np.arange(points + 1) / points) ** power
    gaps = np.geomspace(0.02e-3, 0.25e-3, points)
    pull = fit(model(currents, gaps))
    exact = model(between(currents), between(gaps, "geometric"))
    said = pull.sampled(exact.current, exact.gap)
    for name in ("flux_linkage", "force"):
        true = largest_error(getattr(said, name), getattr(exact, name))
        assert true < 2.0 * getattr(pull.interpolation_error, name), name


def test_interpolation_error_is_not_wide():
    """On seven currents spread evenly the true errors take two thirds of what is said of them."""
    currents, gaps = 0.2 * np.arange(8) / 7.0, np.geomspace(0.02e-3, 0.25e-3, 7)
    shares = {"flux_linkage": [], "force": []}
    for model in (lambda i, g: network_samples(DEVICE, i, g), saturating_samples):
        pull = fit(model(currents, gaps))
        exact = model(between(currents), between(gaps, "geometric"))
        said = pull.sampled(exact.current, exact.gap)
        for name, found in shares.items():
            true = largest_error(getattr(said, name), getattr(exact, name))
            found.append(true / getattr(pull.interpolation_error, name))
    for name, found in shares.items():
        assert 1.0 / 3.0 < max(found) <= 1.0, name


@pytest.mark.parametrize(
    ("current", "gap", "words"),
    [
        (0.21, 0.1e-3, "current = 210 mA .* ends at 200 mA"),
        (np.nan, 0.1e-3, "current = nan mA"),
        (0.1, np.array([0.1e-3, 0.3e-3]), "gap = 300 um .* from 20 to 250 um"),
    ],
)
def test_no_extrapolation(current, gap, words, pull):
    """Outside its samples the map refuses, with value, unit and range."""
    with pytest.raises(InputError, match=words):
        pull.force(current, gap)


def test_a_pull_that_falls_through_zero():
    """Saturated steel may push: a pull that changes its sign is met on both sides."""
    samples = falling_samples(np.linspace(0.0, 0.45, 16), GAPS)
    assert samples.force.min() < 0.0 < samples.force.max()
    said = fit(samples).force(samples.current[:, None], GAPS)
    # cubic between the gaps, and judged relative to a tenth of the largest pull at most
    most = np.abs(samples.force).max()
    np.testing.assert_allclose(said, samples.force, rtol=2e-3, atol=2e-4 * most)


def broken(**changes):
    return replace(linear_samples(CURRENTS, GAPS), **changes)


@pytest.mark.parametrize(
    ("samples", "words"),
    [
        (linear_samples(CURRENTS[:5], GAPS), "4 currents above 0 mA and 10 gaps make no map"),
        (linear_samples(CURRENTS - 0.01, GAPS), "samples of current must increase from 0"),
        (
            broken(flux_linkage=-linear_samples(CURRENTS, GAPS).flux_linkage),
            "flux_linkage must increase",
        ),
        (broken(force=np.full((11, 10), np.nan)), "force are not all finite"),
        (broken(force=linear_samples(CURRENTS, GAPS).force[:5]), r"force have the shape \(5, 10\)"),
    ],
)
def test_unusable_samples_are_refused(samples, words):
    """Samples that make no co-energy map are refused in one sentence."""
    with pytest.raises(InputError, match=words):
        fit(samples)


@pytest.fixture(scope="module")
def kept(samples):
    return fit(replace(samples, force_error=None, model="network", device="mine"))


def test_round_trip(kept, tmp_path):
    """A map read back is the map written, to the last bit; flux linkage and force are enough."""
    bare = fit(Samples(CURRENTS, GAPS, kept.samples.flux_linkage, kept.samples.force))
    for written in (kept, bare):
        write_map(tmp_path / "map.nc", written)
        again = read_map(tmp_path / "map.nc")
        assert np.array_equal(again.coefficients, written.coefficients)
        assert again.interpolation_error == written.interpolation_error
        assert (again.samples.coenergy is None) is (written is bare)
        for name in ("model", "device"):
            assert getattr(again.samples, name) == getattr(written.samples, name)


def test_file_explains_itself(kept, tmp_path):
    """Any netCDF reader finds names, dimensions, units and the sign of the force."""
    write_map(tmp_path / "map.nc", kept)
    with netcdf_file(str(tmp_path / "map.nc"), "r", mmap=False) as file:
        force = file.variables["force"]
        assert (force.dimensions, force.units) == (("current", "gap"), b"N")
        assert b"closes the gap" in force.long_name
        np.testing.assert_array_equal(force[:], kept.samples.force)


def test_other_files_are_refused(kept, tmp_path):
    """Half a file, a text, another netCDF file and no file: one sentence each."""
    write_map(tmp_path / "map.nc", kept)
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


def test_damaged_files_are_refused_or_read(kept, tmp_path):
    """Cut anywhere or with bytes flipped, a file gives a map or one sentence, never a traceback."""
    write_map(tmp_path / "map.nc", kept)
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
