"""Measured curves: what a CSV file may look like, and what is said of one that cannot be used."""

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.studies.measured_data import read_measured


def written(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "sweep.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(
    ("text", "kind", "values"),
    [
        ("# by hand\n\nfrequency (Hz);velocity (mm/s) # peak\n10;1  # first; of two\n20;2#\n",
         "velocity", [1e-3, 2e-3]),
        ("Frequency [Hz]\tVelocity [m s^-1]\n10\t1e-3\n20\t.002\n", "velocity", [1e-3, 2e-3]),
        ('"frequency (Hz)","velocity (mm/s)"\r\n10,1\r\n20,2\r\n', "velocity", [1e-3, 2e-3]),
        ("\ufefffrequency (kHz),velocity (mm/s)\n.01,1\n.02,2\n,\n", "velocity", [1e-3, 2e-3]),
        ("frequency (Hz),displacement_re (µm),displacement_im (um)\n10,1,-2\n20,0,2e-9\n",
         "displacement", [1e-6 - 2e-6j, 2e-15j]),
        ("admittance_phase (deg),frequency (Hz),admittance (uS)\n90,10,1\n-180,20,2\n",
         "admittance", [1e-6j, -2e-6]),
    ],
)  # fmt: skip
def test_every_form_of_a_curve_is_read_into_si(tmp_path, text, kind, values):
    """Separators, quotes, comments, byte order mark, brackets, column order, units, phases."""
    curve = read_measured(written(tmp_path, text))
    assert curve.kind == kind
    np.testing.assert_allclose(curve.frequencies, [10.0, 20.0], rtol=1e-14)
    # rounding of the unit's factor and of cos and sin of the phase
    np.testing.assert_allclose(curve.values, values, rtol=1e-14, atol=1e-21)
    assert curve.has_phase == ("_" in text)
    assert curve.error is None
    assert curve.weight.tolist() == [1.0, 1.0]


def test_uncertainty_and_weight(tmp_path):
    """The uncertainty has a unit of its own; weights have none, and 0 leaves a point out."""
    text = "frequency (Hz),velocity (mm/s),uncertainty (um/s)\n10,1,20\n20,2,40\n"
    np.testing.assert_allclose(read_measured(written(tmp_path, text)).error, [2e-5, 4e-5])
    text = "frequency (Hz),velocity (mm/s),weight\n10,1,0\n20,2,3\n"
    curve = read_measured(written(tmp_path, text))
    assert curve.weight.tolist() == [0.0, 3.0]
    assert curve.at(curve.weight > 0.0).frequencies.tolist() == [20.0]


HEAD = "frequency (Hz),velocity (mm/s)\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["is empty", "frequency (Hz), velocity (mm/s)"]),
        (HEAD, ["holds 0 points", "at least 5"]),
        ("Vibrometer 3\n10,1\n", ["line 1", "begin the file with a header", "with #"]),
        ("frequency (Hz),velocty (mm/s)\n1,2\n", ['did you mean "velocity"']),
        ("frequency (Hz),velocity (m/s),current (A)\n1,2,3\n", ["keep one measured curve"]),
        ("frequency (Hz),velocity_re (m/s)\n1,2\n", ["velocity_re without", "is no curve"]),
        ("frequency (Hz),velocity (furlongs/(((x)\n1,2\n", ["furlongs", "not that of a velocity"]),
        ("frequency (Hz),velocity (m/s),weight,uncertainty (m/s)\n1,2,3,4\n", ["keep one"]),
        ("frequency (Hz);velocity (mm/s)\n10;1,5\n20;2\n", ['"1,5"', "decimals with a point"]),
        (HEAD + "10,1\n20,\n", ["line 3", '"velocity (mm/s)"', "empty"]),
        (HEAD + "10,1\n20,2,3\n", ["line 3 has 3 cells", "2 columns"]),
        (HEAD + "10,1\n20,2\n20,3\n", ["line 4", "repeats that of line 3"]),
        ("frequency (Hz),velocity_re (m/s),velocity_im (m/s)\n1,0,0\n2,1,1\n", ["0 in both parts"]),
        ("frequency (Hz),velocity (m/s),uncertainty (m/s)\n1,2,1e-9\n2,3,0\n",
         ["line 3", "uncertainty is not above 0"]),
        (HEAD + "0,1\n20,2\n", ["line 2", "frequency 0 Hz", "not above 0"]),
        (HEAD + "10,1\n20,-2\n", ["line 3", "velocity is not above 0", "velocity_re"]),
        (HEAD + "10,1e30\n20,2\n", ['"1e30"', "not a possible velocity", "check the value"]),
        ("frequency (Hz),velocity (m/s),weight\n1,2,3\n2,3,-1\n", ["line 3", "is negative"]),
        ("frequency (Hz),velocity (m/s),weight\n1,2,0\n2,3,0\n", ["all weights are 0"]),
        (HEAD + '10,"1\n20,2\n', ["line 2", "is not CSV"]),
    ],
)  # fmt: skip
def test_bad_file_gives_one_sentence(tmp_path, text, words):
    """Each way a file can be wrong names the file, the place, the value and the remedy."""
    path = written(tmp_path, text)
    with pytest.raises(InputError) as refused:
        read_measured(path)
    message = str(refused.value)
    assert str(path) in message
    assert "\n" not in message
    for word in words:
        assert word in message


def test_unreadable_files(tmp_path):
    """Another encoding, a folder, no file, and a name that no file can have."""
    with pytest.raises(InputError, match="is not UTF-8 text"):
        read_measured(written(tmp_path, HEAD + "10,µ\n", encoding="utf-16"))
    for name in (tmp_path, tmp_path / "nowhere.csv", "x\0y", "n" * 5000):
        with pytest.raises(InputError, match="cannot be read"):
            read_measured(name)
