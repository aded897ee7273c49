"""A browser that prints pages, and the pages of anchors in its PDF."""

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.show import browser
from tactgen.validation.show.browser import anchor_pages


@pytest.fixture
def told_to(tmp_path):
    """Return a function that makes a program of lines of shell."""

    def make(*lines):
        path = tmp_path / "chromium"
        path.write_text("\n".join(["#!/bin/sh", *lines, ""]), encoding="utf-8")
        path.chmod(0o755)
        return str(path)

    return make


TARGET = 'for a; do case "$a" in --print-to-pdf=*) file="${a#--print-to-pdf=}";; esac; done'


@pytest.mark.parametrize(
    ("lines", "held"),
    [
        ([TARGET, 'printf "%s\\n" "$@" > "$file"'], True),
        ([TARGET, 'echo half > "$file"', "exit 1"], False),
        ([TARGET, ': > "$file"'], False),
        (["exit 0"], False),
    ],
)
def test_a_page_is_printed_or_that_is_said(lines, held, told_to, tmp_path):
    """Not if it fails, writes nothing, or an empty file."""
    page, target = tmp_path / "page.html", tmp_path / "page.pdf"
    page.write_text("<p>", encoding="utf-8")
    program = told_to(*lines)
    if not held:
        with pytest.raises(InputError, match=r"did not print .*page\.html; open the page"):
            browser.print_pdf(program, page, target)
        return
    browser.print_pdf(program, page, target)
    said = target.read_text(encoding="utf-8").splitlines()
    assert said[-1] == page.as_uri()
    assert {"--virtual-time-budget=15000", "--no-pdf-header-footer"} < set(said)


#: Objects by number: pages 5, 15, 25 below nested nodes, and an anchor on what is no page.
OBJECTS = {
    1: "<</Creator (Chromium)>>",
    15: "<</Type /Page /Parent 4 0 R>>",
    25: "<</Type /Page\n/Parent 3 0 R>>",
    5: "<</Type /Page /Parent 4 0 R>>",
    4: "<</Type /Pages /Kids [5 0 R\n15 0 R] /Count 2>>",
    14: "<</Type /Pages /Kids [25 0 R] /Count 1>>",
    3: "<</Type /Pages /Kids [4 0 R 25 0 R] /Count 3>>",
    12: "<</what [25 0 R /XYZ 0 700 0]>>",
    2: "<</what [5 0 R /XYZ 0 700 0]\n/response [15 0 R /XYZ 0 1 0]\n/plan [25 0 R /XYZ 0 0 0]\n"
    "/lost [9 0 R /XYZ 0 0 0]\n/odd [5 0 R /Fit]>>",
    7: "<</Type /Catalog\n/Pages 3 0 R\n/Dests 2 0 R>>",
}


def pdf(objects):
    body = "".join(f"{number} 0 obj\n{text}\nendobj\n" for number, text in objects.items())
    return f"%PDF-1.4\n{body}trailer\n".encode()


def test_each_anchor_has_its_page():
    """In the order of the tree, whatever their numbers; 2 is not 12, nor 5 the end of 15."""
    assert anchor_pages(pdf(OBJECTS)) == {"what": 1, "response": 2, "plan": 3}


def test_of_another_pdf_nothing_is_told():
    """Without pages, without anchors, without a catalogue, with references to nothing."""
    for catalogue in ("/Pages 3 0 R", "/Dests 2 0 R", "/Pages 8 0 R\n/Dests 8 0 R"):
        changed = {**OBJECTS, 7: f"<</Type /Catalog\n{catalogue}>>"}
        assert anchor_pages(pdf(changed)) == {}
    assert anchor_pages(b"%PDF-1.4 of another program") == {}
