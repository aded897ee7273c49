"""Films of a state: one period as .gif, or as .mp4 where ffmpeg is found."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.validation.fields.result import FieldResult, State
from tactgen.validation.view.stills import Picture, frames

if TYPE_CHECKING:
    from PIL.Image import Image

#: Pictures of one period, and milliseconds that each is shown.
_FRAMES, _SHOWN = 24, 80
#: Periods in an .mp4, which players do not repeat by themselves.
_REPEATS = 4


def check_film(path: Path, state: State) -> None:
    """Refuse a film before anything is drawn.

    Raises
    ------
    InputError
        If the state does not move, or an .mp4 is wanted and there is no ffmpeg.
    """
    if state.kind == "static":
        raise InputError(
            f'state "{state.name}" does not move, so there is no film of it; write --png, or '
            "choose a mode or a harmonic state with --state"
        )
    check_ffmpeg(path)


def check_ffmpeg(path: Path) -> None:
    """Refuse an .mp4 where there is no ffmpeg.

    Raises
    ------
    InputError
        With the remedy.
    """
    if path.suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise InputError(
            f"--mp4 {path} needs the program ffmpeg, which is not on this machine; install it "
            "(apt-get install ffmpeg), or write --gif"
        )


def write_film(
    path: Path,
    result: FieldResult,
    state: State,
    picture: Picture,
    announce: Callable[[str], None] = lambda _: None,
) -> None:
    """Write one period of a state; see :func:`check_film` for what is refused."""
    check_film(path, state)
    phases = [2.0 * np.pi * k / _FRAMES for k in range(_FRAMES)]
    save_film(path, frames(result, state, picture, phases, announce), _SHOWN, _REPEATS)


def save_film(path: Path, images: Sequence[Image], shown: int, repeats: int = 1) -> None:
    """Write pictures of one size as a film, each shown so many milliseconds.

    Parameters
    ----------
    repeats : int
        How often an .mp4 holds them all; a .gif starts again by itself.

    Raises
    ------
    InputError
        If the film cannot be made or written.
    """
    from PIL.Image import Dither

    check_ffmpeg(path)
    with written_whole(path) as temporary:
        if path.suffix == ".gif":
            # one palette for all pictures, so that nothing flickers
            palette = images[0].quantize(colors=255)
            indexed = [image.quantize(palette=palette, dither=Dither.NONE) for image in images]
            indexed[0].save(
                temporary, save_all=True, append_images=indexed[1:], duration=shown, loop=0
            )
            return
        raw = b"".join(image.tobytes() for image in images) * repeats
        size = "{}x{}".format(*images[0].size)
        command = [
            "ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", size, "-r", f"{1000.0 / shown:g}", "-i", "-", "-pix_fmt", "yuv420p",
            "-movflags", "+faststart", "-fflags", "+bitexact", str(temporary),
        ]  # fmt: skip
        done = subprocess.run(command, input=raw, capture_output=True, check=False)
        if done.returncode != 0:
            reason = done.stderr.decode(errors="replace").strip().splitlines() or ["no reason"]
            raise InputError(f"{path} was not made: ffmpeg says: {reason[-1]}; write --gif")
