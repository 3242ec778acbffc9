"""Faults that a maintainer makes: a sign, a factor, a comparison, swapped arguments, another name, a condition dropped."""

import ast
import builtins
import copy
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

SIGNS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult}
COMPARISONS = {
    **{ast.Lt: ast.Gt, ast.LtE: ast.GtE, ast.Gt: ast.Lt, ast.GtE: ast.LtE, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq},
    **{ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In},
}
TAKEN_FOR = [
    *[
        ("sin", "cos"),
        ("min", "max"),
        ("floor", "ceil"),
        ("minimum", "maximum"),
        ("any", "all"),
        ("degrees", "radians"),
    ],
    *[("east", "north"), ("latitude", "longitude"), ("start", "end"), ("begin", "end"), ("first", "last"), ("x", "y")],
    *[("mean", "sigma"), ("depth", "altitude"), ("surface_time", "surface_time_p99"), ("duration", "duration_p99")],
    *[("release_time", "release_time_p99"), ("radius", "line_length"), ("hold", "galvanic_release")],
]
OTHER_NAME = {one: other for pair in TAKEN_FOR for one, other in (pair, pair[::-1])}
ONE_ORDER = {
    "isinstance",
    "replace",
    "zip",
    "Problem",
    "getattr",
    "hasattr",
    "range",
    "cast",
    "min",
    "max",
    "minimum",
    "maximum",
}
"""Calls whose arguments nobody swaps, or in which their order does not count."""


@dataclass(frozen=True)
class Fault:
    """Which fault of a module, where and what it is."""

    number: int
    line: int
    kind: str
    before: str
    after: str

    def __str__(self) -> str:
        return f"{self.line}: {self.kind}: {self.before} -> {self.after}"


_Change = tuple[ast.AST, tuple[str, int | None], ast.expr, str, ast.expr]
"""Where an expression stands, the expression, and what takes its place as which kind of fault."""


def faults(text: str) -> list[Fault]:
    """Return every fault that can be planted in a module."""
    return [
        Fault(number, node.lineno, kind, ast.unparse(node)[:90], ast.unparse(other)[:90])
        for number, (_, _, node, kind, other) in enumerate(_changes(ast.parse(text)))
    ]


def planted(text: str, fault: Fault) -> str:
    """Return the text of the module with one of its faults."""
    tree = ast.parse(text)
    parent, (name, index), _, _, other = next(islice(_changes(tree), fault.number, None))
    if index is None:
        setattr(parent, name, other)
    else:
        getattr(parent, name)[index] = other
    return ast.unparse(tree) + "\n"


def _changes(tree: ast.AST) -> Iterator[_Change]:
    for parent, place, node in _judged(tree):
        for kind, other in _others(node):
            if ast.unparse(node) != ast.unparse(other):
                yield parent, place, node, kind, other


def _judged(node: ast.AST) -> Iterator[tuple[ast.AST, tuple[str, int | None], ast.expr]]:
    """Yield the expressions that compute something: no annotations, messages, docstrings or decorators."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases", "type_params", "format_spec"):
            continue
        for index, child in enumerate(value) if isinstance(value, list) else [(None, value)]:
            if not isinstance(child, ast.AST) or _is_message(child) or getattr(child, "arg", "") == "strict":
                continue
            if isinstance(child, ast.expr):
                yield node, (name, index), child
            yield from _judged(child)


def _is_message(node: ast.AST) -> bool:
    """Whether it is what is raised, a message, a docstring, an import or a type's name."""
    if isinstance(node, ast.Raise | ast.Import | ast.ImportFrom | ast.JoinedStr):
        return True
    if isinstance(node, ast.Call) and ast.unparse(node.func).split(".")[-1] in ("Problem", "cast", "TypeVar"):
        return True
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _others(node: ast.expr) -> Iterator[tuple[str, ast.expr]]:
    match node:
        case ast.BinOp(op=op) if type(op) in SIGNS and not _is_text(node):
            yield "sign or factor", _with(node, op=SIGNS[type(op)]())
        case ast.UnaryOp(op=ast.USub() | ast.Not()):
            yield "sign", node.operand
        case ast.Compare(ops=[op]) if type(op) in COMPARISONS:
            yield "comparison", _with(node, ops=[COMPARISONS[type(op)]()])
        case ast.BoolOp(op=op, values=values):
            yield "and/or", _with(node, op=ast.Or() if isinstance(op, ast.And) else ast.And())
            for index in range(len(values)):
                rest = values[:index] + values[index + 1 :]
                yield "condition dropped", rest[0] if len(rest) == 1 else _with(node, values=rest)
        case ast.IfExp(body=body, orelse=orelse):
            yield "always", body
            yield "never", orelse
        case ast.Constant(value=bool() as value):
            yield "flag", ast.Constant(not value)
        case ast.Constant(value=int() | float() as value):
            yield "constant", ast.Constant(type(value)(2 * value) if value else type(value)(1))
        case ast.Attribute(attr=attr) if attr in OTHER_NAME and isinstance(node.ctx, ast.Load):
            yield "another's name", _with(node, attr=OTHER_NAME[attr])
        case ast.Name(id=name) if name in OTHER_NAME and isinstance(node.ctx, ast.Load) and hasattr(builtins, name):
            yield "another's name", _with(node, id=OTHER_NAME[name])
        case ast.Call(func=func, args=[first, second, *rest]):
            alike = isinstance(first, ast.Constant) == isinstance(second, ast.Constant)
            if alike and ast.unparse(func).split(".")[-1] not in ONE_ORDER and not isinstance(first, ast.Starred):
                yield "swapped arguments", _with(node, args=[second, first, *rest])
        case ast.GeneratorExp(generators=[one, *_]) | ast.ListComp(generators=[one, *_]) if one.ifs:
            dropped = copy.deepcopy(node)
            dropped.generators[0].ifs = []
            yield "condition dropped", dropped


def _with(node: ast.expr, **changed: object) -> ast.expr:
    """A copy with other fields."""
    other = copy.copy(node)
    for name, value in changed.items():
        setattr(other, name, value)
    return other


def _is_text(node: ast.BinOp) -> bool:
    """Whether it joins texts, lists or types."""
    kinds = (ast.JoinedStr, ast.List, ast.Tuple, ast.ListComp)
    sides = (node.left, node.right)
    return any(
        isinstance(each, kinds) or (isinstance(each, ast.Constant) and isinstance(each.value, str)) for each in sides
    )
