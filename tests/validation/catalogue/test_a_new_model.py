"""One row and one class make a model: added at run time, it is in solve, plan and report."""

import sys

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.transfer_matrix import sections
from tactgen.validation.catalogue.models import MODELS, ModelRow
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.comparison import compare
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models.classes import CLASSES
from tactgen.validation.models.model import Model, Modes, Refined
from tactgen.validation.report import page
from tactgen.validation.report.sections.contents import sections as all_sections
from tactgen.validation.scene.load import load_scene

#: First root of cos x cosh x = -1.
_ROOT = 1.875104068711961


class Rayleigh(Model):
    """The first mode of a slender clamped beam."""

    name = "rayleigh"

    @classmethod
    def check(cls, scene):
        """Refuse springs."""
        if scene.support.kind != "clamped":
            raise InputError(
                f'the model rayleigh cannot take support.kind = "{scene.support.kind}"; set '
                "support.kind=clamped"
            )

    def answer(self, need):
        """Return the short-circuit modes, the only thing it knows."""
        assert need == "modes_short"
        return self.run("modes", self._first)

    def _first(self):
        s = self.scene
        (beam, length), *_ = sections(s.device, s.support, s.beam, lossy=False)
        f = _ROOT**2 / (2.0 * np.pi * length**2) * np.sqrt(beam.EI.real / beam.m)
        return Refined(Modes(np.array([float(f)]), ("bending_x",)), (), "rounding")


ROW = ModelRow(
    "rayleigh",
    "slender beam on a clamp",
    "bimorph",
    theory="beam",
    rank=0,
    stages={"modes": ("bimorph", "piezo", "shim", "beam", "support.kind")},
    gives={"modes_short": ("modes",)},
    shortcut="no shear and no inertia of rotation",
    quick=True,
)
FIRST = "short_circuit_frequencies"


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    """Add the row for one test."""
    monkeypatch.setitem(MODELS, ROW.name, ROW)
    monkeypatch.setitem(sys.modules, "tactgen.validation.models.rayleigh", sys.modules[__name__])
    monkeypatch.setitem(CLASSES, ROW.name, ("rayleigh", "Rayleigh"))


def clamped(*overrides):
    return load_scene("prototype", ["support.kind=clamped", "models=rayleigh,tmm", *overrides])[0]


def test_solve_and_plan_take_it(capsys):
    """It answers what it gives, and the plan says what runs and what does not."""
    scene = clamped(f"quantities={FIRST},tip_velocity", "frequency=100")
    solution = solve(scene)
    assert set(solution.by_model(FIRST)) == {"rayleigh", "tmm"}
    assert set(solution.by_model("tip_velocity")) == {"tmm"}
    one, exact = (solution.get(FIRST, model).value[0] for model in ("rayleigh", "tmm"))
    assert one == pytest.approx(exact, rel=0.01)  # shear of a beam 24 times as long as thick
    assert solution.stages.seconds.keys() == solution.plan.keys.keys()
    assert {"rayleigh.modes", "tmm.modes", "tmm.ports"} <= solution.plan.keys.keys()
    assert main(["solve", "--help"]) == 0
    assert "slender beam on a clamp" in capsys.readouterr().out
    assert main(["plan", "paper", "--set", "models=tmm"]) == 0
    assert "model rayleigh is not among the models" in capsys.readouterr().out


def test_what_it_does_not_know_is_refused():
    """A quantity that it cannot give, and a scene that it cannot take, in one sentence."""
    scene = clamped()
    with pytest.raises(InputError, match=r"tip_velocity.*is computed by lumped, tmm"):
        make_plan(scene, ("rayleigh",), ("tip_velocity",))
    with pytest.raises(InputError, match=r"set support\.kind=clamped"):
        make_plan(load_scene("prototype")[0], ("rayleigh",), (FIRST,))


def test_it_is_compared():
    """The most detailed model judges it, and its shortcut is the reason of the difference."""
    scene = clamped()
    rows = {row.quantity: row for row in compare(scene, solve(scene).quantities, "bimorph")}
    own, other = rows[FIRST].cells
    assert (own.model, own.verdict, own.why) == ("rayleigh", "model form", ROW.shortcut)
    assert (other.model, other.verdict) == ("tmm", "reference")
    assert [cell.model for cell in rows["capacitance_free"].cells] == ["tmm"]


@pytest.mark.heavy
@pytest.mark.usefixtures("undrawn")
def test_it_is_in_the_report(tmp_path, monkeypatch):
    """A column of its own, empty where it has no answer; the rest of the page is as ever."""
    shown = ("models", "modes", "response", "uncertainty", "checks", "parameters")
    chosen = lambda study: [s for s in all_sections(study) if s.id in shown]  # noqa: E731
    monkeypatch.setattr(page, "sections", chosen)
    scene = clamped()
    html = page.write_report(scene, {}, tmp_path, True, lambda _: None).read_text("utf-8")
    assert '<th class="n">rayleigh</th><th class="n">tmm</th>' in html
    assert ROW.shortcut in html
