"""A browser that prints pages: stand-ins of a few lines for Chromium, which do as they are told."""

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.show import browser


@pytest.fixture
def told_to(tmp_path):
    """Return a function that makes a program of lines of shell."""

    def make(*lines):
        path = tmp_path / "chromium"
        path.write_text("\n".join(["#!/bin/sh", *lines, ""]), encoding="utf-8")
        path.chmod(0o755)
        return str(path)

    return make


def test_a_page_is_opened_with_a_profile_of_its_own(told_to):
    """Flags, options, the address last; what is written comes back as text, also if it fails."""
    done = browser.run_browser(
        told_to('printf "%s\\n" "$@"', "echo µ >&2", "exit 3"), "page", "--a", "--b"
    )
    *flags, profile, one, two, address = done.stdout.splitlines()
    assert tuple(flags) == browser.FLAGS
    assert profile.startswith("--user-data-dir=/")
    assert (one, two, address) == ("--a", "--b", "page")
    assert (done.stderr, done.returncode) == ("µ\n", 3)


def test_a_browser_that_hangs_is_said(told_to, monkeypatch):
    monkeypatch.setattr(browser, "_LONGEST", 0.05)
    with pytest.raises(InputError, match=r"chromium did not finish page in 0\.05 s; try again"):
        browser.run_browser(told_to("exec sleep 9"), "page")


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


def test_the_first_browser_that_is_there_is_taken(monkeypatch):
    there = {"google-chrome": "/g", "chrome": "/c"}
    monkeypatch.setattr(browser.shutil, "which", there.get)
    assert browser.find_browser() == browser.need_browser("--pdf") == "/g"
