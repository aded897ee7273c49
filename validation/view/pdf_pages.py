"""On which page of a PDF that Chromium has printed each anchor of the page came to stand.

Chromium writes catalogue, pages and named destinations in plain text.  No PDF reader: what is
not found is left out.
"""

from __future__ import annotations

import re

_OBJECT = rb"%d 0 obj\n(.*?)\nendobj"
_REFERENCE = re.compile(rb"(\d+) 0 R")


def anchor_pages(pdf: bytes) -> dict[str, int]:
    """Return the page, counted from 1, of each named destination; nothing of another PDF."""
    root = re.search(rb"/Type /Catalog\s(.*?)\nendobj", pdf, re.DOTALL)
    pages = root and re.search(rb"/Pages (\d+) 0 R", root[1])
    named = root and re.search(rb"/Dests (\d+) 0 R", root[1])
    if not pages or not named:
        return {}
    number = {page: at for at, page in enumerate(_leaves(pdf, int(pages[1])), start=1)}
    found = re.findall(rb"/([^\s/\[]+) \[(\d+) 0 R /XYZ", _body(pdf, int(named[1])))
    return {
        name.decode("ascii", "replace"): number[int(page)]
        for name, page in found
        if int(page) in number
    }


def _leaves(pdf: bytes, node: int) -> list[int]:
    """Return the objects of the pages below a node of the page tree, in order."""
    body = _body(pdf, node)
    kids = re.search(rb"/Kids \[(.*?)\]", body, re.DOTALL)
    if kids is None:
        return [node]
    return [page for kid in _REFERENCE.findall(kids[1]) for page in _leaves(pdf, int(kid))]


def _body(pdf: bytes, number: int) -> bytes:
    found = re.search(rb"(?:^|\n)" + _OBJECT % number, pdf, re.DOTALL)
    return found[1] if found else b""
