"""Calibrations: what they state covers devices that they were not fitted to."""

import numpy as np
import pytest
from scipy.stats import binom

from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks
from tactgen.tmm.beam import calibrated_row, calibrated_section
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence import calibration
from tactgen.validation.evidence.calibration_bimorph import observe, statics
from tactgen.validation.evidence.fit_record import evidence
from tactgen.validation.evidence.judgement import PROMISED, run_parts
from tactgen.validation.evidence.random_devices import clamped_bimorph
from tactgen.validation.scene.load import load_scene


def test_evidence_counts():
    """Medians, shares and the worst device, of numbers known beforehand."""
    left = np.array([[0.01, np.nan], [0.02, 0.1], [0.03, 0.4]])
    found = evidence(("a", "b"), left, np.full((3, 2), 0.025), [["one"], ["two"], ["three"]])
    assert found["errors"]["a"]["median"] == 0.02
    assert found["errors"]["a"]["covered"] == pytest.approx(2.0 / 3.0, rel=1e-4)
    assert found["errors"]["b"]["devices"] == 2
    assert [one["device"] for one in found["worst"]] == ["three", "two", "one"]
    assert found["worst"][0]["of"] == "b"


def test_a_calibration_is_written_where_asked(tmp_path, monkeypatch, capsys):
    """By the command, and into the package only on demand."""
    record = {"devices": 3, "seed": 1, "beyond": {}}
    part = (lambda announce: record), tmp_path / "package.json"
    monkeypatch.setitem(calibration.PARTS, "bimorph", part)
    asked = ["calibrate", "--only", "bimorph", "--out", str(tmp_path)]
    assert main(asked) == 0
    assert (tmp_path / "bimorph.json").exists()
    assert not part[1].exists()
    assert main([*asked, "--install"]) == 0
    assert part[1].read_text() == (tmp_path / "bimorph.json").read_text()
    capsys.readouterr()
    assert main(["calibrate", "--only", "beams"]) == 2
    assert "beams" in capsys.readouterr().err


def test_the_statics_that_are_fitted_are_those_of_a_cantilever():
    """Of a uniform beam: closed forms, whatever the length of the zone at the clamp."""
    from tactgen.tmm.beam.calibrated_section import TheoryChange
    from tactgen.tmm.beam.sections import Section
    from tactgen.validation.evidence.calibration_bimorph import Devices

    length, (ei, ga, k, c) = 0.02, (0.02, 9e4, 3e-5, 8e-7)
    section = Section(*(np.array([v]) for v in (ei, ga, 0.01, 1e-9, k, c)))
    for root in (1e-3, 8e-3):
        at = np.array([length]), np.array([root])
        theory = TheoryChange(*(np.zeros((1, size)) for size in (6, 5, 5, 5, 4)))
        of = Devices((), np.zeros((1, 10)), theory, *at, section, ())
        found = np.exp(statics(np.zeros((1, 6)), of))[0]
        expected = [
            length**3 / (3 * ei) + length / ga, length**2 / (2 * ei), length / ei,
            k * length**2 / (2 * ei), k * length / ei, (c + k**2 / ei) * length,
        ]  # fmt: skip
        np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.heavy
def test_a_device_is_observed_as_before():
    """Seed and number give the same device; clamped, open and sprung frequencies in their order."""
    one, again = observe(5, 3), observe(5, 3)
    assert one.overrides == again.overrides
    np.testing.assert_allclose(one.statics, again.statics, rtol=1e-9)
    assert (one.opened > one.short).all()
    assert one.sprung[0] < one.short[0]


@pytest.mark.heavy
@pytest.mark.parametrize(("part", "devices"), [("calibrated", 60), ("network", 120)])
def test_fresh_devices_are_covered(part, devices):
    """By the modelling errors that the quick models state."""
    (found,) = run_parts("coverage", [part], 11, lambda _: None, devices=devices)
    assert [row.quantity for row in found.rows if not row.holds] == []


@pytest.mark.heavy
def test_higher_modes_are_covered():
    """The fourth and the fifth, of which the error is that of the third times a factor."""
    from tactgen.fem.piezo.modes import natural_modes
    from tactgen.fem.piezo.solid import assemble

    inside = []
    for number in range(60):
        scene, _ = load_scene("prototype", clamped_bimorph(np.random.default_rng([8, number])))
        factors = calibrated_section.section_factors(scene.device, scene.beam)
        if factors.lengthwise < 4:
            continue
        system = assemble(scene.device, bimorph_bricks(scene.device, LEVELS[1]), lossy=False)
        solid = np.array([mode.frequency for mode in natural_modes(system, scene.ends, 5)])
        row = calibrated_row.sections(scene.device, scene.support, scene.beam, factors, lossy=False)
        beam = calibrated_row.bending_frequencies(row, factors, scene.ends, 5, open_circuit=False)
        error = factors.mode_error(5)[3:]
        known = np.isfinite(error)
        inside += (np.abs(beam / solid - 1.0)[3:][known] <= error[known]).tolist()
    assert len(inside) > 30
    assert np.mean(inside) >= PROMISED


@pytest.mark.heavy
def test_resonances_are_covered():
    """Heights of the first resonance, of stiff and soft cores, half of them with losses."""
    inside, ratios = [], []
    for number in range(40):
        rng = np.random.default_rng([13, number])
        overrides = [*clamped_bimorph(rng), f"shim.loss_factor={rng.choice([0.0, 0.05])}"]
        scene, _ = load_scene("prototype", overrides)
        (first,) = solve(scene, ("calibrated",), ("short_circuit_frequencies",)).quantities
        f = float(first.value[0])
        sweep = f"frequency={0.85 * f:.6g}:{1.15 * f:.6g}:9"
        scene, _ = load_scene("prototype", [*overrides, sweep, "mesh.level=2"])
        found = solve(scene, ("calibrated", "solid"), ("tip_displacement",))
        peak, right = (found.get("tip_displacement", m).extreme for m in ("calibrated", "solid"))
        apart = abs(peak.value - right.value)
        inside.append(apart <= peak.expected_error + right.error)
        ratios.append(peak.expected_error / (apart + right.error))
    # fewer would be one draw of twenty, if the share is as promised
    assert sum(inside) >= binom.ppf(0.05, len(inside), PROMISED)
    # a peak's error is that of its own height, not of a slope beside it, which is tens of times it
    # (4.6 of 320 devices; medians of 40 scatter by half of that)
    assert np.median(ratios) <= 7.5
