"""The lumped model: exact in statics, within one percent at the first mode."""

import numpy as np
import pytest
from port_distance import distance

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


@pytest.mark.parametrize("length", [10e-3, 40e-3])
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
    loaded = lumped.equivalent_circuit(pieces, Ends(tip=TipLoad(mass=1.0)))
    # the heavy mass makes the shape the static one under a tip force: k = 1/compliance
    beam, length = pieces[0]
    compliance = length**3 / (3.0 * beam.EI) + length / beam.GA
    assert loaded.stiffness == pytest.approx(1 / compliance, rel=1e-6)
    assert loaded.mass == pytest.approx(1.0 + 33 / 140 * beam.m * length, rel=1e-5)
