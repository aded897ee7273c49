"""The display: generators in rows and columns between boards, plates, springs and screws."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator

from tactgen.geometry import units as u
from tactgen.geometry.device.materials import Own
from tactgen.geometry.device.parameter_group import PAPER_52, Parameters, field, printed
from tactgen.geometry.units import WholeNumber

_COUNT = Annotated[int, BeforeValidator(WholeNumber(1, 32, "4"))]
_SIZE = Own("machined size", 0.01)
_SEED = Annotated[int, BeforeValidator(WholeNumber(0, 999_999_999, "1"))]


class Display(Parameters):
    """Array of generators and the boards that carry them.

    Rows follow each other along y, columns along x, the direction in which the tips move.
    """

    rows: _COUNT = field(4, PAPER_52, "generators along y")
    columns: _COUNT = field(4, PAPER_52, "generators along x")
    pitch: u.SmallLength = printed(
        2.4e-3, PAPER_52, "distance of neighbouring axes", 0.05e-3, own=_SIZE
    )
    width: u.SmallLength = printed(50e-3, PAPER_52, "outer size along x", 0.5e-3, own=_SIZE)
    length: u.SmallLength = printed(70e-3, PAPER_52, "outer size along y", 0.5e-3, own=_SIZE)
    tab_length: u.SmallLength = field(
        2e-3,
        "assumed: gives the paper's 41 mm (section 5.1)",
        "the shim's tab where bimorph.tab_length is 0, since the support stands for its compliance",
        (1.6e-3, 2.4e-3, "assumed: a fifth either way"),
    )
    plate_thickness: u.SmallLength = field(
        4e-3,
        "assumed: the paper's 45 mm in all (section 5.2) less 41 mm of generator",
        "ground plate, of polyoxymethylene",
        (3.5e-3, 4.5e-3, "both heights are printed in whole millimetres"),
    )
    plate_density: u.Density = field(
        1410.0, "assumed: polyoxymethylene", "mass density of ground and support plate",
        (1390.0, 1430.0, "copolymer to homopolymer"),
    )  # fmt: skip
    board_length: u.SmallLength = field(
        56e-3, "assumed: leaves room for the support plate's spacers", "boards' size along y",
        (50e-3, 57e-3, "assumed: what the spacers leave"),
    )  # fmt: skip
    board_thickness: u.SmallLength = field(
        1e-3, "assumed: a thin standard board", "each board", (0.8e-3, 1.6e-3, "standard boards")
    )
    board_density: u.Density = field(
        1850.0, "assumed: glass-fibre epoxy FR-4", "mass density", (1800.0, 2000.0, "FR-4")
    )
    board_permittivity: u.RelativePermittivity = field(
        4.4, "assumed: glass-fibre epoxy FR-4", "relative permittivity", (4.0, 4.8, "FR-4")
    )
    sleeve_protrusion: u.SmallLength = field(
        4e-3,
        "assumed: room for the springs on the spacers between the boards",
        "height of the sleeves above the lower board",
        (2e-3, 8e-3, "assumed: by a factor of two"),
    )
    slot_clearance: u.SmallLength = field(
        0.1e-3, "assumed: routed slots", "between a bimorph and its slot in the upper board",
        (0.05e-3, 0.14e-3, "assumed: up to where neighbouring slots meet"),
    )  # fmt: skip
    support_thickness: u.SmallLength = field(
        2e-3, "assumed: as stiff as needed for 50 g", "support plate of the finger",
        (1e-3, 3e-3, "assumed"),
    )  # fmt: skip
    support_clearance: u.SmallLength = field(
        0.5e-3, "assumed: clear of the moving tips", "between the tips and the plate's opening",
        (0.2e-3, 1e-3, "assumed"),
    )  # fmt: skip
    tip_protrusion: u.Position = field(
        0.0, "assumed: level", "height of the tips above the support plate",
        (-0.2e-3, 0.5e-3, "assumed"),
    )  # fmt: skip
    spacer_diameter: u.SmallLength = field(
        4e-3, "assumed: standard for M2", "spacers of boards and support plate",
        (3e-3, 5e-3, "round spacers for M2"),
    )  # fmt: skip
    spacer_density: u.Density = field(
        8500.0, "assumed: brass", "mass density of the spacers", (8400.0, 8700.0, "brasses")
    )
    screw_diameter: u.SmallLength = field(
        1.6e-3, "assumed: M1.6, the largest that goes into the sleeve", "grub screws' thread",
        (1.0e-3, 1.6e-3, "M1 to M1.6"),
    )  # fmt: skip
    screw_pitch: u.SmallLength = field(
        0.35e-3, "assumed: M1.6 (ISO 261 coarse)", "grub screws' advance in a turn",
        (0.2e-3, 0.35e-3, "fine and coarse"),
    )  # fmt: skip
    screw_length: u.SmallLength = field(
        3e-3, "assumed: a standard length (ISO 4026)", "grub screws", (2e-3, 4e-3, "ISO 4026")
    )
    spring_wire: u.SmallLength = field(
        0.15e-3, "assumed: gives some 15 turns with spring.stiffness", "return springs' wire",
        (0.12e-3, 0.2e-3, "assumed: stock springs"),
    )  # fmt: skip
    spring_diameter: u.SmallLength = field(
        1.5e-3, "assumed: goes into the sleeve's bore", "mean diameter of the return springs",
        (1.2e-3, 1.7e-3, "assumed: up to the bore"),
    )  # fmt: skip
    spring_shear_modulus: u.Modulus = field(
        81.5e9, "assumed: spring steel wire (EN 13906-1)", "return springs' shear modulus",
        (70e9, 81.5e9, "stainless to patented wire"),
    )  # fmt: skip
    trace_width: u.SmallLength = field(
        0.1e-3, "assumed: fine standard boards", "width of a trace", (0.075e-3, 0.15e-3, "boards")
    )
    trace_spacing: u.SmallLength = field(
        0.1e-3, "assumed: fine standard boards", "least distance of traces, slots and edges",
        (0.075e-3, 0.15e-3, "boards"),
    )  # fmt: skip
    layers: _COUNT = field(2, "assumed: a board with two sides", "copper layers of each board")
    board_modulus: u.Modulus = field(
        22e9, "assumed: glass-fibre epoxy FR-4", "modulus in the board's plane",
        (18e9, 26e9, "FR-4, along and across"),
    )  # fmt: skip
    lateral_stiffness: u.LateralStiffness = field(
        8e6,
        "assumed: four brass spacers, clamped at both ends: 4 times 12 E I / L^3",
        "holds the upper board in its plane",
        (2e6, 8e6, "from one pinned end to two clamped ones"),
    )
    board_loss: u.LossTangent = field(
        0.02, "assumed: loss factor of glass-fibre epoxy", "structural loss of board and spacers",
        (0.01, 0.04, "laminates"),
    )  # fmt: skip
    coil_current: u.Current = printed(
        50e-3, "paper section 2.2: holds the rod down", "in driven coils, where the field between "
        "units is asked about", 0.5e-3, own=Own("current", 0.01),
    )  # fmt: skip


class Skin(Parameters):
    """Skin that couples the tips, besides the load of each."""

    thickness: u.LengthOrZero = field(
        1e-3, "assumed: epidermis and the upper dermis of a fingertip", "of the sheet; 0: no sheet",
        (0.5e-3, 2e-3, "assumed: by a factor of two"),
    )  # fmt: skip
    youngs_modulus: u.Modulus = field(
        0.1e6, "assumed: soft tissue at small strain", "modulus along the sheet",
        (0.02e6, 1e6, "assumed: published values of skin spread this far"),
    )  # fmt: skip
    poisson_ratio: u.PoissonRatio = field(
        0.48, "assumed: nearly incompressible tissue", "Poisson ratio", (0.45, 0.495, "soft tissue")
    )
    loss_factor: u.LossTangent = field(
        0.3, "assumed: viscoelastic tissue", "structural loss", (0.1, 0.5, "assumed")
    )


class Scatter(Parameters):
    """Unit-to-unit scatter: relative standard deviations."""

    seed: _SEED = field(1, "assumed: any number", "which draw; the same seed, the same units")
    length: u.RelativeScatter = field(
        0.0025, "assumed: 0.05 mm of 20 mm", "of bimorph.length", (0.001, 0.005, "assumed: sawing")
    )
    thickness: u.RelativeScatter = field(
        0.01, "assumed: thin ceramic plates", "of bimorph.piezo_thickness",
        (0.005, 0.02, "assumed: lapping"),
    )  # fmt: skip
    roughness: u.RelativeScatter = field(
        0.2, "assumed: turned heads on routed boards", "of contact.decay_length",
        (0.05, 0.25, "assumed: from one batch to single parts"),
    )  # fmt: skip
    preload: u.RelativeScatter = field(
        0.1, "assumed: screws set by turns, not by force", "of spring.preload",
        (0.02, 0.2, "assumed"),
    )  # fmt: skip
