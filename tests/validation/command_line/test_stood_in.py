"""Commands whose work takes minutes, with stand-ins for it: what they ask, say and return."""

import shlex
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from standin import StandIns

from tactgen.geometry.errors import InputError
from tactgen.validation.checks.row import Check, Outcome
from tactgen.validation.checks.verification import Verified
from tactgen.validation.command_line import progress
from tactgen.validation.command_line.cli import main
from tactgen.validation.studies.whatif.run import Counts


@pytest.fixture
def stand_in(monkeypatch, tmp_path):
    """Return what puts stand-ins into places of validation; their calls are printed in order."""
    monkeypatch.chdir(tmp_path)
    stand_ins = StandIns(monkeypatch, print)

    @contextmanager
    def announcer(stages=()):
        yield lambda text: print(f"… {text}")

    monkeypatch.setattr(progress, "announcer", announcer)
    return lambda place, answer=None: stand_ins(f"validation.{place}", answer)


@pytest.fixture
def told_of(capsys, approved, tmp_path):
    """Return a function that runs calls, a line each, and compares all that they say."""

    def run(*calls):
        said = []
        for call in calls:
            code = main(shlex.split(call))
            out, beside = capsys.readouterr()
            said += [
                f"$ {call}",
                f"exit code {code}",
                out,
                *(f"! {line}" for line in beside.splitlines()),
            ]
        text = "\n".join(said).replace(tmp_path.as_uri(), "file://HERE")
        approved(text.replace(str(tmp_path), "HERE"))

    return run


def test_report(stand_in, told_of):
    """Written with a second process, printed where that is asked; reproduced, or refused."""
    stand_in("report.page:write_report", Path("out/index.html"))
    stand_in("report.page:print_report", Path("out/report.pdf"))
    stand_in("view.browser:need_browser", "chromium")
    rows = [
        SimpleNamespace(
            name=f"number {k}", model="tmm", verdict=verdict, difference=1e-9, over_bars=0.25
        )
        for k, verdict in enumerate(("identical", "within bars", "within bars", "differs"))
    ]
    found = SimpleNamespace(
        scene="paper", rows=rows, holds=False, elsewhere=["numpy: 1 then, 2 now"]
    )
    stand_in("report.provenance.reproduce:reproduce", found)
    calls = [
        "report",
        "report j1 --quick --model tmm --model beam --out there --pdf",
        "report --set load.stiffness=3N/m --set modes=1",
        "report --reproduce there",
    ]
    others = ("--set modes=1", "--model tmm", "--quick", "--pdf", "--out x", "j1")
    told_of(*calls, *(f"report {other} --reproduce there" for other in others))


def test_view(stand_in, told_of):
    """What a look asks; the page is opened where a browser is, and nothing else is."""
    stand_in("export.view:view", [Path("a.html"), Path("b.png")])
    stand_in("command_line.commands.view:webbrowser.open", False)
    stand_in("studies.transient.film:write_film_page")
    many = "--png p.png --gif g.gif --mp4 m.mp4 --state S --field F --frequency 100,200"
    calls = [
        "view",
        "view --open --png p.png",
        f"view j1 --model tmm --model beam {many}",
        "view --lengths 15mm:30mm --out o.html",
        "view --lengths 15mm",
        "view --lengths 1mm:2mm:3mm",
        "view --set load.stiffness=3N/m --frequency 0",
        "view --run r.nc",
        "view --run r.nc --out page.html --open",
        "view --run r.nc --out page.txt",
        "view paper --run r.nc",
        "view --state S --out page.html",
        "view --field F",
    ]
    of_scene = (
        "model tmm",
        "frequency 1",
        "lengths 1mm:2mm",
        "png a.png",
        "gif a.gif",
        "mp4 a.mp4",
        "state S",
        "field F",
        "set modes=1",
    )
    told_of(*calls, *(f"view --run r.nc --{option}" for option in of_scene))


def test_parts(stand_in, told_of):
    """Benchmarks, stress and coverage: which parts, how many, where to; exit code by verdict."""
    row = SimpleNamespace(verdict="holds")
    for command, room in (("bench", "bench"), ("stress", "checks.stress")):
        part = SimpleNamespace(part="tmm", rows=[row], targets=[SimpleNamespace(met=True)])
        stand_in(f"{room}:run_parts", [part])
        stand_in(f"{room}.output:print_{command}")
        stand_in(f"{room}.output:write_{command}", [Path("a.csv"), Path("b.svg")])
    stand_in("command_line.commands.evidence.part_runs:print_json")
    stand_in("command_line.commands.evidence.coverage:print_json")
    stand_in(
        "checks.coverage.run:run_parts", [SimpleNamespace(name="lumped", rows=["row"], holds=False)]
    )
    stand_in("checks.coverage.output:table", "table")
    stand_in("checks.coverage.output:write", [Path("c.csv")])
    calls = [
        f"{command} {options}"
        for command in ("bench", "stress --seed 3")
        for options in ("", "--quick --out there", "--json", "--only tmm --out there --json")
    ]
    known = [
        "coverage --seed 3",
        "coverage --seed 0 --devices 7 --out there",
        "coverage --seed 1 --json",
        "coverage --seed x",
        "stress --seed -1",
        "stress --only tmn --seed 1",
        "coverage --devices 0",
        "coverage --devices 1234567890",
    ]
    told_of(*calls, *known)


def verified(name, verdict):
    check = Check(
        name, "validation", f"what {name} asks", 1.0, "m", "", 0.0, "", float, explained="so"
    )
    outcome = None if verdict == "skipped" else Outcome(check, 1.5e-3, 0.02, verdict)
    return Verified("beams", SimpleNamespace(id="C"), check, outcome)


def test_verify(stand_in, told_of):
    """Groups and extent, the table with reasons and counts, the book; exit code 1 if one fails."""
    rows = [verified(v.upper(), v) for v in ("pass", "explained", "fail", "skipped", "pass")]
    stand_in("checks.verification:verify", rows)
    stand_in("book.book:write_book", Path("there/index.html"))
    told_of(
        "verify",
        "verify --quick --only beams --only coils",
        "verify --heavy --out there",
        "verify --json",
        "verify --only coils --out there --quick",
    )


def test_simulate(stand_in, told_of):
    """What is run, warned of, written: bounces that amplify, no drive, a flange that touches."""
    time = np.array([0.0, 1e-3, 2e-3])
    run = SimpleNamespace(time=time, worst_imbalance=2e-13)
    answer = SimpleNamespace(
        run=run,
        accuracy=0.05,
        error=0.2,
        certain_until=1e-3,
        errors={"rod_lift": 0.1},
        bars={"rod_lift": np.array([0.0, 1e-6, 2e-6]), "lateral_tip": np.array([0.0, 3e-6, 4e-6])},
    )
    scene = SimpleNamespace(name="generator", drive=SimpleNamespace(voltage=50.0))
    found = SimpleNamespace(
        scene=scene,
        answer=answer,
        load_misfit=0.0123,
        sideways=np.array([1e-5, 3e-5, 4e-5]),
        flange_gap=2e-5,
    )
    phase = SimpleNamespace(name="pressed", start=0.0, end=1e-3, amplitude=2e-6)
    values = (np.array([1.0, -2.0, 0.5]), "m", "of the rod")
    stand_in("studies.transient.files:series", {"rod_lift": values})
    for place in (
        "studies.transient.files:write_run",
        "export.run_motion:write_run_steps",
        "export.run_motion:write_run_film",
        "view.films:check_ffmpeg",
    ):
        stand_in(place)
    stand_in("studies.transient.plot:time_plot", "<svg/>")
    # last: when loaded, the modules above import it by its name, and would keep what stands in
    stand_in("models.generator.phases:phases", [phase])
    stand_in("models.generator.transient:run_scene", found)
    files = "--out r.nc --plot p.svg --fields f.pvd --gif g.gif --mp4 m.mp4"
    drives = '--voltage "10 V sine 200 Hz" --coil "5 V step"'
    told_of(
        f"simulate {drives} --until 2ms --accuracy 0.1 {files}",
        "simulate --json",
        "simulate --out r.txt",
        "simulate --fields f.vtu",
        "simulate --until 1ns",
        "simulate --until 11s",
        "simulate --accuracy 1e-7",
        "simulate --accuracy x",
    )


def test_what_nothing_is_wrong_with_is_not_warned_of(stand_in, capsys):
    """A run that is accurate, driven and clear of the sleeve."""
    answer = SimpleNamespace(
        run=SimpleNamespace(time=np.array([0.0, 1e-3]), worst_imbalance=0.0),
        error=0.05,
        certain_until=1e-3,
        bars=dict.fromkeys(("rod_lift", "lateral_tip"), np.zeros(2)),
    )
    still = SimpleNamespace(
        scene=None, answer=answer, load_misfit=0.0, sideways=np.array([0.0, 2e-5]), flange_gap=2e-5
    )
    stand_in("models.generator.phases:phases", [])
    stand_in("models.generator.transient:run_scene", still)
    for drive in (["--voltage", "1 V step"], ["--coil", "1 mA step"]):
        assert main(["simulate", *drive]) == 0
        assert capsys.readouterr().err == ""


def test_samples_of_a_sensitivity(stand_in, told_of):
    """The headline numbers from the parameters' ranges, beside the derivatives."""

    def row(label, **more):
        target = SimpleNamespace(label=label, unit="m", ill_conditioned=bool(more))
        total = {"a": (0.5, 0.1), "b": (0.25, 0.1), "c": (0.125, 0.0), "d": (0.9, 0.0)}
        return SimpleNamespace(
            target=target,
            value=2e-6,
            numerical=1e-9,
            low=1.5e-6,
            high=3e-6,
            standard=1e-7,
            sampled=2e-7,
            worst=4e-7,
            first={"a": (0.4, 0.1)},
            total=total,
            contributors=sorted(((k, s, c) for k, (s, c) in total.items()), key=lambda e: -e[1]),
        )

    stand_in(
        "studies.uncertainty.propagation:parameter_uncertainty", [row("one"), row("two", ill=1)]
    )
    asked = "--key bimorph.length --quantity static_tip_displacement"
    told_of(
        f"sensitivity --sobol {asked}",
        f"sensitivity --sobol --json {asked}",
        "sensitivity reluctance --sobol",
    )


def test_export(stand_in, told_of):
    """Each kind under its own option; nothing asked is refused, and so is what export refuses."""
    stand_in("export.files:export", [Path("a.step"), Path("b.glb")])
    kinds = (
        "step",
        "glb",
        "mesh",
        "map",
        "ports",
        "state-space",
        "fields",
        "animated-glb",
        "fmu",
        "machine",
    )
    told_of(
        "export j1 --set modes=1 " + " ".join(f"--{kind} {kind}.x" for kind in kinds),
        *(f"export --{kind} x" for kind in kinds),
    )
    stand_in("export.files:export", InputError("no room"))
    assert main(["export", "--step", "a.step"]) == 2


def test_whatif(stand_in, told_of, capsys):
    """What a study is run with and written to; warnings that are not shown; how answers came."""
    axis = SimpleNamespace(key="bimorph.length", unit="m")
    counts = Counts(computed=5, recalled=6, failed=7, refused=8, together=2, walked=1)
    made = {
        "statement": SimpleNamespace(
            scene="paper", axes=[axis], columns={"bimorph.length": ("d", [1])}
        ),
        "points": [1, 2, 3],
        "warnings": [f"kind {n}" for n in range(11)],
        "counts": counts,
        "rows": [({"a": 1}, "tmm", answer("ok")), ({"a": 2}, "tmm", answer("failed"))],
    }
    nothing = {
        **made,
        "rows": made["rows"][1:],
        "warnings": made["warnings"][:8],
        "counts": replace(counts, together=0, walked=0),
    }
    for writer in ("netcdf:write_netcdf", "page:write_page", "csv_table:write_tidy"):
        stand_in(f"studies.whatif.shown.{writer}")
    stand_in("studies.whatif.shown.pictures:study_picture", "<svg/>")
    stand_in("studies.whatif.shown.text_table:table_lines", ["the table"])
    stand_in("studies.whatif.aim.best:verdict", "a verdict")
    stand_in("studies.whatif.aim.wording:sentences", ["what is best"])
    stand_in("studies.whatif.aim.wording:as_values", {"best": 1})
    stand_in("studies.whatif.cluster:check_address", "tcp://there:1")
    stand_in("studies.whatif.run:run_study", SimpleNamespace(**made))
    of = "paper --model tmm --vary bimorph.length=14mm:22mm:3 --quantity capacitance_free"
    aim = '--aim "maximise static_tip_displacement"'
    calls = [
        f"whatif {of}",
        f"whatif {of} --jobs 3 --retry {aim} --plot p.svg",
        f"whatif {of} {aim} --json",
        f"whatif {of} --scheduler tcp://there:1 --out made",
        f"whatif {of} --out made",
        f"whatif --out made --resume {aim}",
    ]
    told_of(*calls)
    stand_in("studies.whatif.run:run_study", SimpleNamespace(**nothing))
    assert main(shlex.split(f"whatif {of} --out other")) == 0
    out, beside = capsys.readouterr()
    assert "write_page" not in out  # of no answer there is nothing to show
    assert "more kinds" not in beside
    assert "3 points: 5 answers computed, 6 kept" in beside


def answer(status):
    return SimpleNamespace(status=status, reason="", seconds=0.0, quantities=(), warnings=("w",))
