"""``tactgen view``: files as asked for, and one sentence for what cannot be shown."""

import html

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.generator_body import standing
from tactgen.validation.show.view import Look, _models, harmonic_frequencies, looked_at, show, view
from tactgen.validation.show.viewer import payload

QUICK = ["j1", "--set", "models=tmm", "--set", "modes=2"]


def test_a_slider_of_the_length_moves_the_bimorph_alone():
    """Else the rod below it is there too, as a rigid body."""
    contact, _ = load_scene("generator", ["models=tmm", "modes=1", "quantities=tip_displacement"])
    for ends, rod in (((18e-3, 22e-3), []), (None, ["rod", "coil"])):
        (result,) = looked_at(contact, Look(lengths=ends, frequencies=()), str)
        shown = payload([result])["results"][0]["regions"]
        assert [r["name"] for r in shown if r["rigid"]] == rod
    held = load_scene("paper", ["models=tmm"])[0]
    assert standing(held, result) is result


def test_a_notebook_holds_the_page():
    """In a frame that asks for no other file."""
    scene, _ = load_scene("j1", ["modes=2"])
    shown = show(scene, ["tmm"], [500.0])
    frame = shown._repr_html_()
    assert '"name":"500 Hz"' in shown.page
    assert html.unescape(frame.partition('srcdoc="')[2].partition('"')[0]) == shown.page
    assert ' src="' not in frame
    assert "height:720px" in frame


@pytest.mark.parametrize(
    ("look", "files", "words"),
    [
        (Look(state="mode 9"), {"png": "a.png"}, r'state "mode 9" is unknown to the model tmm'),
        (Look(shade="stress_zz"), {"png": "a.png"}, "not a field of the model tmm, which has size"),
        (Look(models=("network",)), {"out": "a.html"}, "network has no motion or field to show"),
        (Look(), {"out": "a.txt"}, r"--out .* must end in .html"),
        (Look(lengths=(2e-2, 1e-2)), {"out": "a.html"}, "20 mm to 10 mm; begin below"),
        (Look(lengths=(1e-2, 2e-2)), {"png": "a.png"}, "slider in the page; give --out"),
        (Look(), {"gif": "none/a.gif"}, "its folder does not exist"),
    ],
)
def test_what_cannot_be_shown_is_one_sentence(look, files, words, tmp_path):
    scene, _ = load_scene("j1", ["models=tmm", "modes=1"])
    with pytest.raises(InputError, match=words):
        view(scene, look, {k: tmp_path / v for k, v in files.items()}, lambda _: None)
    assert not list(tmp_path.iterdir())


def test_frequencies_of_driven_states():
    """Above 0 Hz, and not more than a page can hold."""
    for given, words in (("0", "has no vibration to show"), ("10:100:50", "give at most 12")):
        scene, _ = load_scene("j1", [f"frequency={given}"])
        with pytest.raises(InputError, match=words):
            harmonic_frequencies(scene)


def test_lengths_that_no_scene_has_end_with_2(capsys):
    """No range, no unit, no length of a bimorph."""
    for given, words in (
        ("20mm", "--lengths 20mm is not a range"),
        ("1:2mm", 'bimorph.length = "1" has no unit'),
        ("-1mm:9mm", "bimorph.length"),
    ):
        assert main(["view", *QUICK, f"--lengths={given}"]) == 2
        assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("models", "shown"),
    [
        ("lumped,tmm,solid,cad", ("solid", "tmm")), ("cad,tmm", ("cad", "tmm")),
        ("beam,solid", ("solid",)), ("lumped,beam,tmm", ("tmm",)), ("lumped,beam", ("beam",)),
        ("lumped", ("lumped",)), ("network,axisymmetric", ("axisymmetric",)),
        ("tmm,axisymmetric", ("tmm",)),
    ],
)  # fmt: skip
def test_the_fastest_solid_is_shown_with_transfer_matrices_beside_it(models, shown):
    """As far as the scene asks for them; else a row of beams, else the field."""
    assert _models(load_scene("paper", [f"models={models}"])[0]) == shown
