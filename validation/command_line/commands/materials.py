"""``tactgen materials``: the library of ceramics and shims, and what a scene's constants make."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tactgen.validation.command_line.commands.common import Commands
from tactgen.validation.command_line.streams import print_json

if TYPE_CHECKING:
    from tactgen.geometry.device.parameters import Piezo, Shim

#: Keys of ceramics and of shims that are shown.
_KEYS = (
    "s11", "d31", "eps33", "density", "quality_factor", "loss_tangent", "youngs_modulus",
    "poisson_ratio", "shear_modulus",
)  # fmt: skip


def add(commands: Commands) -> None:
    """Declare ``materials``."""
    parser = commands.add_parser("materials", help="list the library of materials, or show one")
    parser.add_argument(
        "name", metavar="NAME", nargs="?", help="a material, or a scene whose materials are shown"
    )
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    from tactgen.geometry.device.ceramic_constants import tabulated
    from tactgen.geometry.device.parameters import Piezo, sources
    from tactgen.validation.scene.parameter_list import show

    found = []
    for of in _chosen(options.name):
        values = {key: of.value(key) for key in _KEYS if key in type(of).model_fields}
        shown = "; ".join(f"{key} {show(v, of.declaration(key))}" for key, v in values.items())
        constants = str(tabulated(of.ceramic())) if isinstance(of, Piezo) else "none"
        source = sources(of)["density"]
        library = type(of)(material=of.material)
        stated = [key for key, value in values.items() if library.value(key) != value]
        if stated:
            source = f"{', '.join(stated)} stated; else {source}"
        found.append({"name": of.material, "source": source, "constants": constants, **values})
        if options.json:
            continue
        print(f"{of.material:16} {shown}")
        if options.name:
            print(f"constants: {constants}\nsource: {source}")
    if options.json:
        print_json(found)
    return 0


def _chosen(name: str | None) -> list[Piezo | Shim]:
    """All materials, one by its name, or those of a scene's layers."""
    from tactgen.geometry.bimorph.segments import bimorph_stack
    from tactgen.geometry.device.ceramic_library import LIBRARY, library_name
    from tactgen.geometry.device.parameters import Piezo, Shim
    from tactgen.geometry.device.shim_library import PAPERS, SHIMS, shim_name
    from tactgen.geometry.errors import InputError
    from tactgen.geometry.synonyms import nearest
    from tactgen.geometry.units import quoted
    from tactgen.validation.scene.files import built_in_scenes
    from tactgen.validation.scene.load import load_scene

    ceramics, shims = tuple(LIBRARY), (PAPERS, *SHIMS)
    if name is None:
        return [*(Piezo(material=of) for of in ceramics), *(Shim(material=of) for of in shims)]
    if ceramic := library_name(name):
        return [Piezo(material=ceramic)]
    if shim := shim_name(name):
        return [Shim(material=shim)]
    if name in built_in_scenes() or Path(name).exists():
        layers = bimorph_stack(load_scene(name)[0].device)
        used = [of.material for of in layers if isinstance(of.material, Piezo | Shim)]
        return list(dict.fromkeys(used))
    raise InputError(
        f"{quoted(name)} is neither a material of the library{nearest(name, (*ceramics, *shims))} "
        "nor a scene; tactgen materials lists all"
    )
