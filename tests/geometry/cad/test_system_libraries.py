"""What needs a system library says so in one sentence, before anything that would crash."""

import ctypes
import resource
import sys

import pytest

from tactgen.geometry.cad.display import display_assembly, display_solids
from tactgen.geometry.cad.solids import build_solids
from tactgen.geometry.device.parameters import Device, Display
from tactgen.geometry.errors import InputError
from tactgen.validation.show.pictures import off_screen


@pytest.mark.parametrize(
    ("what", "names"),
    [
        (lambda: build_solids(Device()), ["libGL.so.1"]),
        (lambda: display_assembly(Device(), Display()), ["libGL.so.1"]),
        (lambda: display_solids(Device(), Display()), ["libGL.so.1"]),
        (off_screen, ["libGL.so.1", "libOSMesa.so.8"]),
    ],
)
def test_a_missing_library_is_named_with_its_package(what, names, monkeypatch):
    """Of each that is missing; the import that would fail for want of it is not tried."""
    for heavy in ("cadquery", "pyvista"):
        monkeypatch.setitem(sys.modules, heavy, None)
    for missing in names:

        def load(name, missing=missing):
            if name == missing:
                raise OSError

        monkeypatch.setattr(ctypes, "CDLL", load)
        with pytest.raises(InputError, match=f"{missing}, which is missing; .* apt-get install"):
            what()


def test_too_little_room_is_said(monkeypatch):
    """VTK would crash the process; without a limit nothing is asked."""
    monkeypatch.setitem(sys.modules, "pyvista", None)
    monkeypatch.setattr(resource, "getrlimit", lambda _: (2**20, 2**20))
    with pytest.raises(InputError, match=r"0\.8 GB of address space, .* 0\.0 GB more; raise"):
        off_screen()
    monkeypatch.setattr(resource, "getrlimit", lambda _: (resource.RLIM_INFINITY,) * 2)
    with pytest.raises(ImportError):
        off_screen()
