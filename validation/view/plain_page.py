"""A plain self-contained page: a title and parts, no request to anywhere."""

from __future__ import annotations

import html
from collections.abc import Sequence

from tactgen.validation.view.page.html import document

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
    """Return the page's text; `parts` are HTML, the title is text."""
    body = "\n".join(parts)
    head = f"<style>{_STYLE}</style>\n"
    return document(title, head, f"<main>\n<h1>{html.escape(title)}</h1>\n{body}\n</main>\n")


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table of texts."""

    def line(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    body = "\n".join(line(row, "td") for row in rows)
    return f'<div class="wide"><table>\n{line(head, "th")}\n{body}\n</table></div>'
