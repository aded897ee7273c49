"""Stills and films: deterministic, with bar and scale, and what cannot be drawn is said."""

import io

import numpy as np
import pytest
from approved import described
from PIL import Image

from tactgen.geometry.errors import InputError
from tactgen.validation.view import films
from tactgen.validation.view.films import check_film, write_film
from tactgen.validation.view.shading import SHADES, drawn_size, enlargement, shades_of, words_of
from tactgen.validation.view.stills import Picture, still

SMALL = {"width": 300, "height": 200}
STRESS = next(shade for shade in SHADES if shade.key == "stress_zz")


def pixels(png):
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)


def test_a_still_is_the_same_twice_and_moves_with_the_phase(seen):
    """The same bytes; half a period later the mode bends the other way and colours swap."""
    result = seen[0]
    state = result.state("mode 1, short circuit")
    picture = Picture(**SMALL, shade=STRESS)
    first, again, other = (still(result, state, picture, p) for p in (0.0, 0.0, np.pi))
    assert first == again
    assert pixels(first).shape == (200, 300, 3)
    middle = slice(60, 130)
    blue, red = (pixels(png)[middle].sum(axis=(0, 1)) @ [-1, 0, 1] for png in (first, other))
    assert blue * red < 0


def test_words_of_every_state_in_every_colour(seen, approved):
    """Titles, numbers and the ends of scales; lengths of rulers."""
    told = {
        f"{result.model}, {state.name}": [
            words_of(result, state), enlargement(result, state),
            {shade.key: shade.top(state) for shade in shades_of(result)},
        ]
        for result in seen
        for state in result.states
    }  # fmt: skip
    approved(described(told))


def test_a_still_has_words_a_bar_and_a_ruler(seen):
    """Above, below and to the right of the device there is ink, also without a shade."""
    result = seen[1]
    for shade in (SHADES[0], None):
        image = pixels(still(result, result.state("static"), Picture(**SMALL, shade=shade)))
        dark = (image < 200).any(axis=2)
        assert dark[:40, :150].any()
        assert dark[150:, :150].any()
        assert dark[165:, 220:].any()


def test_a_film_is_one_period(seen, tmp_path, monkeypatch):
    monkeypatch.setattr(films, "_FRAMES", 4)
    path = tmp_path / "mode.gif"
    write_film(path, seen[1], seen[1].states[0], Picture(**SMALL))
    with Image.open(path) as film:
        assert film.n_frames == 4
        assert film.info["loop"] == 0


def test_films_that_cannot_be_made_are_refused(seen, tmp_path, monkeypatch):
    result = seen[1]
    with pytest.raises(InputError, match='state "static" does not move'):
        check_film(tmp_path / "a.gif", result.state("static"))
    monkeypatch.setattr(films.shutil, "which", lambda _: None)
    with pytest.raises(InputError, match=r"--mp4 .* needs the program ffmpeg"):
        check_film(tmp_path / "a.mp4", result.states[0])


def test_a_twist_is_drawn_small():
    """A tip that turns about its middle by half a radian, one that goes aside by 12 % of height."""
    corners = np.array([[x, y, z] for z in (0.0, 1.0) for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
    turned = np.column_stack([-corners[:, 1], corners[:, 0], 0 * corners[:, 0]]) * corners[:, 2:]
    aside = np.zeros_like(corners)
    aside[:, 0] = corners[:, 2]
    assert drawn_size(corners, turned) == pytest.approx(0.5 * np.hypot(0.1, 0.1))
    assert drawn_size(corners, aside) == pytest.approx(0.12)
