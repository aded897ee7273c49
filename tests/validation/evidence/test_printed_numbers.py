"""The paper's numbers in checks, designs and reports are those that it prints."""

import pytest

from tactgen.tmm.generator.transient.waveform import Sine, Square
from tactgen.validation.catalogue import detection
from tactgen.validation.evidence.cases.motion import SOURCES
from tactgen.validation.evidence.verification import group_rows
from tactgen.validation.studies import reconstruction as stated

#: References of the validation rows, as printed.
PRINTED = {
    "PAP-1": 750.0, "PAP-2": 0.7,
    "MEAS-1": pytest.approx(24.8e-6), "MEAS-2": pytest.approx(3.1e-6),
    "MEAS-3": pytest.approx(1.164e-8), "MEAS-4": pytest.approx(72.4e-6),
    "MEAS-5": pytest.approx(13.6e-6), "MEAS-6": pytest.approx(3.441e-8),
    "MEAS-7": (7.5, 8.5), "MEAS-8": (2.5, 3.5), "MEAS-9": (2.5, 4.0),
}  # fmt: skip


def test_references_of_the_validation_rows():
    """Every number of the paper that a row is held against."""
    rows = {c.id: c for c in (*group_rows("bimorph"), *group_rows("reluctance"))}
    assert {name: rows[name].reference for name in PRINTED} == PRINTED
    assert {row.id for row in group_rows("bimorph") if row.tier == "validation"} == set(PRINTED)
    force = next(c for c in group_rows("reluctance") if c.source == "paper section 5.1")
    assert (force.reference, force.unit) == (0.110, "N")
    assert force.tolerance == pytest.approx(0.5 / 110.0)


def test_references_of_the_rocking_head():
    """Figs 14 to 17 as printed; what the paper only says has a range or a count."""
    rows = {c.id: c.reference for c in group_rows("amplitude") if c.tier == "validation"}
    printed = [rows[f"ROCK-{number}"] for number in range(7, 19)]
    assert printed == [
        3.441e-8, 1.164e-8, 24.8e-6, 3.1e-6, 72.4e-6,
        13.6e-6, (2.5, 4.0), (2.5, 4.0), 24.8e-6, 3.1e-6, 72.4e-6, 13.6e-6,
    ]  # fmt: skip


def test_threshold_and_stated_voltages():
    """Section 6 and Fig 17: amplitudes at the threshold, voltages at which it was felt."""
    points = [(p.frequency, p.amplitude) for p in detection.DISPLAY_THRESHOLD.points]
    assert points == [(10.0, 2e-6), (250.0, 0.2e-6), (1000.0, 1e-6)]
    bound = detection.LITERATURE_BOUND
    assert (bound.frequency, bound.amplitude) == (100.0, 1e-6)
    stated = [(v.frequencies, v.voltages) for v in detection.STATED_VOLTAGES]
    assert stated == [
        ((10.0, 10.0), (8.0, 8.0)), ((100.0, 100.0), (11.0, 11.0)),
        ((250.0, 250.0), (3.0, 3.0)), ((250.0, 1000.0), (2.5, 4.0)),
    ]  # fmt: skip
    highest = detection.HIGHEST_SUBJECT
    assert (highest.frequencies, highest.voltages) == ((75.0, 75.0), (22.0, 22.0))


def test_flux_densities_of_team_20():
    """Table 4 of COMPEL 14 (1995) 57, place by place from 1000 to 5000 ampere-turns."""
    rows = [c for c in group_rows("reluctance") if c.id.startswith("TEAM20-B")]
    printed = {
        "below the pole's centre": (0.36, 0.84, 0.99, 1.03),
        "below its corner": (0.24, 0.63, 0.72, 0.74),
        "section of the pole": (0.72, 1.75, 2.01, 2.05),
        "yoke's leg": (0.13, 0.36, 0.43, 0.46),
    }
    for place, values in printed.items():
        assert tuple(c.reference for c in rows if place in c.requirement) == values


def test_states_of_the_normal_actuator():
    """Section 5.1: gap, force and currents in pulling in, holding and driving."""
    assert (stated.GAP, stated.FORCE) == (0.2e-3, 0.11)
    currents = stated.PULL_IN, stated.HELD, stated.DRIVEN
    assert currents == (0.13, 0.05, 0.12)
    assert (stated.OUTER_DIAMETER, stated.TOTAL_HEIGHT) == (2.3e-3, 41e-3)


def test_drives_of_the_sequence():
    """Section 2: 10 V at 200 Hz on the bimorph, 120 mA at 100 Hz, on and off, in the coil."""
    drive, square = SOURCES.bimorph, SOURCES.coil
    assert (drive, square) == (Sine(10.0, 200.0), Square(0.12, 100.0))
