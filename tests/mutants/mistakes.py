"""Single mistakes that could be in a source file: where each stands and what it puts there.

A mistake is a replacement of a piece of text, found in the syntax tree, so that the rest of the
file stays as it is.  It is no style: what only places or colours a drawing is left out (numbers
in `LOOKS`, in tables of colours and in keywords of that kind), and so are docstrings, annotations
and f-strings.
"""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

#: Folders in which numbers are positions and sizes of what is drawn.
LOOKS = (
    "validation/view", "validation/report/figures", "validation/book", "validation/checks/drawings",
)  # fmt: skip
#: Programs that are not installed for the tests.
ABSENT = ("validation/bench/bimorph/peers",)
#: Keywords that say how something looks.
_LOOK_KEYWORDS = {
    "alpha", "color", "dpi", "figsize", "fontsize", "height_ratios", "lw", "linewidth",
    "linestyle", "marker", "markersize", "pad", "padding", "style", "width_ratios", "zorder",
    "help", "metavar", "font_size", "window_size", "frameon", "clip_on", "sharex", "sharey",
}  # fmt: skip
#: What takes the size of a figure first.
_FIGURES = {"panels", "new_figure"}

_OPERATORS = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.FloorDiv: "*"}
_COMPARISONS = {
    ast.Lt: ">=", ast.LtE: ">", ast.Gt: "<=", ast.GtE: "<", ast.Eq: "!=", ast.NotEq: "==",
    ast.In: "not in", ast.NotIn: "in", ast.Is: "is not", ast.IsNot: "is",
}  # fmt: skip


@dataclass(frozen=True)
class Mistake:
    """One: bytes `start` to `end` of the file become `after`.

    `function` is the outermost one around it, after the classes around that; "" is module level.
    """

    file: str
    line: int
    kind: str
    function: str
    start: int
    end: int
    before: str
    after: str

    def put(self, source: bytes) -> bytes:
        """Return the file with the mistake in it."""
        return source[: self.start] + self.after.encode() + source[self.end :]

    def touches(self, other: "Mistake") -> bool:
        """Return whether both could not be put at once, or stand on one line."""
        apart = self.end <= other.start or other.end <= self.start
        return self.file == other.file and (self.line == other.line or not apart)

    def __str__(self) -> str:
        short = (" ".join(text.split())[:60] for text in (self.before, self.after))
        return f"{self.file}:{self.line} {self.kind}: {' → '.join(short)}"


def mistakes_in(root: Path, file: str) -> list[Mistake]:
    """Return every mistake that can be put into a file, named relative to `root`."""
    return _Finder(file, (root / file).read_bytes()).all()


def is_python(source: bytes) -> bool:
    """Return whether a file can still be read with a mistake in it."""
    try:
        ast.parse(source)
    except SyntaxError:
        return False
    return True


class _Finder:
    """Walks one syntax tree."""

    def __init__(self, file: str, source: bytes) -> None:
        self.file, self.source = file, source
        self.starts = [0]
        for line in source.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))

    def all(self) -> list[Mistake]:
        looks = self.file.startswith(LOOKS)
        return list(self._below(ast.parse(self.source), "", "", looks=looks))

    def _span(self, node: ast.AST) -> tuple[int, int]:
        return (
            self.starts[node.lineno - 1] + node.col_offset,
            self.starts[node.end_lineno - 1] + node.end_col_offset,
        )

    def _text(self, node: ast.AST) -> str:
        start, end = self._span(node)
        return self.source[start:end].decode()

    def _below(
        self, node: ast.AST, function: str, within: str, *, looks: bool
    ) -> Iterator[Mistake]:
        for kind, where, after in self._here(node, looks=looks):
            start, end = where if isinstance(where, tuple) else self._span(where)
            before = self.source[start:end].decode()
            line = self.source[:start].count(b"\n") + 1
            if after != before:
                yield Mistake(self.file, line, kind, function, start, end, before, after)
        if isinstance(node, ast.ClassDef) and not function:
            within = f"{within}{node.name}."
        elif isinstance(node, ast.FunctionDef) and not function:
            function = f"{within}{node.name}"
        looks |= isinstance(node, ast.AnnAssign) and ast.unparse(node.target).endswith("COLOURS")
        for child in _children(node):
            aside = isinstance(child, ast.keyword) and child.arg in _LOOK_KEYWORDS
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                aside |= node.func.id in _FIGURES and child in node.args
            if not aside:
                yield from self._below(child, function, within, looks=looks)

    def _here(self, node: ast.AST, *, looks: bool) -> Iterator[tuple]:
        """Yield kind, node or span, and the text that takes its place."""
        match node:
            case ast.Constant(value=bool()):
                yield "truth", node, str(not node.value)
            case ast.Constant(value=int() | float()) if not looks:
                yield from self._number(node)
            case ast.BinOp():
                yield from self._operation(node)
            case ast.UnaryOp(op=ast.USub() | ast.Not()):
                yield "sign", node, self._text(node.operand)
            case ast.Compare(ops=[op]):
                span = (self._span(node.left)[1], self._span(node.comparators[0])[0])
                yield "comparison", span, f" {_COMPARISONS[type(op)]} "
            case ast.BoolOp():
                other = " or " if isinstance(node.op, ast.And) else " and "
                yield "comparison", node, other.join(f"({self._text(v)})" for v in node.values)
                for value in node.values:
                    rest = [f"({self._text(v)})" for v in node.values if v is not value]
                    word = " and " if isinstance(node.op, ast.And) else " or "
                    yield "term", node, word.join(rest)
            case ast.Subscript(slice=ast.Tuple(elts=[first, second, *rest])):
                swapped = (second, first, *rest)
                if ast.dump(first) != ast.dump(second):
                    yield "index", node.slice, ", ".join(self._text(e) for e in swapped)
            case ast.Dict() | ast.Tuple() | ast.List() | ast.Set():
                yield from self._key(node)
            case ast.Call():
                yield from self._call(node)
            case ast.If(body=[ast.Raise(), *_]):
                yield "refusal", node.test, "False"
            case ast.Expr(value=ast.Call()):
                yield "statement", node, "pass"
            case ast.Attribute(value=ast.Name(id="sys"), attr="stderr"):
                yield "stream", node, "sys.stdout"
            case ast.Attribute(value=ast.Name(id="sys"), attr="stdout"):
                yield "stream", node, "sys.stderr"

    def _number(self, node: ast.Constant) -> Iterator[tuple]:
        if isinstance(node.value, float):
            yield "number 1 %", node, repr(node.value * 1.01) if node.value else "0.01"
            yield "number x3", node, repr(node.value * 3.0) if node.value else "1.0"
        else:
            yield "integer", node, str(node.value + 1)

    def _operation(self, node: ast.BinOp) -> Iterator[tuple]:
        if any(_is_text(side) for side in (node.left, node.right)):
            return
        left, right = f"({self._text(node.left)})", f"({self._text(node.right)})"
        if type(node.op) in _OPERATORS:
            yield "operator", node, f"{left} {_OPERATORS[type(node.op)]} {right}"
        if isinstance(node.op, ast.Add | ast.Sub | ast.Mult | ast.Div):
            yield "term", node, left
        if isinstance(node.op, ast.Add | ast.Mult):
            yield "term", node, right

    def _key(self, node: ast.Dict | ast.Tuple | ast.List | ast.Set) -> Iterator[tuple]:
        """Drop one of three or more entries that are no numbers."""
        dictionary = isinstance(node, ast.Dict)
        parts = node.keys if dictionary else node.elts
        stored = isinstance(getattr(node, "ctx", None), ast.Store)
        if len(parts) < 3 or None in parts or stored:
            return
        words = all(isinstance(p, ast.Constant) and isinstance(p.value, str) for p in parts)
        if not words and not all(isinstance(p, ast.Name | ast.Attribute | ast.Call) for p in parts):
            return
        spans = [self._span(p) for p in parts]
        end = self._span(node)[1]
        for (start, _), (after, _) in zip(spans, [*spans[1:], (end, end)], strict=True):
            if after != end:
                yield "key", (start, after), ""

    def _call(self, node: ast.Call) -> Iterator[tuple]:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        attribute = node.func.attr if isinstance(node.func, ast.Attribute) else ""
        if name == "written_whole":
            yield "write", node.func, '__import__("contextlib").nullcontext'
        if name == "write_text" and len(node.args) == 2:
            path, text = (self._text(a) for a in node.args)
            yield "write", node, f"({path}).write_text({text})"
        other = {"max": "min", "min": "max", "maximum": "minimum", "minimum": "maximum"}
        if name in other:
            yield "operator", node.func, other[name]
        if attribute in other:
            value = self._text(node.func.value)
            yield "operator", node.func, f"{value}.{other[attribute]}"
        for first, second in zip(node.args, node.args[1:], strict=False):
            if all(isinstance(a, ast.Name | ast.Attribute) for a in (first, second)):
                span = (self._span(first)[0], self._span(second)[1])
                yield "index", span, f"{self._text(second)}, {self._text(first)}"
        for keyword in node.keywords:
            if keyword.arg == "stderr":
                yield "stream", keyword.value, f"not {self._text(keyword.value)}"
            elif keyword.arg and keyword.arg not in _LOOK_KEYWORDS and len(node.keywords) > 1:
                yield "key", self._with_comma(keyword), ""

    def _with_comma(self, node: ast.AST) -> tuple[int, int]:
        start, end = self._span(node)
        rest = self.source[end:]
        blank = len(rest) - len(rest.lstrip())
        if rest[blank : blank + 1] == b",":
            end += blank + 1
        return start, end


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str)
    )


def _children(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what is below, but no docstring, annotation, type of words or f-string."""
    for name, value in ast.iter_fields(node):
        if name in {"annotation", "returns", "type_comment"}:
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or isinstance(child, ast.JoinedStr):
                continue
            if isinstance(child, ast.Subscript) and ast.unparse(child.value) == "Literal":
                continue
            if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
                continue
            if isinstance(child, ast.Assign) and ast.unparse(child.targets[0]) == "__all__":
                continue  # nobody imports with a star
            yield child
