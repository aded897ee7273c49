"""Waveforms as they are written, and one sentence for each that cannot be read."""

import itertools
import math
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ideal_gap import IdealGap

from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.system import Coil, Element, Output, Stop, System
from tactgen.tmm.generator.transient.time_integration import simulate
from tactgen.tmm.generator.transient.waveform import Chirp, Sampled, Sine, Sources, Square, Step
from tactgen.validation.models.transient import scene_machine
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies.waveform_text import AMPERES, VOLTS, parsed


@pytest.mark.parametrize(
    ("text", "waveform"),
    [
        ("10 V", Step(10.0)),
        ("-5 mA constant", Step(-5e-3)),
        ("10V sine 0.2 kHz phase 90 deg delay 1 ms", Sine(10.0, 200.0, math.pi / 2, 1e-3)),
        ("1 V square 100 Hz low -1 V duty 0.25", Square(1.0, 100.0, -1.0, 0.25)),
        ("5 V step at 1 ms until 3 ms", Step(5.0, 1e-3, 3e-3)),
        ("1 V chirp 10 Hz to 1 kHz in 20 ms", Chirp(1.0, 10.0, 1000.0, 20e-3)),
        ("drive.csv", Sampled((0.0, 1e-3, 1e-3, 2e-3), (0.0, 0.05, 0.0, 0.01))),
    ],
)
def test_waveforms_are_read(text, waveform, tmp_path, monkeypatch):
    """The unit says what the coil is driven by; samples are read from a file."""
    monkeypatch.chdir(tmp_path)
    Path("drive.csv").write_text("time (ms), current (mA)\n0, 0\n1, 50\n1, 0  # off\n2, 10\n")
    found, amperes = parsed(text, "--coil", (AMPERES, VOLTS)), "mA" in text or ".csv" in text
    assert (found.waveform, found.of) == (waveform, "current" if amperes else "voltage")
    with pytest.raises(InputError, match="is not a level in volts or amperes"):
        parsed("10 kg", "--coil", (VOLTS, AMPERES))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("time (s), current (A)\n0, 1\n", r"is unknown; .* like time \(s\) and voltage \(V\)"),
        ("time (s), voltage (kg)\n0, 1\n", "not that of a voltage"),
        ("time (s), voltage (V)\n0, 0\n2, 0\n3, 0\n1, 0\n", "line 5: time = 1 s is negative"),
        ("time (s), voltage (V)\n", "no rows"),
    ],
)
def test_files_that_are_no_waveform_get_one_sentence(tmp_path, content, words):
    path = tmp_path / "drive.csv"
    path.write_text(content)
    with pytest.raises(InputError, match=words) as refused:
        parsed(str(path), "--voltage", (VOLTS,))
    assert str(refused.value).startswith(f"--voltage {path}")


LEVELS = st.tuples(
    st.one_of(st.floats(-1e7, 1e7), st.sampled_from([0.0, 1e-12, float("inf"), float("nan")])),
    st.sampled_from(["V", "mV", "kV", "mA", "A", "Hz", "kg", ""]),
).map(lambda pair: f"{pair[0]:g} {pair[1]}")
SIZES = st.floats(-1.0, 1e9).map("{:.3g}".format)
OPTIONS = st.tuples(
    st.sampled_from(["phase", "delay", "low", "duty", "at", "until", "to", "in", "sine", "later"]),
    st.one_of(LEVELS, SIZES),
    st.sampled_from(["ms", "s", "Hz", "kHz", "deg", "V", ""]),
).map(" ".join)
TEXTS = st.one_of(
    st.text(max_size=30),
    st.tuples(
        LEVELS, st.sampled_from(["constant", "sine", "square", "step", "chirp", "saw", ""]),
        SIZES, st.sampled_from(["Hz", "kHz", "ms", ""]),
        st.lists(OPTIONS, max_size=3).map(" ".join),
    ).map(" ".join),
)  # fmt: skip


@given(TEXTS)
def test_whatever_is_written_gives_a_waveform_or_one_sentence(text):
    """Any words of the grammar in any order: finite values between its breaks, or why not."""
    refused = ""
    try:
        waveform = parsed(text, "--coil", (AMPERES, VOLTS)).waveform
        edges = [0.0, *waveform.breaks(0.01), 0.01]
    except InputError as error:
        refused = str(error)
    if refused:
        assert "\n" not in refused
        return
    assert edges == sorted(edges)
    for a, b in itertools.islice(itertools.pairwise(edges), 50):
        middle = 0.5 * (a + b)
        values = [waveform.value(t, middle) for t in (a, middle, b)]
        assert all(abs(v) <= waveform.peak * (1.0 + 1e-12) for v in values)
    assert waveform.shortest > 0.0


HERTZ = st.integers(1, 2000).map("{} Hz".format)
MILLISECONDS = st.integers(0, 6).map(lambda k: f"{0.1 * k:.1f} ms")


@st.composite
def drives(draw, unit, most):
    """Return a waveform's text that can be read: any level up to `most`, any kind, any option."""
    level = most * draw(st.integers(-100, 100)) / 100.0
    kind = draw(st.sampled_from(["constant", "sine", "square", "step", "chirp"]))
    text = f"{level:g} {unit} {kind}"
    if kind in ("sine", "square", "chirp"):
        text += f" {draw(HERTZ)}"
    if kind == "chirp":
        return f"{text} to {draw(HERTZ)} in {draw(st.integers(1, 30)) / 10.0:g} ms"
    options = {
        "constant": [],
        "sine": [f"phase {draw(st.integers(-360, 360))} deg", f"delay {draw(MILLISECONDS)}"],
        "square": [
            f"low {most * draw(st.integers(-100, 100)) / 100.0:g} {unit}",
            f"duty {draw(st.integers(1, 99)) / 100.0:g}",
            f"delay {draw(MILLISECONDS)}",
        ],
        "step": [f"at {draw(MILLISECONDS)}", "until 0.7 ms"],
    }[kind]
    text += "".join(f" {option}" for option in options if draw(st.booleans()))
    return text


def moved_or_refused(system, position, voltage, coil):
    """Run 0.5 ms; the balance holds and all is finite, or one sentence says why there is none."""
    sources = Sources(
        parsed(voltage, "--voltage", (VOLTS,)).waveform, parsed(coil, "--coil", (AMPERES,)).waveform
    )  # what is drawn can be read
    refused, found = "", None
    try:
        found = simulate(system, sources, 5e-4, position=position, accuracy=0.5)
    except InputError as error:
        refused = str(error)
    if found is None:
        assert refused
        assert "\n" not in refused
        return
    assert all(np.isfinite(values).all() for values in found.outputs.values())
    assert found.run.worst_imbalance < 1e-10


@settings(max_examples=5)
@given(drives("V", 1e3), drives("A", 1.0))
def test_any_drive_moves_a_mass_between_a_coil_and_a_stop(voltage, coil):
    """An ideal gap of 1 mm, a stop, a piezoelectric push."""
    one = np.eye(1)
    gap = Coil(IdealGap(1e-6), -one[0], 1e-3, 1.0, "current", 1e-4, 2.0, (1e-4, 2e-3))
    system = System(
        1e-3 * one, 1e-3 * one, 100.0 * one, 0.0 * one[0], 1e-3 * one[0], 1e-9,
        (Element("stop", Stop(1e4), one[0], -1e-4),), (), gap,
        {"x": Output(one[0], "m", 1e-4)},
    )  # fmt: skip
    moved_or_refused(system, np.zeros(1), voltage, coil)


@pytest.mark.heavy
@settings(max_examples=25)
@given(drives("V", 200.0), drives("A", 0.3))
def test_any_drive_moves_the_machine_or_is_refused(voltage, coil):
    """Up to 200 V and 0.3 A, free tip."""
    machine = free_machine()
    moved_or_refused(machine.system, machine.rest, voltage, coil)


@lru_cache(maxsize=1)
def free_machine():
    scene, _ = load_scene("generator", ["load.kind=none"])
    return scene_machine(scene, coil="current", volts=10.0)


def test_what_switches_too_often_is_refused_before_it_is_tried():
    """No list of a thousand million times, and no march of a thousand million steps."""
    for text in ("1 V square 10 MHz", "1 V sine 10 MHz"):
        drive = parsed(text, "--voltage", (VOLTS,)).waveform
        one = np.eye(1)
        system = System(one, one, one, one[0], one[0], outputs={"x": Output(one[0], "m", 1.0)})
        with pytest.raises(InputError, match="ask for a shorter time"):
            simulate(system, Sources(drive), 10.0)
