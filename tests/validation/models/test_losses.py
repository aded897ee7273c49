"""Losses of all parts in every model, and a ceramic whose constants grow with the field."""

import numpy as np
import pytest

from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Piezo
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.waveform import Step
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.backbone import check_one_field
from tactgen.validation.models.held_bimorph import run_held
from tactgen.validation.models.transient import scene_machine
from tactgen.validation.scene.conditions import conditions
from tactgen.validation.scene.load import load_scene

#: A bimorph with a bare tab and glue between its layers, which every model of the solid on
#: bricks takes, too; little loss in the ceramic, so that that of the others shows.
LAYERED = ("bimorph.tab_length=2mm", "bimorph.glue_thickness=20um", "support.kind=clamped",
           "load.kind=none", "piezo.quality_factor=1e4", "piezo.loss_tangent=1e-4")  # fmt: skip
LOSING = ("shim.loss_factor=0.05", "glue.loss_factor=0.3")


def answered(name, model, *overrides, frequencies="10,200,1500"):
    scene, _ = load_scene(name, [*overrides, f"models={model}", f"frequency={frequencies}"])
    return solve(scene, (model,), ("tip_displacement",), modelling=False)


@pytest.mark.parametrize("key", ["shim", "glue", "rod"])
def test_each_part_takes_energy_by_both_beam_models(key):
    """Closed form and elements agree on what each part's loss alone does in the real joint."""
    none = ("shim.loss_factor=0", "glue.loss_factor=0", "rod.loss_factor=0", "load.kind=none")
    some = (*none, f"{key}.loss_factor=0.2")
    lossless, tmm, beam = (
        answered("bimorph_on_rod", model, *overrides)
        for model, overrides in (("tmm", none), ("tmm", some), ("beam", some))
    )
    values = [s.quantities[0].value for s in (lossless, tmm, beam)]
    # elements of order five at 1500 Hz
    np.testing.assert_allclose(values[2], values[1], rtol=1e-7)
    assert abs(values[1][1] / values[0][1] - 1.0) > 1e-6


def compliance(model, *overrides):
    """Tip compliance at 10 Hz, far below resonance, base and voltage held (m/N)."""
    found = answered("paper", model, *LAYERED, "accuracy=0.05", *overrides, frequencies="10")
    stiffness = found.models[model].answer("harmonic").fine.stiffness[0]
    return np.linalg.inv(stiffness[np.ix_([2, 3], [2, 3])])[0, 0]


def lag(model, *overrides):
    """Share of the energy that a loss takes (rad): the part in quadrature, without the rest's."""
    lossy, rest = (compliance(model, *more) for more in (overrides, ()))
    return rest.imag / rest.real - lossy.imag / lossy.real


@pytest.mark.heavy
def test_the_solid_loses_in_the_shim_what_the_beam_loses():
    """Its share of the bending energy: that of beam theory to what the width and ends change."""
    assert lag("solid", LOSING[0]) == pytest.approx(lag("tmm", LOSING[0]), rel=0.1)


@pytest.mark.heavy
def test_the_solid_loses_in_the_glue_its_share_of_the_energy():
    """Loss factor times the share that a stiffer glue says, without losses: dC/C per dE/E.

    In the solid the layers shear the glue, of which plane sections know nothing.
    """
    soft, stiff = (
        compliance("solid", f"glue.youngs_modulus={modulus}GPa").real for modulus in (2.97, 3.03)
    )
    share = np.log(soft / stiff) / np.log(3.03 / 2.97)
    # of first order in the loss factor; the next is its square
    assert lag("solid", "glue.loss_factor=0.05") == pytest.approx(0.05 * share, rel=0.01)
    assert lag("solid", "glue.loss_factor=0.05") > 10.0 * lag("tmm", "glue.loss_factor=0.05")


def test_the_generators_own_resonance_is_damped():
    """On the rod with the scene's losses Q is near the 22 of the paper's 20 mm actuator."""
    found = answered("bimorph_on_rod", "tmm", "load.kind=none", frequencies="340:410:281")
    size = np.abs(found.quantities[0].value)
    frequencies = np.asarray(found.scene.frequency)
    half = frequencies[size > size.max() / np.sqrt(2.0)]
    q = frequencies[size.argmax()] / (half[-1] - half[0])
    # a loss factor of 0.044 in tab and glue, which hold nearly all the energy, is Q = 23
    assert q == pytest.approx(22.0, rel=0.2)


GROWTH = "piezo.field_growth_d31=2 mm/kV"


#: Losses under which a d31 that grows alone gives no energy.
LOSSY = ("piezo.loss_tangent=0.5", "piezo.quality_factor=5")


def scene_of(*overrides):
    return load_scene("paper", ["load.kind=none", "support.kind=clamped", *LOSSY, *overrides])[0]


def value(*overrides):
    """Value of the one quantity that a scene asks for."""
    return solve(scene_of(*overrides), modelling=False).quantities[0].value


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
    plain, grown = (value(*asked, g)[0] for g in ("piezo.field_growth_d31=0 mm/kV", GROWTH))
    growth = 2e-6 * 50.0 / 0.26e-3
    expected = 1.0 + growth - 4j / (3.0 * np.pi) * growth
    assert grown / plain == pytest.approx(expected, rel=1e-6)


def test_a_compliance_that_grows_softens_and_damps():
    """Frequencies go with the root of the compliance, as ceramic alone bends the beam's ends."""
    asked = ("models=tmm", "modes=1", "shim.youngs_modulus=1 GPa", "piezo.d31=0 m/V",
             "quantities=short_circuit_frequencies")  # fmt: skip
    plain, soft = (value(*asked, f"piezo.field_growth_s11={g} mm/kV")[0] for g in (0, 1))
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
    stated = value(*asked, f"piezo.d31={small.d31 * growth} m/V",
                   f"piezo.eps33={small.eps33 * growth}",
                   f"piezo.constants=d33 {d33} pC/N; d15 {d15} pC/N")  # fmt: skip
    grown = value(*asked, "piezo.field_growth_eps33=2 mm/kV", GROWTH)
    assert stated == pytest.approx(grown, rel=1e-9)


def test_only_the_field_counts():
    """Twice the voltage on layers in series is the same ceramic; one driven layer has one field."""
    one = scene_of(GROWTH, "models=tmm", "drive.voltage=25V")
    series = scene_of(GROWTH, "models=tmm", "drive.voltage=50V", "bimorph.wiring=series")
    assert one.device.piezo == series.device.piezo
    assert "field in the ceramic 96.154 kV/m" in conditions(one)
    listed = scene_of(GROWTH, "models=tmm", "bimorph.layers=brass 0.3 mm; piezo 0.2 mm +x")
    assert listed.field == pytest.approx(50.0 / 0.2e-3)


@pytest.mark.parametrize(("overrides", "words"), [
    (("circuit.kind=open",), "needs the voltage across the electrodes"),
    (("bimorph.layers=piezo 0.2 mm +x shorted; piezo 0.2 mm +x",),
     r"needs .*bimorph\.layers does not give it"),
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
    edge = value(*own, f"piezo.coupling_loss={0.999 * most}", "frequency=1,100",
                 "quantities=admittance")  # fmt: skip
    assert (edge.real > 0.0).all()
    with pytest.raises(InputError, match=r"piezo\.coupling_loss = .* would give energy"):
        scene_of(*own, f"piezo.coupling_loss={1.001 * most}")
