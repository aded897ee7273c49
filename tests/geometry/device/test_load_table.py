"""Tables of a load: what is read, and one sentence for what cannot be."""

import numpy as np
import pytest

from tactgen.geometry.device.load_table import load_table, read_load_table
from tactgen.geometry.device.parameters import Load
from tactgen.geometry.errors import InputError

HEAD = "frequency (Hz), impedance_re (N s/m), impedance_im (N s/m)"
ROWS = ["10, 0.8, -0.6", "20, 0.7, -0.5", "50, 0.6, -0.4", "100, 0.5, -0.4", "200, 0.5, -0.4",
        "400, 0.6, -0.3"]  # fmt: skip


@pytest.fixture
def written(tmp_path):
    """Return a function that writes lines and gives the file's path."""

    def write(head=HEAD, rows=ROWS):
        path = tmp_path / "load.csv"
        path.write_text("\n".join([head, *rows]) + "\n")
        return path

    return write


def test_four_ways_of_writing_the_same_load(written):
    """Impedance or stiffness, parts or magnitude and phase, in other units: one impedance."""
    f = np.array([10.0, 20.0, 50.0, 100.0, 200.0, 400.0])
    z = 5e-4 + 0.02 / (2j * np.pi * f)  # as soft as a load may be: no number near 1
    k = 2j * np.pi * f * z
    forms = {
        HEAD: (f, z.real, z.imag),
        "frequency (kHz); impedance (N s/mm); impedance_phase (deg)": (
            f / 1e3, abs(z) / 1e3, np.rad2deg(np.angle(z)),
        ),
        "frequency (Hz), stiffness_re (N/mm), stiffness_im (N/mm)": (f, k.real / 1e3, k.imag / 1e3),
        "frequency (Hz), stiffness (N/m), stiffness_phase (rad)": (f, abs(k), np.angle(k)),
    }  # fmt: skip
    for head, columns in forms.items():
        separator = ";" if ";" in head else ","
        rows = [separator.join(repr(float(v)) for v in row) for row in zip(*columns, strict=True)]
        table = read_load_table(written(head, rows))
        np.testing.assert_allclose(table.frequencies, f, rtol=1e-15)
        np.testing.assert_allclose(table.impedance, z, rtol=1e-14)


@pytest.mark.parametrize(
    ("head", "rows", "words"),
    [
        (HEAD.replace("impedance_im", "reactance"), ROWS, 'column 3 "reactance (N s/m)" is unkn'),
        (HEAD.replace(" (Hz)", ""), ROWS, 'column "frequency" has no unit'),
        (HEAD.replace("N s/m", "N/m", 1), ROWS, "not that of a mechanical impedance"),
        ("frequency (Hz), impedance (N s/m)", [r.rpartition(",")[0] for r in ROWS],
         "impedance, which is not a complex load"),
        ("impedance_re (N s/m), impedance_im (N s/m)", ["1, 2"] * 6, "no frequency column"),
        (HEAD, ROWS[:5], "holds 5 frequencies; give 6 to 100000"),
        (HEAD, [ROWS[1], ROWS[0], *ROWS[2:]], "line 3: frequency 10 Hz follows 20 Hz"),
        (HEAD, [*ROWS, "500, -1e-7, -1e-6"], "line 8: at 500 Hz the real part of the impedance is"),
        ("frequency (Hz), stiffness (N/m), stiffness_phase (deg)",
         [*ROWS[:5], "400, -3, 20"], "line 7: stiffness -3 N/m is below 0"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_refused(written, head, rows, words):
    """One sentence with file, line, value and remedy."""
    with pytest.raises(InputError) as refused:
        read_load_table(written(head, rows))
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_table_needs_a_file_that_is_there(tmp_path):
    with pytest.raises(InputError, match=r"needs load\.file"):
        load_table(Load(kind="table"))
    with pytest.raises(InputError, match="cannot be read"):
        load_table(Load(kind="table", file=str(tmp_path / "none.csv")))


def test_a_changed_file_is_read_again(written):
    """Read once, but again when it was written anew."""
    load = Load(kind="table", file=str(written()))
    first = load_table(load)
    assert load_table(load) is first
    written(rows=[*ROWS, "800, 0.7, -0.2"])
    assert load_table(load).band == (10.0, 800.0)
