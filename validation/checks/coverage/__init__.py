"""Do error bars hold?  Random devices, each number with its bar against a much better answer.

The parts and where they are: a part is imported when it is asked for.
"""

#: Module of each part, how many devices by default, and what it holds against what.
PARTS: dict[str, tuple[str, int, str]] = {
    "beam": ("tactgen.validation.checks.coverage.beam", 60, "beam elements against exact spans"),
    "taper": (
        "tactgen.validation.checks.coverage.taper",
        40,
        "tapers by the transfer matrix against four times as many segments",
    ),
    "solid": (
        "tactgen.validation.checks.coverage.solid",
        10,
        "bricks against bricks two levels finer",
    ),
    "cad": (
        "tactgen.validation.checks.coverage.cad",
        4,
        "tetrahedra of the CAD solids against much finer bricks",
    ),
    "axisymmetric": (
        "tactgen.validation.checks.coverage.axisymmetric",
        6,
        "the magnetic field against a finer grid, higher order and farther walls",
    ),
}
