"""Which devices the coverage study draws, and what it makes of their answers."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.warnings import load_warnings
from tactgen.validation.evidence import coverage_actuator as axisymmetric
from tactgen.validation.evidence import coverage_actuator as machine
from tactgen.validation.evidence import coverage_beam as beam
from tactgen.validation.evidence import coverage_solid as solid
from tactgen.validation.evidence.coverage_solid import Answer, Case
from tactgen.validation.scene.scene import load_scene


def keys(case):
    return dict(one.split("=") for one in case.overrides)


@pytest.fixture(scope="module")
def drawn():
    """Return two thousand draws of the solid's part; numbers of the device as they come."""
    rng = np.random.default_rng(20)
    return [solid._drawn(rng, number) for number in range(2000)]


def test_no_bimorph_is_too_stout_too_slender_or_too_wide(drawn):
    """Four to 120 times as long as thick, at most 40 times as wide; up to those limits."""
    slender, wide = [], []
    for case in filter(None, drawn):
        piezo, shim, length, width = (
            float(keys(case)[f"bimorph.{name}"].removesuffix("mm"))
            for name in ("piezo_thickness", "shim_thickness", "length", "width")
        )
        slender.append(length / (2.0 * piezo + shim))
        wide.append(width / (2.0 * piezo + shim))
    assert 3.99 < min(slender) < 4.2
    assert 110.0 < max(slender) < 120.2
    assert 30.0 < max(wide) < 40.1
    assert 0.5 < len(slender) / len(drawn) < 0.9


def test_the_first_that_are_small_enough_come_finer_as_well(monkeypatch):
    """At level 3, without what takes long; none whose reference cannot be afforded."""
    most = solid._MOST_FUNCTIONS
    monkeypatch.setattr(solid, "_functions", lambda case: 0.36 * most * case.level)
    found = solid.varied_cases(3, 8, finer=2)
    assert [case.level for case in found] == [2, 2, 2, 2, 2, 2, 2, 2]
    monkeypatch.setattr(solid, "_functions", lambda case: 0.3 * most * case.level)
    found = solid.varied_cases(3, 8, finer=2)
    assert [case.level for case in found] == [2, 3, 2, 3, 2, 2, 2, 2]
    for coarse, fine in (found[:2], found[2:4]):
        assert fine == replace(coarse, level=3, all_motions=False, at=())
    coarse = [case.overrides for case in solid.varied_cases(3, 5, finer=0)]
    assert coarse == [found[i].overrides for i in (0, 2, 4, 5, 6)]
    large = iter([most + 1, *10 * [most]])
    monkeypatch.setattr(solid, "_functions", lambda case: next(large))
    assert solid.varied_cases(3, 1, finer=0)[0].overrides == found[2].overrides


def test_a_reference_is_two_levels_above_what_it_judges():
    levels = solid.LEVELS
    assert [levels.index(Case((), level=level).reference) for level in (2, 3)] == [3, 4]
    assert solid._functions(Case((), level=3)) > solid._functions(Case((), level=2)) > 1000


def test_a_case_is_asked_about_its_first_resonance():
    case = Case(("bimorph.length=10 mm", "load.kind=none"), level=3, at=(0.9, 2.0))
    scene = case.scene()
    plain, _ = load_scene("prototype", list(case.overrides))
    first = solid.solve(plain, ["tmm"], ["short_circuit_frequencies"]).quantities[0].value[0]
    assert scene.frequency == pytest.approx((0.9 * first, 2.0 * first), rel=1e-5)
    assert scene.mesh.level == 3
    assert replace(case, at=(), model="cad").scene().mesh.level == plain.mesh.level
    assert set(case.quantities) - set(replace(case, at=()).quantities) == {
        "tip_displacement", "admittance",
    }  # fmt: skip


@pytest.mark.parametrize(("held", "all_motions"), [("layers", False), ("shim", True)])
def test_answers_are_the_models_own_numbers(monkeypatch, held, all_motions):
    """Modes by number in their class; of one device held in two ways two keys."""
    kinds = ("bending_x", "torsion", "bending_x", "mixed")
    made = []

    def evaluate(name, model):
        if name.endswith("frequencies"):
            value, classes = np.array([1.0, 2.0, 3.0, 4.0]), kinds
        else:
            value, classes = np.array(5.0 + 1.0j), None
        return Quantity(
            name=name,
            model="tmm",
            value=value,
            unit="1",
            error=0.1 * np.abs(value),
            method="",
            seconds=0.0,
            classes=classes,
        )

    def model(name, scene, stages):
        made.append((name, stages))
        return name

    monkeypatch.setattr(solid, "evaluate", evaluate)
    monkeypatch.setattr(solid, "make_model", model)
    monkeypatch.setattr(solid, "_ShimHeldModel", lambda scene, stages: model("shim", scene, stages))
    found = solid.answers(Case((), held=held, all_motions=all_motions))
    assert [name for name, _ in made] == ["shim" if held == "shim" else "solid"]
    modes = [
        Answer("short_circuit_frequencies", value, 0.1 * value, kind, number)
        for value, kind, number in zip((1.0, 2.0, 3.0, 4.0), kinds, (0, 0, 1, 0), strict=True)
    ]
    assert [a for a in found if a.kind] == (modes if all_motions else [modes[0], modes[2]])
    others = [answer for answer in found if not answer.kind]
    assert [answer.quantity for answer in others] == [
        "static_tip_displacement", "capacitance_free", "capacitance_blocked", "coupling_factor",
    ]  # fmt: skip
    assert {(a.value, a.error, a.number) for a in others} == {
        (5.0 + 1.0j, 0.1 * abs(5.0 + 1.0j), 0)
    }


def test_keys_of_a_shim_held_base_are_no_others(monkeypatch):
    seen = {}
    monkeypatch.setattr(
        solid,
        "evaluate",
        lambda name, model: Quantity(
            name=name, model="solid", value=np.array(1.0), unit="1", error=np.array(0.0)
        ),
    )
    monkeypatch.setattr(solid, "Stages", lambda keys: keys)
    monkeypatch.setattr(solid, "make_model", lambda n, s, stages: seen.setdefault("layers", stages))
    monkeypatch.setattr(
        solid, "_ShimHeldModel", lambda scene, stages: seen.setdefault("shim", stages)
    )
    for held in ("layers", "shim"):
        solid.answers(Case((), held=held))
    assert seen["layers"].keys() == seen["shim"].keys()
    assert not set(seen["layers"].values()) & set(seen["shim"].values())


def test_the_pair_that_is_held_by_its_shim(monkeypatch, few_bricks):
    """Its finer bricks first; fewer nodes at rest than where all layers are held."""
    monkeypatch.setattr(solid, "LEVELS", (few_bricks[0], few_bricks[1]))
    scene = load_scene("prototype", ["mesh.level=2"])[0]
    pair = solid._ShimHeldModel.make_pair(SimpleNamespace(scene=scene))
    fine, coarse = (solid.bimorph_bricks(scene.device, b, "shim") for b in few_bricks[::-1])
    whole = solid.bimorph_bricks(scene.device, few_bricks[1])
    sizes = [int(bricks.used().sum()) for bricks in (*pair.meshes, fine, coarse)]
    assert sizes[:2] == sizes[2:]
    assert sizes[0] > sizes[1]
    assert pair.meshes[0].held == "shim" != whole.held


def test_the_slow_response_of_a_reference_is_its_static_one(monkeypatch, few_bricks):
    """At 1 Hz: the static deflection, and the current of the free capacitance; losses aside.

    Clamped, what is lost is lost in the ceramic: tan δ of its charge, and less than 1/Q beside.
    """
    monkeypatch.setattr(solid.Case, "reference", few_bricks[0])
    case = Case(
        ("drive.voltage=3 V", "modes=1", "frequency=1 Hz", "load.kind=none", "support.kind=clamped")
    )
    static = solid.reference(case, ())
    scene = load_scene("prototype", list(case.overrides))[0]
    found = solid._harmonic(scene, solid.bimorph_bricks(scene.device, few_bricks[0]))
    tip = found["tip_displacement", ""][0]
    assert tip == pytest.approx(static["static_tip_displacement", ""][0], rel=0.05)
    admittance = found["admittance", ""][0]
    capacitance = static["capacitance_free", ""][0].real
    assert admittance.imag == pytest.approx(2.0 * np.pi * 1.0 * capacitance, rel=0.05)
    piezo = scene.device.piezo
    dielectric, elastic = piezo.loss_tangent, 1.0 / piezo.quality_factor
    assert dielectric < admittance.real / admittance.imag < dielectric + elastic


@pytest.mark.parametrize(
    ("kinds", "asked"),
    [(("bending_x",), []), (("bending_x", "torsion"), ["torsion"]),
     (("mixed",), ["bending_y", "torsion", "axial"])],
)  # fmt: skip
def test_references_of_the_classes_that_were_found(monkeypatch, few_bricks, kinds, asked):
    """A mixed mode may be any; frequencies ascend within each class."""
    seen = []
    assemble = solid.assemble_bricks

    def noted(device, bricks, *, lossy, motion="bending_x"):
        seen.append(motion)
        return assemble(device, bricks, lossy=lossy, motion=motion)

    monkeypatch.setattr(solid, "assemble_bricks", noted)
    monkeypatch.setattr(solid.Case, "reference", few_bricks[0])
    found = solid.reference(Case(("modes=2",)), kinds)
    assert seen == ["bending_x", *asked]
    modes = {kind: v for (name, kind), v in found.items() if name.endswith("frequencies")}
    assert {"bending_x", *asked} <= set(modes)
    assert all(values == sorted(values, key=abs) for values in modes.values())
    bending = [value.real for value in modes["bending_x"]]
    (coupling,) = found["coupling_factor", ""]
    assert 0.05 < coupling.real < 0.6
    assert 500.0 < bending[0] < 1000.0 < bending[1]


def test_on_its_rod_a_bimorph_takes_every_frequency_that_is_drawn():
    """The finger of the built-in scene is known up to 1000 Hz; three beyond were refused."""
    scene, _ = beam._on_rod(np.random.default_rng(1))
    scene = scene.model_copy(update={"frequency": (1159.2, 2000.0, 3000.0)})
    assert load_warnings(scene, beam._QUANTITIES) == ()


def test_a_field_is_judged_relative_to_the_better_one():
    point = SimpleNamespace(force=0.9, errors=SimpleNamespace(force=0.3))
    one = axisymmetric._one("here", "force", point, SimpleNamespace(force=-1.0))
    assert (one.where, one.quantity, one.error, one.bar) == ("here", "force", 1.9, 0.3)


class Analytic:
    """A pull k i²/(g + g0)², which a spring of force s(g) balances at i = (g + g0) √(s/k)."""

    K, G0 = 2.0, 1.0

    def __init__(self, device, cells, gaps):
        self.device, self.cells = device, cells

    def force(self, current, gap):
        return self.K * np.asarray(current) ** 2 / (gap + self.G0) ** 2


def against(gap):
    """Return the spring's force that makes the balance 2 − (g − 0.4)² of the whole."""
    return Analytic.K * ((2.0 - (gap - 0.4) ** 2) / (gap + Analytic.G0)) ** 2


@pytest.mark.parametrize(
    ("ends", "pull_in", "drop_out"),
    [((0.0, 1.0), 2.0, 1.64), ((0.5, 1.0), 1.99, 1.64), ((0.1, 0.35), 1.9975, 1.91)],
)
def test_switching_currents_are_extremes_of_the_balance(monkeypatch, ends, pull_in, drop_out):
    """Between the stops where there is one there, else at a stop; holding is at the lower."""
    made = []

    def pull(*given):
        made.append(given[1])
        return Analytic(*given)

    monkeypatch.setattr(machine, "DirectPull", pull)
    monkeypatch.setattr(machine, "spring_force", lambda device, gap: against(gap))
    monkeypatch.setattr(machine, "map_grid", lambda device: (np.linspace(0.0, 5.0, 12), ends))
    monkeypatch.setattr(machine, "between_stops", lambda device, n: np.linspace(*ends, n))
    scene = SimpleNamespace(device=None)
    found = machine._balances(scene)
    assert found["holding_current"] == pytest.approx(2.0 - (ends[0] - 0.4) ** 2)
    assert found["pull_in_current"] == pytest.approx(pull_in, rel=1e-5)
    assert found["drop_out_current"] == pytest.approx(drop_out, rel=1e-5)
    assert made == [machine._FINER * machine.CELLS]
    assert machine._FINER > 1
    # no current of the map is enough somewhere: then there is none at all
    monkeypatch.setattr(machine, "map_grid", lambda device: (np.linspace(0.0, 1.0, 12), ends))
    assert np.isnan(list(machine._balances(scene).values())).all()


def test_no_current_balances_a_spring_that_always_or_never_yields(monkeypatch):
    monkeypatch.setattr(machine, "spring_force", lambda device, gap: gap)
    pull = Analytic(None, 1, (0.0, 1.0))
    assert np.isnan(machine._balance(pull, np.linspace(0.0, 1.0, 5), 1e6))
    assert np.isnan(machine._balance(pull, np.linspace(0.5, 1.0, 5), 1e-9))
    current = machine._balance(pull, np.linspace(0.0, 2.0, 5), 1.0)
    assert pull.force(current, 1.0) == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("missing", [False, True])
def test_switching_is_judged_where_both_have_a_current(monkeypatch, missing):
    scene = SimpleNamespace(device=Device())
    monkeypatch.setattr(machine, "_fitting", lambda rng, tried: (tried(scene) and scene, "here"))
    numbers = {"value": np.array(1.2), "error": np.array(0.3)}
    solution = SimpleNamespace(get=lambda name, model: SimpleNamespace(**numbers))
    monkeypatch.setattr(machine, "solve", lambda *_: solution)
    right = dict.fromkeys(machine._SWITCHING, -1.0)
    right["holding_current"] = np.nan if missing else -1.0
    monkeypatch.setattr(machine, "_balances", lambda scene: right)
    found = machine.judge_switching(None)
    assert len(found) == (2 if missing else 3)
    assert all(one.error == pytest.approx(2.2) and one.bar == 0.3 for one in found)
