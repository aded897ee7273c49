"""Put single mistakes into a copy of the packages and run the tests that could see each.

    python tests/mutants/run.py reach --out reach.json          which test enters which function
    python tests/mutants/run.py draw --reach reach.json --seed 1 --count 150 --out found.json
    python tests/mutants/run.py together --results found.json   all that survived, the whole suite

`reach` runs the default suite once on a copy that notes what is entered (about a quarter longer
than the suite); given tests, it notes those alone and keeps what `reach.json` says of others.

`draw` takes the kinds of mistakes in turn and packages by weight, both from the seed.  On each it
runs the tests that enter its function, those of its own room before others, the cheapest first,
up to the first that fails.  Results are written after each mistake: the same command goes on where
it was ended, with `--again` also on those that no test saw before.  A run without a verdict in
its time is "undecided", which counts as alive.  At the end, the tests that failed are run on the
packages as they are: one that fails there saw nothing.

`together` puts all in at once that survived their tests, runs the whole suite, and each alone on
what fails there: what is left then is seen by no test.  `results.md` keeps what was found.

This is no part of the test suite: it costs some five seconds a mistake.
"""

import argparse
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

import reach
from choice import Chooser
from mistakes import ABSENT, Mistake, is_python, mistakes_in
from trial import import_ahead, tried

ROOT = Path(__file__).parent.parent.parent
COPIED = (*reach.PACKAGES, ".setup", "tests", "notebooks")
#: How often a package is drawn: the largest holds most of what is said about numbers.
WEIGHTS = {"geometry": 0.2, "tmm": 0.2, "fem": 0.2, "validation": 0.4}


def main() -> None:
    """Read the command line and do it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    noting = commands.add_parser("reach", help="note which test enters which function")
    noting.add_argument("--out", type=Path, required=True)
    noting.add_argument("tests", nargs="*", help="note these anew; all by default")
    drawing = commands.add_parser("draw", help="draw mistakes and run the tests on each")
    drawing.add_argument("--reach", type=Path, required=True)
    drawing.add_argument("--seed", type=int, required=True)
    drawing.add_argument("--count", type=int, default=150)
    drawing.add_argument("--packages", nargs="+", choices=WEIGHTS, default=list(WEIGHTS))
    drawing.add_argument("--under", nargs="+", default=[""], help="of these folders alone")
    drawing.add_argument(
        "--most", type=int, default=10**9, help="end after so many, to go on later"
    )
    drawing.add_argument("--again", action="store_true", help="try once more what no test saw")
    drawing.add_argument("--out", type=Path, required=True)
    together = commands.add_parser("together", help="run everything on all that survived")
    together.add_argument("--results", type=Path, required=True)
    together.add_argument("folders", nargs="*", default=["tests"], help="run these alone")
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
    around = {
        **os.environ, "TACTGEN_REACH": str(notes), "PYTHONDONTWRITEBYTECODE": "",
        "PYTHONPATH": os.pathsep.join([str(copy / ".setup"), str(Path(__file__).parent)]),
    }  # fmt: skip
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "reach"]
    base = f"--basetemp={copy.parent / 'base'}"
    subprocess.run([*command, base, *arguments.tests], cwd=copy, env=around, check=False)
    known = None
    if arguments.tests and arguments.out.exists():
        known = json.loads(arguments.out.read_text())
    lines = [line for file in notes.glob("*.jsonl") for line in file.read_text().splitlines()]
    collected = reach.gathered(lines, known)
    arguments.out.write_text(json.dumps(collected))
    print(f"{len(collected['seconds'])} tests, {len(collected['entered'])} functions")


def drawn(
    root: Path,
    seed: int,
    count: int,
    packages: Iterable[str] = reach.PACKAGES,
    under: Iterable[str] = ("",),
) -> list[Mistake]:
    """Return mistakes: kinds in turn (the largest for one that is used up), packages by weight.

    No two touch one line.
    Only files whose path begins with one of `under` are taken.
    """
    weights = {package: WEIGHTS[package] for package in packages}
    chance = random.Random(seed)
    pools: dict[tuple[str, str], list[Mistake]] = defaultdict(list)
    for package in weights:
        for path in sorted((root / package).rglob("*.py")):
            file = path.relative_to(root).as_posix()
            if file.startswith(tuple(under)) and not file.startswith(ABSENT):
                for mistake in mistakes_in(root, file):
                    pools[package, mistake.kind].append(mistake)
    kinds = sorted({kind for _, kind in pools})
    found: list[Mistake] = []
    while len(found) < count:
        package = chance.choices(list(weights), list(weights.values()))[0]
        left = [pools[package, kind] for kind in kinds]
        pool = left[len(found) % len(kinds)] or max(left, key=len)
        mistake = pool.pop(chance.randrange(len(pool)))
        source = mistake.put((root / mistake.file).read_bytes())
        if is_python(source) and not any(mistake.touches(other) for other in found):
            found.append(mistake)
    return found


def _draw(arguments: argparse.Namespace, copy: Path) -> None:
    if arguments.out.exists():
        results = json.loads(arguments.out.read_text())
        if results["seed"] != arguments.seed:
            raise SystemExit(f"{arguments.out} holds seed {results['seed']}: name another file")
    else:
        found = drawn(ROOT, arguments.seed, arguments.count, arguments.packages, arguments.under)
        results = {"seed": arguments.seed, "mistakes": [asdict(m) for m in found]}
    chooser = Chooser(ROOT, json.loads(arguments.reach.read_text()))
    import_ahead()
    wanted = ("", "survived", "undecided") if arguments.again else ("",)
    left = [r for r in results["mistakes"] if r.get("verdict", "") in wanted][: arguments.most]
    for result in left:
        begun = _spent()
        mistake = _mistake(result)
        for tests in chooser.turns(mistake):
            result["verdict"], failed = _tried_on(copy, [mistake], tests)
            result["by"] = failed[:1]
            if result["verdict"] != "survived":
                break
        _write(arguments.out, results)
        number = results["mistakes"].index(result) + 1
        said = f"{number:4} {result['verdict']:9} {_spent() - begun:4.0f} s  {mistake}"
        print(said, *result["by"], flush=True)
    _believe(copy, left)
    _write(arguments.out, results)
    tally = Counter(r.get("verdict", "to come") for r in results["mistakes"])
    print(f"seed {arguments.seed}: {dict(tally)}")


def _believe(copy: Path, results: list[dict]) -> None:
    """Take kills back whose test fails on the packages as they are."""
    seen = [test for r in results if r["verdict"] == "killed" for test in r["by"] if "::" in test]
    if seen:
        _, failed = tried(copy, list(dict.fromkeys(seen)), first_only=False)
        for result in results:
            if set(result["by"]) & set(failed):
                print(f"{result['by'][0]} fails without any mistake")
                result["verdict"] = "undecided"


def _tried_on(
    copy: Path, mistakes: list[Mistake], tests: list[str] | None, folders: tuple[str, ...] = ()
) -> tuple:
    """Run tests on packages with mistakes in them (None: all of the folders, to the end)."""
    whole = {m.file: ((copy / m.file).read_bytes(), (copy / m.file).stat()) for m in mistakes}
    for file, (source, status) in whole.items():
        for mistake in sorted(mistakes, key=lambda m: -m.start):
            if mistake.file == file:
                if source[mistake.start : mistake.end] != mistake.before.encode():
                    raise SystemExit(f"{mistake} is no longer there: draw anew")
                source = mistake.put(source)
        (copy / file).write_bytes(source)
        # compiled files go by time and length: no two mistakes at one time, nor any at the file's
        later = status.st_mtime_ns + (hash(tuple(mistakes)) % 10**6 + 1) * 10**9
        os.utime(copy / file, ns=(later, later))
    try:
        return tried(copy, tests, first_only=tests is not None, folders=folders)
    finally:
        for file, (source, status) in whole.items():
            (copy / file).write_bytes(source)
            os.utime(copy / file, ns=(status.st_atime_ns, status.st_mtime_ns))


def _together(arguments: argparse.Namespace, copy: Path) -> None:
    results = json.loads(arguments.results.read_text())
    alive = ("survived", "undecided")
    left = [r for r in results["mistakes"] if r.get("verdict") in alive]
    import_ahead()
    _, failed = _tried_on(copy, [_mistake(r) for r in left], None, tuple(arguments.folders))
    print(f"{len(left)} mistakes at once: {len(failed)} tests fail", *failed, sep="\n")
    for result in left if failed else []:
        result["verdict"], result["by"] = _tried_on(copy, [_mistake(result)], failed)
        print(result["verdict"], _mistake(result), *result["by"], flush=True)
    _believe(copy, left)
    _write(arguments.results, results)


def _mistake(result: dict) -> Mistake:
    return Mistake(**{name: result[name] for name in Mistake.__dataclass_fields__})


def _write(path: Path, results: dict) -> None:
    whole = path.with_suffix(".part")
    whole.write_text(json.dumps(results, indent=1))
    whole.replace(path)


def _spent() -> float:
    """Return the processor time (s) of the runs so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
