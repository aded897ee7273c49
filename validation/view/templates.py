"""Pages from templates: undefined names are errors, and numbers are written by formats.py."""

from __future__ import annotations

from importlib import resources
from typing import TYPE_CHECKING

from tactgen.geometry.formats import filters

if TYPE_CHECKING:
    from jinja2 import Environment


def page_templates(package: str) -> Environment:
    """Return the templates in the folder ``templates`` of a package."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(str(resources.files(package) / "templates")),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(filters())
    return environment
