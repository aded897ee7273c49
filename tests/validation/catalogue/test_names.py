"""A quantity's or a model's name stands in its row: nothing else asks for one by spelling it."""

import ast
import re
from pathlib import Path

from tactgen import validation
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES

ROOT = Path(validation.__file__).parent
#: Rooms that derive from the rows.  Checks and benchmarks measure stated cases by name.
ROOMS = ("engine", "scene", "studies", "report", "command_line", "export", "models")
#: Names that values of a magnetic field have, too.
_OF_A_FIELD = {"flux_linkage", "coenergy", "incremental_inductance"}
FILES = [file for room in ROOMS for file in sorted((ROOT / room).rglob("*.py"))]
PAGES = sorted((ROOT / "report" / "templates").glob("*.html"))


def words(file):
    """Return the string constants of a module; no docstring is a bare name."""
    tree = ast.parse(file.read_text("utf-8"))
    return {n.value for n in ast.walk(tree) if isinstance(n, ast.Constant)}


def test_no_quantity_is_spelled():
    """In code: a study takes the row itself, everything else a property of it."""
    assert len(FILES) > 80
    for file in FILES:
        assert not words(file) & (QUANTITIES.keys() - _OF_A_FIELD), file.relative_to(ROOT)


def test_no_quantity_is_spelled_in_the_pages():
    """In templates likewise: they show labels and go by properties."""
    assert len(PAGES) > 10
    for page in PAGES:
        quoted = set(re.findall(r"[\"'](\w+)[\"']", page.read_text("utf-8")))
        assert not quoted & (QUANTITIES.keys() - _OF_A_FIELD), page.name


def test_the_engine_spells_no_model():
    """Plan, stages and solution know models by their rows."""
    for file in (ROOT / "engine").glob("*.py"):
        assert not words(file) & MODELS.keys(), file.name
