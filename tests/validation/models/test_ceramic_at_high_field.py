"""A ceramic whose constants grow with the amplitude of the field, by Rayleigh's law."""

import numpy as np
import pytest

from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Piezo
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.waveform import Step
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models.backbone import check_one_field
from tactgen.validation.models.held_bimorph import run_held
from tactgen.validation.models.transient import scene_machine
from tactgen.validation.scene.conditions import conditions
from tactgen.validation.scene.load import load_scene

GROWTH = "piezo.field_growth_d31=2 mm/kV"


#: Losses under which a d31 that grows alone gives no energy.
LOSSY = ("piezo.loss_tangent=0.5", "piezo.quality_factor=5")


def scene_of(*overrides):
    return load_scene("paper", ["load.kind=none", "support.kind=clamped", *LOSSY, *overrides])[0]


def value(scene):
    """Value of the one quantity that a scene asks for."""
    return solve(scene, modelling=False).quantities[0].value


def test_the_linear_constants_are_the_first_harmonic_of_rayleighs_loop():
    """Of a free plate: its strain over the field is a loop of two parabolas, whose area is
    4/3 α E₀³ a period."""
    amplitude, rate = 2e5, 2e-6
    ceramic = Piezo()
    grown = ceramic.model_copy(update={"field_growth_d31": rate}).at_field(amplitude)
    d, alpha = ceramic.d31, rate * ceramic.d31
    angle = np.linspace(0.0, 2.0 * np.pi, 20000, endpoint=False)
    field = amplitude * np.cos(angle)
    falling = np.where(np.sin(angle) >= 0.0, 1.0, -1.0)
    strain = (d + alpha * amplitude) * field + falling * 0.5 * alpha * (amplitude**2 - field**2)
    first = 2.0 * np.mean(strain * np.exp(-1j * angle)) / amplitude
    found = grown.d31 * (1.0 - 1j * grown.coupling_loss)
    assert found == pytest.approx(first, rel=1e-7)
    area = np.pi * amplitude**2 * abs(found.imag)
    assert area == pytest.approx(4.0 / 3.0 * abs(alpha) * amplitude**3, rel=1e-12)


def test_a_bimorph_moves_as_its_plates_strain():
    """Far below resonance the tip per volt goes with d31, its loop's loss included."""
    asked = ("frequency=0.01", "models=tmm", "quantities=tip_displacement")
    plain, grown = (value(scene_of(*asked, g))[0]
                    for g in ("piezo.field_growth_d31=0 mm/kV", GROWTH))  # fmt: skip
    growth = 2e-6 * 50.0 / 0.26e-3
    expected = 1.0 + growth - 4j / (3.0 * np.pi) * growth
    assert grown / plain == pytest.approx(expected, rel=1e-6)


def test_a_compliance_that_grows_softens_and_damps():
    """Frequencies go with the root of the compliance, as ceramic alone bends the beam's ends."""
    asked = ("models=tmm", "modes=1", "shim.youngs_modulus=1 GPa", "piezo.d31=0 m/V",
             "quantities=short_circuit_frequencies")  # fmt: skip
    plain, soft = (value(scene_of(*asked, f"piezo.field_growth_s11={g} mm/kV"))[0] for g in (0, 1))
    growth = 1e-6 * 50.0 / 0.26e-3
    assert (plain / soft) ** 2 == pytest.approx(1.0 + growth, rel=5e-3)  # the shim's own share
    grown = scene_of("piezo.field_growth_s11=1 mm/kV").device.piezo
    loss = (0.2 + 4.0 / (3.0 * np.pi) * growth) / (1.0 + growth)
    assert 1.0 / grown.quality_factor == pytest.approx(loss, rel=1e-12)


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_the_solid_has_the_tensors_of_the_grown_constants():
    """All d grow alike, so that stating each of them gives the same motion."""
    asked = ("models=solid", "mesh.level=2", "quantities=static_tip_displacement")
    growth = 1.0 + 2e-6 * 50.0 / 0.26e-3
    small, base = Piezo(), Piezo().base
    # what is stated of d33 and d15 goes with the root of the permittivity
    d33, d15 = (1e12 * base.d[at] * np.sqrt(growth) for at in ((2, 2), (0, 4)))
    stated = scene_of(*asked, f"piezo.d31={small.d31 * growth} m/V",
                      f"piezo.eps33={small.eps33 * growth}",
                      f"piezo.constants=d33 {d33} pC/N; d15 {d15} pC/N")  # fmt: skip
    grown = scene_of(*asked, "piezo.field_growth_eps33=2 mm/kV", GROWTH)
    one, other = (value(s) for s in (stated, grown))
    assert one == pytest.approx(other, rel=1e-9)


def test_only_the_field_counts():
    """Twice the voltage on layers in series is the same ceramic; answers are kept by the field."""
    tmm = (GROWTH, "models=tmm")
    one = scene_of(*tmm, "drive.voltage=25V")
    series = scene_of(*tmm, "drive.voltage=50V", "bimorph.wiring=series")
    assert one.device.piezo == series.device.piezo
    assert "field in the ceramic 96.154 kV/m" in conditions(one)
    keys = [make_plan(s, ["tmm"], ["tip_displacement"]).keys["tmm.ports"]
            for s in (one, scene_of(*tmm, "drive.voltage=50V"), scene_of("drive.voltage=25V"),
                      scene_of("drive.voltage=50V"))]  # fmt: skip
    assert len(set(keys)) == 3
    assert keys[2] == keys[3]


@pytest.mark.parametrize(("overrides", "words"), [
    (("circuit.resistance=1 kohm",), "needs the voltage across the electrodes"),
    (("circuit.kind=open",), "needs the voltage across the electrodes"),
    (("drive.base_acceleration=1 g", "circuit.kind=load"), "needs the voltage across"),
    (("bimorph.piezo_thickness_profile=0 mm: 0.2 mm, 20 mm: 0.3 mm",), "needs one field in all"),
])  # fmt: skip
def test_an_unknown_field_is_refused(overrides, words):
    with pytest.raises(InputError, match=rf"piezo\.field_growth_d31 {words}"):
        scene_of(GROWTH, *overrides)


def test_what_runs_over_other_fields_says_so():
    scene, _ = load_scene("generator", [GROWTH, *LOSSY, "load.kind=none", "models=tmm"])
    with pytest.raises(InputError, match="field_growth_d31 = 2 mm/kV has no time simulation yet"):
        scene_machine(scene, coil="current", volts=1.0)
    held = scene_of("models=tmm", GROWTH)
    with pytest.raises(InputError, match="has no time simulation yet"):
        run_held(held, Step(10.0), 1e-3, accuracy=0.1)
    check_one_field(scene, [50.0])
    with pytest.raises(InputError, match=r"10 V is another field than that of drive\.voltage"):
        check_one_field(scene, [10.0, 50.0])


@pytest.mark.parametrize("model", ["tmm", "beam"])
def test_at_most_the_loss_that_gives_no_energy(model):
    """On its edge the conductance far below resonance is still positive; beyond it is refused."""
    squared = Piezo().d31 ** 2 / (Piezo().s11 * Piezo().eps33 * EPS0)
    most = float(np.sqrt(0.02 / 60.0 / squared))
    own = ("piezo.loss_tangent=0.02", "piezo.quality_factor=60", f"models={model}")
    edge = scene_of(*own, f"piezo.coupling_loss={0.999 * most}", "frequency=1,100")
    assert (solve(edge, model, "admittance", modelling=False).quantities[0].value.real > 0.0).all()
    with pytest.raises(InputError, match=r"piezo\.coupling_loss = .* would give energy"):
        scene_of(*own, f"piezo.coupling_loss={1.001 * most}")


def test_layers_of_one_field_take_it():
    """One driven ceramic of the scene's own has one field; beside one at 0 V it has not."""
    one = scene_of(GROWTH, "models=tmm", "bimorph.layers=brass 0.3 mm; piezo 0.2 mm +x")
    assert one.field == pytest.approx(50.0 / 0.2e-3)
    with pytest.raises(InputError, match=r"bimorph\.layers does not give it"):
        scene_of(GROWTH, "models=tmm", "bimorph.layers=piezo 0.2 mm +x shorted; piezo 0.2 mm +x")
