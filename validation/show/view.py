"""Views of a scene as files: page, stills, films."""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text, written_whole
from tactgen.validation.engine.solve import asks_display
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.colours import Shade, shades_of
from tactgen.validation.show.export import check_place
from tactgen.validation.show.field import FieldResult
from tactgen.validation.show.gather import MAGNETIC, default_models, gather
from tactgen.validation.show.generator_body import standing

if TYPE_CHECKING:
    from tactgen.validation.show.lengths import LengthRange
    from tactgen.validation.show.page import Still

#: Endings of each kind of file.
SUFFIXES = {"out": (".html",), "png": (".png",), "gif": (".gif",), "mp4": (".mp4",)}
#: Most harmonic states of a page.
_MOST = 12
#: Stills for those who see no movement: their size in pixels.
_STILL = 480, 400


@dataclass(frozen=True)
class Look:
    """Request of a view: models (none: the fastest solid, and TMM), state, colour.

    `lengths` (m) are the ends of the page's length slider; None leaves it out.
    """

    models: tuple[str, ...] = ()
    frequencies: tuple[float, ...] | None = None
    state: str = ""
    shade: str = ""
    lengths: tuple[float, float] | None = None


def view(
    scene: Scene, look: Look, files: dict[str, Path], announce: Callable[[str], None]
) -> list[Path]:
    """Write a page, a still and films of a scene, and return their paths.

    Parameters
    ----------
    files : dict of {"out", "png", "gif", "mp4"} to Path
        What to write where.

    Raises InputError if the scene has nothing to show, a model, state or field is not there, or a
    file cannot be written.
    """
    from tactgen.validation.show.stills import Picture, check_film, still, write_film

    for kind, path in files.items():
        check_place(f"--{kind}", path, SUFFIXES[kind])
    if asks_display(scene.quantities) and not look.models:
        from tactgen.validation.show.display import view_display

        return view_display(scene, files, announce)
    ranges = _ranges(scene, look, files, announce)
    results = looked_at(scene, look, announce)
    first = results[0]
    state = first.state(look.state) if look.state else first.states[0]
    shade = _shade(first, look)
    for kind in ("gif", "mp4"):
        if kind in files:
            check_film(files[kind], state)
    for kind, path in files.items():
        if kind == "out":
            announce("page")
            write_text(path, page_of(results, announce, ranges))
        elif kind == "png":
            announce("still")
            with written_whole(path) as temporary:
                temporary.write_bytes(still(first, state, Picture(shade=shade)))
        else:
            write_film(path, first, state, Picture(800, 480, shade), announce)
    return list(files.values())


def looked_at(scene: Scene, look: Look, announce: Callable[[str], None]) -> list[FieldResult]:
    """Fields of a scene by the models of a view."""
    models = look.models or _models(scene)
    found = gather(scene, models, look.frequencies, "edges", announce)
    # a slider of the length moves the bimorph's points only
    return found if look.lengths else [standing(scene, result) for result in found]


def _ranges(
    scene: Scene, look: Look, files: dict[str, Path], announce: Callable[[str], None]
) -> list[LengthRange | None]:
    """Modes over the lengths that the page's slider has, by model."""
    if look.lengths is None:
        return []
    from tactgen.validation.show.lengths import length_range

    if "out" not in files:
        raise InputError("--lengths makes a slider in the page; give --out FILE.html too")
    models = look.models or _models(scene)
    if MAGNETIC in models:
        raise InputError(
            f"--lengths is about the bimorph, which the model {MAGNETIC} does not know; name a "
            "model of the lateral actuator"
        )
    found = [length_range(scene, name, look.lengths, announce) for name in models]
    if not any(found):
        raise InputError(
            f"--lengths needs a model with a fast way to many lengths, which {', '.join(models)} "
            "has not in this scene; add --model tmm"
        )
    return found


def _models(scene: Scene) -> tuple[str, ...]:
    """Fastest solid of a scene, and transfer matrices beside it."""
    first = default_models(scene)
    alone = first in {("tmm",), (MAGNETIC,)} or "tmm" not in scene.models
    return first if alone else (*first, "tmm")


def _shade(result: FieldResult, look: Look) -> Shade | None:
    if not look.shade:
        return None
    known = shades_of(result)
    for shade in known:
        if shade.key == look.shade:
            return shade
    raise InputError(
        f"--field {look.shade} is not a field of the model {result.model}, which has "
        f"{', '.join(shade.key for shade in known)}"
    )


def page_of(
    results: Sequence[FieldResult],
    announce: Callable[[str], None],
    ranges: Sequence[LengthRange | None] = (),
) -> str:
    """Page in which the results move: HTML that holds all it needs."""
    from tactgen.validation.show.page import page
    from tactgen.validation.show.viewer import payload

    stills = page_stills(results[0], announce)
    title = f"{results[0].scene}: modes and fields"
    return page(title, payload(results, ranges), stills)


def page_stills(result: FieldResult, announce: Callable[[str], None]) -> list[Still]:
    """Stills of the first modes, for those who see no movement."""
    from tactgen.validation.show.stills import captioned

    found = []
    chosen = [s for s in result.states if s.circuit == "short"] or list(result.states)
    for state in chosen[:2]:
        announce(f"still of {state.name}")
        found.append(captioned(result, state, _STILL))
    return found


def harmonic_frequencies(scene: Scene) -> tuple[float, ...]:
    """Scene's frequencies (Hz) as those of harmonic states.

    Raises InputError if one is not above 0 Hz, or there are more than a page can hold.
    """
    if min(scene.frequency) <= 0.0:
        raise InputError(
            f"frequency = {min(scene.frequency):g} Hz has no vibration to show; give one above "
            "0 Hz (the static state is there wherever something acts at rest)"
        )
    if len(scene.frequency) > _MOST:
        raise InputError(
            f"frequency has {len(scene.frequency)} values, each a solution and a state of its own; "
            f"give at most {_MOST}"
        )
    return scene.frequency


@dataclass(frozen=True)
class InlineView:
    """A page that notebooks show in a frame of its own."""

    page: str  #: HTML that holds all it needs
    height: int = 720  #: Of the frame (pixels)

    def _repr_html_(self) -> str:
        """Frame; the page is inside it, so that a copied notebook still shows it."""
        return (
            f'<iframe srcdoc="{html.escape(self.page)}" loading="lazy" title="modes and fields" '
            f'style="width:100%;height:{self.height}px;border:0"></iframe>'
        )


def show(scene: Scene, models: Sequence[str] = (), frequencies: Sequence[float] = ()) -> InlineView:
    """Modes and fields of a scene as a notebook's cell output.

    Parameters
    ----------
    models : sequence of str
        One, or two to stand side by side; none: the fastest solid, and TMM beside it.
    frequencies : sequence of float
        Of driven states (Hz); none: half the first natural frequency, and that.

    Raises InputError if the scene has nothing to show, or a model is not there.
    """
    look = Look(models=tuple(models), frequencies=tuple(frequencies) or None)

    def quiet(stage: str) -> None:
        """Say nothing of a stage."""

    return InlineView(page_of(looked_at(scene, look, quiet), quiet))
