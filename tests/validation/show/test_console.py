"""Tables are as wide as the terminal; in a file they are not folded to one."""

import io
import sys

import pytest

from tactgen.validation.show.browser import console


@pytest.mark.parametrize(("terminal", "width"), [(True, 61), (False, 170)])
def test_width(monkeypatch, terminal, width):
    """Whether standard output is a terminal decides, whatever stderr is."""
    for name, is_one in (("stdout", terminal), ("stderr", not terminal)):
        stream = io.StringIO()
        stream.isatty = lambda is_one=is_one: is_one
        monkeypatch.setattr(sys, name, stream)
    monkeypatch.setenv("COLUMNS", "61")
    assert console(170).width == width
