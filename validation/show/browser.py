"""A Chromium without a window, where there is one: it prints pages to PDF."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from tactgen.geometry.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console


#: Names that Chromium goes by, the first found is taken.
_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
#: Without a window; on a machine without graphics WebGL is drawn by the processor.
FLAGS = (
    "--headless=new", "--no-sandbox", "--hide-scrollbars", "--disable-extensions",
    "--no-first-run", "--disable-background-networking", "--use-gl=angle",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
)  # fmt: skip
#: Longest time (s) that it may take over one page.
_LONGEST = 180.0


def find_browser() -> str | None:
    """Path of a Chromium, None if there is none."""
    return next((path for name in _NAMES if (path := shutil.which(name))), None)


def need_browser(option: str) -> str:
    """Path of a Chromium.

    Raises InputError if there is none, naming the option that needs it.
    """
    found = find_browser()
    if found is None:
        raise InputError(
            f"{option} needs a Chromium or Chrome browser, and none of {', '.join(_NAMES)} is on "
            "this machine; install one (apt-get install chromium), or print the page from your own"
        )
    return found


def run_browser(path: str, address: str, *options: str) -> subprocess.CompletedProcess[str]:
    """Open a page in a headless browser, and return its output.

    Raises InputError if the browser does not end in time.
    """
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [path, *FLAGS, f"--user-data-dir={profile}", *options, address]
        try:
            return subprocess.run(
                command, capture_output=True, text=True, timeout=_LONGEST, check=False
            )
        except subprocess.TimeoutExpired as error:
            raise InputError(
                f"{path} did not finish {address} in {_LONGEST:g} s; try again when the machine "
                "is less busy"
            ) from error


def print_pdf(browser: str, page: Path, target: Path) -> None:
    """Print a page to a PDF; its own style says sizes, margins and page numbers.

    Raises InputError if the browser does not write it.
    """
    done = run_browser(
        browser,
        page.resolve().as_uri(),
        "--virtual-time-budget=15000",
        "--no-pdf-header-footer",
        f"--print-to-pdf={target}",
    )
    if done.returncode != 0 or not target.exists() or target.stat().st_size == 0:
        raise InputError(f"{browser} did not print {page}; open the page and print it by hand")


def anchor_pages(pdf: bytes) -> dict[str, int]:
    """Page, counted from 1, of each named destination; nothing of another PDF."""
    written = re.findall(rb"(?:^|\n)(\d+) 0 obj\n(.*?)\nendobj", pdf, re.DOTALL)
    objects: dict[bytes, bytes] = dict(written)
    root = next((body for body in objects.values() if b"/Type /Catalog" in body), b"")
    pages, named = (re.search(rb"/%s (\d+) 0 R" % key, root) for key in (b"Pages", b"Dests"))
    if not pages or not named:
        return {}

    def leaves(node: bytes) -> list[bytes]:
        """Objects of the pages below a node of the page tree, in order."""
        kids = re.search(rb"/Kids \[(.*?)\]", objects.get(node, b""), re.DOTALL)
        if kids is None:
            return [node]
        return [page for kid in re.findall(rb"(\d+) 0 R", kids[1]) for page in leaves(kid)]

    number = {page: at for at, page in enumerate(leaves(pages[1]), start=1)}
    found = re.findall(rb"/([^\s/\[]+) \[(\d+) 0 R /XYZ", objects.get(named[1], b""))
    return {name.decode("ascii", "replace"): number[page] for name, page in found if page in number}


def console(wide: int) -> Console:
    """Standard output: as wide as the terminal, of so many columns where it is none."""
    from rich.console import Console

    return Console(width=None if sys.stdout.isatty() else wide)
