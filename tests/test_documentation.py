"""The site leads to everything, its links are looked at, README names the commands there are."""

import re
import runpy
from pathlib import Path

import pytest

from tactgen.validation.command_line.cli import commands

ROOT = Path(__file__).parent.parent
PAGES = ROOT / "notebooks"
FAULTS = runpy.run_path(str(ROOT / ".setup" / "docs" / "check_links.py"))["faults"]


def test_every_page_is_in_the_index():
    """A notebook or a chapter that nobody can find is not there."""
    listed = set(re.findall(r"^[\w/]+$", (PAGES / "index.md").read_text("utf-8"), re.MULTILINE))
    there = {
        str(path.relative_to(PAGES).with_suffix(""))
        for path in [*PAGES.glob("*.py"), *PAGES.rglob("*.md")]
    }
    assert listed == there - {"index"}


def test_readme_names_every_command():
    """And no other."""
    text = (ROOT / "README.md").read_text("utf-8")
    table = text[text.index("| command |") :].partition("\n\n")[0]
    first = [line.split("|")[1] for line in table.splitlines()[2:]]
    named = {word for cell in first for word in re.findall(r"`(?:tactgen )?([a-z]+)", cell)}
    assert named == set(commands())


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md"])
def test_links_of_the_readme(name):
    """They lead to files that are there."""
    targets = re.findall(r"\]\(([^)#]+)\)", (ROOT / name).read_text("utf-8"))
    assert targets or name != "README.md"
    assert [t for t in targets if "://" not in t and not (ROOT / t).exists()] == []


@pytest.mark.parametrize(
    ("body", "fault"),
    [
        ('<a href="b.html#there">b</a><img src="data:image/png;base64,AA">', None),
        ('<a href="https://example.org/">elsewhere</a>', None),
        ('<a href="c.html">c</a>', "links to c.html, which is not there"),
        ('<a href="b.html#away">b</a>', "whose anchor is not there"),
        ('<script src="https://example.org/x.js"></script>', "loads https://example.org/x.js"),
        ('<link rel="stylesheet" href="lost.css">', "links to lost.css"),
    ],
)
def test_links_of_the_site(tmp_path, body, fault):
    """What leads nowhere, or is loaded from afar, is said."""
    (tmp_path / "a.html").write_text(body, "utf-8")
    (tmp_path / "b.html").write_text('<p id="there">b</p>', "utf-8")
    found = FAULTS(tmp_path)
    assert found == [] if fault is None else len(found) == 1 and fault in found[0]
