"""The messages of homebot's source that say to a person at the page why something is not done."""

import ast
import itertools
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TypeAlias

from tests.source_trees import SOURCE, source_trees

FIELD = "0"
"""Stands for a value in a message; it has no letters."""

_PLACES = {
    **dict.fromkeys(("RefusedError", "WrongCodeError"), 1),
    **dict.fromkeys(("UnableError", "NoTargetError", "LinkError", "BusyError", "UnansweredError"), 0),
    **dict.fromkeys(("CertificateError", "UsageError"), 0),
}
"""By error: the place of its message among the arguments."""

_MISTAKES = dict.fromkeys(("UsageError", "ValueError", "_NoStepError", "NoTargetError"), 0) | {
    "RefusedError": 1,
    "ConfigError": 2,
}
"""As :data:`_PLACES`, for the text of a routine."""

_OF_OTHERS = re.compile(
    "(cli|mqtt|bridges|testing|house|compat|recording|replay|robots|features/(machine|ros2|recording))/"
    "|gateways/(raw_delivery|nfc/(tag_services|.*reader))|.*/simulated|.*memory_broker"
    "|discovery/(nearness|services|search/.*)"
)
"""Modules that speak to a shell, a program or another machine alone; the last seek for ``homebot find``."""

_UNASKED = {"CorrectHistoryResponse"}
"""Responses of services that no view calls."""

_SETUP = "features/page/"
"""Elsewhere a UsageError is a mistake in a file or a program."""

_Function: TypeAlias = ast.FunctionDef | ast.AsyncFunctionDef
_DEPTH = 6
"""From name to name, at most."""


@dataclass
class _Module:
    """What a module binds: names, those it imports, and those of its classes."""

    names: dict[str, list[ast.AST]] = field(default_factory=dict)
    imported: dict[str, tuple[str, str]] = field(default_factory=dict)
    attributes: dict[str, list[ast.AST]] = field(default_factory=dict)


@cache
def told_messages() -> set[str]:
    """Return them, each with :data:`FIELD` where it has a value.

    A message may stand in a constant, a variable, an attribute of a class or what a function returns.
    """
    found = {text for name in source_trees() if not _OF_OTHERS.match(name) for text in _of(name)}
    return {text for text in found if re.search("[a-z]{2}", text) and not re.search(" ,| $", text)}  # lacks a value


def mistakes_told_in(name: str) -> set[str]:
    """Return what the errors of a module say that a mistake of a person raises, and its advice.

    A module is named by its path in the package. Advice is what functions return or yield, and what begins as such;
    parts of other texts, and words alone, are left out.
    """
    told, more = {*_of(name, _MISTAKES)}, set[str]()
    for node in ast.walk(source_trees()[name]):
        if isinstance(node, _Function):
            returned = (one.value for one in ast.walk(node) if isinstance(one, ast.Return | ast.Yield))
            for value in filter(None, returned):
                texts = value.elts if isinstance(value, ast.Tuple) else [value]
                more.update(itertools.chain.from_iterable(_texts(one, name, node) for one in texts))
        elif isinstance(node, ast.Constant | ast.JoinedStr):
            more.update(
                text for text in _texts(node, name, None) if re.match("(?:write|say|known are|numbers are) ", text)
            )
    told |= {text for text in more if not any(text in other for other in told | more - {text})}
    return {text for text in told if re.search("[a-z]{2} .*[a-z]{2}", text) and not re.search(" ,| $", text)}


@cache
def _module(name: str) -> _Module:
    module = _Module()
    for node in ast.walk(source_trees()[name]):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("homebot."):
            path = node.module.partition(".")[2].replace(".", "/")
            file = next((one for one in (f"{path}.py", f"{path}/__init__.py") if (SOURCE / one).exists()), "")
            module.imported |= {one.asname or one.name: (file, one.name) for one in node.names if file}
        if isinstance(node, ast.ClassDef):
            _bind(node.body, module.attributes)
    _bind(source_trees()[name].body, module.names)
    return module


@cache
def _local(function: _Function) -> dict[str, list[ast.AST]]:
    names: dict[str, list[ast.AST]] = {}
    _bind(ast.walk(function), names)
    return names


def _bind(nodes: Iterable[ast.AST], names: dict[str, list[ast.AST]]) -> None:
    for node in nodes:
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                names.setdefault(name, []).append(node)
            case (
                ast.Assign(targets=[ast.Name(id=name)], value=ast.expr() as value)
                | ast.AnnAssign(target=ast.Name(id=name), value=ast.expr() as value)
                | ast.NamedExpr(target=ast.Name(id=name), value=value)
            ):
                names.setdefault(name, []).append(value)


def _of(name: str, places: Mapping[str, int] = _PLACES) -> Iterator[str]:
    def visit(node: ast.AST, function: _Function | None) -> Iterator[str]:
        function = node if isinstance(node, _Function) else function
        if isinstance(node, ast.Call):
            for argument in _arguments(node, name, places):
                yield from _texts(argument, name, function)
        for child in ast.iter_child_nodes(node):
            yield from visit(child, function)

    return visit(source_trees()[name], None)


def _arguments(call: ast.Call, name: str, places: Mapping[str, int]) -> Iterator[ast.expr]:
    called = ast.unparse(call.func).rpartition(".")[2]
    place = places.get(called)
    is_told = called != "UsageError" or places is _MISTAKES or name.startswith(_SETUP)
    if place is not None and place < len(call.args) and is_told:
        yield call.args[place]
    if called == "Verdict" or (called.endswith("Response") and called not in _UNASKED):
        yield from (one.value for one in call.keywords if one.arg in {"reason", "message"})


def _texts(node: ast.AST, name: str, function: _Function | None, depth: int = _DEPTH) -> list[str]:
    """Return what a message may be that is *node* in the module *name*."""

    def of(node: ast.AST) -> list[str]:
        return _texts(node, name, function, depth)

    match node:
        case ast.Constant(value=str(text)):
            return [text]
        case ast.JoinedStr(values=parts):
            return ["".join(texts) for texts in itertools.product(*map(of, parts))]
        case ast.FormattedValue(value=value, conversion=-1, format_spec=None) | ast.Await(value=value):
            return of(value)
        case ast.FormattedValue(conversion=114):  # !r
            return [f"'{FIELD}'"]
        case ast.IfExp(body=one, orelse=other):
            return of(one) + of(other)
        case ast.BoolOp(values=values):
            return list(dict.fromkeys(text for value in values for text in of(value)))
        case ast.BinOp(left=one, op=ast.Add(), right=other):
            return ["".join(texts) for texts in itertools.product(of(one), of(other))]
        case ast.Call(func=ast.Attribute(value=value, attr="format")):
            return [re.sub(r"\{\w*\}", FIELD, text) for text in of(value)]
    bound = _bound(node, name, function) if depth else []
    found = [text for own, where, inner in bound for text in _texts(own, where, inner, depth - 1)]
    return list(dict.fromkeys(text if re.search(r"\s|^$|^gateways\.", text) else FIELD for text in found)) or [
        FIELD
    ]  # one word is a value


def _bound(node: ast.AST, name: str, function: _Function | None) -> list[tuple[ast.AST, str, _Function | None]]:
    """Return what *node* stands for, each with its module and function."""
    module = _module(name)
    match node:
        case ast.Name(id=own):
            if function and own in (local := _local(function)):
                return [(value, name, function) for value in local[own]]
            if own in module.names:
                return [(value, name, None) for value in module.names[own]]
            file, theirs = module.imported.get(own, ("", ""))
            return _bound(ast.Name(id=theirs), file, None) if file and file != name else []
        case ast.Attribute(value=ast.Name(id="self" | "cls"), attr=own):
            return [(value, name, None) for value in module.attributes.get(own, ())]
        case ast.Call(func=ast.Name() | ast.Attribute(value=ast.Name(id="self" | "cls")) as called):
            return _bound(called, name, function)
        case ast.Call(func=ast.Attribute(value=table, attr="get"), args=[_, *others]):
            values = _bound(ast.Subscript(value=table, slice=ast.Name(id="_")), name, function)
            return [*values, *((other, name, function) for other in others)]
        case ast.Subscript(value=table, slice=ast.Name() | ast.Attribute() | ast.Constant()):
            tables = _bound(table, name, function)
            return [(v, where, inner) for own, where, inner in tables if isinstance(own, ast.Dict) for v in own.values]
        case ast.FunctionDef() | ast.AsyncFunctionDef():
            returns = (one.value for one in ast.walk(node) if isinstance(one, ast.Return))
            return [(value, name, node) for value in returns if value is not None]
    return []
