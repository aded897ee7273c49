"""Which devices the coverage study samples, and what it makes of their answers."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.validation.evidence import coverage_actuator as machine
from tactgen.validation.evidence import coverage_bimorph as solid
from tactgen.validation.evidence.coverage_bimorph import Case
from tactgen.validation.evidence.random_devices import any_scene, solid_bimorph
from tactgen.validation.scene.load import load_scene


def test_no_bimorph_is_too_stout_too_slender_or_too_wide():
    """Four to 120 times as long as thick, at most 40 times as wide; up to those limits."""
    rng, slender, wide = np.random.default_rng(20), [], []
    for overrides in filter(None, (solid_bimorph(rng) for _ in range(2000))):
        keys = dict(one.split("=") for one in overrides)
        piezo, shim, length, width = (
            float(keys[f"bimorph.{name}"].removesuffix("mm"))
            for name in ("piezo_thickness", "shim_thickness", "length", "width")
        )
        slender.append(length / (2.0 * piezo + shim))
        wide.append(width / (2.0 * piezo + shim))
    assert 3.99 < min(slender) < 4.2
    assert 110.0 < max(slender) < 120.2
    assert 30.0 < max(wide) < 40.1
    assert 1000 < len(slender) < 1800


def test_a_seed_samples_the_same_scene_again():
    """And another seed another one."""
    one, again, other = (any_scene(np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert one == again != other


def test_a_case_is_asked_about_its_first_resonance():
    case = Case(("bimorph.length=10 mm", "load.kind=none"), level=3, at=(0.9, 2.0))
    scene = case.scene()
    plain, _ = load_scene("prototype", list(case.overrides))
    first = solid.solve(plain, ["tmm"], ["short_circuit_frequencies"]).quantities[0].value[0]
    assert scene.frequency == pytest.approx((0.9 * first, 2.0 * first), rel=1e-5)
    assert scene.mesh.level == 3
    assert replace(case, at=(), model="cad").scene().mesh.level == plain.mesh.level


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
    found = solid._responses(scene, solid.bimorph_bricks(scene.device, few_bricks[0]))
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

    monkeypatch.setattr(machine, "DirectForce", pull)
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
