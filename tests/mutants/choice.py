"""Which tests are run on a mistake: those that enter its function, cheapest first."""

import ast
from collections import defaultdict
from pathlib import Path

from mistakes import Mistake
from reach import PACKAGES

#: Tests that read the sources, or what is made on import: they enter no function of it.
READERS = (
    "tests/validation/checks/test_tolerances.py", "tests/validation/command_line/test_options.py",
    "tests/test_house.py", "tests/geometry/test_files.py",
    "tests/validation/catalogue/test_names.py", "tests/test_constants.py",
)  # fmt: skip
#: Processor time (s), as measured while noting, that the tests on one mistake may take:
#: those of its own room, which are run alone first, and all.
NEAR, BUDGET = 3.0, 10.0
#: What it costs to collect one more file of tests (s).
FILE = 0.15


class Chooser:
    """Chooses by what was noted: seconds by test, and tests by function that they enter."""

    def __init__(self, root: Path, known: dict) -> None:
        self.seconds, self.entered = known["seconds"], known["entered"]
        self.root, self.importers = root, _importers(root)

    def turns(self, mistake: Mistake) -> list[list[str]]:
        """Return the tests of the mistake's own room that enter its function, and all others."""
        direct = self._reaching(mistake)
        room = f"tests/{Path(mistake.file).parent.as_posix()}"
        near = {t for t in direct if t.startswith(room)}
        if not direct:
            near = self._nearest(Path(room))
        first = self._within(near, NEAR)
        rest = self._within(direct - set(first), BUDGET)
        readers = [t for t in self.seconds if t.startswith(READERS)]
        return [turn for turn in (first, [*rest, *readers]) if turn]

    def _reaching(self, mistake: Mistake) -> set[str]:
        """Return tests that enter the function; if it runs on import, any of the file's users."""
        direct = set(self.entered.get(f"{mistake.file}::{mistake.function}", ()))
        if mistake.function and mistake.function not in _on_import(self.root / mistake.file):
            return direct
        files = {mistake.file, *self.importers[mistake.file]}
        direct |= {t for t in self.seconds if t.split("::")[0] in files}
        return direct.union(*(t for f, t in self.entered.items() if f.split("::")[0] in files))

    def _within(self, tests: set[str], budget: float) -> list[str]:
        """Return the cheapest tests, as many as the budget (s) lets, one at least."""
        taken: list[str] = []
        files: set[str] = set()
        for test in sorted(tests, key=lambda t: (self.seconds[t], t)):
            file = test.split("::")[0]
            budget -= self.seconds[test] + (0.0 if file in files else FILE)
            if taken and budget < 0.0:
                break
            files.add(file)
            taken.append(test)
        return taken

    def _nearest(self, room: Path) -> set[str]:
        """Return the tests in the folder that mirrors a room, or the nearest that has some."""
        while not (found := {t for t in self.seconds if t.startswith(f"{room.as_posix()}/")}):
            room = room.parent
        return found


def _on_import(path: Path) -> set[str]:
    """Return the functions that a file calls on import: what they make is there before a test."""
    tree = ast.parse(path.read_bytes())
    bodies = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    found: set[str] = set()
    left: list[ast.AST] = [n for n in tree.body if isinstance(n, ast.Assign | ast.AnnAssign)]
    while left:
        names = {n.id for n in ast.walk(left.pop()) if isinstance(n, ast.Name)}
        new = names & set(bodies) - found
        found |= new
        left += [bodies[name] for name in new]
    return found


def _importers(root: Path) -> dict[str, set[str]]:
    """Return by file the files that import from it, tests as well."""
    found: dict[str, set[str]] = defaultdict(set)
    for package in (*PACKAGES, "tests"):
        for path in sorted((root / package).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_bytes())):
                if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tactgen."):
                    base = node.module.removeprefix("tactgen.").replace(".", "/")
                    for name in (base, *(f"{base}/{alias.name}" for alias in node.names)):
                        found[f"{name}.py"].add(path.relative_to(root).as_posix())
    return found
