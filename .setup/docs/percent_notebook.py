"""Notebooks that are plain scripts (py:percent), as the site's maker reads them."""

from __future__ import annotations

from typing import Any

import jupytext


def read(text: str) -> Any:
    """Return a script as a notebook of this Python."""
    notebook = jupytext.reads(text, fmt="py:percent")
    notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python"}
    notebook.metadata["language_info"] = {"name": "python"}
    return notebook
