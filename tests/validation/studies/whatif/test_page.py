"""The page of a study: it holds what the study says, needs nothing else, says what is in it."""

import json
import re

import numpy as np

from tactgen.geometry.bimorph.brick_family import BrickMeshing
from tactgen.validation.models.bimorph import solid
from tactgen.validation.models.bimorph.family import solid_family
from tactgen.validation.scene.scene import scene_values
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.run import run_study
from tactgen.validation.studies.whatif.shown.page import write_page

QUICK = (
    BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
    BrickMeshing((2, 2, 3), smallest=0.5, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
)
STATIC = ("static_tip_displacement",)


def written(folder, *vary, models=("tmm",), quantities=STATIC, **more):
    """Return the study, its page, and the data that the page's sliders move over."""
    values, _ = scene_values("prototype", ["accuracy=0.1", "modes=1", "frequency=100"])
    study = run_study(Statement("prototype", values, vary, models, quantities, **more))
    page = write_page(folder, study).read_text(encoding="utf-8")
    data = re.search(r'id="study-data">(.*?)</script>', page)
    return study, page, json.loads(data[1]) if data else None


def test_the_pages_numbers_are_the_studys(tmp_path):
    """The last axis runs fastest; a quantity that a model does not give is not there."""
    study, page, data = written(
        tmp_path, "bimorph.length=14mm:16mm:3", "load.kind=none,finger",
        models=("tmm", "lumped"), quantities=(*STATIC, "tip_displacement"),
    )  # fmt: skip
    tmm, lumped = data["grids"]
    assert (tmm["model"], lumped["model"]) == ("tmm", "lumped")
    assert tmm["axes"] == [[0.014, 0.015, 0.016], ["none", "finger"]]
    for grid in data["grids"]:
        for name in grid["numbers"]:
            said = [
                np.abs(q.value).ravel()[0]
                for answers in study.answers
                for q in answers[grid["model"]].quantities if q.name == name
            ]  # fmt: skip
            np.testing.assert_allclose(grid["numbers"][name]["value"], said)
    assert "own 6 points" in page
    assert not re.findall(
        r"""(?:src|href)=["'](?!#|data:)|<link|url\((?!#)|import\(|fetch\(""", page
    )


def test_a_reduced_basis_gives_a_finer_grid(tmp_path, monkeypatch, own_store):
    for module in (solid, solid_family):
        monkeypatch.setattr(module, "LEVELS", QUICK)
    study, page, data = written(tmp_path, "bimorph.length=14mm:18mm:9", models=("solid",))
    (grid,) = data["grids"]
    assert len(grid["axes"][0]) == 201
    assert "solid: 201 points by its reduced basis" in page
    coarse = [float(answers["solid"].quantities[0].value) for answers in study.answers]
    fine = grid["numbers"][STATIC[0]]
    np.testing.assert_allclose(fine["value"][::25], coarse, rtol=1e-9)
    # no noise: the curve is a smooth one to far less than its bar
    places = np.linspace(-1.0, 1.0, 201)
    smooth = np.polynomial.Chebyshev.fit(places, fine["value"], 8)(places)
    assert (np.abs(smooth - fine["value"]) < 0.1 * np.array(fine["bar"])).all()


def test_samples_have_no_sliders_but_a_picture(tmp_path):
    _, page, data = written(tmp_path, "gap=0.1mm,0.2mm", models=("tmm",))
    assert data is not None
    _, page, data = written(tmp_path, "bimorph.length=normal(14mm,1%)", samples=4)
    assert data is None
    assert "<svg" in page
