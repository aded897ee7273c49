"""A changed constant is a changed decision: what steers the packages is approved.

Thresholds, steps and how fine, how often or where to start are seldom seen in an answer, because
error bars cover them; nor is a name that a list of keys or of modules lacks, until something old
is taken out of the store.  So the list of all is kept, and its diff is where one is seen to move.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
#: Where numbers are places and sizes of what is drawn.
DRAWN = (
    "validation/view", "validation/report/figures", "validation/book", "validation/checks/drawings",
)  # fmt: skip
#: A longer table is written by its rows.
LONG = 120


class _Unworded(ast.NodeTransformer):
    """Leaves words out of what a constant is made of: pages and tables hold them."""

    def visit_Constant(self, node: ast.Constant) -> ast.Constant:
        return ast.Constant("") if isinstance(node.value, str) else node

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.Constant:
        return ast.Constant("")


def constants(tree: ast.AST, within: str = "") -> Iterator[str]:
    """Yield what holds numbers or lists below a module or class: constants, fields, defaults."""
    for node in ast.iter_child_nodes(tree):
        match node:
            case ast.ClassDef(name=name):
                yield from constants(node, f"{within}{name}.")
            case ast.FunctionDef(name=name, args=given):
                names = [a.arg for a in (*given.posonlyargs, *given.args)]
                last = names[len(names) - len(given.defaults) :]
                named = [*zip(last, given.defaults, strict=True)]
                named += zip((a.arg for a in given.kwonlyargs), given.kw_defaults, strict=True)
                for argument, default in named:
                    yield from _told(f"{within}{name}({argument})", default)
            case ast.Assign(targets=[target], value=value):
                yield from _told(within + ast.unparse(target), value)
            case ast.AnnAssign(target=target, value=value):
                yield from _told(within + ast.unparse(target), value)


def _told(name: str, value: ast.expr | None) -> Iterator[str]:
    if value is None or name == "__all__":
        return
    rows = value.elts if isinstance(value, ast.Tuple | ast.Set | ast.List) else []
    if rows and all(map(_is_name, rows)):
        yield f"{name} = {ast.unparse(value)}"
    elif not _is_type(value) and any(_is_number(n) or _is_list(n) for n in ast.walk(value)):
        plain = _Unworded().visit(value)
        whole = ast.unparse(plain)
        if len(whole) > LONG and rows:
            yield f"{name} ="
            yield from (f"  {ast.unparse(row)}" for row in plain.elts)
        else:
            yield f"{name} = {whole}"


def _is_name(node: ast.expr) -> bool:
    return isinstance(node, ast.Starred | ast.Constant) and isinstance(
        getattr(node, "value", None), str | ast.Name
    )


def _is_type(node: ast.AST) -> bool:
    named = isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name)
    return named and node.value.id in ("Literal", "tuple", "dict", "list")


def _is_list(node: ast.AST) -> bool:
    """Return whether a node has so many entries that one may be lacking unseen."""
    entries = node.keys if isinstance(node, ast.Dict) else getattr(node, "elts", ())
    return len(entries) > 2 and isinstance(node, ast.Dict | ast.Tuple | ast.List | ast.Set)


def _is_number(node: ast.AST) -> bool:
    number = isinstance(node, ast.Constant) and isinstance(node.value, int | float | complex)
    return number or isinstance(node, ast.BinOp | ast.UnaryOp | ast.Compare)


@pytest.mark.parametrize("package", ["geometry", "tmm", "fem", "validation"])
def test_no_constant_moves_unseen(package, approved):
    """Approve one that is meant, with its reason in the commit."""
    lines = []
    for path in sorted((ROOT / package).rglob("*.py")):
        file = path.relative_to(ROOT).as_posix()
        found = constants(ast.parse(path.read_bytes()))
        if not file.startswith(DRAWN) and (held := list(found)):
            lines += [file, *(f"  {one}" for one in held)]
    approved("\n".join(lines), exactly=True)
