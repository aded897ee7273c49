"""The length map, its minima, the optimiser and what the optimum rests on."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from tactgen.geometry.errors import InputError
from tactgen.tmm.ports import finger_and_pad as finger
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD, ThresholdCurve
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.variation import value_of, with_values
from tactgen.validation.studies.identify import fit_parameter
from tactgen.validation.studies.length_design import (
    PAPER_LENGTHS,
    Aim,
    check_range,
    dependences,
    design,
    largest_margin,
    lowest_margin,
)
from tactgen.validation.studies.length_design_output import length_plot, sentences
from tactgen.validation.studies.length_map import actuator, length_map, local_minima, tip_amplitude

BAND = (10.0, 1000.0)
#: From well below to above the paper's lengths: m is decided by the band's end, then a minimum.
SHORTER = (10e-3, 40e-3)
PROFILE = "bimorph.width_profile=0 mm: 2.1 mm, 20 mm: 1 mm"
KINDS = [
    ("paper", []),
    ("paper", ["bimorph.wiring=series"]),
    ("paper", ["bimorph.tab_length=2mm"]),
    ("paper", ["support.kind=clamped", "load.kind=none"]),
    ("bimorph_on_rod", []),
]


#: Limited by the band's start, by its end, and by a minimum inside.
WIDE = Aim(lengths=(2e-3, 40e-3))


@pytest.fixture(scope="module")
def paper():
    return load_scene("paper")


@pytest.fixture(scope="module")
def found(paper):
    """The paper's design over the paper's lengths."""
    return design(paper[0], Aim())


def solved(scene, length, frequencies):
    """|w_tip| (m) by the route that `tactgen solve` takes."""
    changed = with_values(scene, {"bimorph.length": length})
    changed = changed.model_copy(update={"frequency": tuple(np.atleast_1d(frequencies).tolist())})
    return np.abs(solve(changed, ("tmm",), ("tip_displacement",)).quantities[0].value)


@pytest.mark.parametrize(("name", "overrides"), KINDS)
def test_map_is_what_solve_gives(name, overrides):
    """Every support, wiring and row of pieces: the map equals single solutions."""
    scene, _ = load_scene(name, overrides)
    lengths, f = np.array([12e-3, 20e-3, 37e-3]), np.geomspace(*BAND, 7)
    found = tip_amplitude(actuator(scene), lengths[:, None], f)
    expected = np.array([solved(scene, length, f) for length in lengths])
    # the same equations, balanced or not before they are solved: condition below 1e5
    assert found == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize(("length", "frequency"), [(20e-3, 934.0), (40e-3, 315.0)])
def test_minimum_of_each_length(paper, length, frequency):
    """Rounded reference values, and bounded Brent on |w|² in ln f along another route."""
    (found,) = length_map(paper[0], np.array([length]), BAND).minima
    assert round(found.frequency) == frequency

    def square(log_f):
        return float(solved(paper[0], length, np.exp(log_f))[0] ** 2)

    around = np.log(frequency) + np.array([-0.05, 0.05])
    brent = minimize_scalar(square, bounds=tuple(around), method="bounded", options={"xatol": 1e-9})
    # a smooth minimum cannot be located better than to the root of rounding
    assert found.frequency == pytest.approx(np.exp(brent.x), rel=1e-6)
    assert found.displacement == pytest.approx(np.sqrt(brent.fun), rel=1e-9)


def test_minimum_law_of_a_slender_clamped_beam(paper, found):
    """Limit: thin, clamped, free tip: all frequencies of Euler-Bernoulli go as 1/length².

    Where another minimum becomes the deepest, no exponent is stated and it is still drawn.
    """
    scene, _ = load_scene(
        "paper",
        ["support.kind=clamped", "load.kind=none", "bimorph.piezo_thickness=2.6um",
         "bimorph.shim_thickness=2.5um"],
    )  # fmt: skip
    study = length_map(scene, np.linspace(10e-3, 12e-3, 5), (60.0, 200.0))
    exponent, misfit = study.minimum_law
    # shear and rotary inertia are of order (thickness/length)² = 6e-7, their factors about 10
    assert exponent == pytest.approx(-2.0, abs=1e-5)
    assert misfit < 1e-6
    study = length_map(paper[0], np.array([1e-3, 20e-3, 40e-3, 80e-3]), BAND)
    assert study.minimum_law is None
    assert length_plot(study, found).startswith("<svg")


def test_every_minimum_is_found():
    """Known function: cos has its minima at odd multiples of pi; here it also ends in one."""
    f = np.linspace(1.0, 20.0, 60)
    rows, where, lowest = local_minima(
        f, np.cos(np.vstack([f, f + 1.0])), lambda r, x: np.cos(x + r[:, None])
    )
    assert rows.tolist() == [0, 0, 0, 0, 1, 1, 1, 1]
    inner = np.array([0, 1, 2, 4, 5, 6])
    expected = np.pi * np.array([1, 3, 5, 1, 3, 5]) - rows[inner]
    assert where[inner] == pytest.approx(expected, rel=1e-7)
    # located to 4e-7 of the bracket of 0.7, and the error is of second order
    assert lowest[inner] == pytest.approx(-np.ones(6), abs=1e-12)
    assert where[[3, 7]].tolist() == [20.0, 20.0]
    for at in (1.1, 19.9):  # a dip beside an end, where the grid only sees a slope

        def dip(rows, x, at=at):
            return np.abs(x - at) + 0.0 * rows[:, None]

        _, where, lowest = local_minima(f, dip(np.zeros(1), f), dip)
        assert where[-1] == pytest.approx(at, rel=1e-7)
        assert lowest[-1] < 1e-6


def test_lowest_margin_is_the_lowest(paper):
    """Against 20000 frequencies; the refined value may only be lower, by the grid's error."""
    device, aim = actuator(paper[0]), Aim()
    f = np.geomspace(*BAND, 20001)
    for length in (10e-3, 20e-3, 30e-3):
        dense = tip_amplitude(device, np.array(length), f) / DISPLAY_THRESHOLD.at(f)
        margin, at = lowest_margin(device, aim, np.array([length]))
        assert margin[0] <= dense.min() * (1 + 1e-12)
        assert margin[0] == pytest.approx(dense.min(), rel=1e-4)
        assert at[0] == pytest.approx(f[np.argmin(dense)], rel=1e-3)


@pytest.mark.parametrize(
    ("name", "overrides", "margin"),
    [
        # all margins for the first kind, one each for the second and the last
        *(pytest.param(*kind, margin, marks=[pytest.mark.heavy]
                       if n and (n, m) not in ((1, 0), (3, 2)) else [])
          for n, kind in enumerate(KINDS[:4]) for m, margin in enumerate((0.5, 1.0, 2.0))),
        pytest.param("bimorph_on_rod", [], 0.2, marks=pytest.mark.heavy),
    ],
)  # fmt: skip
def test_intervals_are_exactly_the_feasible_lengths(name, overrides, margin):
    """The margin is reached at each crossing, kept inside the intervals and nowhere else."""
    scene, _ = load_scene(name, overrides)
    aim = Aim(margin=margin, lengths=(14e-3, 28e-3))
    found, device = design(scene, aim), actuator(scene)
    if found.crossings:
        ends = np.array([length for length, _ in found.crossings])
        # to 1e-6 in length, times a slope of m that stays below 100
        assert lowest_margin(device, aim, ends)[0] == pytest.approx(margin, rel=1e-4)
    inside = np.zeros(found.lengths.shape, dtype=bool)
    for interval in found.intervals:
        inside |= (found.lengths >= interval.shortest) & (found.lengths <= interval.longest)
    assert (inside == (found.margins >= margin)).all()
    assert (found.limit == "compromise") == (not found.intervals)
    if found.intervals:
        assert found.length == found.intervals[0].shortest
    else:
        assert found.margin == pytest.approx(found.margins.max(), rel=0.02)
        assert found.margin >= found.margins.max()


@pytest.fixture(scope="module")
def brute_force(paper):
    """1200 lengths from 3 to 130 mm, 0.3 % apart, and m of each."""
    lengths, device = np.geomspace(3e-3, 130e-3, 1200), actuator(paper[0])
    parts = (lowest_margin(device, Aim(), part)[0] for part in np.array_split(lengths, 10))
    return lengths, np.concatenate([*parts])


@pytest.mark.heavy
@pytest.mark.parametrize(("margin", "number"), [(1.12, 4), (1.0, 3), (0.69, 3), (3.52, 2)])
def test_no_gap_is_missed_over_a_wide_range(paper, brute_force, margin, number):
    """Against brute force: every interval of feasible lengths, and every gap, however narrow.

    At 1 the second gap is 9 % of a length wide; 0.69 and 1.12 cut the tips of dips of m that
    reach 0.681 and 1.104, 3.52 that of a peak of 3.524.
    """
    lengths, margins = brute_force
    edges = np.flatnonzero(np.diff(np.pad(margins >= margin, 1).astype(int)))
    aim = Aim(margin=margin, lengths=(lengths[0], lengths[-1]))
    found = design(paper[0], aim).intervals
    assert len(found) == len(edges) // 2 == number
    step = lengths[1] / lengths[0]
    for interval, first, after in zip(found, edges[::2], edges[1::2], strict=True):
        # the brute force knows an end to one of its own steps
        assert lengths[first] / step <= interval.shortest <= lengths[first]
        assert lengths[after - 1] <= interval.longest <= lengths[after - 1] * step


@pytest.mark.parametrize(
    "lengths", [(19.9999e-3, 20.0001e-3), pytest.param((1e-3, 270e-3), marks=pytest.mark.heavy)]
)
def test_the_scenes_own_length_is_judged_once(paper, lengths):
    """Sentence on the scene's 20 mm (margin below 1) and list of intervals never disagree."""
    found = design(paper[0], Aim(lengths=lengths))
    own = paper[0].bimorph.length
    assert own in found.lengths
    assert found.present[0] < 1.0
    assert not any(i.shortest <= own <= i.longest for i in found.intervals)


def test_lengths_that_cannot_be_had_are_refused():
    """One sentence with the remedy; never the same answer for every length."""
    patch = "bimorph.layers=brass 0.2 mm; PZT-5A 0.2 mm from 3 mm to 19 mm +x"
    scene, _ = load_scene("paper", ["support.kind=clamped", patch])
    with pytest.raises(InputError, match=r"end below a layer of .*; start at 19 mm or more"):
        design(scene, Aim(lengths=SHORTER))


def test_the_remedies_are_accepted(paper):
    """What the refusals of a range propose, 0.77 mm or more, up to 274 mm, above the bare end, is
    answered: its margin can be had at both ends."""
    bare, _ = load_scene("paper", ["bimorph.bare_above=12mm"])
    for scene, lengths in ((paper[0], (0.77e-3, 274e-3)), (bare, (12.1e-3, 40e-3))):
        device, aim = actuator(scene), Aim(lengths=lengths)
        check_range(device, aim)
        assert np.isfinite(lowest_margin(device, aim, np.array(lengths))[0]).all()


def test_map_and_fit_refuse_what_the_ceramic_cannot_be():
    """The map of single lengths has the same limits; fitting the length meets the same profile."""
    scene, _ = load_scene("paper", [PROFILE])
    with pytest.raises(InputError, match="leave the profile out"):
        length_map(scene, np.array([10e-3]), BAND)
    with pytest.raises(InputError, match=r"bimorph\.width_profile is stated for 20 mm"):
        fit_parameter(scene, "bimorph.length")
    assert fit_parameter(load_scene("paper")[0], "bimorph.length").start == 20e-3


def test_curves_pass_through_their_minima(paper):
    """What is plotted is what is stated: each dot lies on its curve, which goes no lower.

    And straight lines in log-log between the points are |w|: beside a dip, where |w| goes as
    the distance x from it and x doubles from point to point, log x is missed by up to
    log10(3 / 2^1.5) = 0.0256 decades, half a line's width in the plot; a fifth is added for |w|
    not being quite straight there.
    """
    study = length_map(paper[0], np.array([20e-3, 40e-3]), BAND)
    for curve, minimum in zip(study.displacement, study.minima, strict=True):
        at = np.flatnonzero(study.frequencies == minimum.frequency)
        assert curve[at] == pytest.approx([minimum.displacement], rel=1e-9)
        assert curve.min() >= minimum.displacement * (1.0 - 1e-9)
    f, drawn = study.frequencies, np.log10(study.displacement)
    between = tip_amplitude(actuator(paper[0]), study.lengths[:, None], np.sqrt(f[1:] * f[:-1]))
    assert np.abs(np.log10(between) - 0.5 * (drawn[:, 1:] + drawn[:, :-1])).max() < 1.2 * 0.0256


def test_the_papers_range(found):
    """20 to 40 mm: 22.64 mm keep the threshold, 20 mm miss it beside the minimum at 934 Hz."""
    assert found.aim.lengths == PAPER_LENGTHS == (20e-3, 40e-3)
    assert (found.warnings, found.limit) == ((), "threshold")
    assert found.margin == pytest.approx(1.0, rel=1e-6)
    assert 22e-3 < found.length < 23e-3
    assert found.present[0] < 1.0
    assert 900.0 < found.present[1] < 970.0


@pytest.fixture(scope="module")
def rows(paper):
    """Sensitivities of the paper's design over a wide range, by key."""
    return {row.key: np.array(row.slopes) for row in dependences(design(paper[0], WIDE), paper[1])}


@pytest.mark.parametrize(
    "key",
    [
        "support.rotational_stiffness",
        *(
            pytest.param(key, marks=pytest.mark.heavy)
            for key in ("piezo.density", "bimorph.width", "piezo.quality_factor", "piezo.d31",
                        "drive.voltage", "shim.youngs_modulus")
        ),
    ],
)  # fmt: skip
def test_implicit_sensitivity_is_that_of_designing_again(paper, rows, key):
    """Implicit function theorem against all three limits found anew with the parameter ±1 %."""
    scene, _ = paper
    again = slopes_again(
        [design(with_values(scene, {key: value_of(scene, key) * s}), WIDE) for s in (1.01, 0.99)]
    )
    # the chord over ±1 % differs from the tangent by 1e-4 of slopes' size; crossings are
    # found to 1e-9, over 2e-2
    assert rows[key] == pytest.approx(again, rel=1e-3, abs=1e-5)


def slopes_again(designs):
    """d ln l / d ln p of every crossing, from two designs with a parameter ±1 %."""
    up, down = (np.array([length for length, _ in d.crossings]) for d in designs)
    assert up.size == down.size == 3
    return np.log(up / down) / np.log(1.01 / 0.99)


def test_finger_sensitivity(paper, rows, monkeypatch):
    """A factor on the finger's whole impedance is one on its stiffness and one on its damping."""
    designs, impedance = [], finger.finger_impedance
    for s in (1.01, 0.99):
        with monkeypatch.context() as changed:
            changed.setattr(finger, "finger_impedance", lambda f, s=s: s * impedance(f))
            designs.append(design(paper[0], WIDE))
    found = rows["load.stiffness"] + rows["load.damping"]
    assert found == pytest.approx(slopes_again(designs), rel=1e-3, abs=1e-5)


def test_threshold_sensitivity(paper, found):
    """A threshold higher by x % throughout is a voltage lower by x %: exact identity."""
    scene, origins = paper
    slopes = {row.key: row.slopes[0] for row in dependences(found, origins)}
    points = sum(slopes[f"threshold at {f} Hz"] for f in (10, 250, 1000))
    assert points == pytest.approx(-slopes["drive.voltage"], rel=1e-9)
    *others, last = DISPLAY_THRESHOLD.points
    moved = (replace(last, amplitude=s * last.amplitude) for s in (1.01, 0.99))
    aims = [Aim(threshold=ThresholdCurve((*others, point))) for point in moved]
    up, down = (design(scene, aim).length for aim in aims)
    again = np.log(up / down) / np.log(1.01 / 0.99)
    assert slopes["threshold at 1000 Hz"] == pytest.approx(again, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("prototype", "piezo.density"),
        *(pytest.param(*of, marks=pytest.mark.heavy) for of in (
            ("paper", "piezo.density"), ("paper", "support.rotational_stiffness"),
            ("prototype", "bimorph.piezo_thickness"))),
    ],
)  # fmt: skip
def test_sensitivity_of_the_largest_margin(name, key):
    """A smooth maximum (paper) and one where the deciding frequency jumps (prototype).

    Against the length found again with the parameter ±1 %.  Voltage and the threshold's
    level cannot move a maximum.
    """
    scene, origins = load_scene(name)
    found = design(scene, Aim(kind="margin", lengths=SHORTER))
    rows = {row.key: row for row in dependences(found, origins)}
    column = [length for length, _ in found.decided].index(found.length)
    around = 0.95 * found.length, 1.05 * found.length
    up, down = (
        largest_margin(
            actuator(with_values(scene, {key: value_of(scene, key) * s})), found.aim, around
        )
        for s in (1.01, 0.99)
    )
    again = np.log(up / down) / np.log(1.01 / 0.99)
    # the peak is found to 1e-7, over 2e-2; slopes beside a jump are off by 1e-3 of themselves
    assert rows[key].slopes[column] == pytest.approx(again, rel=5e-3, abs=1e-4)
    # roundings of 2e-11 in either slope, over a slope by the length that changes by 7e-3
    assert rows["drive.voltage"].slopes[column] == pytest.approx(0.0, abs=5e-9)
    level = sum(rows[f"threshold at {f} Hz"].slopes[column] for f in (10, 250, 1000))
    assert level == pytest.approx(0.0, abs=1e-9)


def test_an_end_of_the_range_or_a_compromise_is_called_so(paper):
    """From 10 mm on the threshold does not decide; that is said, and nothing is differentiated.

    Of a margin that no length keeps the largest one is said.
    """
    scene, origins = paper
    found = design(scene, Aim(lengths=(12e-3, 16e-3)))
    assert (found.length, found.limit) == (12e-3, "end")
    assert dependences(found, origins) == ()
    assert "The range limits the length" in sentences(found)[1]
    found = design(scene, Aim(margin=50.0))
    assert (found.limit, found.intervals) == ("compromise", ())
    assert sentences(found)[1].startswith("No length of 20 mm to 40 mm meets |w| / threshold ≥ 50")
