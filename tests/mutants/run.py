"""Put single mistakes into a copy of the packages and run the tests that could see each.

    python tests/mutants/run.py reach --out reach.json          which test enters which function
    python tests/mutants/run.py draw --reach reach.json --seed 1 --count 150 --out found.json
    python tests/mutants/run.py together --results found.json   all that survived, the whole suite

`reach` runs the default suite once on a copy that notes what is entered (about a quarter longer
than the suite).  `draw` takes the kinds of mistakes in turn and packages by weight, both from the
seed, and runs on each mistake first the tests that enter its function, cheapest first, those of
its own room before others, then whole test files that do so in a fixture.  A mistake that none of
these sees has survived them; `together` puts all of those in at once and runs everything: if that
passes, no test sees any of them.

This is no part of the test suite: it costs some ten seconds a mistake.
"""

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path

import reach
from mistakes import ABSENT, Mistake, is_python, mistakes_in

ROOT = Path(__file__).parent.parent.parent
COPIED = (*reach.PACKAGES, ".setup", "tests", "notebooks")
#: How often a package is drawn: the largest holds most of what is said about numbers.
WEIGHTS = {"geometry": 0.2, "tmm": 0.2, "fem": 0.2, "validation": 0.4}
#: Tests that read the sources: they enter no function of what they judge.
READERS = ("tests/geometry/test_files.py", "tests/validation/catalogue/test_names.py")
#: Processor time (s), as measured while noting, that the tests on one mistake may take.
BUDGET = 20.0
#: Longest run (s) of the tests on one mistake: it may have made a loop without end.
LONGEST = 600.0


def main() -> None:
    """Read the command line and do it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    noting = commands.add_parser("reach", help="note which test enters which function")
    noting.add_argument("--out", type=Path, required=True)
    noting.add_argument("tests", nargs="*", default=["tests"])
    drawing = commands.add_parser("draw", help="draw mistakes and run the tests on each")
    drawing.add_argument("--reach", type=Path, required=True)
    drawing.add_argument("--seed", type=int, required=True)
    drawing.add_argument("--count", type=int, default=150)
    drawing.add_argument("--first", type=int, default=1, help="number to go on with")
    drawing.add_argument("--out", type=Path, required=True)
    together = commands.add_parser("together", help="run everything on all that survived")
    together.add_argument("--results", type=Path, required=True)
    together.add_argument("tests", nargs="*", default=["tests"])
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        copy = Path(folder) / "copy"
        for name in COPIED:
            shutil.copytree(ROOT / name, copy / name, symlinks=True)
        for path in ROOT.iterdir():
            if path.is_file():
                shutil.copy(path, copy)
        {"reach": _reach, "draw": _draw, "together": _together}[arguments.command](arguments, copy)


def _reach(arguments: argparse.Namespace, copy: Path) -> None:
    reach.instrument(copy)
    notes = copy.parent / "notes"
    notes.mkdir()
    _pytest(copy, ["-p", "reach", *arguments.tests], {"TACTGEN_REACH": str(notes)}, None)
    collected = gathered(line for file in notes.iterdir() for line in file.open())
    arguments.out.write_text(json.dumps(collected))
    print(f"{len(collected['seconds'])} tests, {len(collected['entered'])} functions")


def gathered(lines: Iterator[str]) -> dict:
    """Return seconds by test, and by function the tests that enter it and those of its fixtures."""
    seconds: dict[str, float] = defaultdict(float)
    entered: dict[str, set[str]] = defaultdict(set)
    fixtures: dict[str, set[str]] = defaultdict(set)
    for line in map(json.loads, lines):
        seconds[line["test"]] += line["seconds"]
        within = entered if line["when"] == "call" else fixtures
        for function in line["entered"]:
            within[function].add(line["test"])
    return {
        "seconds": {test: round(s, 3) for test, s in seconds.items()},
        "entered": {function: sorted(tests) for function, tests in entered.items()},
        "fixtures": {function: sorted(tests) for function, tests in fixtures.items()},
    }


def drawn(seed: int, count: int) -> list[Mistake]:
    """Return mistakes: kinds in turn, packages by weight, then any, each line once."""
    chance = random.Random(seed)
    pools: dict[tuple[str, str], list[Mistake]] = defaultdict(list)
    for package in reach.PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            file = path.relative_to(ROOT).as_posix()
            if not file.startswith(ABSENT):
                for mistake in mistakes_in(ROOT, file):
                    pools[package, mistake.kind].append(mistake)
    kinds = sorted({kind for _, kind in pools})
    found: list[Mistake] = []
    lines: set[tuple[str, int]] = set()
    while len(found) < count:
        package = chance.choices(list(WEIGHTS), list(WEIGHTS.values()))[0]
        pool = pools.get((package, kinds[len(found) % len(kinds)])) or pools[package, "term"]
        mistake = chance.choice(pool)
        source = mistake.put((ROOT / mistake.file).read_bytes())
        if (mistake.file, mistake.line) not in lines and is_python(source):
            lines.add((mistake.file, mistake.line))
            found.append(mistake)
    return found


def _draw(arguments: argparse.Namespace, copy: Path) -> None:
    known = json.loads(arguments.reach.read_text())
    chosen = chooser(known)
    before = arguments.first - 1
    results: list[dict] = []
    if before:
        results = json.loads(arguments.out.read_text())["mistakes"][:before]
    for number, mistake in enumerate(drawn(arguments.seed, arguments.count), 1):
        if number <= before:
            continue
        tests, started = chosen(mistake), time.perf_counter()
        path = copy / mistake.file
        whole = path.read_bytes()
        path.write_bytes(mistake.put(whole))
        try:
            verdict, by = _verdict(copy, tests)
        finally:
            path.write_bytes(whole)
        results.append({**asdict(mistake), "verdict": verdict, "by": by, "tests": len(tests)})
        arguments.out.write_text(
            json.dumps({"seed": arguments.seed, "mistakes": results}, indent=1)
        )
        seconds = time.perf_counter() - started
        print(f"{number:4} {verdict:9} {seconds:4.0f} s  {mistake}  {by}", flush=True)
    tally = Counter(r["verdict"] for r in results)
    print(f"seed {arguments.seed}: {dict(tally)}")


def chooser(known: dict) -> Callable[[Mistake], list[str]]:
    """Return what chooses the tests on a mistake, cheapest first, its own room's before others."""
    importers = _importers()

    def chosen(mistake: Mistake) -> list[str]:
        files = {mistake.file} if mistake.function else {mistake.file, *importers[mistake.file]}
        wanted = f"{mistake.file}::{mistake.function}"

        def reaching(by: str) -> set[str]:
            return {
                test
                for function, tests in known[by].items()
                if function == wanted or (not mistake.function and function.split("::")[0] in files)
                for test in tests
            }

        room = f"tests/{Path(mistake.file).parent.as_posix()}"
        by_fixture = {test.split("::")[0] for test in reaching("fixtures")}
        direct = reaching("entered")
        late = {t for t in known["seconds"] if t.split("::")[0] in by_fixture} - direct
        taken, spent = [], 0.0
        for tests in (direct, late):
            order = sorted(tests, key=lambda t: (not t.startswith(room), known["seconds"][t], t))
            for test in order:
                if spent < BUDGET or not taken:
                    taken.append(test)
                    spent += known["seconds"][test]
        readers = [t for t in known["seconds"] if t.startswith(READERS)]
        return [*(taken or _nearest_folder(Path(room))), *readers]

    return chosen


def _nearest_folder(room: Path) -> list[str]:
    """Return the tests' folder that mirrors a room, or the nearest around it that is there."""
    while not (ROOT / room).is_dir():
        room = room.parent
    return [room.as_posix()]


def _importers() -> dict[str, set[str]]:
    """Return by file the files that import from it."""
    found: dict[str, set[str]] = defaultdict(set)
    for package in reach.PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_bytes())):
                if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tactgen."):
                    base = node.module.removeprefix("tactgen.").replace(".", "/")
                    names = [base, *(f"{base}/{alias.name}" for alias in node.names)]
                    for name in names:
                        found[f"{name}.py"].add(path.relative_to(ROOT).as_posix())
    return found


def _verdict(copy: Path, tests: list[str]) -> tuple[str, str]:
    """Return killed, survived or hangs, and the first test that failed."""
    listed = copy.parent / "tests.txt"
    listed.write_text("\n".join(tests))
    try:
        code, said = _pytest(copy, ["-x", f"@{listed}"], {}, LONGEST)
    except subprocess.TimeoutExpired:
        return "hangs", ""
    if code == 0:
        return "survived", ""
    failed = [line for line in said.splitlines() if line.startswith(("FAILED", "ERROR"))]
    if code == 4 and not failed:
        raise SystemExit(f"these tests are not there; note anew which enter what:\n{said[-2000:]}")
    return "killed", failed[0][:160] if failed else said[-160:]


def _pytest(copy: Path, more: list[str], environment: dict, longest: float | None) -> tuple:
    """Run tests in the copy on its own packages and an empty store; exit code and output."""
    around = {
        **os.environ, **environment, "TACTGEN_CACHE": str(copy.parent / "store"),
        "PYTHONPATH": os.pathsep.join([str(copy / ".setup"), str(Path(__file__).parent)]),
        "PYTHONDONTWRITEBYTECODE": "",
    }  # fmt: skip
    base = copy.parent / "base"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    done = subprocess.run(
        [*command, f"--basetemp={base}", *more], cwd=copy, env=around, check=False,
        capture_output=True, text=True, timeout=longest,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr


def _together(arguments: argparse.Namespace, copy: Path) -> None:
    results = json.loads(arguments.results.read_text())["mistakes"]
    left = [r for r in results if r["verdict"] == "survived"]
    by_file: dict[str, list[Mistake]] = defaultdict(list)
    for result in left:
        mistake = Mistake(**{k: result[k] for k in Mistake.__dataclass_fields__})
        by_file[mistake.file].append(mistake)
    for file, mistakes in by_file.items():
        source = (copy / file).read_bytes()
        for mistake in sorted(mistakes, key=lambda m: -m.start):
            source = mistake.put(source)
        (copy / file).write_bytes(source)
    _, said = _pytest(copy, arguments.tests, {}, None)
    print(f"{len(left)} mistakes at once")
    print(said[-6000:])


if __name__ == "__main__":
    main()
