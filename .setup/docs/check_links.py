"""Every link and picture of the site leads to a file that is there; nothing is loaded from afar."""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """A page's links, what it loads, and its anchors."""

    def __init__(self, text: str) -> None:
        """Read the page."""
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.anchors: set[str] = {""}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep what a tag points to, and the names it can be found by."""
        given = dict(attrs)
        self.anchors |= {given[key] or "" for key in ("id", "name") if key in given}
        self.links += [given["href"] or ""] if tag == "a" and "href" in given else []
        if tag in ("script", "img", "iframe") and given.get("src"):
            self.loads.append(given["src"] or "")
        if tag == "link" and given.get("rel") in ("stylesheet", "icon"):
            self.loads.append(given.get("href") or "")


def faults(site: Path) -> list[str]:
    """Return a sentence for each link that leads nowhere and each thing loaded from afar."""
    pages = {path: Page(path.read_text("utf-8")) for path in sorted(site.rglob("*.html"))}
    found = []
    for path, page in pages.items():
        here = path.relative_to(site)
        for target in page.links + page.loads:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                if target in page.loads and parts.scheme != "data":
                    found.append(f"{here} loads {target}")
                continue
            aim = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not aim.is_file():
                found.append(f"{here} links to {target}, which is not there")
            elif aim in pages and unquote(parts.fragment) not in pages[aim].anchors:
                found.append(f"{here} links to {target}, whose anchor is not there")
    return found


if __name__ == "__main__":
    sentences = faults(Path(sys.argv[1]).resolve())
    print("\n".join(sentences), file=sys.stderr)
    sys.exit(bool(sentences))
