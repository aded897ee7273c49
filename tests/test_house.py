"""The picture of the house in CONTRIBUTING.md is that of the tree, and names what exists."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parent.parent
PACKAGES = ("geometry", "tmm", "fem", "validation")
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
#: Most source files that a folder may hold, so that each can still be found by its name.
MOST_FILES = 15


def rooms():
    """Every folder of the packages, parents first."""
    for package in PACKAGES:
        yield from sorted(init.parent for init in (ROOT / package).rglob("__init__.py"))


def picture():
    """Return the tree with the first line of each folder's docstring."""
    lines = []
    for room in rooms():
        path = room.relative_to(ROOT)
        words = (ast.get_docstring(ast.parse((room / "__init__.py").read_text("utf-8"))) or "",)
        name = "  " * (len(path.parts) - 1) + path.name + "/"
        lines.append(f"{name:24}{words[0].splitlines()[0].rstrip('.')}")
    return "\n".join(lines)


def test_the_picture_is_the_tree():
    """Whoever adds or renames a room redraws it: paste what the failure shows."""
    drawn = re.search(r"```text\n(.*?)\n```", TEXT, flags=re.DOTALL)
    assert drawn is not None
    assert drawn[1] == picture()


def test_every_path_named_exists():
    """Files and folders in backticks are there."""
    named = set(re.findall(r"`((?:geometry|fem|tmm|validation|tests|notebooks)/[\w./-]*)`", TEXT))
    assert len(named) > 20
    assert not [path for path in sorted(named) if not (ROOT / path).exists()]


#: Files with a class whose instances gather something as they go; all others hold frozen values.
GATHERERS = {
    "geometry/store/sources.py", "geometry/store/store.py", "validation/engine/stages.py",
    "fem/bimorph/reduction/parametric/builder.py", "validation/export/animated_gltf.py",
    "validation/studies/whatif/search/points.py", "validation/view/page/shown.py",
    "validation/bench/bimorph/peers/job.py", "validation/checks/cases/fineness.py",
}  # fmt: skip


def test_values_are_frozen():
    """What is passed from room to room cannot be changed there: a solution stays what it was."""
    loose = {}
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            found = re.findall(r"^\s*@dataclass(?!\(frozen=True)", text, flags=re.MULTILINE)
            if found:
                loose[path.relative_to(ROOT).as_posix()] = len(found)
    assert loose == dict.fromkeys(GATHERERS, 1)


def test_rooms_are_small():
    """A folder with more files than a glance can take wants rooms of its own."""
    crowded = {str(room.relative_to(ROOT)): len(list(room.glob("*.py"))) - 1 for room in rooms()}
    assert not {room: count for room, count in crowded.items() if count > MOST_FILES}


#: Files in which one of two rows that are walked side by side may be longer, and how often.
UNEVEN = {
    "geometry/device/profile.py": 1, "tmm/beam/transfer/star.py": 1,
    "tmm/harmonic_balance/special_points.py": 1, "validation/book/figures.py": 1,
    "validation/checks/stress/plots.py": 1, "validation/report/figures/bimorph.py": 1,
    "validation/report/figures/machine.py": 1, "validation/studies/uncertainty/plot.py": 1,
    "validation/command_line/overview.py": 1, "validation/bench/output.py": 2,
}  # fmt: skip


def test_rows_walked_side_by_side_are_of_one_length():
    """A value that is missing is an error, not one pair less."""
    found = {}
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            if count := path.read_text(encoding="utf-8").count("strict=False"):
                found[path.relative_to(ROOT).as_posix()] = count
    assert found == UNEVEN
