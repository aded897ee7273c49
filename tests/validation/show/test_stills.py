"""Stills and films: deterministic, with bar and scale, and what cannot be drawn is said."""

import io

import numpy as np
import pytest
from PIL import Image

from tactgen.geometry.errors import InputError
from tactgen.validation.show import stills as films
from tactgen.validation.show.field import SHADES, drawn_size
from tactgen.validation.show.stills import Picture, check_film, save_film, still, write_film

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


def test_a_film_is_one_period(seen, tmp_path, monkeypatch):
    """Pictures at even phases from 0, shown without end; what of it goes to ffmpeg."""
    shown, own = [], films.frames
    monkeypatch.setattr(films, "frames", lambda *given: shown.append(given) or own(*given))
    monkeypatch.setattr(films, "_FRAMES", 4)
    path, said = tmp_path / "mode.gif", []
    write_film(path, seen[1], seen[1].states[0], Picture(**SMALL), said.append)
    assert shown[0][3] == pytest.approx([0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi])
    assert said == [f"picture {k} of 4" for k in (1, 2, 3, 4)]
    with Image.open(path) as film:
        assert film.n_frames == 4
        assert (film.info["loop"], film.info["duration"]) == (0, 80)
    with pytest.raises(InputError, match='"static" does not move'):
        write_film(path, seen[1], seen[1].state("static"), Picture(**SMALL))


def test_what_ffmpeg_is_given(tmp_path, monkeypatch):
    """All pictures as often as they are repeated, size and rate; its last word where it fails."""
    folder = tmp_path / "bin"
    folder.mkdir()
    program = folder / "ffmpeg"

    def does(*lines):
        program.write_text("\n".join(["#!/bin/sh", *lines, ""]), encoding="utf-8")
        program.chmod(0o755)

    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    path, images = tmp_path / "a.mp4", [Image.new("RGB", (4, 2), (k, 0, 0)) for k in range(2)]
    does('for last; do :; done; cat > "$last"', f'printf "%s\\n" "$@" > "{tmp_path}/given"')
    save_film(path, images, 40, 3)
    assert path.read_bytes() == b"".join(image.tobytes() for image in images) * 3
    given = (tmp_path / "given").read_text(encoding="utf-8").splitlines()
    assert " ".join(given[:-1]) == (
        "-loglevel error -y -f rawvideo -pix_fmt rgb24 -s 4x2 -r 25 -i - -pix_fmt yuv420p "
        "-movflags +faststart -fflags +bitexact"
    )
    path.unlink()
    for words, told in (("some\\nlast word", "last word"), ("", "no reason")):
        does("cat > /dev/null", f'printf "{words}" >&2', "exit 1")
        with pytest.raises(InputError, match=rf"a\.mp4 was not made: ffmpeg says: {told}; write"):
            save_film(path, images, 40)
    assert not path.exists()


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
