"""A support measured as a table: the springs that it was made of, its error, its refusals."""

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.engine.warnings import request_warnings
from tactgen.validation.scene.load import load_scene

#: The paper's springs, with an inertia that counts: c, d, θ, and what holds the base laterally.
SPRING = (
    "support.rotational_stiffness=0.3 N*m/rad", "support.rotational_damping=3e-5 N*m*s/rad",
    "support.rotational_inertia=2e-9 kg*m^2", "support.lateral_stiffness=1e6 N/m",
)  # fmt: skip
C, D, THETA, LATERAL = 0.3, 3e-5, 2e-9, 1e6


def table(path, frequencies, *, lateral=True, magnitude=False, sign=1.0):
    omega = 2.0 * np.pi * np.asarray(frequencies)
    stiffness = C + sign * 1j * omega * D - omega**2 * THETA
    names, columns = ["frequency (Hz)"], [frequencies]
    if magnitude:
        names += ["rotational_stiffness (mN m/rad)", "rotational_stiffness_phase (deg)"]
        columns += [1e3 * np.abs(stiffness), np.degrees(np.angle(stiffness))]
    else:
        names += ["rotational_stiffness_re (N m/rad)", "rotational_stiffness_im (N m/rad)"]
        columns += [stiffness.real, stiffness.imag]
    if lateral:
        names += ["lateral_stiffness_re (N/mm)", "lateral_stiffness_im (N/mm)"]
        columns += [np.full(len(frequencies), 1e-3 * LATERAL), np.zeros(len(frequencies))]
    rows = [
        ",".join(names),
        *(",".join(f"{v:.17g}" for v in row) for row in zip(*columns, strict=True)),
    ]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return f"support.file={path}"


def answer(*overrides, models="tmm", quantities="tip_displacement"):
    asked = (f"models={models}", f"quantities={quantities}", "frequency=20,300,900",
             "load.kind=none")  # fmt: skip
    found = solve(load_scene("paper", [*asked, *overrides])[0], modelling=False)
    return {(q.name, q.model): q for q in found.quantities}


@pytest.mark.parametrize("magnitude", [False, True])
def test_a_table_of_springs_is_the_springs(tmp_path, magnitude):
    """At the table's own frequencies exactly; by every model, also with the charge."""
    file = table(tmp_path / "s.csv", [10, 20, 100, 300, 500, 900, 1000], magnitude=magnitude)
    asked = {"models": "tmm,beam,lumped", "quantities": "tip_displacement,input_current"}
    springs = answer(*SPRING, **asked)
    measured = answer("support.kind=table", file, **asked)
    assert measured.keys() == springs.keys()
    for key, found in measured.items():
        np.testing.assert_allclose(found.value, springs[key].value, rtol=1e-9)


def test_between_its_points_the_error_covers_what_is_not_known(tmp_path):
    """A coarse table: its answers differ from the springs' by no more than they say."""
    file = table(tmp_path / "s.csv", np.geomspace(10.0, 1000.0, 9))
    exact, found = (
        next(iter(answer(*of).values())) for of in (SPRING, ("support.kind=table", file))
    )
    apart = np.abs(found.value - exact.value)
    assert (apart <= found.error).all()
    assert (apart > 1e-5 * np.abs(exact.value)).any()
    assert (found.error < 0.1 * np.abs(exact.value)).all()


def test_statics_and_modes_take_the_lowest_frequency(tmp_path):
    """And say so; a response alone does not."""
    file = table(tmp_path / "s.csv", [1.0, 2.0, 5.0, 100.0, 500.0, 1000.0])
    asked = {"quantities": "static_tip_displacement,short_circuit_frequencies"}
    plain = [*SPRING[:2], "support.rotational_inertia=0 kg*m^2", SPRING[3]]
    springs, measured = answer(*plain, **asked), answer("support.kind=table", file, **asked)
    for key, found in measured.items():
        np.testing.assert_allclose(found.value, springs[key].value, rtol=1e-6)
    scene, _ = load_scene("paper", ["support.kind=table", file])
    (words,) = request_warnings(scene, ("tmm",), ("short_circuit_frequencies",))
    assert "short_circuit_frequencies takes the support's stiffness at 1 Hz" in words
    assert request_warnings(scene, ("tmm",), ("tip_displacement",)) == ()


def test_without_lateral_columns_the_base_is_held_laterally(tmp_path):
    file = table(tmp_path / "s.csv", [10, 20, 100, 300, 500, 900, 1000], lateral=False)
    stiff = (*SPRING[:3], "support.lateral_stiffness=1e12 N/m")
    exact, found = (
        next(iter(answer(*of).values())) for of in (stiff, ("support.kind=table", file))
    )
    np.testing.assert_allclose(found.value, exact.value, rtol=1e-6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("frequency (Hz),rotational_stiffness_re (N m/rad)\n1,1\n", "give rotational_stiffness_re"),
        ("frequency (Hz),lateral_stiffness_re (N/m),lateral_stiffness_im (N/m)\n1,1,0\n",
         "has no rotational stiffness"),
        ("frequency (Hz),rotational_stiffness_re (N/m),rotational_stiffness_im (N/m)\n1,1,0\n",
         "N"),
    ],
)  # fmt: skip
def test_a_table_that_cannot_be_used_is_refused(tmp_path, text, message):
    path = tmp_path / "s.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        load_scene("paper", ["support.kind=table", f"support.file={path}"])


def test_a_table_that_does_not_hold_at_its_lowest_frequency_has_no_statics(tmp_path):
    """Nor is it a failure; responses are as ever."""
    path = tmp_path / "s.csv"
    rows = ("1,-0.1,0", "2,0.1,0.01", "5,0.2,0.01", "100,0.2,0.01", "500,0.2,0.02", "1e3,0.2,0.03")
    head = "frequency (Hz),rotational_stiffness_re (N m/rad),rotational_stiffness_im (N m/rad)"
    path.write_text("\n".join((head, *rows)), encoding="utf-8")
    scene, _ = load_scene("paper", ["support.kind=table", f"support.file={path}"])
    with pytest.raises(InputError, match=r"no positive real part at its lowest frequency of 1 Hz"):
        request_warnings(scene, ("tmm",), ("static_tip_displacement",))
    assert request_warnings(scene, ("tmm",), ("tip_displacement",)) == ()


def test_a_support_that_gives_energy_away_and_frequencies_outside_are_refused(tmp_path):
    at = [10, 20, 100, 300, 500, 1000]
    with pytest.raises(InputError, match=r"line 2: at 10 Hz the imaginary part .* gives? energy"):
        load_scene("paper", ["support.kind=table", table(tmp_path / "a.csv", at, sign=-1.0)])
    with pytest.raises(InputError, match=r"frequency = 20 Hz is outside the table support\.file"):
        answer("support.kind=table", table(tmp_path / "b.csv", [50, *at[2:], 2000]))
