"""One row makes a quantity: added at run time, it is in every command, and nowhere else."""

import json

import numpy as np
import pytest

from tactgen.geometry.units import Unit
from tactgen.tmm.ports.readout import ModalReadout, Readout
from tactgen.validation.catalogue.quantities import QUANTITIES, AnswerReadout, QuantityRow
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.comparison import compare
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.model import Estimate
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.template import template

ACCELERATION = QuantityRow(
    "tip_acceleration",
    "m/s^2",
    "lateral acceleration of the tip under the drive voltage",
    Readout("w_tip", "motion", rate=2),
    varied=True,
    curve=Unit("m/s^2", "acceleration", "12.3 m/s^2", limits=(1e-9, 1e6)),
)
STIFFENING = QuantityRow(
    "stiffening",
    "1",
    "by how much open electrodes raise the first frequency",
    ModalReadout(("short", "open"), lambda short, opened: opened / short - 1.0),
    varied=True,
)
ENERGY = QuantityRow(
    "field_energy",
    "J",
    "energy of the magnetic field",
    AnswerReadout(
        "magnetic_point",
        lambda point: Estimate(
            point.current * point.flux_linkage.value - point.coenergy.value,
            point.current * point.flux_linkage.error + point.coenergy.error,
        ),
    ),
)


@pytest.fixture(autouse=True)
def rows(monkeypatch):
    """Add the rows for one test."""
    for row in (ACCELERATION, STIFFENING, ENERGY):
        monkeypatch.setitem(QUANTITIES, row.name, row)


def said(capsys, *arguments):
    assert main(list(arguments)) == 0
    return capsys.readouterr().out


def test_solve_gives_it_by_every_model_and_as_json(capsys):
    """(jΩ)² times the displacement, each with its bar; the shift of the first frequency."""
    out = said(
        capsys, "solve", "prototype", "--set", "models=lumped,tmm,beam", "--frequency", "100,500",
        "--quantity", "tip_acceleration,tip_displacement,stiffening,coupling_factor", "--json",
    )  # fmt: skip
    found = {(q["name"], q["model"]): q for q in json.loads(out)["quantities"]}
    squared = -((2.0 * np.pi * np.array([100.0, 500.0])) ** 2)
    for model in ("lumped", "tmm", "beam"):
        acceleration, moved = (
            np.array(found[name, model]["value"])
            for name in ("tip_acceleration", "tip_displacement")
        )
        np.testing.assert_allclose(acceleration, squared[:, None] * moved, rtol=1e-14)
        assert found["tip_acceleration", model]["unit"] == "m/s^2"
        assert all(found["tip_acceleration", model]["uncertainty"])
        coupling, shift = (found[n, model]["value"] for n in ("coupling_factor", "stiffening"))
        assert shift == pytest.approx(1.0 / np.sqrt(1.0 - coupling**2) - 1.0, rel=1e-12)
    assert "tip_acceleration" in said(
        capsys, "solve", "prototype", "--model", "tmm", "--quantity", "tip_acceleration"
    )


def test_all_includes_it_and_help_and_template_name_it(capsys):
    """Whoever looks for what can be asked for finds it."""
    assert {"tip_acceleration", "stiffening"} <= set(load_scene("paper")[0].quantities)
    reluctance = load_scene("reluctance", ["models=network", "quantities=all"])[0]
    assert "field_energy" in reluctance.quantities
    assert "lateral acceleration of the tip" in said(capsys, "solve", "--help")
    assert "acceleration (m/s^2)" in said(capsys, "identify", "--help")
    line = next(line for line in template().splitlines() if line.startswith("# quantities"))
    assert "tip_acceleration" in line


@pytest.mark.heavy
def test_sensitivities_follow(capsys):
    """An acceleration depends on each parameter as the velocity does; the voltage counts once."""
    out = said(
        capsys, "sensitivity", "prototype", "--frequency", "300", "--quantity",
        "tip_acceleration,tip_velocity,stiffening", "--json",
    )  # fmt: skip
    rows = json.loads(out)["sensitivities"]
    columns = {c["quantity"]: c["logarithmic"] for c in rows}
    bar = next(c["uncertainty"] for c in rows if c["quantity"] == "tip_acceleration")
    for key, slope in columns["tip_velocity"].items():
        assert columns["tip_acceleration"][key] == pytest.approx(slope, rel=0.0, abs=2.0 * bar[key])
    assert bar["drive.voltage"] < 1e-10
    assert columns["tip_acceleration"]["drive.voltage"] == pytest.approx(
        1.0, rel=0.0, abs=bar["drive.voltage"]
    )
    # to first order the shift is half the square of the coupling factor, which goes as d31
    assert columns["stiffening"]["piezo.d31"] == pytest.approx(2.0, rel=0.1)


def test_report_compares_it():
    """Beside the other single numbers of its actuator, for either actuator."""
    scene, _ = load_scene("prototype", ["models=lumped,tmm", "quantities=stiffening"])
    rows = compare(scene, solve(scene).quantities, "bimorph")
    (shift,) = (row.cells for row in rows if row.quantity == "stiffening")
    assert [cell.verdict for cell in shift] == ["model form", "reference"]
    magnetic, _ = load_scene("reluctance", ["models=network", "quantities=field_energy,coenergy"])
    solution = solve(magnetic)
    rows = compare(magnetic, solution.quantities, "reluctance")
    assert [row.quantity for row in rows] == ["coenergy", "field_energy"]
    # of saturable iron the energy is less than the co-energy
    assert 0.0 < rows[1].cells[0].value < rows[0].cells[0].value
