"""State space of the solid: real, stable, passive, and how it differs from the lossy solid."""

import numpy as np
import pytest

from tactgen.fem.piezo.krylov import reduce_to_ports
from tactgen.fem.piezo.port_model import motions
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.state_space import (
    TITLE,
    _branches,
    differences,
    state_space,
    write_state_space,
)
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.bricks import BrickMeshing, bimorph_bricks
from tactgen.geometry.device.parameters import Device, Load, Support
from tactgen.tmm.ports.supports_and_loads import ends_of
from tactgen.validation.command_line.cli import main

BOUNDS = (10.0, 20000.0)
SPRINGS = ends_of(Support(), Load()).base


def dissipation_form(model):
    """Return the matrix of −(power lost) over (x, u): negative semidefinite if passive.

    [A + Aᵀ, B − Cᵀ; Bᵀ − C, −D − Dᵀ], the positive-real lemma with energy ½ xᵀx.
    """
    cross = model.b - model.c.T
    return np.block([[model.a + model.a.T, cross], [cross.T, -model.d - model.d.T]])


@pytest.fixture(scope="module")
def model():
    mesh = bimorph_bricks(Device(), BrickMeshing((2, 2, 2), smallest=0.5))
    return reduce_to_ports(assemble(Device(), mesh, lossy=True), np.array(BOUNDS)).fine


@pytest.fixture(scope="module", params=[SPRINGS, None], ids=["springs", "clamped"])
def base(request):
    return request.param


@pytest.fixture(scope="module")
def found(model, base):
    return state_space(model, base, BOUNDS)


def test_real_and_stable(found, base):
    """All poles in the left half plane; ports are those that the support leaves."""
    for matrix in (found.a, found.b, found.c, found.d):
        assert matrix.dtype == float
    assert np.linalg.eigvals(found.a).real.max() < 0.0
    assert len(found.inputs) == len(found.outputs) == (3 if base is None else 5)


def test_passive_by_structure(found):
    """Positive-real lemma with energy ½ xᵀx: no state and no input can gain from it."""
    form = np.linalg.eigvalsh(dissipation_form(found))
    assert form.max() < 1e-13 * np.abs(form).max()  # zero but for rounding


def test_reciprocal(found):
    """Force to current equals voltage to velocity but for the sign that power has it."""
    g = found.frequency_response(np.geomspace(*BOUNDS, 50))
    size = np.sqrt(np.abs(np.einsum("nii->ni", g)))
    error = np.abs(g - g.transpose(0, 2, 1)) / (size[:, :, None] * size[:, None, :])
    assert error.max() < 1e-9


def test_agrees_at_resonances(model, base, found):
    """Tip velocity per volt at each resonance, where it matters, within 2 %.

    What is left is of the order of 1/Q, 1/57 here: the couplings have no losses of their own.
    """
    at, solid, error = differences(model, base, found, BOUNDS)
    beside = [
        np.abs(motions(model.multiport(at * shift), Ends(base))[0])
        for shift in (1.0 - 1e-4, 1.0 + 1e-4)
    ]
    size = np.abs(solid[0]) / (2.0 * np.pi * at)
    peaks = (beside[0] < size) & (beside[1] < size)
    assert peaks.sum() >= 3
    assert error[0, peaks].max() < 0.02


def test_loss_tangent_is_held():
    """Branches of resistor and capacitor keep tan δ over the range, and C in its middle.

    5 % of tan δ: the branches end 1.5 decades outside (2 % at the edge, 2/π arctan of 10^-1.5),
    and the series resistor adds 2.5e-4 at 5 kHz, 1.7 % of this tan δ.
    """
    loss = 0.015
    capacities, times = _branches(1e-9 * (1.0 - 1j * loss), *BOUNDS)
    assert np.all(capacities > 0.0)
    assert np.all(times > 0.0)
    f = np.geomspace(10.0, 5000.0, 40)  # above, the series resistor shows (1e-3 at the top)
    c = (capacities / (1.0 + 2j * np.pi * f[:, None] * times)).sum(axis=1)
    assert -c.imag == pytest.approx(loss * 1e-9, rel=0.05)
    middle = np.sqrt(BOUNDS[0] * BOUNDS[1])
    c = (capacities / (1.0 + 2j * np.pi * middle * times)).sum()
    assert c.real == pytest.approx(1e-9, rel=1e-6)


def test_file_tells_what_differs(model, base, found, tmp_path):
    """Matrices, ports, range, and the measured distance at every peak and dip."""
    write_state_space(tmp_path / "s.npz", model, base, BOUNDS)
    with np.load(tmp_path / "s.npz") as data:
        assert data["title"].item() == TITLE
        assert np.array_equal(data["a"], found.a)
        assert tuple(data["outputs"]) == found.outputs
        assert data["extreme_errors"].shape == (3, data["extreme_frequencies"].size)


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_command_writes_both(tmp_path, capsys):
    """From the command line; series wiring takes half of the voltage in each layer."""
    capacitance = []
    for wiring in ("parallel", "series"):
        ports, states = tmp_path / f"{wiring}.npz", tmp_path / f"{wiring}-states.npz"
        settings = ("mesh.level=2", "frequency=100,2000", f"bimorph.wiring={wiring}")
        arguments = [part for setting in settings for part in ("--set", setting)]
        files = ["--ports", str(ports), "--state-space", str(states)]
        assert main(["export", "paper", *arguments, *files]) == 0
        assert capsys.readouterr().out.splitlines() == [str(ports), str(states)]
        with np.load(states) as data:
            capacitance.append(data["d"][-1, -1])
    assert capacitance[0] == pytest.approx(4.0 * capacitance[1], rel=1e-9)


def test_no_range_is_refused(tmp_path, capsys):
    """0 Hz alone: one sentence, exit code 2, no file."""
    file = tmp_path / "s.npz"
    assert main(["export", "paper", "--set", "frequency=0", "--state-space", str(file)]) == 2
    assert "gives a state space no range" in capsys.readouterr().err
    assert not file.exists()
