"""The lumped model: exact in statics, within one percent at the first mode."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs, TipLoad
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Support
from tactgen.tmm.beam import lumped
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.beam.modes import bending_frequencies

SPRING, CLAMPED, ROD = Support(), Support(kind="clamped"), Support(kind="rod")
TAB = Device(bimorph=Bimorph(tab_length=2e-3))
ROWS = [
    (Device(), SPRING),
    (Device(bimorph=Bimorph(length=5e-3)), CLAMPED),
    (TAB, CLAMPED),
    (TAB, ROD),
]
ENDS = [Ends(), Ends(Springs(3e6, 0.24, rotational_inertia=1e-12))]


def distance(a, b):
    """Return |a − b| relative to the geometric mean of the diagonal neighbours."""
    size = np.sqrt(np.abs(np.einsum("nii->ni", b)))
    return (np.abs(a - b) / (size[:, :, None] * size[:, None, :])).max(axis=(1, 2))


@pytest.mark.parametrize(("device", "support"), ROWS)
def test_statics_are_exact(device, support):
    """At 0 Hz the lumped ports are those of the transfer-matrix model, with all losses."""
    exact, got = (
        model.multiport(device, support, Beam(), np.zeros(1)).stiffness for model in (tmm, lumped)
    )
    # rounding times the condition number of the joints: the rod is 1e5 times as stiff as the tab
    assert distance(got, exact) < 1e-10


@pytest.mark.parametrize(("device", "support"), ROWS)
def test_inertia_is_of_the_static_shapes(device, support):
    """Far below the first mode D has the right Ω² term, in every entry and of the right sign.

    The consistent mass leaves out shear and keeps the static joints, so a percent of it
    is wrong; a wrong sign in any row would make the difference twice the term itself.
    """
    f = np.array([0.0, 50.0])
    exact, got = (
        model.multiport(device, support, Beam(), f, lossy=False).stiffness
        for model in (tmm, lumped)
    )
    term = exact[1] - exact[0]
    error = np.abs(got[1] - got[0] - term)
    size = np.sqrt(np.abs(np.diag(term)))
    counted = np.abs(term) > 1e-9 * np.abs(exact[0]).max(axis=1)[:, None]
    assert (error[counted] < 0.05 * np.maximum(np.abs(term), size[:, None] * size)[counted]).all()


def test_neglected_terms_are_of_fourth_order():
    """Without shear the lumped D is right up to Ω²: its error grows 16-fold per octave."""
    f = np.array([50.0, 100.0, 200.0])
    device, rigid = Device(bimorph=Bimorph(length=40e-3)), Beam(shear_correction=1e9)
    exact, got = (
        model.multiport(device, CLAMPED, rigid, f, lossy=False).stiffness[:, 2, 2].real
        for model in (tmm, lumped)
    )
    error = np.abs(got - exact)
    # next term: (f/1660 Hz)², the first resonance with both ends held, 1.5 % at 200 Hz
    np.testing.assert_allclose(error[1:] / error[:-1], 16.0, rtol=0.02)


def smits_choi(beam, length):
    """Return the static cantilever matrix (3, 3): [ψ, w, Q] at the tip from [M, F, U].

    Smits and Choi (1991) for a bimorph, with the shim inside EI and K and the shear term
    added; the rotation is ψ ≈ −w', hence the signs off their table.
    """
    a = length / beam.EI
    return np.array(
        [
            [a, -0.5 * a * length, a * beam.K],
            [-0.5 * a * length, a * length**2 / 3.0 + length / beam.GA, -0.5 * a * length * beam.K],
            [a * beam.K, -0.5 * a * length * beam.K, length * beam.C + a * beam.K**2],
        ],
        dtype=complex,
    )


def test_smits_choi_is_the_compliance():
    """The static cantilever matrix of Smits and Choi, with shear, inverts the lumped stiffness."""
    ((beam, length),) = tmm.sections(Device(), CLAMPED, Beam(), lossy=True)
    d = lumped.lumped_model([(beam, length)]).stiffness
    # [ψ, w, Q] from [M, F, U], ports 3, 2 and 4
    compliance = np.linalg.inv(d[np.ix_([3, 2], [3, 2])])
    coupled = np.zeros((3, 3), dtype=complex)
    coupled[:2, :2] = compliance
    coupled[:2, 2] = -compliance @ d[[3, 2], 4]
    coupled[2, :2] = d[4, [3, 2]] @ compliance
    coupled[2, 2] = d[4, 4] + d[4, [3, 2]] @ coupled[:2, 2]
    np.testing.assert_allclose(smits_choi(beam, length), coupled, rtol=1e-13)


def test_smits_choi_without_shim_and_shear():
    """Without shim and shear w/F = s11 l³/(2 b h³), w/U = 3 d31 l²/(4 h²), h one layer's height.

    Smits and Choi (1991), table for two like layers in parallel, each with the voltage U.
    """
    thin, h, l, b = 1e-9, 0.26e-3, 20e-3, 2.1e-3
    device = Device(bimorph=Bimorph(shim_thickness=thin, piezo_thickness=h))
    ((beam, _),) = tmm.sections(device, CLAMPED, Beam(shear_correction=1e12), lossy=False)
    matrix = smits_choi(beam, l).real
    s11, d31 = device.piezo.s11, device.piezo.d31
    # the shim left adds 3/2 of thin/h
    assert matrix[1, 1] == pytest.approx(s11 * l**3 / (2 * b * h**3), rel=1e-5)
    assert abs(matrix[1, 2]) == pytest.approx(abs(3 * d31 * l**2 / (4 * h**2)), rel=1e-5)


@pytest.mark.parametrize("length", [10e-3, 14e-3, 20e-3, 40e-3])
@pytest.mark.parametrize("open_circuit", [False, True])
@pytest.mark.parametrize("ends", ENDS)
def test_first_mode_within_a_percent(length, open_circuit, ends):
    """The one-mode circuit has the exact first frequency within 1 %, short and open."""
    device = Device(bimorph=Bimorph(length=length))
    pieces = tmm.sections(device, SPRING, Beam(), lossy=False)
    circuit = lumped.equivalent_circuit(pieces, ends, open_circuit=open_circuit)
    exact = bending_frequencies(pieces, ends, 1, open_circuit=open_circuit)[0]
    ratio = np.sqrt(circuit.stiffness / circuit.mass) / (2 * np.pi) / exact
    # static shapes with their mass are a Rayleigh quotient: an upper bound, less 1e-3 for the
    # shear that the mass does not see
    assert 0.999 < ratio < 1.01


@pytest.mark.parametrize("ends", ENDS)
def test_coupling_factor_from_circuit_and_frequencies(ends):
    """N²/(N² + k C_b) equals 1 − (f_short/f_open)² of the exact beam within 5 %.

    The identity is exact for one mode; higher modes' share of the blocked capacitance and
    the error of the frequencies (half a percent of each, mostly common) remain.
    """
    pieces = tmm.sections(Device(bimorph=Bimorph(length=14e-3)), SPRING, Beam(), lossy=False)
    circuit = lumped.equivalent_circuit(pieces, ends)
    n2 = circuit.turns_ratio**2
    from_circuit = n2 / (n2 + circuit.stiffness * circuit.blocked_capacitance)
    short, opened = (bending_frequencies(pieces, ends, 1, open_circuit=o)[0] for o in (False, True))
    assert from_circuit == pytest.approx(1 - (short / opened) ** 2, rel=0.05)


@pytest.mark.parametrize("ends", ENDS)
def test_circuit_keeps_the_static_capacitance(ends):
    """At 0 Hz the circuit draws the charge of the free actuator: C_b + N²/k."""
    pieces = tmm.sections(Device(), SPRING, Beam(), lossy=False)
    circuit = lumped.equivalent_circuit(pieces, ends)
    beam, length = pieces[0]
    # no external force: the whole beam curves freely on any statically determinate support
    free = ((beam.C + beam.K**2 / beam.EI) * length).real
    static = circuit.blocked_capacitance + circuit.turns_ratio**2 / circuit.stiffness
    assert static == pytest.approx(free, rel=1e-12)


def test_circuit_carries_tip_load():
    """Tip mass and stiffness add to the circuit's, referred to the tip."""
    pieces = tmm.sections(Device(), SPRING, Beam(), lossy=False)
    bare = lumped.equivalent_circuit(pieces, Ends())
    loaded = lumped.equivalent_circuit(pieces, Ends(tip=TipLoad(mass=1.0)))
    # the heavy mass makes the shape the static one under a tip force: k = 1/compliance
    beam, length = pieces[0]
    compliance = smits_choi(beam, length)[1, 1].real
    assert loaded.stiffness == pytest.approx(1 / compliance, rel=1e-6)
    assert loaded.mass == pytest.approx(1.0 + 33 / 140 * beam.m * length, rel=1e-5)
    assert loaded.short_circuit_frequency < bare.short_circuit_frequency


def test_scaling_metre_to_millimetre():
    """A circuit a thousand times smaller has masses 1e-9, stiffnesses 1e-3 times as large."""
    big = Device(bimorph=Bimorph(length=20.0, width=2.1, piezo_thickness=0.26, shim_thickness=0.25))
    small, large = (
        lumped.equivalent_circuit(tmm.sections(d, SPRING, Beam(), lossy=False), Ends())
        for d in (Device(), big)
    )
    assert small.mass == pytest.approx(1e-9 * large.mass, rel=1e-11)
    assert small.stiffness == pytest.approx(1e-3 * large.stiffness, rel=1e-11)
    assert small.turns_ratio == pytest.approx(1e-3 * large.turns_ratio, rel=1e-11)
    assert small.blocked_capacitance == pytest.approx(1e-3 * large.blocked_capacitance, rel=1e-11)
