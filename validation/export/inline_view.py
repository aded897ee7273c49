"""The moving page inside a notebook."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass

from tactgen.validation.export.view import Look, looked_at, page_of
from tactgen.validation.scene.scene import Scene


@dataclass(frozen=True)
class InlineView:
    """A page that notebooks show in a frame of its own.

    Attributes
    ----------
    page : str
        HTML that holds all it needs.
    height : int
        Of the frame (pixels).
    """

    page: str
    height: int = 720

    def _repr_html_(self) -> str:
        """Return the frame; the page is inside it, so that a copied notebook still shows it."""
        return (
            f'<iframe srcdoc="{html.escape(self.page)}" loading="lazy" title="modes and fields" '
            f'style="width:100%;height:{self.height}px;border:0"></iframe>'
        )


def show(scene: Scene, models: Sequence[str] = (), frequencies: Sequence[float] = ()) -> InlineView:
    """Return modes and fields of a scene as what a notebook shows when it is a cell's last value.

    Parameters
    ----------
    models : sequence of str
        One, or two to stand side by side; none: the fastest solid, and TMM beside it.
    frequencies : sequence of float
        Of driven states (Hz); none: half the first natural frequency, and that.

    Raises
    ------
    InputError
        If the scene has nothing to show, or a model is not there.
    """
    look = Look(models=tuple(models), frequencies=tuple(frequencies) or None)

    def quiet(stage: str) -> None:
        """Say nothing of a stage."""

    return InlineView(page_of(looked_at(scene, look, quiet), quiet))
