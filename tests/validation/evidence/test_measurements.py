"""What heavy rows measure, on made-up runs and branches; and cases on their coarsest meshes."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.validation.engine.results import Quantity
from tactgen.validation.evidence.cases import (
    amplitude,
    bimorph,
    iron,
    motion,
    special_beams,
    team20,
)
from tactgen.validation.models.generator import transient as run_phases
from tactgen.validation.models.generator.transient import Phase


@pytest.fixture
def made_phases(monkeypatch):
    """Put given phases in place of those of a run, and of any run."""

    def put(*found):
        monkeypatch.setattr(run_phases, "phases", lambda run: found)
        monkeypatch.setattr(motion, "paper_run", lambda: "run")
        monkeypatch.setattr(motion, "_finger_run", lambda angle=0.0: ("run", angle))
        motion._amplitudes.cache_clear()

    yield put
    motion._amplitudes.cache_clear()


def test_rise_and_fall_are_from_the_switching_to_the_stop(made_phases):
    """The first phase on the stop after it; what rests there at the start does not count."""
    made_phases(
        Phase("pressed", 0.0, 1e-4, 0.0), Phase("falling", 1e-4, 4e-4, 0.0),
        Phase("held", 4e-4, 5.1e-3, 0.0), Phase("rising", 5.1e-3, 5.7e-3, 0.0),
        Phase("pressed", 5.7e-3, 7e-3, 0.0),
    )  # fmt: skip
    assert motion.fall_time() == pytest.approx(4e-4)
    assert motion.rise_time() == pytest.approx(0.7e-3)


@pytest.mark.parametrize(
    ("rising", "falling", "ratio"), [(3e-6, 8e-6, 4.0), (9e-6, 8e-6, 9.0 / 8.0)]
)
def test_flight_over_contact_takes_the_largest_of_each_kind(made_phases, rising, falling, ratio):
    """Over the smaller of both stops; 1 or more where the rising tip moves more."""
    made_phases(
        Phase("held", 0.0, 1.0, 1e-6), Phase("rising", 1.0, 2.0, rising),
        Phase("falling", 2.0, 3.0, falling), Phase("falling", 3.0, 4.0, 1e-6),
        Phase("pressed", 4.0, 5.0, 5e-6), Phase("held", 5.0, 6.0, 2e-6),
    )  # fmt: skip
    assert motion.flight_to_contact() == pytest.approx(ratio)


def test_held_over_pressed_is_by_what_both_runs_share(made_phases, monkeypatch):
    """The smallest held over the largest pressed, without the rest at the start."""
    sizes = {0.0: 1e9, 1.0: 6.0, 2.0: 2.0, 3.0: 5.0, 4.0: 4.0}
    made_phases(*(
        Phase(name, start, start + 0.5, 0.0)
        for name, start in (("pressed", 0.0), ("held", 1.0), ("pressed", 2.0), ("held", 3.0),
                            ("pressed", 4.0), ("rising", 5.0))
    ))  # fmt: skip
    asked = []

    def oscillation(seen, frequency):
        asked.append(([run for run, _, _ in seen], [angle for *_, angle in seen], frequency))
        (start,) = {phase.start for _, phase, _ in seen}
        return sizes[start] * 1j

    monkeypatch.setattr(run_phases, "common_oscillation", oscillation)
    assert motion.held_to_pressed() == pytest.approx(5.0 / 4.0)
    angles = [0.0, 0.5 * np.pi]
    assert asked == 4 * [([("run", angle) for angle in angles], angles, 200.0)]


def test_runs_are_those_of_figure_16(monkeypatch):
    """10 V at 200 Hz, 120 mA on and off at 100 Hz; under the finger for a period and a half."""
    asked = []
    monkeypatch.setattr(motion, "_scene_run", lambda *given: asked.append(given))
    for run in (motion.paper_run, motion._finger_run):
        run.cache_clear()
    motion.paper_run()
    motion._finger_run(0.5)
    for run in (motion.paper_run, motion._finger_run):
        run.cache_clear()
    (alone, until, *_), (sources, longer, _, name, overrides) = asked
    assert (alone.bimorph.amplitude, alone.bimorph.frequency, alone.bimorph.phase) == (
        10.0,
        200.0,
        0.0,
    )
    assert (alone.coil.high, alone.coil.frequency) == (0.12, 100.0)
    assert (sources.bimorph.frequency, sources.bimorph.phase, sources.coil) == (
        200.0,
        0.5,
        alone.coil,
    )
    assert (until, longer) == (7e-3, pytest.approx(1.5 / 100.0))
    assert (name, overrides) == ("generator", ())


@pytest.fixture
def branches(monkeypatch):
    """Put made-up folds, peaks and loaded deflections in place of continued branches."""
    at = lambda *fs: [SimpleNamespace(orbit=SimpleNamespace(frequency=f)) for f in fs]  # noqa: E731
    known = {
        "not activated": (at(500.0, 300.0), at(400.0, 700.0)),
        "held": (at(80.0, 60.0), at(50.0)),
    }
    asked = []

    def head(scene, state, load):
        asked.append((scene, state, load))
        return SimpleNamespace(oscillator=state)

    def loaded(state, load="finger"):
        asked.append((state, load))
        slope = {"held": -3.0, "not activated": 1.5}[state]
        return SimpleNamespace(displacement=np.array([1.0, -3.0j, 2.0]), fitted_slope=slope)

    monkeypatch.setattr(amplitude, "_head", head)
    monkeypatch.setattr(amplitude, "_free", lambda state: state)
    monkeypatch.setattr(amplitude, "folds", lambda oscillator, branch: known[branch][0])
    monkeypatch.setattr(amplitude, "peaks", lambda oscillator, branch, height: known[branch][1])
    monkeypatch.setattr(amplitude, "speed", lambda head: None)
    monkeypatch.setattr(amplitude, "_loaded", loaded)
    return asked


def test_folds_and_peaks_are_those_of_their_state(branches):
    """The lower fold over the upper, in the order of the branch; the first peak of each."""
    assert amplitude.overhang_up() == 0.6
    assert amplitude.overhang_held() == 0.75
    assert amplitude.peaks_up() == 2.0
    assert amplitude.peak_up_over_held() == 8.0
    assert {scene for scene, *_ in branches} == {"paper"}
    assert {load for *_, load in branches} == {"none"}


def test_loaded_deflections_and_their_slopes(branches, monkeypatch):
    """Slopes held and not activated; the extremes of the displacement's size."""
    assert amplitude.slope_held() == -3.0
    assert amplitude.slope_up() == 1.5
    assert amplitude.slope_ratio() == -2.0
    assert amplitude.extreme_deflection("held", "largest") == 3.0
    assert amplitude.extreme_deflection("held", "smallest", "pad") == 1.0
    assert branches[-2:] == [("held", "finger"), ("held", "pad")]
    monkeypatch.setattr(amplitude, "voltage_for", lambda head, *given: given)
    assert amplitude.threshold_voltage_at_end("held") == (1000.0, 1e-6, 50.0)
    assert branches[-1] == ("paper", "held", "finger")


def test_the_peak_of_one_mode_is_found_from_three_points(monkeypatch):
    """Of an oscillator 0.2 % away from the printed frequency, damped like the beam."""
    own, damping = 1.002 * 42.65, 0.02
    monkeypatch.setattr(special_beams, "_deep_beam_at", lambda f: abs(
        1.0 / (own**2 - f**2 + 2j * damping * own**2)))  # fmt: skip
    assert special_beams._deep_beam_peak() == pytest.approx(own, rel=1e-4)


def test_a_stretched_ball_has_the_factor_of_its_shape():
    """A third where it is not stretched; Osborn's on a mesh that errs by percents."""
    assert iron._factor(1.0, 2) == pytest.approx(1.0 / 3.0, rel=0.02)
    assert iron._factor(2.0, 2) == pytest.approx(0.173564, rel=0.05)


def test_two_models_of_a_job_are_apart_by_so_many_of_both_bars(monkeypatch):
    """The largest of all quantities and modes counts."""
    values = {"solid": [10.0, 20.0], "cad": [10.3, 19.0]}

    def get(name, model):
        scale = 1.0 if name == "coupling_factor" else 0.1
        bar = np.full(2, 0.3 if model == "solid" else 0.1)
        return Quantity(
            name=name,
            model=model,
            value=scale * np.array(values[model]),
            unit="1",
            error=bar,
            method="",
            seconds=0.0,
        )

    asked = []
    monkeypatch.setattr(bimorph, "_solved", lambda *given: asked.append(given) or (
        SimpleNamespace(get=get)))  # fmt: skip
    assert bimorph.j1_cad_against_bricks() == pytest.approx(1.0 / 0.4)
    assert asked[0][:2] == ("j1", "solid,cad")


def test_team20_is_read_by_one_potential_or_by_the_mean_of_both(monkeypatch):
    force = {"A": 8.0, "phi": 9.0}

    def states(potential):
        seen = SimpleNamespace(centre=0.5 * force[potential])
        return {1000.0: (SimpleNamespace(force=force[potential]), seen)}

    monkeypatch.setattr(team20, "_states", states)
    assert team20._force(1000.0) == 8.0
    assert team20._best_force(1000.0) == 8.5
    assert team20._flux_density(1000.0, "centre") == 4.0
