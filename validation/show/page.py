"""The page itself: one file with script, style, data and stills, that asks nothing of a network."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from typing import TYPE_CHECKING, Any

from tactgen.geometry.formats import filters

if TYPE_CHECKING:
    from jinja2 import Environment


#: What a browser may do with the page: run what is in it, and load nothing.
_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"


@dataclass(frozen=True)
class Still:
    """Still picture for a page: PNG bytes and caption."""

    png: bytes
    caption: str

    @property
    def source(self) -> str:
        """Picture as an address that contains it."""
        return inline(self.png)


def fragment(
    data: dict[str, Any], stills: Sequence[Still], *, light: bool = False, name: str = "tv-data"
) -> str:
    """Viewer as a part of a page that also has :func:`assets`.

    With `light` it stays light where the reader's system is dark, as the page around it.
    Where a page has two viewers, each has its own `name`.
    """
    pictures = "".join(
        f'<figure><img alt="{html.escape(s.caption)}" src="{s.source}">'
        f"<figcaption>{html.escape(s.caption)}</figcaption></figure>"
        for s in stills
    )
    return (
        f"{data_script(name, data)}\n"
        f'<div class="tv{" tv-light" if light else ""}" data-payload="{name}">\n'
        f'<div class="tv-stills" hidden><p class="tv-why"></p>{pictures}</div>\n'
        "<noscript><style>.tv .tv-stills[hidden]{display:block!important}</style>"
        "<p>Scripts are off, so nothing moves here. Still pictures:</p></noscript>\n</div>\n"
    )


def data_script(name: str, data: dict[str, Any]) -> str:
    """Data as an element of this name that a page's script reads."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    return f'<script type="application/json" id="{name}">{text}</script>'


def assets() -> str:
    """Script and style of the viewer, which a page needs once."""
    return (
        f"<style>{asset('viewer.css')}</style>\n{library()}<script>{asset('viewer.js')}</script>\n"
    )


def library() -> str:
    """Scripts of pictures in space and of packed data, which a page needs once."""
    return f"<script>{asset('three.min.js')}</script>\n<script>{asset('unpacked.js')}</script>\n"


def page(title: str, data: dict[str, Any], stills: Sequence[Still]) -> str:
    """Whole page with the viewer alone."""
    head = (
        f"{assets()}<style>html,body{{margin:0;height:100%}}.tv{{min-height:100%}}"
        "@media (min-width:48.01rem){.tv{height:100vh;grid-template-rows:minmax(0,1fr)}}</style>\n"
    )
    return document(title, head, fragment(data, stills))


def document(title: str, head: str, body: str) -> str:
    """Whole page that loads nothing, with more of its own in head and body."""
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{html.escape(title)}</title>\n{head}</head>\n<body>\n{body}</body>\n</html>\n"
    )


def inline(png: bytes) -> str:
    """Picture as an address that contains it."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def asset(name: str) -> str:
    """Text of a script or style sheet in the folder ``assets``."""
    return (resources.files("tactgen.validation.show") / "assets" / name).read_text(
        encoding="utf-8"
    )


def page_templates(package: str) -> Environment:
    """Templates in the folder ``templates`` of a package."""
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


_STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 "Source Sans 3", "Segoe UI", "Helvetica Neue", Arial, sans-serif;
  color: #1d2733; background: #e9eef3; margin: 0; }
main { max-width: 1080px; margin: 24px auto; background: #fff; padding: 36px 48px 56px; }
h1 { font-size: 26px; margin: 0 0 8px; } h2 { font-size: 19px; margin: 32px 0 8px; }
p { max-width: 76ch; } figure { margin: 12px 0; } figure svg { width: 100%; height: auto; }
table { border-collapse: collapse; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th { text-align: left; border-bottom: 2px solid #1d2733; padding: 4px 8px; }
td { border-bottom: 1px solid #d8dfe6; padding: 4px 8px; }
figcaption { color: #5b6b7b; font-size: 13px; }
.pair { display: flex; gap: 32px; justify-content: space-around; align-items: end; }
.wide { overflow-x: auto; } input[type=range] { width: 60%; vertical-align: middle; }
@media print { body { background: white; } main { margin: 0; padding: 0; max-width: none; } }
"""


def plain_page(title: str, parts: Sequence[str]) -> str:
    """Page's text; `parts` are HTML, the title is text."""
    body = "\n".join(parts)
    head = f"<style>{_STYLE}</style>\n"
    return document(title, head, f"<main>\n<h1>{html.escape(title)}</h1>\n{body}\n</main>\n")


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Table of texts."""

    def line(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    body = "\n".join(line(row, "td") for row in rows)
    return f'<div class="wide"><table>\n{line(head, "th")}\n{body}\n</table></div>'
