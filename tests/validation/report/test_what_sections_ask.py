"""What sections ask of long calculations, and what they leave out: with stand-ins for these."""

from types import SimpleNamespace

import numpy as np
import pytest
from approved import described
from standin import StandIns, told

from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.readout import ModalReadout
from tactgen.validation.report.sections import bimorph, bridge, contents, gallery, large_motion
from tactgen.validation.report.sections.section import Section
from tactgen.validation.report.study import Apart
from tactgen.validation.scene.scene import Scene, load_scene


def with_frequencies(value):
    """Return a scene with what sections change of it."""
    if isinstance(value, Scene):
        support = f"{value.support.kind}, {value.support.lateral_stiffness:g} N/m"
        frequency = ",".join(f"{f:g}" for f in value.frequency[:6])
        return f"scene {value.name} of {value.piezo.material}, {support}, at {frequency}"
    return told(value)


@pytest.fixture
def said():
    return []


@pytest.fixture
def stand_in(monkeypatch, said):
    stand_ins = StandIns(monkeypatch, said.append, with_frequencies)
    return lambda place, answer=None: stand_ins(f"validation.{place}", answer)


@pytest.fixture
def study(said):
    """Return what makes a study of a scene, as far as sections ask it."""

    def make(name, *settings, quick=False, **more):
        scene, origins = load_scene(name, settings)
        plain = {
            "scene": scene,
            "origins": origins,
            "quick": quick,
            "rungs": ["rung"],
            "solids": "solids",
            "chain": None,
            "announce": lambda text: said.append(f"… {text}"),
            "asks_field": True,
            "lateral": True,
            "normal": None,
            "shown_mesh": None,
            "elsewhere": None,
            "solution": SimpleNamespace(),
            "alone": lambda name, here: said.append(f"alone {name}") or here(),
        }
        return SimpleNamespace(**{**plain, **more})

    return make


def test_the_bridge_and_what_stands_beside_it(stand_in, study, said, approved, monkeypatch):
    """Two materials, ends, widths and steps at five frequencies, of a whole report alone."""
    stand_in("models.bimorph.bridge:bridge", ["rung of another"])
    stand_in("models.bimorph.bridge.end_effect:end_effect", "ends")
    stand_in("models.bimorph.bridge.width:width_study", "widths")
    stand_in("report.sections.bridge:bridge_plot", "plot")

    def steps(scene, names, announce, solids):
        """Two that go together, the second of modes, and one that has no value."""
        said.append(f"> stepped {with_frequencies(scene)} on {solids}: {' '.join(names)}")
        count = len(scene.frequency)

        def step(name, together, read=None):
            return SimpleNamespace(
                is_untouched=name == "moved_by_none",
                steps=("start", "one", "two"), row=SimpleNamespace(name=name, read=read),
                goes_with=lambda other: "a_b" in (name, other.row.name) and name != "none",
                together=together, shares=np.arange(2.0 * count).reshape(2, count),
                values=[None, 1e3 + np.arange(count)],
            )  # fmt: skip

        some = np.where(np.arange(count) % 2, np.nan, 0.1)
        modal = ModalReadout(("short",))
        return [step("a_b", some), step("c", some), step("modes", some + 1.0, modal),
                step("none", np.nan * some), step("moved_by_none", some)]  # fmt: skip

    monkeypatch.setattr("tactgen.validation.models.bimorph.bridge.stepped.stepped", steps)
    scenes = (
        ("paper", "frequency=10:900:9"),
        ("paper", "frequency=20", "piezo.d31=-100pC/N"),
        ("j1", "bimorph.glue_thickness=10um", "piezo.material=M1876", "frequency=1,2"),
    )
    for scene in scenes:
        for quick in (True, False):
            said.append(described(bridge.bridge_section(study(*scene, quick=quick))))
    said.append(described(bridge.bridge_section(study("paper", rungs=None))))
    approved("\n".join(said))


def test_what_holds_the_bimorph(stand_in, study, said, approved):
    """The way into the rod, or why there is none; nothing in a quick report."""
    stand_in("report.sections.bridge:bridge_plot", "plot")
    stand_in("report.sections.bridge:_support", {"support": "as built"})
    stand_in("models.bimorph.beam_values:beam_values", SimpleNamespace(first_frequency=2.0))
    device, support = (
        load_scene("bimorph_on_rod")[0].device,
        load_scene("bimorph_on_rod")[0].support,
    )
    chain = SimpleNamespace(
        device=SimpleNamespace(device=device, support=support),
        rungs=lambda: ["rung"],
        beam_values="values",
        branches=lambda: "branches",
        free_tab=1e-3,
        bar=0.1,
    )
    said.append(described(bridge.holding_section(study("bimorph_on_rod", chain=chain))))
    wide = device.model_copy(update={"bimorph": device.bimorph.model_copy(update={"width": 9e-3})})
    refused = SimpleNamespace(device=SimpleNamespace(device=wide, support=support))
    said.append(described(bridge.holding_section(study("paper", chain=refused))))
    for quick, given in ((True, chain), (False, None)):
        assert bridge.holding_section(study("paper", chain=given, quick=quick)) is None
    assert bridge._lateral_effect(study("paper")) == 0.0
    approved("\n".join(said))


def test_the_assumed_constants(stand_in, study, said, approved):
    """On the rod of the clamped bimorph; only where a field model of a ceramic is asked for."""
    rows = [SimpleNamespace(values=None), SimpleNamespace(values=1.0), SimpleNamespace(values=2.0)]
    stand_in("models.bimorph.material_effects:material_effects", rows)
    for scene in ("paper", "bimorph_on_rod"):
        said.append(described(bridge.material_section(study(scene))))
    for more in ({"quick": True}, {"asks_field": False}):
        assert bridge.material_section(study("paper", **more)) is None
    assert bridge.material_section(study("paper", "piezo.d31=0pC/N")) is None
    approved("\n".join(said))


def test_pictures(stand_in, study, said, approved, monkeypatch):
    """Solids, mesh, its held end, the normal actuator; tetrahedra that stand beside bricks."""
    cells = SimpleNamespace(cells=np.zeros((12, 10)), kind="tetra10")
    stand_in("export.files:scene_solids", "solids")
    stand_in("export.files:normal_actuator_solids", "normal solids")
    stand_in("models.bimorph.meshes:cells_of", cells)
    stand_in("view.pictures:mesh_picture", b"mesh")
    stand_in("view.pictures:solids_picture", b"solids")
    for scene, more in (
        (("paper",), {}),
        (("paper",), {"shown_mesh": "mesh", "normal": "actuator"}),
        (("bimorph_on_rod", "models=cad"), {"shown_mesh": "mesh", "normal": "actuator"}),
        (("reluctance",), {"lateral": False, "normal": "actuator"}),
        (
            ("paper", "bimorph.glue_thickness=10um", "bimorph.bare_above=1mm"),
            {"shown_mesh": "mesh"},
        ),
    ):
        said.append(f"{' '.join(scene)}: {described(gallery.pictures(study(*scene, **more)))}")
    model = SimpleNamespace(meshes=lambda: ["tetrahedra", "coarser"])
    monkeypatch.setattr(gallery, "TwoMeshModel", SimpleNamespace)
    both = study("paper", "models=solid,cad", solution=SimpleNamespace(models={"cad": model}))
    said.append(described(gallery.beside(both)))
    apart = study("paper", "models=solid,cad", elsewhere=SimpleNamespace(mesh="made apart"))
    assert gallery.beside(apart) == "made apart"
    assert gallery.beside(study("paper", "models=solid")) is None
    approved("\n".join(said))


@pytest.mark.parametrize(
    ("models", "asked", "shown"),
    [
        ("solid,tmm,beam", "lumped tmm solid", ("solid", "tmm")),
        ("solid,beam", "beam solid", ("solid",)),
        ("lumped,tmm", "lumped tmm", ("tmm",)),
        ("tmm,lumped", "tmm lumped", ("lumped", "tmm")),
        ("cad,tmm", "tmm cad", ("cad", "tmm")),
    ],
)
def test_what_moves_is_by_the_solid_with_transfer_matrices_beside_it(models, asked, shown, study):
    solved = SimpleNamespace(models_of=lambda _: asked.split())
    assert gallery._moving_models(study("paper", f"models={models}", solved_here=solved)) == shown


def test_the_run_in_time(stand_in, study, said, approved):
    """Of Fig 16, coarser if quick; where there is none, why."""
    stand_in("models.generator.transient:run_scene", "a run")
    for quick in (True, False):
        said.append(large_motion.run_in_time(study("generator", quick=quick)))
    stand_in("models.generator.transient:run_scene", InputError("no bore"))
    said.append(large_motion.run_in_time(study("generator")))
    said.append(described(large_motion._time(study("generator"))))
    approved("\n".join(said))


def test_large_amplitudes(stand_in, study, said, approved):
    """Beside the paper's only for its device, load and voltage; none without two frequencies."""

    def state(name, *, deflection=True, curves=()):
        moved = SimpleNamespace(
            displacement=np.array([3e-6, 4e-6j]),
            fitted_slope=1e-9,
            ended="at the end",
            frequencies=np.array([10.0, 100.0]),
        )
        return SimpleNamespace(state=name, curves=curves, deflection=moved if deflection else None)

    both = (state("not activated", curves=("curve",)), state("held"))
    stand_in("report.sections.large_motion:rocking_states", both)
    for figure in ("states_plot", "deflection_plot"):
        stand_in(f"report.figures.amplitude:{figure}", figure)
    own = ("frequency=0,10,100", "models=tmm")
    for settings, given in (
        (("load.kind=finger", "drive.voltage=50V"), both),
        (("load.kind=none",), both),
        (("drive.voltage=10V",), (state("not activated", deflection=False), both[1])),
        (("bimorph.length=18mm",), both),
    ):
        stand_in("report.sections.large_motion:rocking_states", given)
        scene = study("generator", *own, *settings)
        said.append(f"{settings}: {described(large_motion._amplitude(scene))}")
    assert large_motion._amplitude(study("generator", "frequency=0,100")) is None
    assert large_motion._amplitude(study("generator", quick=True)) == {"states": ()}
    approved("\n".join(said))


def test_what_is_the_same_for_every_scene(stand_in, study, said, approved):
    """Stress of a whole report alone; length and spread of any."""
    stand_in("report.sections.bimorph:stress_output.section", "stress")
    stand_in("report.sections.bimorph:length_section.section", "length")
    stand_in("report.sections.bimorph:uncertainty_section.section", "spread")
    stand_in("report.sections.bimorph:voltage_section.section", "voltage")
    stand_in("report.sections.bimorph:audit.section", "audit")
    for quick in (True, False):
        one = study("paper", quick=quick, parameter_uncertainty="ranges", solution="solution")
        for make in (
            bimorph._stress,
            bimorph._length,
            bimorph._voltage,
            bimorph._uncertainty,
            bimorph._audit,
        ):
            said.append(str(make(one)))
    own = study("paper", "bimorph.width=3mm")
    assert bimorph._voltage(own) is None
    approved("\n".join(said))


def test_each_part_goes_by_its_name(study, said, monkeypatch):
    """A section's contents, pictures, a run, a model solved apart, or what a study has by it."""
    made = [
        Section(name, name, lambda _, name=name: f"section {name}") for name in ("load", "length")
    ]
    monkeypatch.setattr(bimorph, "LATERAL", tuple(made))
    monkeypatch.setattr(
        bimorph, "PRINTED_FORMULAS", Section("audit", "", lambda one: f"audit of {one.scene.name}")
    )
    monkeypatch.setattr(large_motion, "run_in_time", lambda _: "a run")
    monkeypatch.setattr(gallery, "bimorph", lambda _: "pictures of it")
    monkeypatch.setattr(gallery, "moving", lambda _: "what moves")
    monkeypatch.setattr(contents, "made_apart", lambda _, name: f"{name} apart")
    one = study("paper", parameter_uncertainty="ranges")
    expected = {
        "load": "section load",
        "length": "section length",
        "audit": "audit of paper",
        "run": "a run",
        "pictures": "pictures of it",
        "moving": "what moves",
        "cad": "cad apart",
        "solid": "solid apart",
        "rungs": ["rung"],
        "parameter_uncertainty": "ranges",
    }
    assert {name: contents.part(one, name) for name in expected} == expected


def test_parts_of_one_report_share_a_study():
    """As long as the same is asked; of another scene, or another extent, there is another."""
    scene, origins = load_scene("paper")
    first = contents._study((scene, origins, True))
    assert contents._study((scene, origins, True)) is first
    other = contents._study((scene, origins, False))
    assert other is not first
    assert (first.quick, other.quick, other.origins, other.scene.name) == (
        True,
        False,
        origins,
        "paper",
    )


def test_what_stands_apart_travels_with_its_mesh(study, monkeypatch):
    """A picture of tetrahedra only; of the quantities those that the model gives."""
    asked = []

    def solved(scene, models, quantities, announce):
        asked.append((models, quantities))
        stages = SimpleNamespace(to_travel=lambda: "stages")
        return SimpleNamespace(quantities=("q",), stages=stages)

    monkeypatch.setattr(contents, "solve", solved)
    monkeypatch.setattr(gallery, "tetrahedra", lambda solution: "a picture")
    one = study("paper", "quantities=tip_displacement,coupling_factor")
    for name, mesh in (("cad", "a picture"), ("solid", None)):
        assert contents.made_apart(one, name) == Apart(("q",), "stages", mesh)
    assert asked == [((n,), ("tip_displacement", "coupling_factor")) for n in ("cad", "solid")]


def test_a_mesh_in_words(monkeypatch):
    """Bricks by their degrees, tetrahedra by their nodes."""
    monkeypatch.setattr(gallery, "Bricks", SimpleNamespace)
    words = gallery._kind(SimpleNamespace(degree=(2, 3, 4)), None)
    assert words == "bricks of degree 2, 3, 4 across the layers, the width and along the length"
    for kind, nodes in (("tetra", "tetrahedra with"), ("tetra10", "curved tetrahedra with")):
        assert gallery._kind(None, SimpleNamespace(kind=kind)) == f"{nodes} 10 nodes"
