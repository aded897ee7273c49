"""All that cheap geometry says, as approved: sizes, names, counts and refusals."""

from functools import partial

import numpy as np
import pytest

from tactgen.geometry.bimorph.bimorph_bricks import LEVELS, bimorph_bricks
from tactgen.geometry.bimorph.pieces import beam_pieces
from tactgen.geometry.bimorph.rod_bricks import ROD_LEVELS, rod_bricks, rod_parts
from tactgen.geometry.bimorph.stretching import LEVELS as LONG_LEVELS
from tactgen.geometry.bimorph.stretching import dividing
from tactgen.geometry.device.groups.declaration import Parameters
from tactgen.geometry.device.groups.display import Scatter, Skin
from tactgen.geometry.device.groups.operation import Beam, Drive, Limits, Load, Threshold
from tactgen.geometry.device.layout import closed_form_volumes, layout, moving_rings, total_height
from tactgen.geometry.device.parameters import Bimorph, Device, Display, Sleeve, Support
from tactgen.geometry.device.piezo_library import LIBRARY
from tactgen.geometry.device.shim_library import SHIMS
from tactgen.geometry.device.steel_library import SOFT_MAGNETS
from tactgen.geometry.device.winding import winding
from tactgen.geometry.display.bill import bill_of_parts, total_mass
from tactgen.geometry.display.clearances import clearances, footprint
from tactgen.geometry.display.layout import axes, display_parts, levels, spacer_axes
from tactgen.geometry.display.scattered_units import drawn_units
from tactgen.geometry.display.wiring import wiring
from tactgen.geometry.errors import InputError
from tactgen.geometry.reluctance.cell_tets import Cell, cell_mesh
from tactgen.geometry.reluctance.nine_tets import nine_mesh
from tactgen.geometry.reluctance.section_grid import graded_grid
from tactgen.geometry.reluctance.section_regions import actuator_regions
from tactgen.geometry.reluctance.sector_tets import Sector, sector_mesh
from tactgen.geometry.reluctance.team20 import Team20Meshing, team20_mesh
from tactgen.geometry.units import Unit
from tests.approved import described

PAPER = Device()
DEVICES = {
    "paper": PAPER,
    "foil": Device(
        bimorph=Bimorph(length=9e-3, width=1.7e-3, shim_thickness=30e-6, bare_below=0.6e-3),
        sleeve=Sleeve(outer_radius=1.1e-3),
    ),
    "thick": Device(
        bimorph=Bimorph(length=31e-3, tab_length=0.0, shim_thickness=0.6e-3, bare_above=2e-3)
    ),
    "glued": Device(bimorph=Bimorph(glue_thickness=12e-6, tab_length=3e-3)),
}
DISPLAYS = {
    "paper": (PAPER, Display()),
    "wide": (
        Device(bimorph=Bimorph(length=14e-3, width=1.7e-3)),
        Display(rows=2, columns=3, pitch=2.6e-3),
    ),
}


def answer(ask, *given):
    """Return what is answered, or why it is not."""
    try:
        return ask(*given)
    except InputError as error:
        return f"refused: {error}"


def meshed(mesh):
    """Return what a mesh is made of: counts, and of regions and faces how far they reach."""
    cells = {name: mesh.cells[mesh.cells_of(name)] for name in mesh.regions}
    parts = {
        name: [len(corners), *span(mesh.points[corners])]
        for name, corners in (cells | mesh.faces).items()
    }
    return {"points": mesh.points, "kind": mesh.kind, "parts": parts}


def span(points):
    """Return lowest, highest and mean coordinates."""
    points = points.reshape(-1, 3)
    return [points.min(axis=0), points.max(axis=0), np.abs(points).mean(axis=0)]


def half_section(device, refinement, gap):
    """Return the lines of the grid over the half section."""
    grid = graded_grid(actuator_regions(device, gap), 60e-3, refinement=refinement)
    return [grid.r, grid.z]


@pytest.mark.parametrize("name", DISPLAYS)
def test_a_display(name, approved):
    """Every part with its size, place and mass, and what is clear of what."""
    asked = {
        "levels": levels, "axes": lambda _, d: axes(d), "footprint": lambda d, _: footprint(d),
        "spacers": lambda _, d: spacer_axes(d.width, d.board_length, d), "bill": bill_of_parts,
        "mass": lambda *both: total_mass(bill_of_parts(*both)), "clearances": clearances,
        "wiring": wiring,
    }  # fmt: skip
    if name == "wide":
        asked["parts"] = display_parts
    approved(described({what: answer(ask, *DISPLAYS[name]) for what, ask in asked.items()}))


ALONE = (
    ("bricks", bimorph_bricks, LEVELS),
    ("bricks of a family", lambda one, level: dividing([one], level), LONG_LEVELS),
)
ON_A_ROD = {
    "rod": (
        Device(bimorph=Bimorph(tab_length=0.9e-3)),
        [("bricks on the rod", rod_bricks, ROD_LEVELS)],
    ),
    "long on a rod": (
        Device(bimorph=Bimorph(length=41e-3, tab_length=0.6e-3, shim_thickness=0.3e-3)),
        [("parts on the rod", rod_parts, ROD_LEVELS[::2])],
    ),
}


@pytest.mark.parametrize("name", DEVICES | ON_A_ROD)
def test_a_device(name, approved):
    """Its parts, its rows of pieces, and every level of its divisions."""
    device, divisions = ON_A_ROD[name] if name in ON_A_ROD else (DEVICES[name], ALONE)
    asked = {
        **{f"parts {on}": partial(layout, device, on) for on in ("alone", "rod")},
        "volumes": partial(closed_form_volumes, device),
        "height": partial(total_height, device),
        "rings": partial(moving_rings, device),
        "winding": partial(winding, device.coil),
        **{
            f"row, {on}": partial(beam_pieces, device, Support(kind=on))
            for on in ("clamped", "rod")
        },
        **{
            f"{what} {n}": partial(divide, device, level)
            for what, divide, family in divisions
            for n, level in enumerate(family)
        },
        **{
            f"half section, fineness {fine}, gap {gap}": partial(half_section, device, fine, gap)
            for fine, gap in ((0.5, 0.02e-3), (1.0, 0.3e-3), (2.0, 0.02e-3))
        },
    }
    approved(described({what: answer(ask) for what, ask in asked.items()}))


def test_meshes_of_hexahedra_and_swept_tetrahedra(approved):
    """Counts, and how far every region and face reaches."""
    said = {
        "sector": meshed(sector_mesh(PAPER, 0.2e-3, Sector(refinement=0.5, copies=8, layers=2))),
        "cell": meshed(cell_mesh(PAPER, 0.2e-3, 2.4e-3, Cell(refinement=0.4, layers=2))),
        "nine": meshed(nine_mesh(PAPER, 0.2e-3, 2.4e-3, Cell(refinement=0.4, layers=2))),
        "TEAM problem 20": meshed(team20_mesh(Team20Meshing(scale=4.0))),
    }
    approved(described(said))


def test_points_of_bricks(approved, few_bricks):
    """Nodes, electrodes and the bimorph taken whole, at its corners and at every node."""
    device = Device(bimorph=Bimorph(length=4e-3, glue_thickness=20e-6, bare_below=0.4e-3))
    bricks = bimorph_bricks(device, few_bricks[0])
    on_rod = rod_bricks(Device(bimorph=Bimorph(tab_length=0.9e-3)), ROD_LEVELS[0])
    said = [
        {
            "shape": each.shape, "axes": [axis.nodes for axis in each.axes],
            "electrodes": [np.argwhere(mask).sum(axis=0) for mask in each.electrodes()],
            "used": int(each.used().sum()),
        }
        for each in (bricks, on_rod)
    ]  # fmt: skip
    said += [meshed(bricks.corner_mesh()), meshed(bricks.node_mesh())]
    approved(described(said))


def test_every_parameter(approved):
    """What each is unless stated, within which limits, how far off, and by which source."""
    kinds = {
        "display": Display, "skin": Skin, "scatter": Scatter, "support": Support, "load": Load,
        "threshold": Threshold, "drive": Drive, "limits": Limits, "beam": Beam,
        **{name: type(part) for name, part in Device() if isinstance(part, Parameters)},
    }  # fmt: skip
    said = {}
    for group, kind in kinds.items():
        for name, field in kind.model_fields.items():
            extra = field.json_schema_extra or {}
            limits = [
                (unit.si, unit.above, unit.at_least, unit.below, unit.limits, unit.shown)
                for held in field.metadata
                if isinstance(unit := getattr(held, "func", None), Unit)
            ]
            said[f"{group}.{name}"] = " | ".join(
                str(v)
                for v in (
                    field.default,
                    field.description,
                    extra.get("spread"),
                    extra.get("own"),
                    *limits,
                )
            )
    approved(described(said))


def test_every_material(approved):
    """All that the libraries say of ceramics, shims and steels."""
    approved(described(dict(LIBRARY) | dict(SHIMS) | dict(SOFT_MAGNETS)))


def test_units_as_they_come_out_of_the_shop(approved):
    """The draws of a seed stay what they were."""
    scatter = Scatter(seed=7, length=0.05, thickness=0.05, roughness=0.2, preload=0.2)
    drawn = drawn_units(PAPER, Display(rows=5, columns=5), scatter)
    approved(
        described([[d.bimorph.length, d.bimorph.piezo_thickness, d.contact.decay_length,
                    d.spring.preload] for d in drawn])
    )  # fmt: skip
