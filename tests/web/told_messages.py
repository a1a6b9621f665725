"""The messages of homebot's source that say to a person at the page why something is not done."""

import ast
import itertools
import re
from collections.abc import Iterator
from pathlib import Path

import homebot

FIELD = "0"
"""Stands for a value in a message; it has no letters."""

_PACKAGE = Path(homebot.__file__).parent
_PLACES = {
    **dict.fromkeys(("RefusedError", "WrongCodeError"), 1),
    **dict.fromkeys(("UnableError", "NoTargetError", "LinkError", "BusyError", "UnansweredError"), 0),
    **dict.fromkeys(("CertificateError", "UsageError"), 0),
}
"""By error: the place of its message among the arguments."""

_OF_OTHERS = re.compile(
    "(cli|mqtt|bridges|testing|house|compat|recording|replay|robots|features/(machine|ros2|recording))/"
    "|gateways/(raw_delivery|nfc/(tag_services|.*reader))|.*/simulated|.*memory_broker"
)
"""Modules that speak to a shell, a program or another machine alone."""

_SETUP = "features/page/"
"""Elsewhere a UsageError is a mistake in a file or a program."""


def told_messages() -> set[str]:
    """Return them, each with :data:`FIELD` where it has a value."""
    found = {text for module in _PACKAGE.rglob("*.py") for text in _of(module)}
    return {text for text in found if re.search("[a-z]{2}", text)}


def _of(module: Path) -> Iterator[str]:
    name = module.relative_to(_PACKAGE).as_posix()
    if _OF_OTHERS.match(name):
        return
    for call in ast.walk(ast.parse(module.read_text())):
        if not isinstance(call, ast.Call):
            continue
        called = ast.unparse(call.func).rpartition(".")[2]
        place = _PLACES.get(called)
        if place is not None and place < len(call.args) and (called != "UsageError" or name.startswith(_SETUP)):
            yield from _texts(call.args[place])
        if called == "Verdict" or called.endswith("Response"):
            for keyword in call.keywords:
                if keyword.arg in {"reason", "message"}:
                    yield from _texts(keyword.value)


def _texts(node: ast.expr) -> list[str]:
    """Return what a message may be."""
    match node:
        case ast.Constant(value=str(text)):
            return [text]
        case ast.JoinedStr(values=parts):
            return ["".join(texts) for texts in itertools.product(*map(_texts, parts))]
        case ast.IfExp(body=one, orelse=other):
            return _texts(one) + _texts(other)
        case ast.BinOp(left=one, op=ast.Add(), right=other):
            return ["".join(texts) for texts in itertools.product(_texts(one), _texts(other))]
    return [FIELD]
