"""Do error bars hold?  Random devices, each number with its bar against a much better answer.

The parts and where they are: a part is imported when it is asked for.
"""

_HERE = "tactgen.validation.checks.coverage"
#: Module and function of each part, how many devices by default, and what it holds against what.
PARTS: dict[str, tuple[str, str, int, str]] = {
    "tmm": (
        f"{_HERE}.tmm", "judge", 60,
        "the transfer matrix against 80 digits; its bars count rounding and are meant to be wide",
    ),
    "beam": (f"{_HERE}.beam", "judge", 60, "beam elements against exact spans"),
    "taper": (
        f"{_HERE}.taper", "judge", 40,
        "tapers by the transfer matrix against four times as many segments",
    ),
    "solid": (f"{_HERE}.solid", "judge", 16, "bricks against bricks two levels finer"),
    "cad": (
        f"{_HERE}.cad", "judge", 4,
        "tetrahedra of the CAD solids against much finer bricks",
    ),
    "reduced": (
        f"{_HERE}.reduced", "judge", 12,
        "a member of a family by its reduced basis against bricks two levels finer",
    ),
    "axisymmetric": (
        f"{_HERE}.axisymmetric", "judge", 20,
        "the magnetic field against a finer grid, higher order and farther walls",
    ),
    "magnetic3d": (
        f"{_HERE}.magnetic3d", "judge", 20,
        "the magnetic field on coarse tetrahedra against the half section's",
    ),
    "map": (f"{_HERE}.machine", "judge_map", 60, "the co-energy map against the network itself"),
    "switching": (
        f"{_HERE}.machine", "judge_switching", 30,
        "switching currents against balances of a network four times as fine",
    ),
    "generator": (
        f"{_HERE}.machine", "judge_motions", 30,
        "small motions of the machine against those by a network four times as fine",
    ),
    "time": (f"{_HERE}.in_time", "judge", 30, "runs in time against runs in much finer steps"),
}  # fmt: skip
