"""Films of a state: one period as .gif, or as .mp4 where ffmpeg is found."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.validation.fields.result import FieldResult, State
from tactgen.validation.view.stills import Picture, frames

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
    from PIL.Image import Dither

    images = frames(result, state, picture, phases, announce)
    with written_whole(path) as temporary:
        if path.suffix == ".gif":
            # one palette for all pictures, so that nothing flickers
            palette = images[0].quantize(colors=255)
            indexed = [image.quantize(palette=palette, dither=Dither.NONE) for image in images]
            indexed[0].save(
                temporary, save_all=True, append_images=indexed[1:], duration=_SHOWN, loop=0
            )
            return
        raw = b"".join(image.tobytes() for image in images) * _REPEATS
        size = f"{picture.width}x{picture.height}"
        command = [
            "ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", size, "-r", f"{1000.0 / _SHOWN:g}", "-i", "-", "-pix_fmt", "yuv420p",
            "-movflags", "+faststart", "-fflags", "+bitexact", str(temporary),
        ]  # fmt: skip
        done = subprocess.run(command, input=raw, capture_output=True, check=False)
        if done.returncode != 0:
            reason = done.stderr.decode(errors="replace").strip().splitlines() or ["no reason"]
            raise InputError(f"{path} was not made: ffmpeg says: {reason[-1]}; write --gif")
