"""The documentation site: notebooks, guide, and a reference that the program writes itself."""

from __future__ import annotations

import logging
import sys
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

project = "tactgen"
author = "tactgen authors"
html_title = "tactgen"
html_theme = "furo"
html_show_copyright = False
html_show_sphinx = False
extensions = ["myst_nb"]
myst_heading_anchors = 3
# notebooks are plain scripts; each runs while the site is made, and must not fail
sys.path.insert(0, str(Path(__file__).parent))
nb_custom_formats = {".py": "percent_notebook.read"}
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_merge_streams = True
logging.getLogger("traitlets").setLevel(logging.WARNING)
# words on stderr (progress, warnings) are no part of a page
nb_output_stderr = "remove"


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Return a Markdown table."""
    lines = [head, ("---",) * len(head), *rows]
    cells = [[cell.replace("|", "\\|").replace("\n", " ") for cell in line] for line in lines]
    return "\n".join("| " + " | ".join(line) + " |" for line in cells)


def _commands() -> str:
    from tactgen.validation.command_line.cli import commands

    parts = []
    for name, parser in commands().items():
        parts.append(f"## `tactgen {name}`\n\n```text\n{parser.format_help().rstrip()}\n```")
    return "\n\n".join(parts)


def _keys() -> str:
    from tactgen.validation.scene.load import load_scene
    from tactgen.validation.scene.parameter_list import parameter_rows

    scene, _ = load_scene("paper")
    rows = [
        (f"`{row.key}`", row.text, row.meaning, row.source) for row in parameter_rows(scene, {})
    ]
    return _table(("key", "value in `paper`", "meaning", "source"), rows)


def _quantities() -> str:
    from tactgen.validation.catalogue.models import MODELS, gives
    from tactgen.validation.catalogue.quantities import QUANTITIES

    rows = []
    for name, row in QUANTITIES.items():
        able = ", ".join(model for model in MODELS if gives(model, name))
        rows.append((f"`{name}`", row.unit, row.meaning, able))
    return _table(("quantity", "unit", "meaning", "models"), rows)


def _models() -> str:
    from tactgen.validation.catalogue.models import MODELS

    rows = [(f"`{m.name}`", m.actuator, m.description, m.theory) for m in MODELS.values()]
    return _table(("model", "of the actuator", "what it is", "theory"), rows)


def _scenes() -> str:
    from tactgen.validation.scene.files import built_in_scenes
    from tactgen.validation.scene.load import load_scene

    rows = [(f"`{name}`", load_scene(name)[0].description) for name in built_in_scenes()]
    return _table(("scene", "what it is"), rows)


WRITTEN = {
    "commands": _commands,
    "keys": _keys,
    "models": _models,
    "quantities": _quantities,
    "scenes": _scenes,
}


class Written(SphinxDirective):
    """``{written} NAME``: a part of the reference that the program knows best."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the part as nodes of the page."""
        return self.parse_text_to_nodes(WRITTEN[self.arguments[0]](), allow_section_headings=True)


def setup(app: Sphinx) -> None:
    """Tell Sphinx of the directive."""
    app.add_directive("written", Written)
